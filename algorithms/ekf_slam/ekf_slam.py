"""EKF-SLAM with beacons.

`EkfSlamFilter` is the mathematics, `EkfSlam` the estimator on a robot: odometry predicts, sightings correct. Two rules
reject outliers, since a single wrong sighting would distort the whole map:

- a sighting of a landmark in the map is used only if it lies within the gate around the expected measurement;
- a beacon enters the state at its first sighting, when the pose is most certain, but the published map only after
  several sightings agree on its position; if the next ones disagree, it is removed from the state.

Sightings may lack the name of their beacon; those are associated with the map, or ignored.
"""

import itertools
import math
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from functools import partial
from operator import methodcaller
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, Odometry, RobotInfo, Sighting

from ..estimation.constant_errors import LARGE_MOTION, LARGE_SENSOR
from ..estimation.ekf_models import bicycle_motion, odometry_motion
from ..estimation.odometry_errors import COUNT, DELAY, OdometryErrors
from ..estimation.range_errors import RANGE_ERRORS, RangeErrors
from ..estimation.recent_motion import RecentMotion
from ..estimation.relocation import ANYWHERE, Relocation
from ..picture_errors import PictureErrors, each_of
from .association import joint_compatibility, nearest_neighbour
from .ekf_filter import EkfSlamFilter, Jacobians
from .invariant_ekf import InvariantEkfSlamFilter
from .landmark_merging import DuplicateLandmarks
from .map_management import Probation
from .past_positions import Mark, PastPositions
from .rival_filters import RivalFilters

__all__ = ["EkfSlam", "EkfSlamFilter", "InvariantEkfSlamFilter", "bicycle_motion", "odometry_motion"]


_MEMORY = 0.2
"""Weight of the newest tick in the running average of the odometry covariance."""

_MIN_COVARIANCE_RATIO = 0.5
"""Minimum of a tick's covariance relative to that average. With 1, the mean would be a third more than stated."""

RENEW = 0.5
"""Change of a landmark's position, relative to its distance, after which Jacobians are updated: they are off by 27
degrees."""
FAR = 0.2
"""Corrections that turn the robot by more than this, or move it by more than this ratio to the distance of a landmark,
are iterated: after a minute without a landmark, the first sighting may turn the robot farther than Jacobians are valid
for [rad]."""
SYSTEMATIC_LENGTH = 1.0
"""Distance over which systematic errors of odometry are assumed to equal its noise [m, rad]."""
Innovations = tuple[tuple[Hashable, Array, Array], ...]
"""Innovations of accepted sightings: landmark, innovation (2,) and its covariance (2, 2)."""

_ASSOCIATIONS = {"nearest": nearest_neighbour, "joint": joint_compatibility}


class EkfSlam:
    """Estimates the pose and a map of beacons from odometry and sightings."""

    def __init__(
        self,
        *,
        jacobians: Jacobians | Literal["invariant"] = "invariant",
        gate: float = 13.8,
        confirmations: int = 3,
        patience: float = 5.0,
        odometry_scale: float = 1.0,
        sighting_scale: float = 1.0,
        nod_deg: float = 0.15,
        repeat: float = 0.5,
        systematic: float | None = None,
        delay: float = DELAY,
        association: Literal["known", "nearest", "joint"] = "known",
        joint_covariance: bool = False,
        frame: Literal["map", "start"] = "map",
    ) -> None:
        """Set the rules.

        Args:
            jacobians: 'invariant' and 'first-estimates' stay consistent when loops close, 'invariant' also after the
                large corrections of real logs; 'standard' is the textbook's.
            gate: Largest squared Mahalanobis distance of a sighting that counts; 13.8 keeps 99.9 % of good ones
                (chi-square, two degrees of freedom).
            confirmations: Number of consistent sightings, the first included, before a beacon enters the map.
            patience: Time within which they must agree [s]; an unnamed landmark that is not seen again is forgotten.
            odometry_scale: Factor on the standard deviation of odometry, for slip that its data sheet does not include.
            sighting_scale: Factor on the standard deviation of sightings.
            nod_deg: Pitch and roll of the robot at constant speed, standard deviation; they shift all sightings of one
                picture together. The pitch is larger while the speed changes.
            repeat: Correlated part of the variance of a camera's sightings from image to image (0 to 1), times the
                distance over which it is correlated [m]; a Kalman filter assumes independent sightings.
            systematic: Distance after which the systematic errors of odometry (distance, turn and veer) are assumed to
                equal its stated noise [m]; they are part of the state. So are an offset and a relative error of ranges,
                if ranges scatter by less than their stated noise. Infinite: none of these. By default 1 m for named
                sightings, and none for unnamed ones: with a more uncertain pose, wrong associations would be accepted.
            delay: Standard deviation of the delay, positive or negative, between odometry and the motion; also part of
                the state, unless `systematic` is infinite [s].
            association: Association of unnamed sightings: 'known' ignores them, 'nearest' pairs each with the best
                landmark, 'joint' finds the largest jointly compatible pairing. Unnamed landmarks are numbered from 0.
            joint_covariance: Whether the estimate includes the joint covariance of pose and map.
            frame: What stays in place when the filter learns late that its map is rotated relative to the start: with
                'map' the path and the map as reported so far, with 'start' the first pose.
        """
        if jacobians not in ("standard", "first-estimates", "invariant"):
            raise ValueError(f"jacobians is {jacobians!r}; it must be standard, first-estimates or invariant")
        if confirmations < 1:
            raise ValueError(f"confirmations is {confirmations}; it must be at least 1")
        if association not in ("known", *_ASSOCIATIONS):
            raise ValueError(f"association is {association!r}; it must be known, {' or '.join(_ASSOCIATIONS)}")
        if frame not in ("map", "start"):
            raise ValueError(f"frame is {frame!r}; it must be map or start")
        self._jacobians, self._gate, self._held = jacobians, gate, frame == "map"
        self._association = association
        self._probation = Probation(confirmations=confirmations, patience=patience)
        self._rules = confirmations, patience
        self._odometry_scale = odometry_scale
        self._sighting_scale = sighting_scale
        self._nod, self._repeat = math.radians(nod_deg), repeat
        self._joint = joint_covariance
        usual = SYSTEMATIC_LENGTH if association == "known" else math.inf
        self._systematic = usual if systematic is None else systematic
        self._delay = delay
        self._odometry_errors = OdometryErrors(self._systematic, delay=self._delay)
        self._motion = odometry_motion()
        self._rivals = _new_filters(jacobians, pose=np.zeros(3), covariance=np.zeros((3, 3)), errors=False)
        self._usual = np.zeros(3)
        self._merged: set[Hashable] = set()
        self._past: PastPositions | None = None

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self._recent, self._relocation = RecentMotion(), Relocation()
        self._duplicates = DuplicateLandmarks(gate=self._gate, scale=self._sighting_scale)
        self._odometry_errors = OdometryErrors(self._systematic, delay=self._delay)
        self._errors = PictureErrors(robot, nod=self._nod, repeat=self._repeat)
        self._rivals = _new_filters(
            self._jacobians,
            pose=robot.prior.as_array(),
            covariance=robot.prior_covariance,
            errors=not math.isinf(self._systematic),
        )
        self._range_errors = RangeErrors(scale=self._sighting_scale)
        self._usual, self._merged = np.zeros(3), set()
        self._past = PastPositions(self._rivals) if self._held else None
        confirmations, patience = self._rules
        self._probation = Probation(confirmations=confirmations, patience=patience)

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        covariance = self._steadied(moved.covariance) * self._odometry_scale**2
        self._move(moved, covariance, seen.dt)
        self._recent.move(moved, seen.time)
        self._errors.move(moved, seen.sightings)
        self._forget(seen.time)
        sightings = [self._recent.to_now(sighting) for sighting in seen.sightings]
        named = [sighting for sighting in sightings if sighting.name is not None]
        self._limit_range_errors([sighting for sighting in seen.sightings if sighting.name is not None])
        innovations = self._take([sighting.name for sighting in named], named, seen.time)
        self._relocate(seen.time)
        nameless = [sighting for sighting in sightings if sighting.name is None]
        if nameless and self._association != "known":
            innovations += self._associate(nameless, seen.time)
        belief = self._reported(innovations, distance=math.hypot(moved.forward, moved.left))
        return self._relocation.reported(belief, seen)

    def _reported(self, innovations: Innovations, *, distance: float) -> Estimate:
        """Return the belief; with frame 'map', a late correction of the whole map does not move what was reported."""
        believed = self._rivals.believed()
        if self._past is not None:
            self._past.move(distance)
            if innovations:
                self._past.hold(believed)
        mapped = self._mapped()
        belief = Estimate(
            pose=Pose.from_array(believed.pose),
            covariance=believed.covariance,
            landmarks=believed.landmarks(mapped),
            innovations=innovations,
            joint_covariance=believed.joint_covariance_of(mapped) if self._joint else None,
        )
        if self._past is not None:
            self._past.mark(self._rivals, believed.pose)
            belief = self._past.reported(belief)
        return belief

    def lost(self) -> bool:
        """Return whether nearly all recent sightings contradict the map, or expected sightings are missing."""
        return self._relocation.doubted

    @property
    def _filter(self) -> EkfSlamFilter:
        return self._rivals.leading

    @property
    def systematic_errors(self) -> Array:
        """Systematic errors of odometry, estimated by the filter that assumes them small, shape (4,).

        Relative error of the distance, turn per metre [rad/m], relative error of the turn, and delay of the motion [s].
        """
        return self._rivals.usual.parameters

    @property
    def range_errors(self) -> tuple[Array, Array]:
        """Estimated offset [m] and relative error of ranges, (2,), and their covariance; (0,) without such errors."""
        return self._rivals.usual.sensor_errors

    def _move(self, moved: Odometry, covariance: Array, seconds: float) -> None:
        """Predict with odometry; systematic errors add up to the odometry noise over `systematic`."""
        delay = float(self._filter.parameters[3])
        errors = self._odometry_errors.step(moved, covariance, seconds, delay=delay)
        self._rivals.predict(
            self._motion, (moved.forward, moved.left, moved.turn), covariance, errors=errors, seconds=seconds
        )

    def _limit_range_errors(self, sightings: Sequence[Sighting]) -> None:
        """Limit systematic errors of ranges to what the scatter of named sightings allows."""
        if math.isinf(self._systematic):
            return
        prior = self._range_errors.begin(sightings)
        self._rivals.assume_ranges(prior)
        variances = self._range_errors.constraint(sightings, self._recent)
        if variances is not None:
            self._rivals.constrain_ranges(variances)
        self._rivals.expect_ranges(self._range_errors.variances)

    def _relocate(self, time: float) -> None:
        """Relocate the robot to where the recent sightings fit the map, if nearly all of them fail."""
        if not self._relocation.lost:
            return
        places = {name: mean for name, (mean, _) in self._filter.landmarks(self._mapped()).items()}
        found = self._relocation.find(self._recent, time, places)
        if found is not None:
            self._rivals.change(lambda slam: slam.relocate(found.pose, np.diag(ANYWHERE) ** 2))
            self._rivals.update(list(found.sightings), *self._measured(list(found.sightings.values())))

    def _steadied(self, claimed: Array) -> Array:
        """Return the covariance of odometry, no variance less than half of its average over the last ticks.

        The actual noise of the wheels grows with the true motion, the stated one with the measured motion. In a tick
        where noise cancels the motion, the stated error is almost zero, and every sighting would look like an outlier.
        """
        self._usual = (1.0 - _MEMORY) * self._usual + _MEMORY * np.diag(claimed)
        return np.asarray(claimed + np.diag(np.maximum(_MIN_COVARIANCE_RATIO * self._usual - np.diag(claimed), 0.0)))

    def _take(self, names: Sequence[Hashable], sightings: Sequence[Sighting], time: float) -> Innovations:
        """Correct by sightings of landmarks in the state, and add the others; return the accepted innovations."""
        known = [i for i, name in enumerate(names) if name in self._filter]
        innovations = self._correct([names[i] for i in known], [sightings[i] for i in known], time) if known else ()
        for name, sighting in zip(names, sightings, strict=True):
            if name not in self._filter and not self._relocation.lost:
                self._rivals.update([name], *self._measured([sighting]))
                self._probation.begin(name, time)
        return innovations

    def _correct(self, names: Sequence[Hashable], sightings: Sequence[Sighting], time: float) -> Innovations:
        """Correct by sightings within the gate; remove landmarks on probation that too many contradict."""
        Z, R = self._measured(sightings)
        nu, S = self._filter.innovations(names, Z, R)
        distances = _squared_distances(nu, S)
        good = distances < self._gate
        lost = self._relocation.lost
        counting = [] if lost else np.flatnonzero(good).tolist()
        if counting:
            together = self._errors.covariance([sightings[i] for i in counting], scale=self._sighting_scale)
            self._rivals.update([names[i] for i in counting], Z[counting], together)
        for name, sighting, agrees, distance in zip(names, sightings, good.tolist(), distances.tolist(), strict=True):
            if name not in self._probation:
                self._relocation.record(name, sighting, distance, gate=self._gate)
            if lost:
                continue
            if agrees:
                self._probation.agrees(name, time)
            elif self._probation.fails(name):
                self._rivals.change(methodcaller("remove", name))
        return tuple((names[i], nu[i], S[i]) for i in counting)

    def _forget(self, time: float) -> None:
        """Remove unnamed landmarks that were not seen again: false sightings."""
        for name in self._probation.overdue(time):
            if isinstance(name, int):
                self._probation.end(name)
                self._rivals.change(methodcaller("remove", name))

    def _associate(self, sightings: Sequence[Sighting], time: float) -> Innovations:
        """Correct by sightings without names, and add new landmarks; return the innovations.

        Confirmed landmarks come first: a provisional one gets only sightings that no confirmed one explains. Otherwise
        a poor sighting of a landmark could start a duplicate beside it.
        """
        Z, R = self._measured(sightings)
        mapped = self._mapped()
        names = _ASSOCIATIONS[self._association](self._filter, Z, R, among=mapped)
        paired = [i for i, name in enumerate(names) if name is not None]
        unmatched = self._unmatched(names, mapped, Z, R)
        innovations = self._take([names[i] for i in paired], [sightings[i] for i in paired], time)
        self._merge([(name, sightings[i]) for i, name in enumerate(names) if name is not None])
        if not unmatched:
            return innovations
        waiting = [name for name in self._filter.names() if name in self._probation]
        names = nearest_neighbour(self._filter, Z[unmatched], R[unmatched], among=waiting)
        fresh = self._numbers()
        names = [next(fresh) if name is None else name for name in names]
        return innovations + self._take(names, [sightings[i] for i in unmatched], time)

    def _merge(self, seen: Sequence[tuple[Hashable, Sighting]]) -> None:
        """Merge landmarks that were mapped twice, based on those seen now, each with its sighting."""
        seen = [(name, sighting) for name, sighting in seen if isinstance(name, int)]
        self._duplicates.record([name for name, _ in seen])
        while pair := self._duplicates.find(
            self._filter, seen, [name for name in self._mapped() if isinstance(name, int)]
        ):
            kept, gone, _ = pair
            self._rivals.change(methodcaller("unite", *pair))
            self._duplicates.unite(kept, gone)
            self._merged.add(gone)
            seen = [(kept if name == gone else name, sighting) for name, sighting in seen]

    def _unmatched(self, names: Sequence[Hashable | None], mapped: Sequence[Hashable], Z: Array, R: Array) -> list[int]:
        """Return the sightings that match no landmark, except one that another sighting matches better."""
        unpaired = [i for i, name in enumerate(names) if name is None]
        free = [name for name in mapped if name not in names]
        if not free or not unpaired:
            return unpaired
        expected, expected_covariance = self._filter.expect(free)
        nu = Z[unpaired][:, None] - expected
        nu[..., 1] = wrap_angles(nu[..., 1])
        distance = _squared_distances(nu, expected_covariance + R[unpaired][:, None])
        return [i for i, nearest in zip(unpaired, distance.min(axis=1), strict=True) if nearest > self._gate]

    def _mapped(self) -> list[Hashable]:
        """Return the landmarks that are not on probation, oldest first."""
        return [name for name in self._filter.names() if not (name in self._probation or isinstance(name, Mark))]

    def _numbers(self) -> Iterator[int]:
        """Yield numbers for new unnamed landmarks, the smallest free ones."""
        return (n for n in itertools.count() if n not in self._filter and n not in self._merged)

    def _measured(self, sightings: Sequence[Sighting]) -> tuple[Array, Array]:
        """Return measurements (k, 2) [m, rad] and their covariances (k, 2, 2)."""
        Z = np.array([(sighting.range, sighting.bearing) for sighting in sightings])
        return Z, each_of(self._errors.covariance(sightings, scale=self._sighting_scale))


def _new_filters(
    jacobians: Jacobians | Literal["invariant"], *, pose: Array, covariance: Array, errors: bool
) -> RivalFilters:
    """Return filters with and without errors of odometry, both with errors of ranges, and one with large errors.

    Without `errors`, only one without any.
    """
    sensor = RANGE_ERRORS if errors else 0
    make: Callable[..., EkfSlamFilter] = InvariantEkfSlamFilter
    if jacobians != "invariant":
        make = partial(EkfSlamFilter, jacobians=jacobians, renew=RENEW)
    filters = [make(pose=pose, covariance=covariance, parameters=COUNT, sensor=sensor, far=FAR) for _ in range(3)]
    if not errors:
        return RivalFilters(filters[0], None)
    wide = make(pose=pose, covariance=covariance, parameters=len(LARGE_MOTION), sensor=len(LARGE_SENSOR), far=FAR)
    return RivalFilters(filters[0], filters[1], wide, filters[2])


def _squared_distances(nu: Array, S: Array) -> Array:
    """Return nu^T S^-1 nu of many innovations, shape (...)."""
    return np.asarray(np.einsum("...i,...i->...", nu, np.linalg.solve(S, nu[..., None])[..., 0]))
