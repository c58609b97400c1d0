"""SLAM without beacons: scans are laid on one another, and where the robot comes back, the loop is closed."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Scan

from .ekf_models import odometry_motion
from .occupancy import OccupancyGrid, lidar_of
from .pose_graph import PoseGraph, carried, step_between
from .scan_matching import Match, Surface, align, joined, search, surface_of

LOCAL = 6
"""Scans back that make up the surface on which a new one is laid."""
AROUND = 4
"""Scans before and after an old one that make up the surface on which a loop is closed."""


@dataclass(frozen=True, slots=True, eq=False)
class Keyframe:
    """A scan that stays in the map."""

    scan: Scan
    points: Array
    """In the robot's frame, shape (n, 2) [m]."""
    surface: Surface
    """In the robot's frame."""


class LidarSlam:
    """Estimates the pose from odometry and a lidar, and keeps a graph of poses whose scans are the map.

    A scan becomes part of the map when the robot has moved far enough. It is laid on the last few by a point-to-line
    ICP that starts from odometry and weighs it; when the robot is near a place that it knew long ago, the scan is
    searched for there, and if it fits, the graph gets a step that closes the loop and is solved again.

    References:
        Lu, Milios, Globally Consistent Range Scan Alignment for Environment Mapping, Autonomous Robots 4, 1997.
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
    ) -> None:
        """Set the rules.

        Args:
            lidar: Name of the lidar; None for the first.
            distance: How far the robot drives between two scans of the map [m].
            turn_deg: Or how far it turns.
            loop_distance: How near an old scan must be to be tried for a loop [m].
            loop_share: Share of a scan's points that must lie on old walls for a loop to count.
            odometry_scale: Factor on the standard deviation of odometry, for slip that its data sheet leaves out.
        """
        self._lidar = lidar
        self._distance, self._turn = distance, np.radians(turn_deg)
        self._loop_distance, self._loop_share = loop_distance, loop_share
        self._scale = odometry_scale
        self.keyframes: list[Keyframe] = []
        self.graph = PoseGraph(np.zeros((0, 3)))
        self.loops = 0
        self._step: Array = np.zeros(3)
        self._step_covariance: Array = np.zeros((3, 3))

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map.

        Raises:
            ValueError: The robot has no such lidar.
        """
        self._name, self._robot_from_lidar = lidar_of(robot, self._lidar)
        self._motion = odometry_motion()
        self._prior, self._prior_covariance = robot.prior.as_array(), np.asarray(robot.prior_covariance, dtype=float)
        self.keyframes, self.graph, self.loops = [], PoseGraph(np.zeros((0, 3))), 0
        self._covariance = self._prior_covariance
        self._closed = 0
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and, when the robot has moved, its scan."""
        moved = np.array([seen.odometry.forward, seen.odometry.left, seen.odometry.turn])
        self._step, F, G = self._motion(self._step, moved)
        covariance = seen.odometry.covariance * self._scale**2
        self._step_covariance = F @ self._step_covariance @ F.T + G @ covariance @ G.T
        far = np.hypot(*self._step[:2]) > self._distance or abs(self._step[2]) > self._turn
        if self._name in seen.scans and (far or not self.keyframes):
            self._extend(seen.scans[self._name])
        return self._belief()

    def grid(self, **keys: float) -> OccupancyGrid:
        """Return the map as a grid of odds; the keys are those of `OccupancyGrid`."""
        grid = OccupancyGrid(**keys)
        for pose, keyframe in zip(self.graph.poses, self.keyframes, strict=True):
            grid.add(Pose.from_array(pose) @ self._robot_from_lidar, keyframe.scan)
        return grid

    def _extend(self, scan: Scan) -> None:
        """Add a scan to the map: lay it on the last ones, then look for a loop."""
        points = self._robot_from_lidar.transform(scan.points())
        keyframe = Keyframe(scan, points, surface_of(points))
        if not self.keyframes:
            pose, _, _ = self._motion(self._prior, self._step)
            self.graph.add_pose(pose)
        else:
            last = len(self.keyframes) - 1
            match = self._laid(keyframe, range(max(0, last - LOCAL + 1), last + 1), last)
            pose, F, G = self._motion(self.graph.poses[last], match.pose)
            self.graph.add_pose(pose)
            self.graph.add_step(last, last + 1, match.pose, match.information)
            spread = np.asarray(np.linalg.inv(match.information), dtype=float)
            self._covariance = F @ self._covariance @ F.T + G @ spread @ G.T
        self.keyframes.append(keyframe)
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))
        self._close_loop()

    def _laid(self, keyframe: Keyframe, numbers: range, base: int) -> Match:
        """Return where a new scan lies in the frame of the last pose, among scans of the map."""
        information = np.linalg.inv(self._step_covariance + np.diag([1e-4, 1e-4, 1e-5]) ** 2)
        surface = self._surface(numbers, base)
        if len(surface.points) < 20 or len(keyframe.points) < 20:
            return Match(self._step, np.asarray(information, dtype=float), 0.0)
        return align(surface, keyframe.points, self._step, np.asarray(information, dtype=float))

    def _surface(self, numbers: range, base: int) -> Surface:
        """Return the walls of some scans in the frame of one of them."""
        poses = step_between(self.graph.poses[base], self.graph.poses[numbers.start : numbers.stop])
        return joined([self.keyframes[i].surface.moved(pose) for i, pose in zip(numbers, poses, strict=True)])

    def _close_loop(self) -> None:
        """Match the newest scan with those of long ago, and solve the graph again if one fits."""
        newest = len(self.keyframes) - 1
        old = newest - 5 * LOCAL
        if old < 1 or newest < self._closed + LOCAL:
            return
        pose = self.graph.poses[newest]
        apart = np.hypot(*(self.graph.poses[:old, :2] - pose[:2]).T)
        turned = np.abs(wrap_angles(self.graph.poses[:old, 2] - pose[2]))
        near = int(np.argmin(apart + 0.3 * turned))
        if apart[near] > self._loop_distance:
            return
        surface = self._surface(range(max(0, near - AROUND), min(old, near + AROUND + 1)), near)
        keyframe = self.keyframes[newest]
        if len(surface.points) < 60 or len(keyframe.points) < 60:
            return
        guess = search(surface, keyframe.points, step_between(self.graph.poses[near], pose))
        match = align(surface, keyframe.points, guess, np.diag([1.0, 1.0, 10.0]))
        if match.share < self._loop_share:
            return
        self.graph.add_step(near, newest, match.pose, match.information)
        self.graph.solve()
        # The graph holds its first pose; how unsure that one is turns and shifts all.
        by_first = carried(self.graph.poses[newest], self.graph.poses[0])
        self._covariance = self.graph.covariance(newest) + by_first @ self._prior_covariance @ by_first.T
        self._closed, self.loops = newest, self.loops + 1

    def _belief(self) -> Estimate:
        """Return the newest pose of the graph carried on by odometry."""
        base = self.graph.poses[-1] if self.keyframes else self._prior
        pose, F, G = self._motion(base, self._step)
        covariance = F @ self._covariance @ F.T + G @ self._step_covariance @ G.T
        return Estimate(Pose.from_array(pose), covariance)
