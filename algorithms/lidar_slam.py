"""SLAM with a lidar: matches scans to each other, and closes loops when the robot returns."""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Shown

from .estimation.ekf_models import odometry_motion
from .estimation.pose_graph import PoseGraph, compose, step_between
from .estimation.recent_motion import SAME
from .occupancy import OccupancyGrid, shown_grid
from .scans.level_scan import LevelLidar, LevelScan
from .scans.map_parts import Keyframe, PartsMap
from .scans.odometry_bias import OdometryBias
from .scans.odometry_delay import SynchronousOdometry, retimed
from .scans.scan_matching import WallField
from .scans.scan_odometry import ScanOdometry
from .scans.scan_search import CONTRARY, FEWEST, Fit, MatchedPose, match_pose
from .scans.scan_walls import Surface, walls_of

SLIP = np.array([0.05, 0.05, 0.02])
"""Errors of odometry beyond its data sheet: relative to the distance, to the sideways distance, and to the turn."""
FLOOR = np.array([0.01, 0.01, 0.003])
"""The constant part of these errors [m, m, rad]."""

WITNESSES = 8.0
"""Weight of the assumed factor on the noise of odometry, as a number of steps compared with scans."""
COMPARED, EXPLAINED = 60, 0.6
"""Number of points of a scan between two keyframes that are compared with the last scans, and the minimum proportion
near walls for agreement."""
SHAKEN = np.diag([0.5, 0.5, 0.5]) ** 2
"""Covariance of the pose between scans while wheels slip or something pushes the robot [m^2, rad^2]."""
STILL = 1e-6
"""The robot is at rest in a tick if the motion by odometry is less than this [m, rad]."""


class LidarSlam:
    """Estimates the pose from odometry and a lidar, and keeps a map of scans.

    A scan becomes a keyframe when the robot has moved far enough. It is matched against the walls of the last few
    keyframes over all poses that odometry allows; the covariance accounts for competing hypotheses. A few keyframes
    form a submap, which is a node of the pose graph. A finished submap is searched for in old ones; an unambiguous
    match closes a loop.

    References:
        Lu, Milios, Globally Consistent Range Scan Alignment for Environment Mapping, Autonomous Robots 4, 1997. Olson,
        Real-Time Correlative Scan Matching, ICRA 2009. Hess et al., Real-Time Loop Closure in 2D LIDAR SLAM, ICRA 2016.
    """

    def __init__(
        self,
        *,
        lidar: str | None = None,
        distance: float = 0.3,
        turn_deg: float = 15.0,
        loop_distance: float = 3.0,
        loop_share: float = 0.75,
        odometry_scale: float = 2.0,
        show_every: float = 0.0,
        deskew: bool = True,
    ) -> None:
        """Set the rules.

        Args:
            lidar: Name of the lidar; None for the first.
            distance: Distance between two keyframes [m].
            turn_deg: Turn between two keyframes.
            loop_distance: Distance within which old submaps are tried for a loop closure [m], increased by the possible
                drift.
            loop_share: Minimum ratio of matching walls to walls near old ones for a loop closure.
            odometry_scale: Factor on the standard deviation of odometry, for slip that its data sheet does not include.
            show_every: Period at which the map is shown as a grid [s]; 0: never.
            deskew: Whether to undo the robot's motion by odometry in scans of a lidar that measures while it rotates.
        """
        if show_every < 0.0:
            raise ValueError(f"show_every is {show_every:g} s; it must be at least 0")
        self._show_every = show_every
        self._lidar, self._deskew = lidar, deskew
        self._distance, self._turn = distance, np.radians(turn_deg)
        self._loop_distance, self._loop_share = loop_distance, loop_share
        self._scale = odometry_scale
        self._begin(np.zeros(3), np.zeros((3, 3)))

    def _begin(self, prior: Array, covariance: Array) -> None:
        """Reset everything to the start of the robot."""
        self._prior, self._newest = prior, (prior, covariance)
        self._trajectory: list[tuple[float, float, int, Array]] = []
        self._reached: list[Array] = []
        self._bias = OdometryBias()
        rules = {"loop_distance": self._loop_distance, "loop_share": self._loop_share}
        self._map = PartsMap(prior, covariance, self._bias, **rules)
        self._odometry, self._by_scans = SynchronousOdometry(), ScanOdometry()
        self._held, self._turn_since = deque[LevelScan](), 0.0
        self._field: WallField | None = None
        self._slipping = False
        self._squares, self._witnesses = WITNESSES * self._scale**2, WITNESSES
        self._shown, self._next_shown = tuple[Shown, ...](), 0.0
        self._rest()

    def _rest(self) -> None:
        """Restart the accumulated motion here."""
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))
        self._raw_step, self._driven, self._moving = np.zeros(3), 0.0, 0.0

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map.

        Raises:
            ValueError: The robot has no such lidar.
        """
        self._scans = LevelLidar(robot, self._lidar, deskew=self._deskew)
        self._motion = odometry_motion()
        self._begin(robot.prior.as_array(), np.asarray(robot.prior_covariance, dtype=float))

    @property
    def keyframes(self) -> list[Keyframe]:
        """The scans of the map."""
        return self._map.keyframes

    def poses(self) -> Array:
        """Return the poses of these scans in the world as known by now, shape (n, 3)."""
        return self._map.poses()

    @property
    def graph(self) -> PoseGraph:
        """Pose graph of the parts of the map."""
        return self._map.graph

    @property
    def loops(self) -> int:
        """Number of closed loops."""
        return self._map.loops.closed

    def lost(self) -> bool:
        """Return whether scans fit the map neither at the expected pose nor, so far, anywhere else."""
        return self._map.lost

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and, when the robot has moved, its scan."""
        level_scan = self._scans.update(seen)
        walls = None
        if self._by_scans.is_needed(seen):
            walls = None if level_scan is None else walls_of(level_scan)
            seen = replace(seen, odometry=self._by_scans.update(seen, level_scan, walls))
        odometry = self._odometry.update(seen.odometry, seen.moment)
        forward, left, turn = odometry.forward, odometry.left, odometry.turn
        moved = np.array([forward, left, turn])
        seconds = seen.dt if max(abs(forward), abs(left), abs(turn)) > STILL else 0.0
        self._raw_step = compose(self._raw_step, moved)
        self._driven, self._moving = self._driven + math.hypot(forward, left), self._moving + seconds
        self._step, F, G = self._motion(self._step, self._bias.corrected(moved, seconds))
        self._step_covariance = F @ self._step_covariance @ F.T + G @ odometry.covariance @ G.T
        x, y, turned = self._step.tolist()
        far = math.hypot(x, y) > self._distance or abs(turned) > self._turn
        due = self._due(level_scan)
        shaken = self._slipping or (seconds > 0.0 and due is not None and self._is_elsewhere(due))
        if due is not None and (far or not self.keyframes or shaken):
            self._extend(due, walls_of(due) if walls is None or due is not level_scan else walls)
            self._map.work()
            self._newest, self._walls = self._map.belief(), self._map.recent_walls()
            self._field = WallField(self._walls) if len(self._walls.points) >= FEWEST else None
        true = self._odometry.time - self._odometry.delay.seconds
        self._trajectory.append((seen.moment, true, len(self.keyframes) - 1, self._step))
        if self._show_every and seen.time >= self._next_shown:
            self._shown, self._next_shown = (shown_grid(self.grid()),), seen.time + self._show_every
        return self._belief()

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return the final trajectory: pose at the end of each tick's motion and its time [s], from the whole map."""
        self._map.finish()
        self._newest = self._map.belief() if self.keyframes else self._newest
        poses = [*self._map.poses(), self._prior]
        # The correction by the next scan of the map is spread over the motion before it.
        ends = [compose(pose, reached) for pose, reached in zip(poses, self._reached, strict=False)]
        corrections = [target - end for target, end in zip(poses[1:-1], ends, strict=True)]
        found = [
            self._interpolated(poses[number], step, number, corrections) for _, _, number, step in self._trajectory
        ]
        times, true = np.array([entry[:2] for entry in self._trajectory]).reshape(-1, 2).T
        final = retimed(times, true, found)
        return [(time, Pose.from_array(pose)) for time, pose in zip(times.tolist(), final, strict=True)]

    def _interpolated(self, last: Array, step: Array, number: int, corrections: Sequence[Array]) -> Array:
        """Return a pose between two scans of the map.

        Args:
            last: Pose of the previous scan, world frame, shape (3,).
            step: Motion by odometry since then, shape (3,).
            number: Number of the previous scan; -1 for none.
            corrections: Difference of each next scan from odometry, world frame, shape (3,) each.
        """
        pose = compose(last, step)
        if 0 <= number < len(corrections):
            share = min(1.0, _size(step) / max(_size(self._reached[number]), 1e-9))
            x, y, heading = corrections[number].tolist()
            pose = pose + share * np.array([x, y, wrap_angle(heading)])
        return pose

    def grid(self, **keys: float) -> OccupancyGrid:
        """Return the map as a grid of odds; the keys are those of `OccupancyGrid`."""
        grid = OccupancyGrid(**keys)
        for pose, keyframe in zip(self._map.poses(), self.keyframes, strict=True):
            grid.add(Pose.from_array(pose) @ keyframe.level_scan.robot_from_lidar, keyframe.level_scan.scan)
        return grid

    def _due(self, level_scan: LevelScan | None) -> LevelScan | None:
        """Return the newest scan for whose time odometry is available; later ones wait, with that of this tick."""
        if level_scan is not None:
            self._held.append(level_scan)
        due = None
        while self._held and self._odometry.time_of(self._held[0].scan.stamp) < self._odometry.time + SAME:
            due = self._held.popleft()
        return due

    def _from_now(self, level_scan: LevelScan, walls: Surface) -> tuple[LevelScan, Surface]:
        """Return a scan and its walls in the frame of the robot now, if the scan is older than its motion."""
        step = self._odometry.since(level_scan.scan.stamp)
        if not step.any():
            return level_scan, walls
        now_from_then = Pose.from_array(step).inverse()
        level_scan = replace(level_scan, robot_from_lidar=now_from_then @ level_scan.robot_from_lidar)
        return level_scan, walls.moved(now_from_then.as_array())

    def _is_elsewhere(self, level_scan: LevelScan) -> bool:
        """Return whether the last scans contradict odometry: something pushed the robot, or its wheels slip."""
        if self._field is None:
            return False
        since = self._odometry.since(level_scan.scan.stamp)
        points = level_scan.points()
        points = Pose.from_array(compose(self._step, step_between(since, np.zeros(3)))).transform(points)
        if len(points) < FEWEST or self._field.beside(points[:: 1 + len(points) // COMPARED]) > EXPLAINED:
            return False
        level_scan, surface = self._from_now(level_scan, walls_of(level_scan))
        through = self._map.through(level_scan, surface, self._walls)
        return len(surface.points) >= FEWEST and min(through(self._step)) > CONTRARY

    def _extend(self, level_scan: LevelScan, walls: Surface) -> None:
        """Match a scan, given its walls, to the last ones, and add it to the map."""
        level_scan, surface = self._from_now(level_scan, walls)
        noise = self._scale**2 * self._step_covariance
        matched = MatchedPose(self._step, noise, noise, noise, np.eye(3))
        moved = self._raw_step, self._driven, self._moving
        if self.keyframes:
            noise = noise + self._slip()
            systematic = self._bias.step_covariance(*moved)
            through = self._map.through(level_scan, surface, self._walls)
            matched = match_pose(
                surface, self._walls, self._step, noise, systematic=systematic, through=through, field=self._field
            )
            self._slipping = matched.fit is Fit.SLIPPED
            correction = matched.pose - self._step
            correction[2] = wrap_angle(float(correction[2]))
            self._reached.append(self._step)
            self._check_turn(correction, matched)
            self._bias.learn(*moved, correction, noise, matched.covariance)
            self._compare_turn(level_scan.scan.stamp, matched)
        self._map.add(level_scan, surface, matched, matched.follows @ self._bias.slopes(*moved))
        self._rest()

    def _check_turn(self, correction: Array, matched: MatchedPose) -> None:
        """Compare the error of odometry in a turn, as shown by scans, with the noise of its data sheet.

        Args:
            correction: The step by scans and odometry less that by odometry, shape (3,).
            matched: The step by scans.
        """
        by_sheet, by_scans = float(self._step_covariance[2, 2]), float(matched.own[2, 2])
        if by_scans < by_sheet:
            self._squares += correction[2] ** 2 / (by_sheet + by_scans)
            self._witnesses += 1.0

    def _compare_turn(self, stamp: float, matched: MatchedPose) -> None:
        """Update the delay of odometry with the turn of a step to a scan of some time [s]."""
        before, self._turn_since = self._turn_since, self._odometry.turn_since(stamp)
        turn = float(matched.pose[2]) + before - self._turn_since
        by_sheet, by_scans = float(self._step_covariance[2, 2]), float(matched.own[2, 2])
        variance = by_scans + min(1.0, self._squares / self._witnesses) * by_sheet + FLOOR[2] ** 2
        self._odometry.delay.add(stamp, turn if by_scans < by_sheet else math.nan, self._moving, variance)

    def _slip(self) -> Array:
        """Return the covariance of the errors of odometry beyond its data sheet, shape (3, 3)."""
        distance = float(np.hypot(*self._step[:2]))
        amount = np.array([distance, distance, abs(self._step[2])])
        return np.diag((FLOOR + SLIP * amount) ** 2)

    def _belief(self) -> Estimate:
        """Return the pose of the newest scan, propagated by odometry."""
        pose, covariance = self._newest
        pose, F, G = self._motion(pose, self._step)
        # Search windows have to be wide, but the reported covariance since the last scan has the noise that scans have
        # shown.
        by_odometry = max(1.0, self._squares / self._witnesses) * self._step_covariance
        covariance = F @ covariance @ F.T + G @ by_odometry @ G.T
        if self._slipping:
            covariance = covariance + SHAKEN
        if self._odometry.delay.seconds > 0.0:
            step, step_covariance = self._odometry.overdue()
            pose, F, G = self._motion(pose, step)
            covariance = F @ covariance @ F.T + G @ step_covariance @ G.T
        return Estimate(Pose.from_array(pose), covariance, show=self._shown)


def _size(step: Array) -> float:
    """Return the size of a step [m], with turns converted by a lever arm of half a metre."""
    return float(np.hypot(step[0], step[1]) + 0.5 * abs(step[2]))
