"""EKF-SLAM with beacons that are known by name: where am I, and where does each of them hang?

`EkfSlamFilter` is the mathematics, `EkfSlam` the estimator that brings it to a robot: odometry moves the belief,
sightings correct it. Two rules keep bad sightings out, for one wrong picture would bend the whole map:

- a sighting of a landmark in the map counts only if it lies within the gate of what is expected;
- a beacon enters the map only when some sightings of it agree about its place.
"""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .ekf_filter import EkfSlamFilter, Jacobians
from .ekf_models import bicycle_motion, landmark_from, odometry_motion
from .invariant_ekf import InvariantEkfSlamFilter

__all__ = ["EkfSlam", "EkfSlamFilter", "InvariantEkfSlamFilter", "bicycle_motion", "odometry_motion"]


_DRIFT = 0.05
"""How far the robot may lose its way between two sightings that are compared, standard deviation [m]."""


_MEMORY = 0.2
"""Share of the newest tick in the running average of what odometry claims to err."""


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """One sighting of a beacon that is not in the map yet."""

    time: float
    """[s]"""
    place: Array
    """Where it puts the beacon, shape (2,) [m]."""
    covariance: Array
    """Of the place as the measurement alone gives it, shape (2, 2) [m^2]."""

    def agrees(self, other: "_Look", gate: float) -> bool:
        """Return whether both can be looks at the same place."""
        apart = self.place - other.place
        spread = self.covariance + other.covariance + _DRIFT**2 * np.eye(2)
        return bool(apart @ np.linalg.solve(spread, apart) < gate)


class EkfSlam:
    """Estimates the pose and a map of named beacons from odometry and sightings.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 10.3.3: a list of landmarks that are provisional.
    """

    def __init__(
        self,
        *,
        jacobians: Jacobians | Literal["invariant"] = "first-estimates",
        gate: float = 13.8,
        confirmations: int = 3,
        patience: float = 5.0,
        odometry_scale: float = 1.0,
        sighting_scale: float = 1.0,
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
            sighting_scale: Factor on the standard deviation of sightings, for errors that repeat from one picture
                to the next, which a Kalman filter takes for independent.
            joint_covariance: Whether the estimate carries the covariance of pose and map together.
        """
        if confirmations < 1:
            raise ValueError(f"confirmations is {confirmations}; it must be at least 1")
        self._jacobians = jacobians
        self._gate = gate
        self._confirmations = confirmations
        self._patience = patience
        self._odometry_scale = odometry_scale
        self._sighting_scale = sighting_scale
        self._joint = joint_covariance
        self._motion = odometry_motion()
        self._filter = _new_filter(jacobians, pose=np.zeros(3), covariance=np.zeros((3, 3)))
        self._usual = np.zeros(3)
        self._waiting: dict[str, list[_Look]] = {}

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self._filter = _new_filter(self._jacobians, pose=robot.prior.as_array(), covariance=robot.prior_covariance)
        self._usual = np.zeros(3)
        self._waiting = {}

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        covariance = self._steadied(moved.covariance) * self._odometry_scale**2
        self._filter.predict(self._motion, (moved.forward, moved.left, moved.turn), covariance)
        known = [sighting for sighting in seen.sightings if sighting.name in self._filter]
        innovations = self._correct(known) if known else ()
        self._add([sighting for sighting in seen.sightings if sighting.name not in self._filter], seen.time)
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

    def _correct(self, sightings: Sequence[Sighting]) -> tuple[tuple[Hashable, Array, Array], ...]:
        """Correct by sightings of landmarks in the map; return the innovations of those that counted."""
        names = [sighting.name for sighting in sightings]
        Z, R = self._measured(sightings)
        nu, S = self._filter.innovations(names, Z, R)
        distance = np.einsum("ki,ki->k", nu, np.linalg.solve(S, nu[:, :, None])[:, :, 0])
        good = np.flatnonzero(distance < self._gate)
        if good.size:
            self._filter.update([names[i] for i in good], Z[good], R[good])
        return tuple((names[i], nu[i], S[i]) for i in good)

    def _add(self, sightings: Sequence[Sighting], time: float) -> None:
        """Let beacons into the map that enough looks agree about; the newest look tells where they are."""
        for sighting in sightings:
            if sighting.name is None:
                continue
            Z, R = self._measured([sighting])
            place, J = landmark_from(self._filter.pose, Z[0])
            look = _Look(time, place, J @ R[0] @ J.T)
            waiting = [old for old in self._waiting.get(sighting.name, ()) if time - old.time < self._patience]
            if 1 + sum(look.agrees(old, self._gate) for old in waiting) >= self._confirmations:
                self._filter.update([sighting.name], Z, R)
                self._waiting.pop(sighting.name, None)
            else:
                self._waiting[sighting.name] = [*waiting, look]

    def _measured(self, sightings: Sequence[Sighting]) -> tuple[Array, Array]:
        """Return measurements (k, 2) [m, rad] and their covariances (k, 2, 2)."""
        Z = np.array([(sighting.range, sighting.bearing) for sighting in sightings])
        return Z, np.array([sighting.covariance for sighting in sightings]) * self._sighting_scale**2


def _new_filter(jacobians: Jacobians | Literal["invariant"], *, pose: Array, covariance: Array) -> EkfSlamFilter:
    if jacobians == "invariant":
        return InvariantEkfSlamFilter(pose=pose, covariance=covariance)
    return EkfSlamFilter(jacobians=jacobians, pose=pose, covariance=covariance)
