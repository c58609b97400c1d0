"""Drives along straight lines from point to point, on the estimated pose."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Command, Estimate, Observation, RobotInfo, WorldMap


class Waypoints:
    """Follows a path of straight lines by pure pursuit; at a sharp corner it turns on the spot; it stops at the end.

    The path starts at the robot and leads through the points. It is split into legs at sharp corners. On a leg the
    robot steers along the circle to a point of the path a lookahead distance ahead.

    References:
        Coulter, Implementation of the Pure Pursuit Path Tracking Algorithm, CMU-RI-TR-92-01, 1992, section 2.
    """

    def __init__(
        self,
        points: Sequence[Sequence[float]],
        *,
        laps: int = 1,
        speed: float = 0.6,
        tolerance: float = 0.3,
        lookahead: float = 0.6,
        sharp_deg: float = 50.0,
    ) -> None:
        """Set the path.

        Args:
            points: Where to go, each (x, y) [m], in the frame of the estimate.
            laps: How many times to visit all points in their order.
            speed: Speed on straight lines, if the robot can [m/s].
            tolerance: Distance at which a sharp corner counts as reached [m].
            lookahead: Lookahead distance along the path [m].
            sharp_deg: Corners that turn by more than this are taken on the spot.
        """
        self._points = np.asarray(points, dtype=float)
        if self._points.ndim != 2 or self._points.shape[1] != 2 or not len(self._points):
            raise ValueError(f"points has shape {self._points.shape}; it must be a list of [x, y]")
        if not np.isfinite(self._points).all():
            raise ValueError(f"points are {points}; they must be finite numbers")
        for key, value in {"laps": laps, "speed": speed, "tolerance": tolerance, "lookahead": lookahead}.items():
            if value <= 0:
                raise ValueError(f"{key} is {value}; it must be above 0")
        self._laps = laps
        self._speed = speed
        self._tolerance = tolerance
        self._lookahead = lookahead
        self._sharp = math.radians(sharp_deg)

    def start(self, robot: RobotInfo, map: WorldMap | None, rng: Generator) -> None:
        """Build the path from the robot's prior position."""
        path = np.vstack([(robot.prior.x, robot.prior.y), *[self._points] * self._laps])
        self._legs = cut_at_corners(path, self._sharp)
        self._along = 0.0
        self._turning = True
        self._robot = robot

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist that follows the path; zero once the end is reached."""
        position = np.array([belief.pose.x, belief.pose.y])
        while self._legs:
            self._along, aim, left = look_ahead(self._legs[0], position, self._along, self._lookahead)
            if left > (self._tolerance if len(self._legs) > 1 else 0.02):
                return self._steer(aim - position, belief.pose.heading, left)
            self._legs, self._along, self._turning = self._legs[1:], 0.0, True
        return Command()

    def _steer(self, toward: Array, heading: float, left: float) -> Command:
        """Return the twist toward a point of the path with a distance left on this leg."""
        distance = float(np.hypot(*toward))
        bearing = wrap_angle(math.atan2(toward[1], toward[0]) - heading)
        fastest = self._robot.max_turn
        if self._turning or abs(bearing) > self._sharp:
            self._turning = abs(bearing) > 0.1
            if self._turning:
                braking = math.sqrt(2.0 * 0.5 * self._robot.max_turn_acceleration * abs(bearing))
                return Command(turn=math.copysign(min(0.6 * fastest, braking, 2.5 * abs(bearing)), bearing))
        curvature = 2.0 * math.sin(bearing) / max(distance, 0.5 * self._lookahead)
        braking = math.sqrt(2.0 * 0.5 * self._robot.max_acceleration * max(left, 0.0))
        speed = min(self._speed, self._robot.max_speed, braking, 0.05 + 2.0 * left)
        if abs(curvature) * speed > 0.6 * fastest:
            speed = 0.6 * fastest / abs(curvature)
        return Command(forward=speed, turn=speed * curvature)


def cut_at_corners(path: Array, sharp: float) -> list[Array]:
    """Return the pieces of a path between corners that turn by more than `sharp` [rad], points (n, 2) each [m].

    Points that repeat the one before are left out.
    """
    path = path[np.concatenate([[True], np.any(np.diff(path, axis=0) != 0.0, axis=1)])]
    ahead = np.diff(path, axis=0)
    headings = np.arctan2(ahead[:, 1], ahead[:, 0])
    turns = np.abs([wrap_angle(float(turn)) for turn in np.diff(headings)])
    cuts = [0, *(np.flatnonzero(turns > sharp) + 1).tolist(), len(path) - 1]
    return [path[a : b + 1] for a, b in itertools.pairwise(cuts) if b > a]


def look_ahead(leg: Array, position: Array, along: float, lookahead: float) -> tuple[float, Array, float]:
    """Return the robot's position along a leg, and the point that it steers for.

    Args:
        leg: Corners of a path, shape (n, 2) [m].
        position: Position of the robot, shape (2,) [m].
        along: Previous distance along the leg [m]; it never decreases.
        lookahead: Lookahead distance [m].

    Returns:
        along: Distance along the leg of the nearest point, at most 2 lookaheads further [m].
        aim: The point of the path a lookahead further; the leg's last line is extended if necessary; shape (2,) [m].
        left: Distance from the nearest point to the end of the leg [m].
    """
    steps = np.diff(leg, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1])
    starts = np.concatenate([[0.0], np.cumsum(lengths)])
    inside = np.clip(np.sum((position - leg[:-1]) * steps, axis=1) / lengths, 0.0, lengths)
    places = np.clip(starts[:-1] + inside, along, along + 2.0 * lookahead)
    nearest = np.stack([np.interp(places, starts, leg[:, i]) for i in (0, 1)], axis=-1)
    along = min(float(places[np.argmin(np.sum((nearest - position) ** 2, axis=1))]), float(starts[-1]))
    aim = np.array([np.interp(along + lookahead, starts, leg[:, i]) for i in (0, 1)])
    aim += steps[-1] / lengths[-1] * max(along + lookahead - starts[-1], 0.0)
    return along, aim, float(starts[-1]) - along
