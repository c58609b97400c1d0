"""Follows walls: the simplest way to explore a building."""

import math
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array
from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap

from .paths.controllers import lqr_gains

TOWARDS = np.arange(2, 6)
"""Rays of the ring from 45 to 112 degrees to the left, towards the wall."""


class WallFollow:
    """Keeps a wall on one side, at a distance, with the ring of proximity rays.

    The wall is a line fitted to the hits of the rays on that side; an LQR follows a line parallel to it. At an inner
    corner the robot turns away; around an outer corner it drives a curve until it detects the wall again.

    References:
        Anderson, Moore, Optimal Control: Linear Quadratic Methods (1990), section 2.4, for the gains.
    """

    def __init__(self, *, side: Literal["left", "right"] = "right", distance: float = 0.4, speed: float = 0.35) -> None:
        """Set side, distance and speed.

        Args:
            side: Side of the wall.
            distance: Distance from the robot's rim to the wall [m].
            speed: Speed, limited by that of the robot [m/s].
        """
        if side not in ("left", "right"):
            raise ValueError(f"side is {side!r}; it must be 'left' or 'right'")
        if speed <= 0 or distance <= 0:
            raise ValueError(f"speed is {speed} and distance {distance}; both must be above 0")
        self._sign = 1.0 if side == "left" else -1.0
        self._distance, self._speed = distance, speed

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Compute the gains."""
        self._robot = robot
        self._forward = min(self._speed, robot.max_speed)
        self._gains = lqr_gains(self._forward, robot.dt, lateral=6.0, heading=2.0)
        self._following = False

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that follows the wall."""
        # A wall on the right is handled as its mirror image on the left.
        ring = seen.proximity if self._sign > 0 else np.roll(seen.proximity[::-1], 1)
        turn, share = self._steer(ring)
        fastest = 0.7 * self._robot.max_turn
        return Command(forward=share * self._forward, turn=self._sign * min(max(turn, -fastest), fastest))

    def _steer(self, ring: Array) -> tuple[float, float]:
        """Return the turn rate for a wall at the left [rad/s], and the factor of the speed."""
        ahead = float(min(ring[15], ring[0], ring[1]))
        needed = self._distance + 0.1
        if ahead < needed:
            self._following = True
            return -1.2, max(0.0, (ahead - 0.1) / needed - 0.5)
        hits = TOWARDS[ring[TOWARDS] < 3.0 * self._distance + 0.3]
        if len(hits) < 2:
            # An outer corner: drive around it at the set distance; straight on before the first wall.
            radius = self._distance + self._robot.radius
            return (0.8 * self._forward / radius if self._following else 0.0), 0.8
        self._following = True
        # The wall is the line from the hindmost to the foremost hit.
        angles = hits[[-1, 0]] * (2.0 * math.pi / 16)
        reach = ring[hits[[-1, 0]]] + self._robot.radius
        (x, y), (x_ahead, y_ahead) = np.column_stack([reach * np.cos(angles), reach * np.sin(angles)]).tolist()
        direction = math.atan2(y_ahead - y, x_ahead - x)
        distance = abs(x * math.sin(direction) - y * math.cos(direction))
        # Too close to the wall on the left means too far left of the line parallel to it.
        lateral = self._distance + self._robot.radius - distance
        return float(-self._gains @ (lateral, -direction)), 1.0
