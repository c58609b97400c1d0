"""Localization with known beacons: Kalman filters of filterpy with three states.

The world must say `map: known`; the catalogue then contains the position of each beacon. `EkfLocalization` linearises
at the mean, `UkfLocalization` propagates seven sigma points through motion and measurement.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .ekf_slam.association import chi_square
from .estimation.ekf_models import odometry_motion, range_bearing

FLOOR = 1e-12
"""Added to the variances of the prior, so that a pose known exactly still has a square root of its covariance."""


def known_places(catalogue: Mapping[str, BeaconInfo]) -> dict[str, Array]:
    """Return the positions of the beacons, name -> (2,) [m].

    Raises:
        ValueError: The catalogue has no positions.
    """
    places = {name: info.pose.as_array()[:2] for name, info in catalogue.items() if info.pose is not None}
    if not places:
        raise ValueError("no position of a beacon is known; write 'map: known' under 'run' of the world")
    return places


def difference(one: Array, other: Array) -> Array:
    """Return the difference, whose last entry is an angle in [-pi, pi)."""
    result = np.asarray(one - other)
    result[-1] = wrap_angle(result[-1])
    return result


class _Localization(ABC):
    """Base class of both filters: prediction with odometry, correction with gated sightings of known beacons."""

    def __init__(self, *, confidence: float = 0.999) -> None:
        """Set the gate.

        Args:
            confidence: Probability that a correct sighting passes the gate; others are rejected as outliers.
        """
        self._gate = float(chi_square(confidence, 2))
        self._places: dict[str, Array] = {}
        self._filter: Any = None

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior.

        Raises:
            ValueError: The world does not say where its beacons hang.
        """
        self._places = known_places(catalogue)
        self._filter = self._new_filter()
        self._filter.x = robot.prior.as_array()
        self._filter.P = np.asarray(robot.prior_covariance) + FLOOR * np.eye(3)

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        self._predict(np.array([moved.forward, moved.left, moved.turn]), moved.covariance)
        innovations = []
        for sighting in seen.sightings:
            place = self._places.get(sighting.name or "")
            if place is None:
                continue
            nu, S = self._innovation(sighting, place)
            if nu @ np.linalg.solve(S, nu) < self._gate:
                self._correct(sighting, place)
                innovations.append((sighting.name, nu, S))
        self._filter.x[2] = wrap_angle(self._filter.x[2])
        return Estimate(
            pose=Pose.from_array(self._filter.x),
            covariance=0.5 * (self._filter.P + self._filter.P.T),
            innovations=tuple(innovations),
        )

    def _innovation(self, sighting: Sighting, place: Array) -> tuple[Array, Array]:
        """Return the innovation of a sighting (2,) and its covariance (2, 2), to first order."""
        z, H, _ = range_bearing(self._filter.x, place[None])
        nu = difference(np.array([sighting.range, sighting.bearing]), z[0])
        return nu, np.asarray(H[0] @ self._filter.P @ H[0].T + sighting.covariance)

    @abstractmethod
    def _new_filter(self) -> Any:
        """Return a filter of filterpy for three states."""

    @abstractmethod
    def _predict(self, step: Array, covariance: Array) -> None:
        """Predict the belief with odometry."""

    @abstractmethod
    def _correct(self, sighting: Sighting, place: Array) -> None:
        """Correct the belief by a sighting of a beacon at a known place."""


class EkfLocalization(_Localization):
    """Estimates the pose with the extended Kalman filter.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 7.2, with the motion of odometry.
    """

    def _new_filter(self) -> Any:
        from filterpy.kalman import ExtendedKalmanFilter

        class PlaneFilter(ExtendedKalmanFilter):  # type: ignore[misc]  # filterpy has no types
            """filterpy's filter with the motion model of odometry instead of F x + B u."""

            x: Any
            Q: Any

            def predict_x(self, u: Array) -> None:
                self.x, F, G = odometry_motion()(self.x, u)
                self.F, self.Q = F, G @ self.Q @ G.T

        return PlaneFilter(dim_x=3, dim_z=2)

    def _predict(self, step: Array, covariance: Array) -> None:
        self._filter.Q = covariance
        self._filter.predict(step)

    def _correct(self, sighting: Sighting, place: Array) -> None:
        self._filter.update(
            np.array([sighting.range, sighting.bearing]),
            HJacobian=lambda pose: range_bearing(pose, place[None])[1][0],
            Hx=lambda pose: range_bearing(pose, place[None])[0][0],
            R=sighting.covariance,
            residual=difference,
        )


class UkfLocalization(_Localization):
    """Estimates the pose with the unscented Kalman filter.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 7.4. Julier, Uhlmann, Unscented Filtering and
        Nonlinear Estimation, Proc. IEEE 92(3), 2004; sigma points of van der Merwe (2004).
    """

    def _new_filter(self) -> Any:
        from filterpy.kalman import MerweScaledSigmaPoints, UnscentedKalmanFilter

        # kappa = 3 - n, as Julier has it; alpha 1e-1 keeps the points where bearings are still nearly linear.
        points = MerweScaledSigmaPoints(n=3, alpha=0.1, beta=2.0, kappa=0.0, subtract=difference)
        return UnscentedKalmanFilter(
            dim_x=3,
            dim_z=2,
            dt=1.0,
            hx=lambda pose, place: range_bearing(pose, place[None])[0][0],
            fx=lambda pose, _, step: odometry_motion()(pose, step)[0],
            points=points,
            x_mean_fn=_mean_with_angle,
            z_mean_fn=_mean_with_angle,
            residual_x=difference,
            residual_z=difference,
        )

    def _predict(self, step: Array, covariance: Array) -> None:
        # The noise of odometry lies in the robot's frame before the step; filterpy adds Q after it.
        _, _, G = odometry_motion()(self._filter.x, step)
        self._filter.Q = G @ covariance @ G.T
        self._filter.predict(step=step)

    def _correct(self, sighting: Sighting, place: Array) -> None:
        self._filter.update(np.array([sighting.range, sighting.bearing]), R=sighting.covariance, place=place)
        # Several simultaneous sightings: draw the points anew from the newest covariance.
        self._filter.sigmas_f = self._filter.points_fn.sigma_points(self._filter.x, self._filter.P)


def _mean_with_angle(points: Array, weights: Array) -> Array:
    """Return the weighted mean of points whose last entry is an angle, which is averaged about the first's."""
    about = points[0]
    differences = points - about
    differences[:, -1] = (differences[:, -1] + np.pi) % (2.0 * np.pi) - np.pi
    return np.asarray(about + weights @ differences)
