"""Pose of a flat picture of known size from the four corners of its image.

The picture's frame has its origin at its center, x to its right, y down, z into the wall; the camera's frame is
optical (x right, y down, z ahead). `camera_from_picture` is a rotation R and an offset t.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Intrinsics

from ..estimation.inverses import inverse_of

STEPS = 8
"""Maximum number of Gauss-Newton steps."""
SETTLED = 1e-3
"""Size of the last step at convergence [m, rad]: the error after a step is of the order of its square."""
EDGE_ON = 1e-6
"""Cosine of the angle between line of sight and normal below which a plane is a line in the image."""
LIKELY_MISFIT = 9.2
"""99 % quantile of chi-square with 2 degrees of freedom: 8 coordinates of corners minus 6 of a pose."""


@dataclass(frozen=True, slots=True, eq=False)
class PlanarPose:
    """The pose of a flat picture in the camera's optical frame."""

    rotation: Array
    """camera_from_picture, shape (3, 3)."""
    position: Array
    """The picture's center, shape (3,) [m]."""
    covariance: Array
    """Covariance of (position, rotation vector in the camera's frame), shape (6, 6) [m, rad]."""
    misfit: float
    """Squared Mahalanobis distance of the corners, 8 - 6 degrees of freedom."""


def picture_corners(width: float, height: float) -> Array:
    """Return the corners in the picture's frame from its top left clockwise, shape (4, 3) [m]."""
    x, y = width / 2.0, height / 2.0
    return np.array([[-x, -y, 0.0], [x, -y, 0.0], [x, y, 0.0], [-x, y, 0.0]])


def image_from_plane(rotation: Array, position: Array, intrinsics: Intrinsics) -> Array:
    """Return the homography from the picture's plane [m] to the image [px], shape (3, 3).

    References:
        Hartley, Zisserman, Multiple View Geometry (2004), equation 8.1: K [r1 r2 t].
    """
    camera_from_plane = rotation.copy()
    camera_from_plane[:, 2] = position
    return intrinsics.matrix() @ camera_from_plane


def pose_from_homography(homography: Array, intrinsics: Intrinsics) -> tuple[Array, Array]:
    """Return an initial guess of rotation (3, 3) and position (3,) [m] of the plane of a homography.

    References:
        Zhang, A Flexible New Technique for Camera Calibration, IEEE PAMI 22(11), 2000, section 3.1.
    """
    columns = np.linalg.solve(intrinsics.matrix(), homography)
    columns = columns * np.sign(columns[2, 2]) / np.sqrt(np.linalg.norm(columns[:, 0]) * np.linalg.norm(columns[:, 1]))
    rough = np.stack([columns[:, 0], columns[:, 1], _cross_matrix(columns[:, 0]) @ columns[:, 1]], axis=1)
    u, _, vt = np.linalg.svd(rough)
    return u @ np.diag([1.0, 1.0, float(np.linalg.det(u @ vt))]) @ vt, columns[:, 2]


def fit_pose(
    corners: Array,
    covariance: Array,
    size: tuple[float, float],
    intrinsics: Intrinsics,
    *,
    guess: tuple[Array, Array] | None = None,
) -> PlanarPose | None:
    """Return the pose that fits the corners best; None for corners that determine none.

    Without a guess, or when the fit from it is poor, both poses of the ambiguity of a plane seen nearly from the
    front are refined, and the better one is returned.

    Args:
        corners: Image of the corners from the picture's top left clockwise, shape (4, 2) [px].
        covariance: Covariance of (u, v) of the corners in turn, shape (8, 8) [px^2].
        size: Width and height of the picture [m].
        intrinsics: Intrinsics of the camera.
        guess: Rotation (3, 3) and position (3,) [m] near the pose.

    References:
        Collins, Bartoli, Infinitesimal Plane-based Pose Estimation, IJCV 109, 2014, for the second pose.
    """
    points, information, start = picture_corners(*size), inverse_of(covariance), guess
    if start is None:
        homography = homography_between(points[:, :2], corners)
        start = None if homography is None else pose_from_homography(homography, intrinsics)
    if start is None or information is None:
        return None
    fit = _refine(*start, points, corners, information, intrinsics)
    if fit is None:
        return None
    if guess is not None:
        if fit.misfit < LIKELY_MISFIT:
            return fit
        start = fit.rotation, fit.position
    mirrored = _mirrored(*start)
    other = None if mirrored is None else _refine(mirrored, start[1], points, corners, information, intrinsics)
    return fit if other is None else min(fit, other, key=lambda each: each.misfit)


def _mirrored(rotation: Array, position: Array) -> Array | None:
    """Return the rotation whose normal is mirrored at the line of sight, shape (3, 3); None for one seen edge-on."""
    sight, normal = position / np.linalg.norm(position), rotation[:, 2]
    if abs(normal @ sight) < EDGE_ON:
        return None
    return rotation_between(normal, 2.0 * (normal @ sight) * sight - normal) @ rotation


def homography_between(source: Array, target: Array) -> Array | None:
    """Return the homography that maps four points to four points, shape (3, 3), last element 1.

    None where three points of one side are on a line: then there is no homography.
    """
    x, y, u, v = source[:, 0], source[:, 1], target[:, 0], target[:, 1]
    one, zero = np.ones(4), np.zeros(4)
    rows = np.concatenate(
        [
            np.stack([x, y, one, zero, zero, zero, -u * x, -u * y], axis=1),
            np.stack([zero, zero, zero, x, y, one, -v * x, -v * y], axis=1),
        ]
    )
    try:
        homography = np.append(np.linalg.solve(rows, np.concatenate([u, v])), 1.0).reshape(3, 3)
    except np.linalg.LinAlgError:
        return None
    return None if inverse_of(homography) is None else homography


def rotation_between(first: Array, second: Array) -> Array:
    """Return the smallest rotation from one unit vector to another, which is not its opposite, shape (3, 3)."""
    axis = _cross_matrix(_cross_matrix(first) @ second)
    return np.asarray(np.eye(3) + axis + axis @ axis / (1.0 + float(first @ second)))


def _refine(
    rotation: Array, position: Array, points: Array, corners: Array, information: Array, intrinsics: Intrinsics
) -> PlanarPose | None:
    """Return the pose after Gauss-Newton steps from an initial guess; None if they lead behind the camera."""
    for _ in range(STEPS):
        turned = points @ rotation.T
        if not min(turned[:, 2].tolist()) > -position[2]:
            return None
        error, H = corner_error(turned, position, corners, intrinsics)
        weighted = H.T @ information
        normal, pull = weighted @ H, weighted @ error
        solvable, solution = cv2.solve(normal, pull[:, None], flags=cv2.DECOMP_CHOLESKY)
        if not solvable:
            return None
        step = np.asarray(solution, dtype=float).ravel()
        position = position + step[:3]
        rotation = rotation_of(step[3:]) @ rotation
        if cv2.norm(step, cv2.NORM_INF) < SETTLED:
            break
    covariance = inverse_of(normal)
    if covariance is None:
        return None
    # Subtract the reduction of the misfit that the last, small step predicts.
    return PlanarPose(rotation, position, covariance, float(error @ information @ error - pull @ step))


def corner_error(turned: Array, position: Array, corners: Array, intrinsics: Intrinsics) -> tuple[Array, Array]:
    """Return measured minus predicted corners, shape (8,) [px], and the derivative of the prediction, shape (8, 6).

    Args:
        turned: Corners relative to the picture's center, in the camera's frame, shape (4, 3) [m].
        position: Position of the center, shape (3,) [m].
        corners: Measured corners, shape (4, 2) [px].
        intrinsics: Intrinsics of the camera.
    """
    fx, fy = intrinsics.fx, intrinsics.fy
    left, rows = [], []
    # Four points: plain numbers are several times faster than arrays.
    for (a, b, c), (x, y, z), seen in zip(turned.tolist(), (turned + position).tolist(), corners.tolist(), strict=True):
        u, v, fu, fv = x / z, y / z, fx / z, fy / z
        left += [seen[0] - fx * u - intrinsics.cx, seen[1] - fy * v - intrinsics.cy]
        # By position, then by a small turn w of the camera's axes, which moves (a, b, c) by w x (a, b, c).
        rows.append([fu, 0.0, -fu * u, -fu * u * b, fu * (c + u * a), -fu * b])
        rows.append([0.0, fv, -fv * v, -fv * (c + v * b), fv * v * a, fv * a])
    return np.array(left), np.array(rows)


def rotation_of(vector: Array) -> Array:
    """Return the rotation of a rotation vector [rad] by Rodrigues' formula, shape (3, 3)."""
    return np.asarray(cv2.Rodrigues(vector)[0])


def _cross_matrix(vector: Array) -> Array:
    """Return the matrix of the cross product with a vector."""
    x, y, z = vector.tolist()
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
