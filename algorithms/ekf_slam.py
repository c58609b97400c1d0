"""EKF-SLAM: where am I, and where does each beacon hang?

`EkfSlamFilter` is the mathematics, `EkfSlam` the estimator that brings it to a robot: odometry moves the belief,
sightings correct it. Two rules keep bad sightings out, for one wrong picture would bend the whole map:

- a sighting of a landmark in the map counts only if it lies within the gate of what is expected;
- a beacon enters the map only when some sightings of it agree about its place.

Sightings come with the name of their beacon or without; those without are paired with the map, or left alone.
"""

import itertools
import math
from collections.abc import Hashable, Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .association import joint_compatibility, nearest_neighbour
from .ekf_filter import EkfSlamFilter, Jacobians
from .ekf_models import bicycle_motion, landmark_from, odometry_motion
from .invariant_ekf import InvariantEkfSlamFilter
from .map_management import Look, Probation
from .picture_errors import PictureErrors, each_of

__all__ = ["EkfSlam", "EkfSlamFilter", "InvariantEkfSlamFilter", "bicycle_motion", "odometry_motion"]


_MEMORY = 0.2
"""Share of the newest tick in the running average of what odometry claims to err."""


_ASSOCIATIONS = {"nearest": nearest_neighbour, "joint": joint_compatibility}


class EkfSlam:
    """Estimates the pose and a map of beacons from odometry and sightings."""

    def __init__(
        self,
        *,
        jacobians: Jacobians | Literal["invariant"] = "first-estimates",
        gate: float = 13.8,
        confirmations: int = 3,
        patience: float = 5.0,
        odometry_scale: float = 1.0,
        sighting_scale: float = 1.0,
        nod_deg: float = 0.15,
        repeat: float = 0.5,
        association: Literal["known", "nearest", "joint"] = "known",
        joint_covariance: bool = False,
    ) -> None:
        """Set the rules.

        Args:
            jacobians: 'first-estimates' and 'invariant' stay consistent when loops close; 'standard' is the textbook's.
            gate: Largest squared Mahalanobis distance of a sighting that counts; 13.8 keeps 99.9 % of good ones
                (chi-square, two degrees of freedom).
            confirmations: How many sightings must agree before a beacon enters the map.
            patience: How long a sighting waits for others to agree with it [s].
            odometry_scale: Factor on the standard deviation of odometry, for slip that its data sheet leaves out.
            sighting_scale: Factor on the standard deviation of sightings.
            nod_deg: How far the robot nods and sways while it drives at a steady speed, standard deviation; what a
                camera sees at one moment shifts together then. As its speed changes it nods farther.
            repeat: Share of the variance of a camera's sightings that repeats from image to image, times the way over
                which it does [m]; a Kalman filter takes each sighting for a new one.
            association: What becomes of sightings without a name: with 'known' nothing; 'nearest' pairs each with
                the landmark that fits it best, 'joint' finds the largest pairing that can be true as a whole.
                Landmarks without a name are numbered from 0.
            joint_covariance: Whether the estimate carries the covariance of pose and map together.
        """
        if confirmations < 1:
            raise ValueError(f"confirmations is {confirmations}; it must be at least 1")
        if association not in ("known", *_ASSOCIATIONS):
            raise ValueError(f"association is {association!r}; it must be known, {' or '.join(_ASSOCIATIONS)}")
        self._jacobians = jacobians
        self._gate = gate
        self._association = association
        self._probation = Probation(confirmations=confirmations, patience=patience, gate=gate)
        self._rules = confirmations, patience
        self._odometry_scale = odometry_scale
        self._sighting_scale = sighting_scale
        self._nod, self._repeat = math.radians(nod_deg), repeat
        self._joint = joint_covariance
        self._motion = odometry_motion()
        self._filter = _new_filter(jacobians, pose=np.zeros(3), covariance=np.zeros((3, 3)))
        self._usual = np.zeros(3)

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self._errors = PictureErrors(robot, nod=self._nod, repeat=self._repeat)
        self._filter = _new_filter(self._jacobians, pose=robot.prior.as_array(), covariance=robot.prior_covariance)
        self._usual = np.zeros(3)
        confirmations, patience = self._rules
        self._probation = Probation(confirmations=confirmations, patience=patience, gate=self._gate)

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        covariance = self._steadied(moved.covariance) * self._odometry_scale**2
        self._filter.predict(self._motion, (moved.forward, moved.left, moved.turn), covariance)
        self._errors.move(moved, seen.sightings)
        named = [sighting for sighting in seen.sightings if sighting.name is not None]
        known = [sighting for sighting in named if sighting.name in self._filter]
        innovations = self._correct([sighting.name for sighting in known], known) if known else ()
        self._add([sighting for sighting in named if sighting.name not in self._filter], seen.time)
        nameless = [sighting for sighting in seen.sightings if sighting.name is None]
        if nameless and self._association != "known":
            innovations += self._associate(nameless, seen.time)
        return Estimate(
            pose=Pose.from_array(self._filter.pose),
            covariance=self._filter.covariance,
            landmarks=self._filter.landmarks(),
            innovations=innovations,
            joint_covariance=self._filter.joint_covariance if self._joint else None,
        )

    def _steadied(self, claimed: Array) -> Array:
        """Return the covariance of odometry, no variance less than its average over the last ticks.

        The noise of wheels grows with the motion that they made, what they claim with the motion that they measured.
        A tick in which noise hides the motion claims next to no error; then every sighting would look like an outlier.
        """
        self._usual = (1.0 - _MEMORY) * self._usual + _MEMORY * np.diag(claimed)
        return np.asarray(claimed + np.diag(np.maximum(self._usual - np.diag(claimed), 0.0)))

    def _correct(
        self, names: Sequence[Hashable], sightings: Sequence[Sighting]
    ) -> tuple[tuple[Hashable, Array, Array], ...]:
        """Correct by sightings of landmarks in the map; return the innovations of those that counted."""
        Z, R = self._measured(sightings)
        nu, S = self._filter.innovations(names, Z, R)
        good = np.flatnonzero(_squared_distances(nu, S) < self._gate).tolist()
        if good:
            together = self._errors.covariance([sightings[i] for i in good], scale=self._sighting_scale)
            self._filter.update([names[i] for i in good], Z[good], together)
        return tuple((names[i], nu[i], S[i]) for i in good)

    def _add(self, sightings: Sequence[Sighting], time: float) -> None:
        """Let beacons into the map that enough looks agree about; the newest look tells where they are."""
        for sighting in sightings:
            if self._probation.passes(sighting.name, self._look(sighting, time)):
                self._filter.update([sighting.name], *self._measured([sighting]))

    def _associate(self, sightings: Sequence[Sighting], time: float) -> tuple[tuple[Hashable, Array, Array], ...]:
        """Correct by sightings without names, and let new landmarks in; return the innovations."""
        Z, R = self._measured(sightings)
        names = _ASSOCIATIONS[self._association](self._filter, Z, R)
        known = [i for i, name in enumerate(names) if name is not None]
        strange = self._strange([i for i, name in enumerate(names) if name is None], names, Z, R)
        innovations = self._correct([names[i] for i in known], [sightings[i] for i in known]) if known else ()
        entered = self._probation.passing([self._look(sightings[i], time) for i in strange])
        for i in itertools.compress(strange, entered):
            self._filter.update([self._numbered()], Z[i], R[i])
        return innovations

    def _strange(self, unpaired: Sequence[int], names: Sequence[Hashable], Z: Array, R: Array) -> list[int]:
        """Return the sightings that no landmark can explain but one that another sighting explains better."""
        free = [name for name in self._filter.names() if name not in names]
        if not free or not unpaired:
            return list(unpaired)
        expected, spread = self._filter.expect(free)
        nu = Z[unpaired][:, None] - expected
        nu[..., 1] = wrap_angles(nu[..., 1])
        distance = _squared_distances(nu, spread + R[unpaired][:, None])
        return [i for i, nearest in zip(unpaired, distance.min(axis=1), strict=True) if nearest > self._gate]

    def _numbered(self) -> int:
        """Return the number of the next landmark without a name."""
        return sum(isinstance(name, int) for name in self._filter.names())

    def _look(self, sighting: Sighting, time: float) -> Look:
        Z, R = self._measured([sighting])
        place, J = landmark_from(self._filter.pose, Z[0])
        return Look(time, place, J @ R[0] @ J.T)

    def _measured(self, sightings: Sequence[Sighting]) -> tuple[Array, Array]:
        """Return measurements (k, 2) [m, rad] and their covariances (k, 2, 2)."""
        Z = np.array([(sighting.range, sighting.bearing) for sighting in sightings])
        return Z, each_of(self._errors.covariance(sightings, scale=self._sighting_scale))


def _new_filter(jacobians: Jacobians | Literal["invariant"], *, pose: Array, covariance: Array) -> EkfSlamFilter:
    if jacobians == "invariant":
        return InvariantEkfSlamFilter(pose=pose, covariance=covariance)
    return EkfSlamFilter(jacobians=jacobians, pose=pose, covariance=covariance)


def _squared_distances(nu: Array, S: Array) -> Array:
    """Return nu^T S^-1 nu of many innovations, shape (...)."""
    return np.asarray(np.einsum("...i,...i->...", nu, np.linalg.solve(S, nu[..., None])[..., 0]))
