"""The pose of a camera from landmarks: matched near where they should be seen, or by appearance alone."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

from ..beacon_vision.picture_features import match
from .picture_points import PicturePoints
from .view_geometry import LandmarkRays, seen_from

GATE = 11.8
"""Squared Mahalanobis distance of a feature from where a landmark should be (chi-square, 2 degrees of freedom: 99.7 %).
"""
ALIKE = 56
"""Maximum number of bits by which two descriptors of one point differ, of 256."""
OUTLIER = 16.3
"""Squared normalised error above which a match is wrong (chi-square, 3 degrees of freedom: 99.9 %)."""
SOFT = 4.0
"""Squared normalised error at which the weight of a match is halved (Cauchy)."""
ROUNDS = 5
"""Iterations of Gauss-Newton."""
INDEPENDENT = 10.0
"""Number of independent matches that all matches of a picture count for: errors of landmarks and of the lens are
shared."""
MIN_MATCHES = 8
"""Minimum number of matches that give a pose."""
TRIES, NEAR = 150, 0.25
"""Number of poses tried from some matches each, and maximum standard deviation of the inverse depths of the landmarks,
relative to it."""
OFF_FLOOR = 0.2
"""Maximum height above the floor [m], and tilt [rad], of a robot at such a pose."""
SEARCHED = 0.1
"""Maximum variance of an inverse depth for which a feature is looked for along its ray [1/m^2]."""
VAGUE, ANY_DEPTH = 0.5, 1e2
"""Standard deviation of an inverse depth, relative to it, above which only the direction of a landmark counts, and the
variance that it has then [1/m^2]."""
REACH = 0.012
"""Error of a place (x / z) up to which a match agrees with such a pose."""


@dataclass(frozen=True, slots=True, eq=False)
class Located:
    """The pose from which a picture was taken."""

    state: Array
    """As for `seen_from`, shape (5,)."""
    covariance: Array
    """Shape (5, 5)."""
    landmarks: NDArray[np.intp]
    """Indices of the landmarks that agree with it."""
    features: NDArray[np.intp]
    """Index of the feature of each."""
    visible: NDArray[np.intp]
    """Indices of the landmarks that should be in the picture."""


def locate(
    points: PicturePoints,
    rays: LandmarkRays,
    descriptors: NDArray[np.uint64],
    guess: Array,
    prior: tuple[Array, Array],
    *,
    robot_from_camera: Array,
    extent: tuple[Array, Array],
) -> Located:
    """Return the pose of a picture by the landmarks that it shows where they should be.

    It minimises the squared errors of places in the picture and of inverse depths, weighted by the covariance of each
    with that of the landmark's depth, together with the prior (Gauss-Newton with Cauchy's weights).

    Args:
        points: Features of the picture.
        rays: Landmarks.
        descriptors: Of the landmarks, shape (m, 4).
        guess: Where to look for them, shape (5,).
        prior: Mean (5,) and covariance (5, 5) of the pose without the picture.
        robot_from_camera: Pose of the camera, shape (4, 4) [m].
        extent: Smallest and largest place in a picture, shape (2,) each.

    References:
        Mur-Artal, Tardos, ORB-SLAM2, IEEE T-RO 33(5), 2017, section III.C: motion-only bundle adjustment. Civera et al.
        (2008), section III: measurements of points on rays.
    """
    z, H, H_inverse = seen_from(rays, guess, robot_from_camera)
    low, high = extent
    inside = (z[:, 2] > 0.0) & ((z[:, :2] > low) & (z[:, :2] < high)).all(axis=1)
    visible = np.flatnonzero(inside)
    mean, covariance = prior
    rows, columns = _matched(points, rays, descriptors, visible, (z, H, H_inverse), covariance)
    if len(rows) < MIN_MATCHES:
        return Located(mean, covariance, rows[:0], columns[:0], visible)
    chosen, seen, noise = rays.only(rows), points.rays[columns], points.noise[columns]
    state, information = guess, np.linalg.inv(covariance)
    R = np.zeros((len(rows), 3, 3))
    R[:, (0, 1, 2), (0, 1, 2)] = noise**2
    R[:, (0, 1), (0, 1)] += chosen.noise[:, None] ** 2
    # Uncertain depths share a prior mean, which would act as false information about how far the robot moved.
    variances = np.where(chosen.variances < (VAGUE * chosen.inverses) ** 2, chosen.variances, ANY_DEPTH)
    for number in range(ROUNDS + 1):
        z, H, H_inverse = seen_from(chosen, state, robot_from_camera)
        error = seen - z
        S = R + variances[:, None, None] * H_inverse[:, :, None] * H_inverse[:, None, :]
        W = np.linalg.inv(S)
        squared = np.einsum("ki,kij,kj->k", error, W, error)
        if number == ROUNDS:
            break
        weights = 1.0 / (1.0 + squared / SOFT)
        weights *= min(1.0, INDEPENDENT / weights.sum())
        HW = H.transpose(0, 2, 1) @ W
        known = information + np.einsum("k,kij,kjl->il", weights, HW, H)
        pull = np.einsum("k,kij,kj->i", weights, HW, error) + information @ (mean - state)
        state = state + np.linalg.solve(known, pull)
    agree = squared < OUTLIER
    return Located(state, np.linalg.inv(known), rows[agree], columns[agree], visible)


def _matched(
    points: PicturePoints,
    rays: LandmarkRays,
    descriptors: NDArray[np.uint64],
    visible: NDArray[np.intp],
    expected: tuple[Array, Array, Array],
    covariance: Array,
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of a landmark and a feature, each the other's most similar within the gate."""
    z, H, H_inverse = (part[visible, :2] for part in expected)
    S = H @ covariance @ H.transpose(0, 2, 1)
    S += np.minimum(rays.variances[visible], SEARCHED)[:, None, None] * H_inverse[:, :, None] * H_inverse[:, None, :]
    noise = rays.noise[visible] ** 2 + float(np.median(points.noise[:, 0])) ** 2 if len(points) else 0.0
    a, b, c = S[:, 0, 0] + noise, S[:, 0, 1], S[:, 1, 1] + noise
    determinant = a * c - b * b
    p, q, r = ((part / determinant).astype(np.float32)[:, None] for part in (c, -2.0 * b, a))
    dx, dy = (points.rays[None, :, k].astype(np.float32) - z[:, k, None].astype(np.float32) for k in (0, 1))
    row, column = np.nonzero(p * dx * dx + q * dx * dy + r * dy * dy < GATE)
    bits = np.bitwise_count(descriptors[visible[row]] ^ points.descriptors[column]).sum(axis=1, dtype=np.intp)
    alike = bits <= ALIKE
    return mutual(visible[row[alike]], column[alike], bits[alike])


def mutual(
    rows: NDArray[np.intp], columns: NDArray[np.intp], bits: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the pairs of mutual nearest neighbours, given the number of different bits of each pair."""
    order = np.argsort(bits, kind="stable")
    by_row, by_column = (order[np.unique(each[order], return_index=True)[1]] for each in (rows, columns))
    both = np.intersect1d(by_row, by_column)
    return rows[both], columns[both]


def locate_anywhere(
    points: PicturePoints,
    rays: LandmarkRays,
    descriptors: NDArray[np.uint64],
    *,
    robot_from_camera: Array,
) -> Array | None:
    """Return the pose (3,) in the plane that most features similar to landmarks agree with; None if there is none.

    Args:
        points: Features of a picture.
        rays: Landmarks, in the frame of the pose.
        descriptors: Of the landmarks.
        robot_from_camera: Pose of the camera, shape (4, 4) [m].

    References:
        Fischler, Bolles, Random Sample Consensus, Communications of the ACM 24(6), 1981. Ke, Roumeliotis, An Efficient
        Algebraic Solution to the Perspective-Three-Point Problem, CVPR 2017.
    """
    features, landmarks = match(points.descriptors, descriptors)
    back, forth = match(descriptors, points.descriptors)
    known = np.isin(features * len(descriptors) + landmarks, forth * len(descriptors) + back)
    known &= rays.variances[landmarks] < (NEAR * rays.inverses[landmarks]) ** 2
    features, landmarks = features[known], landmarks[known]
    if len(features) < MIN_MATCHES:
        return None
    places, seen = rays.only(landmarks).points(), points.rays[features, :2]
    found, turned, shift, agreeing = cv2.solvePnPRansac(
        places, seen, np.eye(3), None, iterationsCount=TRIES, reprojectionError=REACH, flags=cv2.SOLVEPNP_AP3P
    )
    if not found or agreeing is None or len(agreeing) < MIN_MATCHES:
        return None
    camera_from_frame = np.eye(4)
    camera_from_frame[:3, :3], camera_from_frame[:3, 3] = cv2.Rodrigues(turned)[0], shift[:, 0]
    frame_from_robot = np.linalg.inv(robot_from_camera @ camera_from_frame)
    if abs(frame_from_robot[2, 3]) > OFF_FLOOR or frame_from_robot[2, 2] < math.cos(OFF_FLOOR):
        return None
    x, y = frame_from_robot[:2, 3].tolist()
    return np.array([x, y, math.atan2(frame_from_robot[1, 0], frame_from_robot[0, 0])])
