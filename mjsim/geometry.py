"""Poses in the plane and in space, angles and segments; NumPy only.

Frames are named as in `outer_from_inner`, so that neighbours cancel:
`p_world = world_from_robot.transform(p_robot)`.
"""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
MAGNIFICATIONS = (1, 2, 5, 10, 20, 50, 100)
"""Magnifications of ellipses in drawings."""


def wrap_angle(angle: float) -> float:
    """Wrap an angle to [-pi, pi) [rad]."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def wrap_angles(angles: ArrayLike) -> Array:
    """Wrap angles to [-pi, pi) [rad], any shape."""
    return np.asarray((np.asarray(angles, dtype=float) + np.pi) % (2.0 * np.pi) - np.pi)


@dataclass(frozen=True, slots=True)
class Pose:
    """A position and a heading in the plane; also the transform outer_from_inner of that frame.

    Examples:
        >>> import mjsim
        >>> world_from_robot = mjsim.Pose(2.0, 1.0, 0.0)
        >>> world_from_robot @ mjsim.Pose(0.5, 0.0, 0.25)
        Pose(x=2.5, y=1.0, heading=0.25)
        >>> world_from_robot.transform([1.0, 0.0]).tolist()
        [3.0, 1.0]
    """

    x: float
    """[m]"""
    y: float
    """[m]"""
    heading: float
    """Counter-clockwise from the x axis [rad]; not wrapped: `wrap_angle` maps it to [-pi, pi)."""

    @classmethod
    def from_array(cls, values: ArrayLike) -> Self:
        """Return the pose of (x, y, heading), shape (3,)."""
        x, y, heading = np.asarray(values, dtype=float).tolist()
        return cls(x, y, heading)

    def as_array(self) -> Array:
        """Return (x, y, heading), shape (3,) [m, m, rad]."""
        return np.array([self.x, self.y, self.heading], dtype=float)

    def matrix(self) -> Array:
        """Return the homogeneous transform outer_from_inner, shape (3, 3)."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return np.array([[c, -s, self.x], [s, c, self.y], [0.0, 0.0, 1.0]])

    def __matmul__(self, inner: "Pose") -> "Pose":
        """Return outer_from_innermost of outer_from_inner @ inner_from_innermost."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose(
            self.x + c * inner.x - s * inner.y,
            self.y + s * inner.x + c * inner.y,
            wrap_angle(self.heading + inner.heading),
        )

    def inverse(self) -> "Pose":
        """Return inner_from_outer."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, wrap_angle(-self.heading))

    def transform(self, points_inner: ArrayLike) -> Array:
        """Return points of the inner frame in the outer frame, shape (..., 2) [m]."""
        points = np.asarray(points_inner, dtype=float)
        c, s = math.cos(self.heading), math.sin(self.heading)
        return np.asarray(points @ np.array([[c, s], [-s, c]]) + (self.x, self.y))


@dataclass(frozen=True, slots=True)
class Pose3:
    """A position and an orientation in space; also the transform outer_from_inner of that frame."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    z: float
    """Up [m]."""
    qx: float
    """Component x of the unit quaternion of outer_from_inner; `qy`, `qz` and `qw` are the others."""
    qy: float
    qz: float
    qw: float

    @classmethod
    def from_planar(cls, pose: Pose) -> Self:
        """Return the pose of a body that stands upright on the floor."""
        half = pose.heading / 2.0
        return cls(float(pose.x), float(pose.y), 0.0, 0.0, 0.0, math.sin(half), math.cos(half))

    @classmethod
    def from_matrix(cls, matrix: Array) -> Self:
        """Return the pose of a homogeneous transform, shape (4, 4) [m].

        References:
            Shepperd, Quaternion from Rotation Matrix, J. of Guidance and Control 1(3), 1978: via the largest component.
        """
        R = matrix[:3, :3]
        trace = float(np.trace(R))
        squares = [trace, *np.diagonal(R).tolist()]
        largest = squares.index(max(squares))
        if largest == 0:
            parts = [1.0 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]
        else:
            i = largest - 1
            j, k = (i + 1) % 3, (i + 2) % 3
            parts = [R[k, j] - R[j, k], 0.0, 0.0, 0.0]
            parts[1 + i], parts[1 + j], parts[1 + k] = 1.0 + 2.0 * R[i, i] - trace, R[i, j] + R[j, i], R[i, k] + R[k, i]
        w, x, y, z = (np.array(parts) / np.linalg.norm(parts)).tolist()
        px, py, pz = matrix[:3, 3].tolist()
        return cls(px, py, pz, x, y, z, w)

    def planar(self) -> Pose:
        """Return the position and the heading of the x axis, both seen from above; the heading is in [-pi, pi]."""
        qx, qy, qz, qw = self.qx, self.qy, self.qz, self.qw
        return Pose(self.x, self.y, math.atan2(2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qy * qy + qz * qz)))

    def pitch(self) -> float:
        """Return how far the body leans forward about its y axis, in [-pi, pi] [rad]."""
        return math.atan2(
            2.0 * (self.qw * self.qy - self.qx * self.qz), 1.0 - 2.0 * (self.qx * self.qx + self.qy * self.qy)
        )

    def as_array(self) -> Array:
        """Return (x, y, z, qx, qy, qz, qw), shape (7,) [m, 1]."""
        return np.array([self.x, self.y, self.z, self.qx, self.qy, self.qz, self.qw], dtype=float)

    def matrix(self) -> Array:
        """Return the homogeneous transform outer_from_inner, shape (4, 4) [m]."""
        qx, qy, qz, qw = self.qx, self.qy, self.qz, self.qw
        return np.array(
            [
                [1.0 - 2.0 * (qy * qy + qz * qz), 2.0 * (qx * qy - qz * qw), 2.0 * (qx * qz + qy * qw), self.x],
                [2.0 * (qx * qy + qz * qw), 1.0 - 2.0 * (qx * qx + qz * qz), 2.0 * (qy * qz - qx * qw), self.y],
                [2.0 * (qx * qz - qy * qw), 2.0 * (qy * qz + qx * qw), 1.0 - 2.0 * (qx * qx + qy * qy), self.z],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )


def roll_and_pitch(quaternions: ArrayLike) -> Array:
    """Return how far bodies lean to the side and forward.

    Args:
        quaternions: Unit quaternions (x, y, z, w) of outer_from_inner, shape (..., 4).

    Returns:
        Roll about x in [-pi, pi], the left side up, and pitch about y in [-pi/2, pi/2], the nose down, both positive;
        shape (..., 2) [rad].

    References:
        ROS REP 103: rotations about the fixed axes x, y, z, in this order, right-handed.
    """
    qx, qy, qz, qw = np.moveaxis(np.asarray(quaternions, dtype=float), -1, 0)
    roll = np.arctan2(2.0 * (qw * qx + qy * qz), 1.0 - 2.0 * (qx * qx + qy * qy))
    pitch = np.arcsin(np.clip(2.0 * (qw * qy - qz * qx), -1.0, 1.0))
    return np.stack([roll, pitch], axis=-1)


def headings(quaternions: ArrayLike) -> Array:
    """Return the headings of the x axes of bodies, seen from above.

    Args:
        quaternions: (x, y, z, w) of outer_from_inner, of any length but 0, shape (..., 4).

    Returns:
        In [-pi, pi], shape (...) [rad].
    """
    qx, qy, qz, qw = np.moveaxis(np.asarray(quaternions, dtype=float), -1, 0)
    return np.asarray(np.arctan2(2.0 * (qw * qz + qx * qy), qw * qw + qx * qx - qy * qy - qz * qz))


def ellipse_points(mean: ArrayLike, covariance: ArrayLike, *, probability: float = 0.95, count: int = 48) -> Array:
    """Return the outlines of the ellipses that contain 2-D Gaussians with the given probability.

    Args:
        mean: Centres, shape (..., 2) [m].
        covariance: Shape (..., 2, 2) [m^2], positive semi-definite.
        probability: In (0, 1).
        count: Number of points of each outline.

    Returns:
        Shape (..., count, 2) [m], in the frame of `mean`.

    References:
        Squared Mahalanobis distance in two dimensions is chi-square with two degrees of freedom, whose
        quantile is -2 ln(1 - p).
    """
    values, vectors = np.linalg.eigh(np.asarray(covariance, dtype=float))
    radii = np.sqrt(np.maximum(values, 0.0) * -2.0 * math.log(1.0 - probability))
    angles = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    turned = (circle * radii[..., None, :]) @ np.swapaxes(vectors, -1, -2)
    return np.asarray(np.asarray(mean, dtype=float)[..., None, :] + turned)


def ellipse_magnification(covariance: ArrayLike, radius: float) -> int:
    """Return the largest of 1, 2, 5, ..., 100 by which the 95 % ellipse of a Gaussian can grow and stay in a circle.

    Args:
        covariance: Shape (2, 2) [m^2].
        radius: Radius of the circle [m].
    """
    reach = float(np.linalg.norm(ellipse_points((0.0, 0.0), covariance), axis=-1).max())
    return max((each for each in MAGNIFICATIONS if each * reach <= radius), default=1)


def align_rigid(source: ArrayLike, target: ArrayLike) -> Pose:
    """Return target_from_source, the rigid motion that moves points closest to their partners.

    Args:
        source: Points, shape (n, 2), n >= 2 [m].
        target: Their partners, shape (n, 2) [m].

    Raises:
        ValueError: Shapes differ or fewer than two points are given.

    References:
        Umeyama, IEEE PAMI 13(4), 1991, without scale, in two dimensions.
    """
    a, b = np.asarray(source, dtype=float), np.asarray(target, dtype=float)
    if a.shape != b.shape or a.ndim != 2 or a.shape[0] < 2 or a.shape[1] != 2:
        raise ValueError(f"shapes are {a.shape} and {b.shape}; both must be (n, 2) with n of at least 2")
    centre_a, centre_b = a.mean(axis=0), b.mean(axis=0)
    u, v = a - centre_a, b - centre_b
    heading = math.atan2(float(np.sum(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])), float(np.sum(u * v)))
    turned = Pose(0.0, 0.0, heading).transform(centre_a)
    return Pose(float(centre_b[0] - turned[0]), float(centre_b[1] - turned[1]), heading)


def nearest_moments(moments: Array) -> Array:
    """Return the nearest principal moments of inertia of which none exceeds the sum of the others.

    The change is minimal in the least-squares sense; moments that are valid come back as they are.

    Args:
        moments: Ascending, shape (3,) [kg m^2].
    """
    excess = max(float(moments[2] - moments[0] - moments[1]), 0.0) / 3.0
    return np.asarray(moments + np.array([excess, excess, -excess]))


def places_at(times: Array, track: Array, *, gap: float) -> Array:
    """Return the planar poses of a robot at some times, NaN where its track has none.

    Args:
        times: Shape (K,) [s].
        track: Rows of time [s], x, y [m] and heading [rad], in order of time.
        gap: Maximum time between two rows to interpolate [s].

    Returns:
        (x, y, heading), shape (K, 3), interpolated linearly.
    """
    before, share, known = _between(times, track[:, 0], gap)
    steps = track[before + 1, 1:] - track[before, 1:]
    steps[:, 2] = wrap_angles(steps[:, 2])
    places = track[before, 1:] + share[:, None] * steps
    places[:, 2] = wrap_angles(places[:, 2])
    return np.where(known[:, None], places, np.nan)


def poses_at(times: Array, track: Array, *, gap: float) -> Array:
    """Return the 3-D poses of a body at some times, NaN where its track has none.

    Args:
        times: Shape (K,) [s].
        track: Rows of time [s], x, y, z [m] and unit quaternion x, y, z, w, in order of time, shape (N, 8).
        gap: Maximum time between two rows to interpolate [s].

    Returns:
        (x, y, z, qx, qy, qz, qw), shape (K, 7), interpolated along the shorter rotation.
    """
    before, share, known = _between(times, track[:, 0], gap)
    first, second = track[before, 1:], track[before + 1, 1:].copy()
    # A quaternion and its negative are the same rotation.
    second[(first[:, 3:] * second[:, 3:]).sum(axis=1) < 0.0, 3:] *= -1.0
    poses = np.where(share[:, None] < 1.0, first, second)  # exactly, even if the other one is NaN
    within = (share > 0.0) & (share < 1.0)
    poses[within] += share[within, None] * (second - first)[within]
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    return np.where(known[:, None], poses, np.nan)


def _between(times: Array, since: Array, gap: float) -> tuple[NDArray[np.intp], Array, NDArray[np.bool_]]:
    """Return for each time the row before it, the weight of the next row, and whether the gap is short enough.

    Args:
        times: Shape (K,) [s].
        since: Times of the rows, shape (N,), N at least 2 [s].
        gap: Maximum time between two rows to interpolate [s].
    """
    # The last of rows with equal times counts.
    after = np.searchsorted(since, times, side="right").clip(1, len(since) - 1)
    before = after - 1
    length = since[after] - since[before]
    inside = (times >= since[before]) & (times <= since[after])
    share = np.where(length > 0.0, (times - since[before]) / np.where(length > 0.0, length, 1.0), 0.0)
    return before, share, inside & (length <= gap)
