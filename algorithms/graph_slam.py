"""Graph SLAM: smooths the whole trajectory with all sightings.

gtsam's iSAM2 updates the solution of the graph at each new pose. gtsam is optional: `pip install gtsam`.
"""

import math
from collections.abc import Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .estimation.constant_errors import LARGE_SENSOR
from .estimation.ekf_models import landmark_from, odometry_motion
from .estimation.graph_errors import MOTION, GraphErrors
from .estimation.graph_factors import (
    HUBER,
    PoseSightings,
    leg_factor,
    pose_factor,
    prior_factor,
    shared_sighting_factor,
    sighting_factor,
    turned_covariance,
)
from .estimation.graph_refinement import Displacement, Leg, MeasuredGraph, moved_path, refined_poses, sound_sightings
from .estimation.held_frame import HeldFrame
from .estimation.look_checks import GATE, LookChecks, PosedSighting
from .estimation.pose_graph import compose
from .estimation.range_errors import RANGE_ERRORS
from .estimation.recent_motion import RecentMotion
from .estimation.relocation import ANYWHERE, Relocation
from .estimation.rough_odometry import ROUGH, RoughOdometry
from .picture_errors import PictureErrors, each_of

FLOOR = 1e-3
"""Minimum standard deviation of the position of a robot that turns by one radian [m/sqrt(rad)]. With odometry that is
exact along a direction, the graph could not be solved."""
SOFT = 1e-9
"""Added to the variances of a leg between two poses, which may be tiny, and of the first pose, which may be zero: 0.03
mm and 0.002 degrees."""
RELINEARISED = 0.01
"""A pose or landmark whose solution has moved by more than this is linearised again [m, rad]. With ten times that,
gtsam's default, a corridor of 14 m bends by 0.1 m more."""


class GraphSlam:
    """Estimates the pose and a map of named beacons by incremental smoothing.

    A pose is added to the graph when a new landmark is seen, or when any is seen and the robot has moved far enough.
    The graph
    also contains the systematic errors of odometry and, where ranges scatter by less than their stated noise, those of
    ranges. Sightings have a robust loss, which bounds the influence of wrong ones. The final path is that of the whole
    graph, solved again with the estimated systematic errors, noise of sightings and displacements of the robot
    (`graph_refinement`). It cannot tell whether all ranges are too long or all distances of odometry too short.

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
        nod_deg: float = 0.15,
        repeat: float = 0.5,
        frame: Literal["map", "start"] = "map",
    ) -> None:
        """Set the rules.

        Args:
            distance: Distance between two poses of the graph [m].
            turn_deg: Or turn between them.
            sighting_scale: Factor on the standard deviation of sightings.
            systematic: Distance over which systematic errors of odometry are assumed to equal its noise [m]; infinite
                for none, also of ranges.
            nod_deg: Pitch and roll of the robot at constant speed, standard deviation; they shift all sightings of one
                picture.
            repeat: Correlated part of the variance of a camera's sightings from image to image (0 to 1), times the
                distance over which it is correlated [m].
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
        self._nod, self._repeat = math.radians(nod_deg), repeat
        self._step: Array = np.zeros(3)
        self._step_covariance: Array = np.zeros((3, 3))
        self._slopes: Array = np.zeros((3, MOTION))

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Start the graph with the robot's prior."""
        gtsam = self._gtsam
        parameters = gtsam.ISAM2Params()
        parameters.setRelinearizeThreshold(_thresholds(gtsam))
        parameters.setFactorization("QR")  # Short legs are a hundred times as stiff as sightings.
        self._solver = gtsam.ISAM2(parameters)
        self._motion = odometry_motion()
        self._recent = RecentMotion()
        self._picture_errors = PictureErrors(robot, nod=self._nod, repeat=self._repeat)
        self._checks, self._relocation = LookChecks(), Relocation()
        self._roughness, self._stated = RoughOdometry(), np.zeros((3, 3))
        self._names: dict[str, int] = {}
        self._places: dict[str, Array] = {}
        self._landmarks = 0
        self._number = 0
        self._steps: list[tuple[float, int, Array, Array]] = []
        self._legs: list[Leg] = []
        self._sightings: list[tuple[int, Sighting]] = []
        self._failing: list[tuple[int, Sighting]] = []  # since one agreed, by tick
        self._displacements: list[Displacement] = []
        self._errors = GraphErrors(gtsam, length=self._systematic, scale=self._scale)
        self._pose = self._believed_pose = robot.prior.as_array()
        self._poses = self._pose[None]
        self._frame = HeldFrame(self._pose)
        # A pose known exactly has no square root of its information.
        covariance = np.asarray(robot.prior_covariance, dtype=float) + SOFT * np.eye(3)
        graph, first = gtsam.NonlinearFactorGraph(), gtsam.Values()
        graph.add(prior_factor(gtsam, self._key(), self._pose, covariance))
        first.insert(self._key(), gtsam.Pose2(*self._pose))
        motion, sensor = self._errors.keys
        first.insert(motion, np.zeros(MOTION))
        if self._errors.possible:
            first.insert(sensor, np.zeros(len(self._errors.mean) - MOTION))
        self._solver.update(graph, first)
        self._covariance = self._first_covariance = covariance
        self._map: dict[Hashable, tuple[Array, Array]] = {}
        self._forget_step()

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        control, slopes = self._errors.step(moved, seen.dt)
        self._recent.move(moved, seen.time)
        self._step, F, G = self._motion(self._step, control)
        floor = np.diag([1.0, 1.0, 0.0]) * FLOOR**2 * abs(moved.turn)
        self._slopes = F @ self._slopes + G @ slopes
        self._stated = F @ self._stated @ F.T + G @ moved.covariance @ G.T + floor
        stated = moved.covariance * (ROUGH if self._roughness.odds > 1.0 else 1.0)
        self._step_covariance = F @ self._step_covariance @ F.T + G @ stated @ G.T + floor
        named_sightings = [sighting for sighting in seen.sightings if sighting.name is not None]
        self._errors.see(named_sightings, self._recent)
        named = [self._recent.to_now(each) for each in named_sightings]
        self._doubt(named)
        if self._relocation.lost:
            named = self._relocate(seen.time)
        step = self._mended_step()
        far = np.hypot(*step[:2]) > self._distance or abs(step[2]) > self._turn
        # In a turn, the sighting in which a landmark appears may be the only one that connects it with those before it.
        used = named if far or any(each.name not in self._names for each in named) else []
        self._picture_errors.move(moved, used)
        if used:
            covariances = each_of(self._picture_errors.covariance(used, scale=1.0))
            used = [replace(each, covariance=R) for each, R in zip(used, covariances, strict=True)]
            self._extend(used, seen.time)
        self._steps.append((seen.time, self._number, self._step, self._slopes))
        return self._relocation.reported(self._belief(), seen)

    def lost(self) -> bool:
        """Return whether nearly all recent sightings contradict the map, or expected sightings are missing."""
        return self._relocation.doubted

    def _doubt(self, sightings: list[Sighting]) -> None:
        """Record how well sightings of the map fit the pose of the robot."""
        pose, _, G = self._motion(self._pose, self._mended_step())
        moved = G @ self._step_covariance @ G.T
        for sighting in sightings:
            name = sighting.name or ""
            if name in self._names and not self._checks.is_young(name):
                distance = self._checks.distance(pose, self._places[name], self._errors.mended(sighting), moved=moved)
                was_lost = self._relocation.lost
                self._relocation.record(name, sighting, distance, gate=GATE)
                if distance < GATE and not was_lost:
                    self._failing.clear()
                else:
                    self._failing.append((len(self._steps), sighting))

    def _relocate(self, time: float) -> list[Sighting]:
        """Return sightings by which a lost robot is relocalized, after the step to its pose; none until there are any.

        The step of odometry since the last pose is replaced by an unknown one.
        """
        found = self._relocation.find(self._recent, time, self._places, corrected=self._errors.mended)
        if found is None:
            return []
        self._displace()
        self._step = (Pose.from_array(self._pose).inverse() @ Pose.from_array(found.pose)).as_array()
        self._step_covariance, self._slopes = np.diag(ANYWHERE) ** 2, np.zeros((3, MOTION))
        return list(found.sightings.values())

    def _displace(self) -> None:
        """Record that the robot was displaced: what it has seen since sightings began to fail is from elsewhere."""
        end = len(self._steps)
        failing = [(tick, self._errors.mended(sighting)) for tick, sighting in self._failing if tick < end]
        self._failing.clear()
        if failing:
            self._displacements.append(Displacement(end, self._number, self._step, self._slopes, failing))
            begin = self._steps[max(failing[0][0] - 1, 0)][1] + 1
            self._sightings = sound_sightings(self._sightings, begin, {sighting.name for _, sighting in failing})

    @property
    def range_errors(self) -> tuple[Array, Array]:
        """Offset [m] and relative error of ranges within the data sheet, (2,), with covariance; (0,) without errors."""
        if not (self._errors.possible and self._names):
            return np.zeros(0), np.zeros((0, 0))
        ranges = slice(MOTION, MOTION + RANGE_ERRORS)
        mean, covariance = self._errors.usual
        return mean[ranges], covariance[ranges, ranges]

    def path(self) -> Sequence[tuple[float, Pose]]:
        """Return the final trajectory: time [s] and pose of each tick, from solving the whole graph again."""
        drive = self._measured_graph()
        poses, errors = refined_poses(self._gtsam, drive)
        path = np.array([self._motion(poses[n], step + slopes @ errors)[0] for _, n, step, slopes in self._steps])
        for each in self._displacements:
            expected, _, _ = self._motion(poses[each.pose], each.step + each.slopes @ errors)
            path = moved_path(path, expected, each, self._places)
        return [(time, Pose.from_array(pose)) for (time, *_), pose in zip(self._steps, path, strict=True)]

    def _measured_graph(self) -> MeasuredGraph:
        """Return the measurements, and the solver's poses and landmarks."""
        return MeasuredGraph(
            poses=self._poses,
            landmarks=dict(self._places),
            first_covariance=self._first_covariance,
            legs=self._legs,
            sightings=[(row, self._errors.mended(each, self._errors.chosen)) for row, each in self._sightings],
            systematic_variances=self._errors.variances[:MOTION],
        )

    def _extend(self, sightings: list[Sighting], time: float) -> None:
        """Add a pose and its sightings, and solve."""
        gtsam = self._gtsam
        graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
        pose, F, G = self._motion(self._pose, self._mended_step())
        before = self._key()
        self._number += 1
        covariance = self._step_covariance + SOFT * np.eye(3)
        self._legs.append(Leg(self._step, covariance, self._slopes))
        values.insert(self._key(), gtsam.Pose2(*pose))
        self._poses = np.concatenate([self._poses, pose[None]])
        self._checks.move(F, G @ (covariance + self._slopes_covariance()) @ G.T)
        self._roughness.move(F, G @ self._stated @ G.T)
        for sighting in sightings:
            if (name := sighting.name or "") in self._names and not self._checks.is_young(name):
                self._roughness.see(pose, self._places[name], self._errors.mended(sighting))
        placed = [(self._place_key(posed, values), *posed) for posed in self._believed(sightings, time)]
        keys = before, self._key(), self._errors.keys[0]
        self._add_factors(graph, keys, (self._step, covariance, self._slopes), placed)
        self._solve(graph, values)
        self._read()
        self._forget_step()

    def _believed(self, sightings: list[Sighting], time: float) -> Iterator[PosedSighting]:
        """Yield the accepted sightings: those from the newest pose, and earlier ones that have been waiting."""
        for sighting in sightings:
            name = sighting.name or ""
            if name not in self._names:
                self._checks.begin(name)
                yield self._number, sighting
            elif self._checks.agrees(self._poses[-1], self._places[name], self._errors.mended(sighting)):
                yield self._number, sighting
            elif agreeing := self._checks.wait(self._number, sighting, self._recent, time):
                if self._checks.is_young(name):
                    # Its first sighting was wrong: leave it to a landmark that is never seen again.
                    self._checks.begin(name)
                    del self._names[name]
                    self._sightings = [posed for posed in self._sightings if posed[1].name != name]
                yield from agreeing

    def _place_key(self, posed: PosedSighting, values: Any) -> int:
        """Return the key of the landmark of a sighting; a new landmark is added to the values."""
        gtsam, (number, sighting) = self._gtsam, posed
        name = sighting.name or ""
        if name not in self._names:
            self._names[name] = gtsam.symbol("l", self._landmarks)
            self._landmarks += 1
            mended = self._errors.mended(sighting)
            self._places[name], _ = landmark_from(self._poses[number], np.array([mended.range, mended.bearing]))
            values.insert(self._names[name], self._places[name])
        self._sightings.append(posed)
        return self._names[name]

    def _add_factors(
        self,
        graph: Any,
        keys: tuple[int, int, int],
        leg: tuple[Array, Array, Array],
        placed: list[tuple[int, int, Sighting]],
    ) -> None:
        """Add the factors of odometry to the newest pose and of sightings.

        Args:
            graph: Graph to which they are added.
            keys: Keys of the pose before, the newest pose and the systematic errors of odometry.
            leg: Step of odometry between both, its covariance and its slopes.
            placed: Key of the landmark, number of the pose and sighting of each.
        """
        gtsam, sensor = self._gtsam, self._errors.keys[1]
        loss = gtsam.noiseModel.mEstimator.Huber.Create(HUBER)
        newest = [(place, seen) for place, number, seen in placed if self._errors.possible and number == self._number]
        if newest:
            covariances = [sighting.covariance * self._scale**2 for _, sighting in newest]
            places, sightings = [place for place, _ in newest], [sighting for _, sighting in newest]
            graph.add(pose_factor(gtsam, keys, leg, PoseSightings(sensor, places, sightings, covariances)))
        else:
            graph.add(leg_factor(gtsam, keys, *leg))
        for place, number, sighting in placed:
            at, covariance = gtsam.symbol("x", number), sighting.covariance * self._scale**2
            if not self._errors.possible:
                graph.add(sighting_factor(gtsam, (at, place), sighting, covariance, loss))
            elif number != self._number:
                graph.add(shared_sighting_factor(gtsam, (at, place, sensor), sighting, covariance, loss))

    def _solve(self, graph: Any, values: Any) -> None:
        """Add new factors and values, and replace priors of the constant errors that have changed."""
        outdated = self._errors.renew(graph)
        self._errors.added(self._solver.update(graph, values, outdated).getNewFactorsIndices())

    def _read(self) -> None:
        """Read pose, map and constant errors from the solver."""
        values = self._solver.calculateEstimate()
        # They are in the order of their numbers.
        self._poses = self._gtsam.utilities.extractPose2(values)
        self._pose = self._poses[-1]
        self._places = {name: np.asarray(values.atPoint2(key)) for name, key in self._names.items()}
        keys = self._errors.keys if self._errors.possible else ()
        P = self._solver.jointMarginalCovariance([*keys, self._key(), *self._names.values()]).fullMatrix()
        step = np.zeros(len(P))
        if keys:
            solved = np.concatenate([values.atVector(key) for key in keys])
            step, P = self._errors.average(solved, P, rough=self._roughness.odds)
        self._publish(step, P)

    def _publish(self, step: Array, P: Array) -> None:
        """Set pose and map to the solution changed by a step, with the covariance of both, the pose in its own axes."""
        self._covariance = turned_covariance(P[:3, :3], self._pose[2])
        self._believed_pose = compose(self._pose, step[:3])
        if self._held:
            self._frame.add(self._poses, float(np.sqrt(self._covariance[2, 2])))
        self._map = {
            name: self._frame.landmark(place + step[row : row + 2], P[row : row + 2, row : row + 2])
            for row, (name, place) in zip(range(3, len(P), 2), self._places.items(), strict=True)
        }

    def _belief(self) -> Estimate:
        """Return the last pose of the graph, propagated by odometry, and the map."""
        step = self._step + self._slopes @ self._errors.mean[:MOTION]
        pose, F, G = self._motion(self._frame.pose(self._believed_pose), step)
        own = self._step_covariance + self._slopes_covariance()
        covariance = F @ self._frame.pose_covariance(self._believed_pose, self._covariance) @ F.T + G @ own @ G.T
        return Estimate(Pose.from_array(pose), covariance, dict(self._map))

    def _mended_step(self) -> Array:
        """Return the step since the last pose, corrected for the errors of odometry in the graph, shape (3,)."""
        return np.asarray(self._step + self._slopes @ self._errors.solved[:MOTION])

    def _slopes_covariance(self) -> Array:
        """Return the covariance of that step from the uncertainty of the errors, shape (3, 3)."""
        return np.asarray(self._slopes @ self._errors.covariance[:MOTION, :MOTION] @ self._slopes.T)

    def _forget_step(self) -> None:
        self._step, self._step_covariance = np.zeros(3), np.zeros((3, 3))
        self._slopes, self._stated = np.zeros((3, MOTION)), np.zeros((3, 3))

    def _key(self) -> int:
        return int(self._gtsam.symbol("x", self._number))


def _thresholds(gtsam: Any) -> Any:
    """Return by how much each kind of variable moves before it is linearised again.

    Errors of ranges never are: a range is linear in them, apart from their product with the position.
    """
    thresholds = gtsam.ISAM2ThresholdMap()
    for kind, size in (("x", 3), ("l", 2), ("e", MOTION)):
        thresholds.insert((kind, np.full(size, RELINEARISED)))
    thresholds.insert(("r", np.full(len(LARGE_SENSOR), np.inf)))
    return thresholds
