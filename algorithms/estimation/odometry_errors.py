"""Systematic errors of odometry, which a filter estimates along with the pose.

The data sheet of odometry gives white noise. But worn wheels always overestimate the distance, a wrong track
underestimates turns, and a flat tyre makes the robot veer. Over a long distance these errors exceed the noise, and a
filter that treats them as noise is overconfident in its heading. Odometry may also be late, or early if commands
replace it: then part of a tick's motion belongs to another tick.
"""

import math
from collections import deque

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Odometry

COUNT = 4
"""Number of errors: relative error of distance; turn per metre driven [rad/m]; relative error of turn; and delay of the
motion [s]."""
DELAY = 0.05
"""Standard deviation of the delay [s]: of wheels following commands, or of computers reporting their motion."""
LATEST = 0.5
"""Maximum delay of the motion [s]."""
BEGIN = 0.05
"""Distance after which the noise of odometry is compared with the distance [m]."""


class OdometryErrors:
    """Models systematic errors of odometry in proportion to its noise.

    Noise of rate q adds q d to the variance over a distance d, a constant scale error s adds s^2 d^2. Both are equal
    over a given distance L if the variance of s is q / L. For the turn, one radian counts as one metre.
    """

    def __init__(self, length: float, *, delay: float = DELAY) -> None:
        """Start at rest, without errors.

        Args:
            length: L; infinite for a robot without such errors [m].
            delay: Standard deviation of the delay, if there are such errors [s].
        """
        self._length, self._delay = length, 0.0 if math.isinf(length) else delay
        self._claimed, self._moved = np.zeros(2), np.zeros(2)
        self._given = np.zeros(COUNT)
        self._increments: deque[Array] = deque()

    @property
    def variances(self) -> Array:
        """Prior variances of the errors so far, shape (4,)."""
        return self._given.copy()

    def step(
        self, moved: Odometry, covariance: Array, seconds: float, *, delay: float = 0.0
    ) -> tuple[Array, Array, Array]:
        """Return the motion of a tick and its dependence on the errors.

        Args:
            moved: The motion of the tick by odometry.
            covariance: Covariance of (forward, left, turn), shape (3, 3).
            seconds: Period of the tick [s].
            delay: Estimated delay of the motion [s].

        Returns:
            control: (forward, left, turn) of the tick with that delay, minus its slope times it, shape (3,).
            slopes: Derivative of (forward, left, turn) by the errors, shape (3, 4).
            gained: Increase of their variances at this tick, shape (4,).
        """
        increment = np.array([moved.forward, moved.left, moved.turn])
        distance = float(np.hypot(moved.forward, moved.left))
        self._claimed += covariance[0, 0] + covariance[1, 1], covariance[2, 2]
        self._moved += distance, distance + abs(moved.turn)
        gained = np.zeros(COUNT)
        if self._moved[0] > BEGIN:
            by_distance, by_turn = (self._claimed / self._moved / self._length).tolist()
            gained = np.maximum(np.array([by_distance, by_turn, by_turn, self._delay**2]) - self._given, 0.0)
            self._given += gained
        self._increments.appendleft(increment)
        while len(self._increments) > LATEST / seconds + 2.0:
            self._increments.pop()
        # Velocity is constant within a tick, so the motion of a delayed tick consists of parts of two ticks.
        whole, part = divmod(min(max(delay, 0.0), LATEST) / seconds, 1.0)
        newer, older = (self._past(int(whole) + back) for back in (0, 1))
        forward, left, turn = ((1.0 - part) * newer + part * older).tolist()
        slopes = np.array([[forward, 0.0, 0.0, 0.0], [left, 0.0, 0.0, 0.0], [0.0, forward, turn, 0.0]])
        slopes[:, 3] = (older - newer) / seconds
        return np.array([forward, left, turn]) - max(delay, 0.0) * slopes[:, 3], slopes, gained

    def _past(self, ticks: int) -> Array:
        """Return the motion by odometry a number of ticks ago; the robot was at rest before the first."""
        return self._increments[ticks] if ticks < len(self._increments) else np.zeros(3)
