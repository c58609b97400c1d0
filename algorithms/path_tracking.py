"""Drives along a smooth curve through points, with a choice of controllers."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap

from .paths.controllers import feedback_linearisation, lqr_gains, path_errors
from .paths.trajectories import SpeedProfile, SplinePath, fastest_profile

SLOWEST = 0.05
"""Minimum speed, so that the robot starts from rest [m/s]."""


class PathTracking:
    """Follows a spline through points with LQR or feedback linearisation, as fast as the robot's limits allow.

    References:
        The gains and the law: `controllers`. The speeds: `trajectories`, which needs toppra.
    """

    def __init__(
        self,
        points: Sequence[Sequence[float]],
        *,
        controller: Literal["lqr", "linearisation"] = "lqr",
        speed: float = 0.5,
        limits: float = 0.6,
    ) -> None:
        """Set the path.

        Args:
            points: Each (x, y) [m], in the frame of the estimate; the curve starts at the robot.
            controller: Control law for following the curve.
            speed: Maximum speed, if the robot can [m/s].
            limits: Part of the robot's limits of turn rate and acceleration that the plan uses, 0 to 1; the rest is for
                control.
        """
        if controller not in ("lqr", "linearisation"):
            raise ValueError(f"controller is {controller!r}; it must be 'lqr' or 'linearisation'")
        self._points = np.asarray(points, dtype=float)
        self._controller, self._top, self._share = controller, speed, limits

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Compute the curve from the robot's prior, and its speeds."""
        self._robot = robot
        first = np.array([[robot.prior.x, robot.prior.y]])
        self._path = SplinePath(np.concatenate([first, self._points]))
        self._profile: SpeedProfile = fastest_profile(
            self._path,
            speed=min(self._top, robot.max_speed),
            turn=self._share * robot.max_turn,
            acceleration=self._share * robot.max_acceleration,
            turn_acceleration=self._share * robot.max_turn_acceleration,
        )
        self._speeds = np.linspace(SLOWEST, max(self._top, 2 * SLOWEST), 12)
        self._gains = np.array([lqr_gains(speed, robot.dt) for speed in self._speeds])
        self._along = 0.0
        self._turning = True

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist along the curve; zero at its end."""
        pose = belief.pose
        self._along = self._nearest(pose.x, pose.y)
        left = self._path.length - self._along
        if left < 0.03:
            return Command()
        direction = float(self._path.heading(self._along))
        errors = path_errors(pose, self._path.at(self._along), direction)
        self._turning &= abs(errors[1]) > 0.05
        if self._turning:
            return Command(turn=float(np.clip(-2.0 * errors[1], -0.5, 0.5) * self._robot.max_turn))
        # The profile's speed is zero at rest: evaluate it slightly ahead, with a minimum speed.
        speed = max(float(self._profile.speed(self._along + 0.05)), SLOWEST)
        if self._controller == "lqr":
            gains = np.array([np.interp(speed, self._speeds, column) for column in self._gains.T])
            return Command(forward=speed, turn=float(speed * self._path.curvature(self._along) - gains @ errors))
        return self._linearised(belief, speed)

    def _linearised(self, belief: Estimate, speed: float) -> Command:
        """Return the twist that keeps a point ahead of the robot on the curve."""
        ahead, pose = 0.2, belief.pose
        point = np.array([pose.x + ahead * np.cos(pose.heading), pose.y + ahead * np.sin(pose.heading)])
        along = min(self._along + ahead, self._path.length)
        direction = float(self._path.heading(along))
        tangent = np.array([np.cos(direction), np.sin(direction)])
        # The curve is extended by a straight line beyond its end.
        target = self._path.at(along) + (self._along + ahead - along) * tangent
        velocity = speed * tangent + 2.0 * (target - point)
        return feedback_linearisation(pose, velocity, ahead=ahead)

    def _nearest(self, x: float, y: float) -> float:
        """Return the distance along the curve of the nearest point within the next metre [m]."""
        candidates = np.linspace(self._along, min(self._along + 1.0, self._path.length), 41)
        return float(candidates[np.argmin(np.hypot(*(self._path.at(candidates) - (x, y)).T))])
