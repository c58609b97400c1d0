"""Systematic errors of odometry, which a filter estimates beside the pose: they are the same from tick to tick.

A data sheet of odometry tells noise that is new in each tick. But worn wheels report too long a way all along, a wrong
track too small a turn, and a flat tyre turns the robot a little with each metre. Over a long way that adds up to more
than noise does, and a filter that takes it for noise is too sure of its heading.
"""

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Odometry

COUNT = 3
"""Errors: of the way, as a share of it; of the turn, for each metre driven [rad/m]; of the turn, as a share of it."""
BEGIN = 0.05
"""Once the robot has driven so far, the noise that odometry claims is compared with its way [m]."""


class OdometryErrors:
    """How far off odometry may be at every tick, as far as its claims of noise tell.

    Noise of rate q adds q d to the variance over a way d, a constant share s of it s^2 d^2. Both make as much over a
    given way L if the variance of s is q / L. For the turn a radian turned counts as a metre of way.
    """

    def __init__(self, way: float) -> None:
        """Start at rest, with no error given; `way` is L, infinite for a robot without such errors [m]."""
        self._way = way
        self._claimed, self._moved = np.zeros(2), np.zeros(2)
        self._given = np.zeros(COUNT)

    def step(self, moved: Odometry, covariance: Array) -> tuple[Array, Array]:
        """Return what a tick tells of them.

        Args:
            moved: The motion of the tick.
            covariance: Of (forward, left, turn) as it is claimed, shape (3, 3).

        Returns:
            slopes: Derivative of (forward, left, turn) by the errors, shape (3, 3).
            gained: By how much their variances grow at this tick, shape (3,).
        """
        forward, left, turn = moved.forward, moved.left, moved.turn
        way = float(np.hypot(forward, left))
        self._claimed += covariance[0, 0] + covariance[1, 1], covariance[2, 2]
        self._moved += way, way + abs(turn)
        gained = np.zeros(COUNT)
        if self._moved[0] > BEGIN:
            by_way, by_turn = (self._claimed / self._moved / self._way).tolist()
            gained = np.maximum(np.array([by_way, by_turn, by_turn]) - self._given, 0.0)
            self._given += gained
        slopes = np.array([[forward, 0.0, 0.0], [left, 0.0, 0.0], [0.0, forward, turn]])
        return slopes, gained
