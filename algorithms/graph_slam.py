"""Graph SLAM: smooths the whole trajectory with all sightings.

gtsam's iSAM2 updates the solution of the graph at each new pose. gtsam is optional: `pip install gtsam`.
"""

from collections.abc import Hashable, Iterator, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .ekf_models import landmark_from, odometry_motion
from .graph_factors import leg_factor, look_factor, prior_factor, turned_covariance
from .graph_refinement import Leg, MeasuredGraph, refined_poses
from .held_frame import HeldFrame
from .look_checks import Look, LookChecks
from .odometry_errors import COUNT, OdometryErrors
from .recent_motion import RecentMotion

HUBER = 1.345
"""Scale of Huber's loss in standard deviations: 95 % efficient on clean data."""

FLOOR = 1e-3
"""Minimum standard deviation of the position of a robot that turns by one radian [m/sqrt(rad)]. With odometry that is
exact along a direction, the graph could not be solved."""
SOFT = 1e-9
"""Added to the variances of a leg between two poses, which may be tiny, and of the first pose, which may be zero: 0.03
mm and 0.002 degrees."""
RELINEARISED = 0.01
"""A pose or landmark whose solution has moved by more is linearised again [m, rad]. With ten times that, gtsam's
default, a corridor of 14 m bends by 0.1 m more."""
GROWN = 1.2
"""The prior of the systematic errors is replaced when their variances have grown by this factor."""


class GraphSlam:
    """Estimates the pose and a map of named beacons by incremental smoothing.

    A pose is added to the graph when something is seen and the robot has moved far enough since the last one. The graph
    also contains the systematic errors of odometry. Sightings have a robust loss, which bounds the influence of wrong
    ones. The final path is that of the whole graph, solved again with the estimated systematic errors of odometry and
    noise of sightings.

    References:
        Kaess et al., iSAM2: Incremental Smoothing and Mapping Using the Bayes Tree, IJRR 31(2), 2012. Grisetti et
        al., A Tutorial on Graph-Based SLAM, IEEE ITS Magazine 2(4), 2010.
    """

    def __init__(
        self,
        *,
        distance: float = 0.05,
        turn_deg: float = 3.0,
        sighting_scale: float = 1.0,
        systematic: float = 1.0,
        frame: Literal["map", "start"] = "map",
    ) -> None:
        """Set the rules.

        Args:
            distance: Distance between two poses of the graph [m].
            turn_deg: Or turn between them.
            sighting_scale: Factor on the standard deviation of sightings.
            systematic: Distance over which systematic errors of odometry are assumed to equal its noise [m]; infinite
                for none.
            frame: What stays fixed if the rotation of the map relative to the start is corrected later: 'map' for the
                published map and path, 'start' for the first pose (`held_frame`). The final path is in the frame of the
                start.

        Raises:
            ImportError: gtsam is not installed.
        """
        if frame not in ("map", "start"):
            raise ValueError(f"frame is {frame!r}; it must be map or start")
        try:
            import gtsam
        except ImportError:
            raise ImportError("GraphSlam needs gtsam, which is not installed; type: pip install gtsam") from None
        self._gtsam: Any = gtsam
        self._distance, self._turn = distance, np.radians(turn_deg)
        self._scale, self._systematic, self._held = sighting_scale, systematic, frame == "map"
        self._step: Array = np.zeros(3)
        self._step_covariance: Array = np.zeros((3, 3))
        self._slopes: Array = np.zeros((3, COUNT))

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Start the graph with the robot's prior."""
        gtsam = self._gtsam
        parameters = gtsam.ISAM2Params()
        parameters.setRelinearizeThreshold(RELINEARISED)
        parameters.setFactorization("QR")  # Legs of a robot that hardly moves are hundred times as stiff as sightings.
        self._solver = gtsam.ISAM2(parameters)
        self._common = gtsam.symbol("e", 0)
        self._motion = odometry_motion()
        self._recent = RecentMotion()
        self._checks = LookChecks()
        self._names: dict[str, int] = {}
        self._places: dict[str, Array] = {}
        self._landmarks = 0
        self._number = 0
        self._steps: list[tuple[float, int, Array, Array]] = []
        self._legs: list[Leg] = []
        self._looks: list[tuple[int, Sighting]] = []
        self._odometry_errors, self._doubt = OdometryErrors(self._systematic), np.zeros(COUNT)
        self._told_doubt, self._doubt_factor = np.zeros(COUNT), -1
        self._errors, self._error_covariance = np.zeros(COUNT), np.zeros((COUNT, COUNT))
        self._pose = robot.prior.as_array()
        self._poses = self._pose[None]
        self._frame = HeldFrame(self._pose)
        # A pose known exactly has no square root of its information.
        spread = np.asarray(robot.prior_covariance, dtype=float) + SOFT * np.eye(3)
        graph, first = gtsam.NonlinearFactorGraph(), gtsam.Values()
        graph.add(prior_factor(gtsam, self._key(), self._pose, spread))
        first.insert(self._key(), gtsam.Pose2(*self._pose))
        first.insert(self._common, self._errors)
        self._solver.update(graph, first)
        self._covariance = self._first_covariance = spread
        self._map: dict[Hashable, tuple[Array, Array]] = {}
        self._forget_step()

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        control, slopes, gained = self._odometry_errors.step(
            moved, moved.covariance, seen.dt, delay=float(self._errors[3])
        )
        self._recent.move(moved, seen.time)
        self._step, F, G = self._motion(self._step, control)
        floor = np.diag([1.0, 1.0, 0.0]) * FLOOR**2 * abs(moved.turn)
        self._slopes, self._doubt = F @ self._slopes + G @ slopes, self._doubt + gained
        self._step_covariance = F @ self._step_covariance @ F.T + G @ moved.covariance @ G.T + floor
        step = self._mended_step()
        far = np.hypot(*step[:2]) > self._distance or abs(step[2]) > self._turn
        named = [self._recent.to_now(sighting) for sighting in seen.sightings if sighting.name is not None]
        if named and (far or not self._names):
            self._extend(named, seen.time)
        self._steps.append((seen.time, self._number, self._step, self._slopes))
        return self._belief()

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return the final trajectory: time [s] and pose of each tick, from solving the whole graph again."""
        drive = self._measured_graph()
        poses, errors = refined_poses(self._gtsam, drive)
        found = []
        for time, number, step, slopes in self._steps:
            pose, _, _ = self._motion(poses[number], step + slopes @ errors)
            found.append((time, Pose.from_array(pose)))
        return found

    def _measured_graph(self) -> MeasuredGraph:
        """Return the measurements, and the solver's poses and landmarks."""
        return MeasuredGraph(
            poses=self._poses,
            landmarks=dict(self._places),
            first_covariance=self._first_covariance,
            legs=self._legs,
            looks=self._looks,
            doubt=self._doubt,
        )

    def _extend(self, sightings: list[Sighting], time: float) -> None:
        """Add a pose and its sightings, and solve."""
        gtsam = self._gtsam
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        pose, F, G = self._motion(self._pose, self._mended_step())
        before = self._key()
        self._number += 1
        spread = self._step_covariance + SOFT * np.eye(3)
        self._legs.append(Leg(self._step, spread, self._slopes))
        keys = (before, self._key(), self._common)
        graph.add(leg_factor(gtsam, keys, self._step, spread, self._slopes))
        values.insert(self._key(), gtsam.Pose2(*pose))
        self._poses = np.concatenate([self._poses, pose[None]])
        self._checks.move(F, G @ (spread + self._slopes @ self._error_covariance @ self._slopes.T) @ G.T)
        for look in self._believed(sightings, time):
            graph.add(self._look_factor(look, values))
        self._solve(graph, values)
        self._read()
        self._forget_step()

    def _believed(self, sightings: list[Sighting], time: float) -> Iterator[Look]:
        """Yield the accepted looks: those from the newest pose, and earlier ones that have been waiting."""
        for sighting in sightings:
            name = sighting.name or ""
            if name not in self._names:
                self._checks.begin(name)
                yield self._number, sighting
            elif self._checks.agrees(self._poses[-1], self._places[name], sighting):
                yield self._number, sighting
            elif looks := self._checks.wait(self._number, sighting, self._recent, time):
                if self._checks.is_young(name):
                    # Its first look was wrong: that stays with a landmark of which nobody hears any more.
                    self._checks.begin(name)
                    del self._names[name]
                    self._looks = [look for look in self._looks if look[1].name != name]
                yield from looks

    def _look_factor(self, look: Look, values: Any) -> Any:
        """Return the factor of a look; a new landmark is added to the values."""
        gtsam, (number, sighting) = self._gtsam, look
        name = sighting.name or ""
        if name not in self._names:
            self._names[name] = gtsam.symbol("l", self._landmarks)
            self._landmarks += 1
            measured = np.array([sighting.range, sighting.bearing])
            self._places[name], _ = landmark_from(self._poses[number], measured)
            values.insert(self._names[name], self._places[name])
        self._looks.append(look)
        loss = gtsam.noiseModel.mEstimator.Huber.Create(HUBER)
        keys = gtsam.symbol("x", number), self._names[name]
        return look_factor(gtsam, keys, sighting, sighting.covariance * self._scale**2, loss)

    def _solve(self, graph: Any, values: Any) -> None:
        """Add new factors and values, and replace the prior of the systematic errors if it has changed."""
        gtsam, outdated = self._gtsam, []
        changed = self._doubt_factor < 0 or bool(np.any(self._doubt > GROWN * self._told_doubt))
        if changed:
            if self._doubt_factor >= 0:
                outdated = [self._doubt_factor]
            self._told_doubt = self._doubt
            noise = gtsam.noiseModel.Diagonal.Variances(self._doubt + SOFT)
            graph.add(gtsam.PriorFactorVector(self._common, np.zeros(COUNT), noise))
        result = self._solver.update(graph, values, outdated)
        if changed:
            self._doubt_factor = result.getNewFactorsIndices()[graph.size() - 1]

    def _read(self) -> None:
        """Read pose, map and systematic errors from the solver."""
        gtsam, values = self._gtsam, self._solver.calculateEstimate()
        # They stand in the order of their numbers.
        self._poses = gtsam.utilities.extractPose2(values)
        self._pose = self._poses[-1]
        # The covariance of a pose is given in the pose's own axes.
        self._covariance = turned_covariance(self._solver.marginalCovariance(self._key()), self._pose[2])
        self._errors = np.asarray(values.atVector(self._common))
        self._error_covariance = np.asarray(self._solver.marginalCovariance(self._common))
        if self._held:
            self._frame.add(self._poses, float(np.sqrt(self._covariance[2, 2])))
        self._places = {name: np.asarray(values.atPoint2(key)) for name, key in self._names.items()}
        self._map = {
            name: self._frame.landmark(place, self._solver.marginalCovariance(self._names[name]))
            for name, place in self._places.items()
        }

    def _belief(self) -> Estimate:
        """Return the last pose of the graph, propagated by odometry, and the map."""
        pose, F, G = self._motion(self._frame.pose(self._pose), self._mended_step())
        own = self._step_covariance + self._slopes @ self._error_covariance @ self._slopes.T
        covariance = F @ self._frame.pose_covariance(self._pose, self._covariance) @ F.T + G @ own @ G.T
        return Estimate(Pose.from_array(pose), covariance, dict(self._map))

    def _mended_step(self) -> Array:
        """Return the step since the last pose, corrected for the systematic errors of odometry, shape (3,)."""
        return np.asarray(self._step + self._slopes @ self._errors)

    def _forget_step(self) -> None:
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))
        self._slopes = np.zeros((3, COUNT))

    def _key(self) -> int:
        return int(self._gtsam.symbol("x", self._number))
