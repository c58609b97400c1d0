"""Factors of a gtsam graph: odometry and sightings, both with systematic errors, and priors."""

import math
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Sighting

from .ekf_models import MIN_RANGE

HUBER = 1.345
"""Scale of Huber's loss of sightings in standard deviations: 95 % efficient on clean data."""


def leg_factor(gtsam: Any, keys: tuple[int, int, int], step: Array, covariance: Array, slopes: Array) -> Any:
    """Return the odometry factor between two poses, as a function of its systematic errors.

    Args:
        gtsam: The module.
        keys: Keys of the first pose, the second pose, and the errors of odometry (e,).
        step: Second pose in the frame of the first if there are no such errors, shape (3,) [m, m, rad].
        covariance: Covariance of the step, in the frame of the first pose, shape (3, 3).
        slopes: Jacobian of the step by the errors, shape (3, e).
    """
    one, other, common = keys
    expected, by_errors = step.tolist(), -slopes

    def error(_: Any, values: Any, jacobians: list[Array] | None) -> Array:
        residual, by_first, by_second = _leg(values.atPose2(one), values.atPose2(other), expected)
        if jacobians is not None:
            _fill(jacobians, [np.array(by_first).reshape(3, 3), np.array(by_second).reshape(3, 3), by_errors])
        return _wrapped(np.array(residual) + by_errors @ values.atVector(common))

    return gtsam.CustomFactor(gtsam.noiseModel.Gaussian.Covariance(covariance), list(keys), error)


def sighting_factor(gtsam: Any, keys: tuple[int, int], sighting: Sighting, covariance: Array, loss: Any) -> Any:
    """Return the factor of a sighting from a pose to a landmark.

    Args:
        gtsam: The module.
        keys: Keys of the pose and the landmark.
        sighting: The measurement.
        covariance: Covariance of range and bearing, shape (2, 2).
        loss: A robust loss of gtsam's `noiseModel.mEstimator`.
    """
    noise = gtsam.noiseModel
    # gtsam puts bearing before range.
    robust = noise.Robust.Create(loss, noise.Gaussian.Covariance(np.asarray(covariance)[::-1, ::-1]))
    return gtsam.BearingRangeFactor2D(*keys, gtsam.Rot2(sighting.bearing), sighting.range, robust)


def shared_sighting_factor(
    gtsam: Any, keys: tuple[int, int, int], sighting: Sighting, covariance: Array, loss: Any
) -> Any:
    """Return the factor of a sighting from a pose to a landmark, with errors that all sightings have in common.

    Args:
        gtsam: The module.
        keys: Keys of the pose, the landmark, and the errors of the sensor (3,): offset [m] and relative error of
            ranges, and offset of bearings [rad].
        sighting: The measurement.
        covariance: Covariance of range and bearing, shape (2, 2).
        loss: A robust loss of gtsam's `noiseModel.mEstimator`.
    """
    at, place, common = keys

    def error(_: Any, values: Any, jacobians: list[Array] | None) -> Array:
        errors = values.atVector(common).tolist()
        residual, by_pose, by_place, by_errors = _sighting(values.atPose2(at), values.atPoint2(place), errors, sighting)
        if jacobians is not None:
            _fill(jacobians, [np.array(by).reshape(2, -1) for by in (by_pose, by_place, by_errors)])
        return np.array(residual)

    noise = gtsam.noiseModel
    return gtsam.CustomFactor(noise.Robust.Create(loss, noise.Gaussian.Covariance(covariance)), list(keys), error)


class PoseSightings(NamedTuple):
    """Sightings from one pose, with errors common to all."""

    common: int
    """Key of these errors (3,), as in `shared_sighting_factor`."""
    places: list[int]
    """Key of the landmark of each."""
    sightings: list[Sighting]
    """The measurements."""
    covariances: list[Array]
    """Covariances of range and bearing, shape (2, 2) each."""


def pose_factor(gtsam: Any, keys: tuple[int, int, int], leg: tuple[Array, Array, Array], seen: PoseSightings) -> Any:
    """Return one factor of odometry to a pose and of the sightings from it, with Huber's loss of each sighting.

    It equals a `leg_factor` and a `shared_sighting_factor` for each sighting. Calling a Python function takes gtsam
    longer than this function needs.

    Args:
        gtsam: The module.
        keys: Those of `leg_factor`.
        leg: Step, covariance and slopes of `leg_factor`.
        seen: The sightings.
    """
    (one, other, errors), (step, covariance, slopes) = keys, leg
    expected, rows = step.tolist(), 3 + 2 * len(seen.sightings)
    by_errors = np.zeros((rows, slopes.shape[1]))
    by_errors[:3] = -slopes
    places = list(dict.fromkeys(seen.places))
    information = [np.linalg.inv(each) for each in seen.covariances]

    def error(_: Any, values: Any, jacobians: list[Array] | None) -> Array:
        second, ranges = values.atPose2(other), values.atVector(seen.common).tolist()
        residual, by_first, by_second = _leg(values.atPose2(one), second, expected)
        stacked, J = np.zeros(rows), [np.zeros((rows, size)) for size in (3, 3, 3, *[2] * len(places))]
        stacked[:3] = _wrapped(np.array(residual) + by_errors[:3] @ values.atVector(errors))
        J[0][:3], J[1][:3] = np.array(by_first).reshape(3, 3), np.array(by_second).reshape(3, 3)
        row = 3
        for place, sighting, weights in zip(seen.places, seen.sightings, information, strict=True):
            residual, by_pose, by_place, by_ranges = _sighting(second, values.atPoint2(place), ranges, sighting)
            nu = np.array(residual)
            weight = math.sqrt(HUBER / max(math.sqrt(nu @ weights @ nu), HUBER))
            stacked[row : row + 2] = weight * nu
            J[1][row : row + 2] = weight * np.array(by_pose).reshape(2, 3)
            J[2][row : row + 2] = weight * np.array(by_ranges).reshape(2, 3)
            J[3 + places.index(place)][row : row + 2] = weight * np.array(by_place).reshape(2, 2)
            row += 2
        if jacobians is not None:
            _fill(jacobians, [J[0], J[1], by_errors, *J[2:]])
        return stacked

    noise = gtsam.noiseModel.Gaussian.Covariance(scipy.linalg.block_diag(covariance, *seen.covariances))
    return gtsam.CustomFactor(noise, [one, other, errors, seen.common, *places], error)


def _leg(first: Any, second: Any, expected: list[float]) -> tuple[tuple[float, ...], ...]:
    """Return the step between two poses minus the expected one, and its derivatives by increments of both (9,).

    gtsam's increments of a pose are in the frame of that pose.
    """
    x, y, heading = first.x(), first.y(), first.theta()
    dx, dy, turn = second.x() - x, second.y() - y, second.theta() - heading
    c, s = math.cos(heading), math.sin(heading)
    forward, left = c * dx + s * dy, c * dy - s * dx
    residual = forward - expected[0], left - expected[1], turn - expected[2]
    c, s = math.cos(turn), math.sin(turn)
    by_first = -1.0, 0.0, left, 0.0, -1.0, -forward, 0.0, 0.0, -1.0
    return residual, by_first, (c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0)


def _sighting(pose: Any, place: Array, errors: list[float], sighting: Sighting) -> tuple[tuple[float, ...], ...]:
    """Return expected minus measured range and bearing, and derivatives by pose (6,), landmark (4,) and errors (6,)."""
    (x, y), (offset, scale, turned), heading = place.tolist(), errors, pose.theta()
    dx, dy = x - pose.x(), y - pose.y()
    c, s = math.cos(heading), math.sin(heading)
    forward, left = c * dx + s * dy, c * dy - s * dx
    distance, stretch = max(math.hypot(forward, left), MIN_RANGE), 1.0 + scale
    squared, ratio = distance * distance, stretch / distance
    bearing = wrap_angle(math.atan2(left, forward) + turned - sighting.bearing)
    return (
        (offset + stretch * distance - sighting.range, bearing),
        (-ratio * forward, -ratio * left, 0.0, left / squared, -forward / squared, -1.0),
        (ratio * dx, ratio * dy, -dy / squared, dx / squared),
        (1.0, distance, 0.0, 0.0, 0.0, 1.0),
    )


def _fill(jacobians: Any, arrays: list[Array]) -> None:
    """Write arrays into a vector of gtsam, one at a time as it requires."""
    for place, array in enumerate(arrays):
        jacobians[place] = array


def _wrapped(residual: Array) -> Array:
    residual[2] = wrap_angle(float(residual[2]))
    return residual


class SharedPrior:
    """The prior of a vector of errors in an iSAM2 graph, replaced when its variances have changed."""

    def __init__(self, gtsam: Any, key: int, *, changed: float) -> None:
        """Start without a factor in the graph.

        Args:
            gtsam: The module.
            key: Key of the errors.
            changed: The factor by which a variance has to change.
        """
        self._gtsam, self._key, self._changed = gtsam, key, changed
        self._variances: Array | None = None
        self._factor, self._place = -1, -1

    def renew(self, graph: Any, variances: Array) -> list[int]:
        """Add the prior to a graph of new factors if its variances have changed; return which factor is outdated."""
        old = self._variances
        if old is not None and np.all((variances <= self._changed * old) & (old <= self._changed * variances)):
            return []
        noise = self._gtsam.noiseModel.Diagonal.Variances(variances)
        self._variances, self._place = variances, graph.size()
        graph.add(self._gtsam.PriorFactorVector(self._key, np.zeros(len(variances)), noise))
        return [] if self._factor < 0 else [self._factor]

    @property
    def variances(self) -> Array:
        """Those in the graph; zeros before the first."""
        return np.zeros(0) if self._variances is None else self._variances

    def added(self, factors: Any) -> None:
        """Remember the index that the solver has given to the prior, if it was added; `factors` has all new indices."""
        if self._place >= 0:
            self._factor, self._place = factors[self._place], -1


def prior_factor(gtsam: Any, key: int, pose: Array, covariance: Array) -> Any:
    """Return the prior of a pose (3,) with a covariance (3, 3) in the world frame."""
    noise = gtsam.noiseModel.Gaussian.Covariance(turned_covariance(covariance, -float(pose[2])))
    return gtsam.PriorFactorPose2(key, gtsam.Pose2(*pose), noise)


def turned_covariance(covariance: Array, angle: float) -> Array:
    """Return a covariance (3, 3) of (x, y, heading), rotated by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(R @ covariance @ R.T)
