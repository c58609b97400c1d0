"""Follows a planned curve of poses, which may change its direction, and turn on the spot."""

import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, RobotInfo

SPACING = 0.02
"""Distance between points on the curve [m]."""
SLOW = 0.1
"""Minimum speed of the driven wheels [m/s]."""
CONVERGENCE = 5.0
"""How quickly the robot returns to the curve [1/m]."""
BENT = 0.3
"""Difference of curvatures, by their maximum, at which the robot stands in between."""
TURN_RATE = 0.5
"""Maximum turn rate on the curve: faster, wheels skid [rad/s]."""
FACING = 0.02
"""Difference at which a turn on the spot is over [rad]."""

STEERING, STEER_RATE, STEER_OFF = 0.01, 1.2, 0.2
"""Speed while a wheel turns to another curvature, rate at which it surely does so, where its maximum angle counts as 45
degrees, and how far it may be off while the robot drives [m/s, rad/s, rad]."""


class CurveFollower:
    """Feedback that leads a robot along a curve."""

    def __init__(self, robot: RobotInfo, *, bend: float, top: float) -> None:
        """Take the limits of the robot, its maximum curvature on curves [1/m] and its maximum speed [m/s]."""
        self._robot, self._bend, self._top = robot, bend, top
        # How much faster a wheel that drives and steers is than the robot, by the curvature [m].
        self._arm = robot.max_acceleration / robot.max_turn_acceleration if robot.drive == "tricycle" else 0.0
        self._is_steered, self._steer = not math.isinf(robot.max_curvature) or robot.drive == "tricycle", 0.0
        self.begin(np.zeros((0, 3)), np.zeros(0), np.zeros(0))

    def begin(self, poses: Array, bends: Array, ways: Array) -> None:
        """Take a curve.

        Args:
            poses: At most `SPACING` apart, shape (n, 3) [m, m, rad].
            bends: Curvature on the way to each of them, shape (n,) [1/m].
            ways: 1 forwards, -1 backwards, 0 on the spot, on the way to each of them, shape (n,).
        """
        self._poses, self._bends, self._ways, self._at = poses, bends, ways, 0

    @property
    def is_busy(self) -> bool:
        """Whether some of the curve is left."""
        return self._at < len(self._poses)

    def stop(self) -> None:
        """Drop the rest of the curve."""
        self._at = len(self._poses)

    @property
    def left(self) -> Array:
        """The rest of the curve, shape (n, 3) [m, m, rad]."""
        return self._poses[self._at :]

    def command(self, pose: Pose) -> Command:
        """Return the twist that leads along the curve, and stops where its direction changes.

        References:
            Paden, Cap, Yong, Yershov, Frazzoli, A Survey of Motion Planning and Control Techniques for Self-Driving
            Urban Vehicles, IEEE T-IV 1(1), 2016, section V-A: feedback of the distance and the heading.
        """
        way = float(self._ways[self._at])
        changes = np.flatnonzero(self._ways[self._at :] != way)
        end = self._at + int(changes[0]) - 1 if len(changes) else len(self._poses) - 1
        if way == 0.0:
            return self._turned(pose, end)
        ahead = self._poses[self._at : min(self._at + 15, end) + 1]
        self._at += int(np.argmin(np.hypot(ahead[:, 0] - pose.x, ahead[:, 1] - pose.y)))
        x, y, heading = self._poses[self._at].tolist()
        c, s = math.cos(heading), math.sin(heading)
        along = way * (c * (x - pose.x) + s * (y - pose.y))
        left = SPACING * (end - self._at) + along
        if left < 0.5 * SPACING:
            self._at = end + 1
            return Command()
        aside = c * (pose.y - y) - s * (pose.x - x)
        off = math.remainder(pose.heading - heading, 2.0 * math.pi)
        bend = float(self._bends[min(self._at + 1, end)])
        # It returns to the curve as with two equal time constants, in metres.
        bend = bend * math.cos(off) - way * 2.0 * CONVERGENCE * math.sin(off) - CONVERGENCE**2 * aside
        bend = min(max(bend, -self._bend), self._bend)
        if self._is_steered and self._turns_wheel(bend):
            return Command(forward=way * STEERING, turn=bend * way * STEERING)
        # It stands where the curve bends otherwise: the wheels take time to turn.
        others = np.flatnonzero(np.abs(self._bends[self._at : end + 1] - self._bends[self._at]) > BENT * self._bend)
        soon = min(left, SPACING * int(others[0])) if len(others) else left
        rim = math.hypot(1.0, self._arm * bend)
        top = min(self._top, TURN_RATE / max(abs(bend), 1e-6), math.sqrt(self._robot.max_acceleration / rim * soon))
        forward = way * min(max(top, SLOW / rim), 4.0 * left + 0.02)
        return Command(forward=forward, turn=bend * forward)

    def _turns_wheel(self, bend: float) -> bool:
        """Return whether the wheel needs more time to turn for a curvature [1/m]; its angle is not measured."""
        left = math.atan(bend / self._bend) - self._steer
        most = STEER_RATE * self._robot.dt
        self._steer += min(max(left, -most), most)
        return abs(left) - most > STEER_OFF

    def _turned(self, pose: Pose, end: int) -> Command:
        """Return the turn on the spot to the heading of a point on the curve."""
        left = math.remainder(float(self._poses[end, 2]) - pose.heading, 2.0 * math.pi)
        if abs(left) < FACING:
            self._at = end + 1
            return Command()
        rate = min(0.5 * self._robot.max_turn, math.sqrt(0.5 * self._robot.max_turn_acceleration * abs(left)))
        return Command(turn=math.copysign(rate, left))
