"""Graph SLAM: smooths the whole trajectory with all sightings.

gtsam's iSAM2 solves the graph a little further at each new pose. It is not among what mjsim needs:
`pip install gtsam`.
"""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .ekf_models import landmark_from, odometry_motion
from .graph_refinement import Leg, MeasuredGraph, refined_poses, turned_covariance
from .odometry_errors import COUNT, OdometryErrors

HUBER = 1.345
"""Beyond so many standard deviations an error counts less than its square: 95 % efficient on clean data (Huber)."""

FLOOR = 1e-3
"""Least standard deviation of the place of a robot that turns by one radian [m/sqrt(rad)]. Odometry that claims to be
exact along a direction makes a graph that cannot be solved; no robot turns about a point of no size."""


class GraphSlam:
    """Estimates the pose and a map of named beacons by incremental smoothing.

    A pose enters the graph when something is seen and the robot has moved far enough since the last one. Sightings
    have a robust loss, so that a wrong one pulls with a bounded force. The final path is that of the whole graph,
    solved again with the systematic errors of odometry and the noise of sightings that it shows.

    References:
        Kaess et al., iSAM2: Incremental Smoothing and Mapping Using the Bayes Tree, IJRR 31(2), 2012. Grisetti et
        al., A Tutorial on Graph-Based SLAM, IEEE ITS Magazine 2(4), 2010.
    """

    def __init__(
        self, *, distance: float = 0.15, turn_deg: float = 8.0, sighting_scale: float = 1.0, systematic: float = 1.0
    ) -> None:
        """Set the rules.

        Args:
            distance: How far the robot drives between two poses of the graph [m].
            turn_deg: Or how far it turns.
            sighting_scale: Factor on the standard deviation of sightings.
            systematic: Way over which systematic errors of odometry are taken to make as much as the noise that it
                claims [m], for the final path; infinite: there are none.

        Raises:
            ImportError: gtsam is not installed.
        """
        try:
            import gtsam
        except ImportError:
            raise ImportError("GraphSlam needs gtsam, which is not installed; type: pip install gtsam") from None
        self._gtsam: Any = gtsam
        self._distance, self._turn = distance, np.radians(turn_deg)
        self._scale, self._systematic = sighting_scale, systematic
        self._step: Array = np.zeros(3)
        self._step_covariance: Array = np.zeros((3, 3))
        self._slopes: Array = np.zeros((3, COUNT))

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin the graph with the robot's prior."""
        gtsam = self._gtsam
        self._solver = gtsam.ISAM2(gtsam.ISAM2Params())
        self._motion = odometry_motion()
        self._names: dict[str, int] = {}
        self._number = 0
        self._steps: list[tuple[float, int, Array, Array]] = []
        self._legs: list[Leg] = []
        self._looks: list[tuple[int, Sighting]] = []
        self._odometry_errors, self._doubt = OdometryErrors(self._systematic), np.zeros(COUNT)
        self._pose = robot.prior.as_array()
        # A pose known exactly has no square root of its information.
        spread = np.asarray(robot.prior_covariance, dtype=float) + 1e-10 * np.eye(3)
        graph, first = gtsam.NonlinearFactorGraph(), gtsam.Values()
        noise = gtsam.noiseModel.Gaussian.Covariance(turned_covariance(spread, -self._pose[2]))
        graph.add(gtsam.PriorFactorPose2(self._key(), gtsam.Pose2(*self._pose), noise))
        first.insert(self._key(), gtsam.Pose2(*self._pose))
        self._solver.update(graph, first)
        self._covariance = self._first_covariance = spread
        self._map: dict[Hashable, tuple[Array, Array]] = {}
        self._forget_step()

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = np.array([seen.odometry.forward, seen.odometry.left, seen.odometry.turn])
        self._step, F, G = self._motion(self._step, moved)
        floor = np.diag([1.0, 1.0, 0.0]) * FLOOR**2 * abs(seen.odometry.turn)
        _, slopes, gained = self._odometry_errors.step(seen.odometry, seen.odometry.covariance, seen.dt)
        self._slopes, self._doubt = F @ self._slopes + G @ slopes, self._doubt + gained
        self._step_covariance = F @ self._step_covariance @ F.T + G @ seen.odometry.covariance @ G.T + floor
        far = np.hypot(*self._step[:2]) > self._distance or abs(self._step[2]) > self._turn
        named = [sighting for sighting in seen.sightings if sighting.name is not None]
        if named and (far or not self._names):
            self._extend(named)
        self._steps.append((seen.time, self._number, self._step, self._slopes))
        return self._belief()

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return the final trajectory: time [s] and pose of each tick, by the whole graph solved again."""
        drive = self._measured_graph()
        poses, errors = refined_poses(self._gtsam, drive)
        found = []
        for time, number, step, slopes in self._steps:
            pose, _, _ = self._motion(poses[number], step + slopes @ errors)
            found.append((time, Pose.from_array(pose)))
        return found

    def _measured_graph(self) -> MeasuredGraph:
        """Return what was measured, and where the solver has poses and landmarks."""
        values, symbol = self._solver.calculateEstimate(), self._gtsam.symbol
        poses = [values.atPose2(symbol("x", number)) for number in range(self._number + 1)]
        return MeasuredGraph(
            poses=np.array([(pose.x(), pose.y(), pose.theta()) for pose in poses]),
            landmarks={name: np.asarray(values.atPoint2(key)) for name, key in self._names.items()},
            first_covariance=self._first_covariance,
            legs=self._legs,
            looks=self._looks,
            doubt=self._doubt,
        )

    def _extend(self, sightings: list[Sighting]) -> None:
        """Add a pose and what is seen from it, and solve."""
        gtsam = self._gtsam
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        before = self._key()
        self._number += 1
        spread = self._step_covariance + 1e-12 * np.eye(3)
        self._legs.append(Leg(self._step, spread, self._slopes))
        noise = gtsam.noiseModel.Gaussian.Covariance(turned_covariance(spread, -self._step[2]))
        graph.add(gtsam.BetweenFactorPose2(before, self._key(), gtsam.Pose2(*self._step), noise))
        pose, _, _ = self._motion(self._pose, self._step)
        values.insert(self._key(), gtsam.Pose2(*pose))
        for sighting in sightings:
            name = sighting.name or ""
            if name not in self._names:
                self._names[name] = gtsam.symbol("l", len(self._names))
                values.insert(self._names[name], landmark_from(pose, np.array([sighting.range, sighting.bearing]))[0])
            graph.add(self._factor(sighting))
            self._looks.append((self._number, sighting))
        self._solver.update(graph, values)
        self._read()
        self._forget_step()

    def _factor(self, sighting: Sighting) -> Any:
        """Return the factor of one sighting; gtsam has the bearing before the range."""
        gtsam = self._gtsam
        covariance = np.asarray(sighting.covariance)[::-1, ::-1] * self._scale**2
        robust = gtsam.noiseModel.Robust.Create(
            gtsam.noiseModel.mEstimator.Huber.Create(HUBER), gtsam.noiseModel.Gaussian.Covariance(covariance)
        )
        key, bearing = self._names[sighting.name or ""], gtsam.Rot2(sighting.bearing)
        return gtsam.BearingRangeFactor2D(self._key(), key, bearing, sighting.range, robust)

    def _read(self) -> None:
        """Take pose and map out of the solver."""
        values = self._solver.calculateEstimate()
        pose = values.atPose2(self._key())
        self._pose = np.array([pose.x(), pose.y(), pose.theta()])
        # The covariance of a pose is given in the pose's own axes.
        self._covariance = turned_covariance(self._solver.marginalCovariance(self._key()), self._pose[2])
        self._map = {
            name: (np.asarray(values.atPoint2(key)), np.asarray(self._solver.marginalCovariance(key)))
            for name, key in self._names.items()
        }

    def _belief(self) -> Estimate:
        """Return the last pose of the graph carried on by odometry, and the map."""
        pose, F, G = self._motion(self._pose, self._step)
        covariance = F @ self._covariance @ F.T + G @ self._step_covariance @ G.T
        return Estimate(Pose.from_array(pose), covariance, dict(self._map))

    def _forget_step(self) -> None:
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))
        self._slopes = np.zeros((3, COUNT))

    def _key(self) -> int:
        return int(self._gtsam.symbol("x", self._number))
