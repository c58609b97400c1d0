"""Motion and measurement models of the plane, each with its derivatives.

A motion takes the pose (x, y, heading) and a control, and returns the new pose, the derivative F (3, 3) by the
pose and the derivative G (3, m) by the control. World frame, metres and radians.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.linalg.blas import dtrsm

from mjsim.geometry import Array, wrap_angle, wrap_angles

Places = np.ndarray[tuple[int], np.dtype[np.intp]]
"""Indices of x of k landmarks in the mean, shape (k,)."""

MotionModel = Callable[[Array, Array], tuple[Array, Array, Array]]
"""motion(pose, control) -> new pose (3,), F (3, 3), G (3, m)."""

MIN_RANGE = 1e-3
"""Minimum range of a landmark after correction [m]."""


class Slopes(NamedTuple):
    """Derivatives of k measurements of range and bearing."""

    pose: Array
    """Shape (k, 2, 3)."""
    landmark: Array
    """Each by its landmark, shape (k, 2, 2)."""
    sensor: Array
    """By the errors of the sensor, shape (k, 2, s)."""


def bicycle_motion(wheelbase: float, period: float) -> MotionModel:
    """Return the motion of a vehicle driven and steered at its front wheel.

    Args:
        wheelbase: Distance between the axles [m].
        period: Time that one control lasts [s].

    Returns:
        A motion with control (speed [m/s], steering angle [rad, left positive]).

    References:
        Dissanayake et al., A Solution to the SLAM Problem, IEEE T-RA 17(3), 2001, section V, taken at the front wheel.
    """

    def move(pose: Array, control: Array) -> tuple[Array, Array, Array]:
        x, y, heading = pose.tolist()
        speed, steering = float(control[0]), float(control[1])
        c, s = math.cos(heading + steering), math.sin(heading + steering)
        sine, step = math.sin(steering), speed * period
        F = np.array([[1.0, 0.0, -step * s], [0.0, 1.0, step * c], [0.0, 0.0, 1.0]])
        G = np.array(
            [
                [period * c, -step * s],
                [period * s, step * c],
                [period * sine / wheelbase, step * math.cos(steering) / wheelbase],
            ]
        )
        return np.array([x + step * c, y + step * s, wrap_angle(heading + step * sine / wheelbase)]), F, G

    return move


def odometry_motion() -> MotionModel:
    """Return the motion by odometry: control (forward [m], left [m], turn [rad]) in the robot's frame before it.

    References:
        Smith, Self, Cheeseman, Estimating Uncertain Spatial Relationships in Robotics, 1990: compounding, section 3.2.
    """

    def move(pose: Array, control: Array) -> tuple[Array, Array, Array]:
        x, y, heading = pose.tolist()
        forward, left, turn = np.asarray(control, dtype=float).tolist()
        c, s = math.cos(heading), math.sin(heading)
        dx, dy = c * forward - s * left, s * forward + c * left
        F = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
        G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        return np.array([x + dx, y + dy, wrap_angle(heading + turn)]), F, G

    return move


def range_bearing(pose: Array, landmarks: Array) -> tuple[Array, Array, Array]:
    """Predict range and bearing of landmarks, with derivatives by the pose and by each landmark.

    Args:
        pose: (x, y, heading) in the world frame, shape (3,).
        landmarks: Positions in the world frame, shape (k, 2) [m].

    Returns:
        z: Range [m] and bearing [rad, in [-pi, pi), left positive], shape (k, 2).
        H_pose: Derivative of z by the pose, shape (k, 2, 3).
        H_landmark: Derivative of z by the landmark, shape (k, 2, 2).

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 10.1 lines 14 to 16.
    """
    dx, dy = (landmarks - pose[:2]).T
    squared = dx * dx + dy * dy
    distance = np.sqrt(squared)
    z = np.stack([distance, (np.arctan2(dy, dx) - pose[2] + np.pi) % (2.0 * np.pi) - np.pi], axis=-1)
    H_landmark = np.empty((len(landmarks), 2, 2))
    H_landmark[:, 0, 0], H_landmark[:, 0, 1] = dx / distance, dy / distance
    H_landmark[:, 1, 0], H_landmark[:, 1, 1] = -dy / squared, dx / squared
    H_pose = np.zeros((len(landmarks), 2, 3))
    H_pose[:, :, :2] = -H_landmark
    H_pose[:, 1, 2] = -1.0
    return z, H_pose, H_landmark


def landmark_from(pose: Array, measurement: Array) -> tuple[Array, Array]:
    """Return the position of a landmark seen from a pose, and its derivative by the measurement.

    Args:
        pose: (x, y, heading) in the world frame, shape (3,).
        measurement: Range [m] and bearing [rad, left positive], shape (2,).

    Returns:
        landmark: World frame, shape (2,) [m].
        J: Derivative of it by the measurement, shape (2, 2).

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 10.1 line 10, the inverse of the measurement.
    """
    distance, bearing = float(measurement[0]), float(measurement[1])
    c, s = math.cos(float(pose[2]) + bearing), math.sin(float(pose[2]) + bearing)
    landmark = np.array([float(pose[0]) + distance * c, float(pose[1]) + distance * s])
    return landmark, np.array([[c, -distance * s], [s, distance * c]])


def measured(z: Array, H_pose: Array, H_landmark: Array, errors: Array) -> tuple[Array, Slopes]:
    """Return what a sensor with errors (s,) measures, shape (k, 2), and derivatives; exact without errors (s = 0).

    Args:
        z: True range [m] and bearing [rad], shape (k, 2).
        H_pose: Derivative of it by the pose, shape (k, 2, 3).
        H_landmark: Jacobian by the landmark, shape (k, 2, 2).
        errors: Offset [m] and relative error of the range, shape (2,); offset of the bearing too [rad], (3,); or (0,).
    """
    H_sensor = np.zeros((len(z), 2, len(errors)))
    if not len(errors):
        return z, Slopes(H_pose, H_landmark, H_sensor)
    offset, scale, turned = (*errors.tolist(), 0.0)[:3]
    H_sensor[:, 0, 0], H_sensor[:, 0, 1], H_sensor[:, 1, 2:] = 1.0, z[:, 0], 1.0
    stretch = np.array([1.0 + scale, 1.0])
    H = Slopes(stretch[:, None] * H_pose, stretch[:, None] * H_landmark, H_sensor)
    return np.asarray(z * stretch + (offset, turned)), H


def corrected(z: Array, errors: Array) -> tuple[Array, Array, Array]:
    """Return the true range and bearing of a measurement by a sensor with errors (s,).

    Returns:
        z: True range [m] and bearing [rad], shape (2,).
        J: Derivative by the measurement, shape (2, 2).
        J_errors: Derivative by the errors, shape (2, s).
    """
    if not len(errors):
        return z, np.eye(2), np.zeros((2, 0))
    offset, scale, turned = (*errors.tolist(), 0.0)[:3]
    stretch = 1.0 + scale
    true = max((float(z[0]) - offset) / stretch, MIN_RANGE)
    by_errors = np.array([[-1.0 / stretch, -true / stretch, 0.0], [0.0, 0.0, -1.0]])[:, : len(errors)]
    return np.array([true, float(z[1]) - turned]), np.diag([1.0 / stretch, 1.0]), by_errors


def innovation(Z: Array, expected: Array) -> Array:
    """Return measured minus expected range and bearing, shape (k, 2) [m, rad]."""
    nu = Z - expected
    nu[:, 1] = wrap_angles(nu[:, 1])
    return nu


def together(R: Array, count: int) -> Array:
    """Return the joint covariance of measurements, shape (k, 2, k, 2): given one for all, one for each, or itself."""
    if R.shape == (2 * count, 2 * count):
        return R.reshape(count, 2, count, 2)
    together, each = np.zeros((count, 2, count, 2)), np.arange(count)
    together[each, :, each] = R
    return together


def gain(HP: Array, S: Array, nu: Array) -> tuple[Array, Array, float]:
    """Return the step K nu, shape (n,), W = L^-1 H P, shape (m, n), with S = L L^T, and the likelihood of nu.

    The likelihood is a logarithm, without the term of (2 pi)^(m / 2).
    """
    L = np.asarray(np.linalg.cholesky(S), dtype=float)
    W, white = solved(L, HP), solved(L, nu[:, None])[:, 0]
    return W.T @ white, W, float(-0.5 * white @ white - np.log(np.diag(L)).sum())


def solved(L: Array, B: Array) -> Array:
    """Return L^-1 B, shape (m, n), for a lower triangular L, shape (m, m).

    By BLAS: LAPACK's function starts one thread per core, however small L is, and waits for all.
    """
    return np.asarray(dtrsm(1.0, L.T, B.T, side=1).T)


def couple(P: Array, B: Array) -> None:
    """Add the effect of errors of p parameters, times B (3, p), on the pose to P, whose rows already have F P.

    Args:
        P: Covariance of pose, parameters and landmarks, changed in place; columns of the pose are left to the caller.
        B: Derivative of the pose by the parameters, shape (3, p).
    """
    base = 3 + B.shape[1]
    crossed = P[:3, 3:base] @ B.T
    P[:3, :3] += crossed + crossed.T + B @ P[3:base, 3:base] @ B.T
    P[:3, 3:] += B @ P[3:base, 3:]


def projected(P: Array, places: Places, H: Slopes, sensor: slice) -> tuple[Array, Array]:
    """Return H P, shape (2 k, m), and H P H^T, shape (2 k, 2 k).

    Args:
        P: Covariance of pose, parameters and landmarks, shape (m, m).
        places: Indices of x of k landmarks in it, shape (k,).
        H: Derivatives of each measurement.
        sensor: Where the errors of the sensor are in P.
    """
    count, columns = 2 * len(places), places[:, None] + (0, 1)
    HP = (H.pose @ P[:3] + H.landmark @ P[columns]).reshape(count, len(P))
    if H.sensor.size:
        HP += (H.sensor @ P[sensor]).reshape(count, len(P))
    C = (HP[:, :3] @ H.pose.reshape(count, 3).T).reshape(count, len(places), 2)
    C += np.einsum("akj,kij->aki", HP[:, columns], H.landmark)
    if H.sensor.size:
        C += (HP[:, sensor] @ H.sensor.reshape(count, -1).T).reshape(C.shape)
    return HP, C.reshape(count, count)
