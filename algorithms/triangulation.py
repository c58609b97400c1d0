"""Pose from bearings to beacons at known positions, without a map or a history.

`bearings_only` solves for one instant. `Triangulation` runs it on a robot: three beacons in view give a pose, and
odometry propagates it to the next.
"""

from collections.abc import Mapping

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike
from scipy.optimize import least_squares

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo

from .estimation.ekf_models import odometry_motion, range_bearing
from .localization import known_places


def bearings_only(places: ArrayLike, bearings: ArrayLike, deviations: ArrayLike) -> tuple[Pose, Array]:
    """Return the pose from bearings to beacons at known positions.

    The lines of sight are linear in (cos, sin) of the heading and in the position rotated by it, which gives an
    initial pose without a guess; least squares on the bearings then gives the most likely one.

    Args:
        places: Positions of the beacons, shape (n, 2) with n at least 3 [m].
        bearings: Bearing to each, left positive, shape (n,) [rad].
        deviations: Standard deviation of each bearing, or of all, shape (n,) or () [rad].

    Returns:
        The pose, and its covariance (3, 3) to first order.

    Raises:
        ValueError: There are fewer than three beacons, or they and the robot lie on one circle or line, so that the
            pose is ambiguous.

    References:
        Shimshoni, On Mobile Robot Localization from Landmark Bearings, IEEE T-RA 18(6), 2002: the linear solution.
    """
    beacons, angles = np.asarray(places, dtype=float), np.asarray(bearings, dtype=float)
    sigma = np.broadcast_to(np.asarray(deviations, dtype=float), angles.shape)
    if len(beacons) < 3:
        raise ValueError(f"{len(beacons)} beacons are in view; a pose needs three")

    def misses(pose: Array) -> Array:
        return np.asarray(wrap_angles(range_bearing(pose, beacons)[0][:, 1] - angles) / sigma)

    def slopes(pose: Array) -> Array:
        return np.asarray(range_bearing(pose, beacons)[1][:, 1] / sigma[:, None])

    found = least_squares(misses, _linear_solution(beacons, angles), jac=slopes, method="lm")
    information = found.jac.T @ found.jac
    if np.linalg.cond(information) > 1e10:
        raise ValueError("beacons and robot are on one circle or line, where the pose is ambiguous")
    return Pose.from_array([*found.x[:2], wrap_angles(found.x[2])]), np.asarray(np.linalg.inv(information), dtype=float)


def _linear_solution(beacons: Array, angles: Array) -> Array:
    """Return the least-squares pose from the lines of sight, shape (3,)."""
    # Relative to the beacons' centroid and in units of their spread, so that the four unknowns are of similar size.
    middle = beacons.mean(axis=0)
    size = float(np.abs(beacons - middle).max()) or 1.0
    x, y = ((beacons - middle) / size).T
    c, s = np.cos(angles), np.sin(angles)
    # With h = (cos, sin) of the heading and q the position in the robot's axes: Im(e^{-i bearing} (R^T p - q)) = 0.
    A = np.column_stack([c * y - s * x, -(c * x + s * y), s, -c])
    cosine, sine, qx, qy = np.linalg.svd(A)[2][-1]
    length = np.hypot(cosine, sine)
    if length < 1e-9:
        raise ValueError("beacons and robot are on one circle or line, where the pose is ambiguous")
    cosine, sine, qx, qy = (float(value / length) for value in (cosine, sine, qx, qy))
    position = np.array([cosine * qx - sine * qy, sine * qx + cosine * qy])
    ahead = (np.stack([x, y], axis=-1) - position) @ (cosine, sine)
    left = (np.stack([x, y], axis=-1) - position) @ (-sine, cosine)
    # The opposite heading has the same lines of sight, but with all beacons behind.
    turned = np.pi if np.sum(ahead * c + left * s) < 0.0 else 0.0
    return np.array([*(middle + size * position), np.arctan2(sine, cosine) + turned])


class Triangulation:
    """Estimates the pose from bearings alone, and by odometry in between.

    The world must set `map: known`. A fix less certain than the pose propagated by odometry is ignored.
    """

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior.

        Raises:
            ValueError: The world does not give the poses of its beacons.
        """
        self._places = known_places(catalogue)
        self._pose = robot.prior.as_array()
        self._covariance = np.array(robot.prior_covariance, dtype=float)
        self._motion = odometry_motion()

    def update(self, seen: Observation) -> Estimate:
        """Return the pose of this tick."""
        moved = seen.odometry
        self._pose, F, G = self._motion(self._pose, np.array([moved.forward, moved.left, moved.turn]))
        self._covariance = F @ self._covariance @ F.T + G @ moved.covariance @ G.T
        sightings = {sighting.name: sighting for sighting in seen.sightings if sighting.name in self._places}
        if len(sightings) >= 3:
            self._fix(
                np.array([self._places[name] for name in sightings if name is not None]),
                np.array([sighting.bearing for sighting in sightings.values()]),
                np.sqrt([sighting.covariance[1, 1] for sighting in sightings.values()]),
            )
        return Estimate(Pose.from_array(self._pose), self._covariance)

    def _fix(self, places: Array, bearings: Array, deviations: Array) -> None:
        try:
            pose, covariance = bearings_only(places, bearings, deviations)
        except ValueError:
            return  # They lie on one circle: the position is not determined.
        if np.linalg.det(covariance) < np.linalg.det(self._covariance):
            self._pose, self._covariance = pose.as_array(), covariance
