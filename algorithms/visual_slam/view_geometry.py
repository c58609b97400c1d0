"""Landmarks as points on rays, and where a camera on a robot that moves in the plane sees them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

CLOSE = 0.05
"""A point closer than this counts as behind the camera, relative to its depth where it was first seen."""
STATES = 5
"""Size of a camera's state: x, y and heading of the robot, and pitch and roll of its body."""


@dataclass(frozen=True, slots=True, eq=False)
class LandmarkRays:
    """Points at unknown or known distances on rays, in one frame of the plane.

    A point is `origin + direction / inverse`. The view of distant points, and of points at an unknown depth, is nearly
    linear in the inverse depth.

    References:
        Civera, Davison, Montiel, Inverse Depth Parametrization for Monocular SLAM, IEEE T-RO 24(5), 2008.
    """

    origins: Array
    """Where each was first seen from, shape (n, 3) [m]."""
    directions: Array
    """Vectors with component 1 along the optical axis, shape (n, 3)."""
    inverses: Array
    """Inverse depth along that axis, shape (n,) [1/m]."""
    variances: Array
    """Of the inverse depths, shape (n,) [1/m^2]."""
    noise: Array
    """Standard deviation of the place in the picture where it was first seen, x / z, shape (n,)."""

    def points(self) -> Array:
        """Return the points, shape (n, 3) [m]."""
        return np.asarray(self.origins + self.directions / self.inverses[:, None])

    def only(self, chosen: NDArray[np.intp]) -> "LandmarkRays":
        """Return some of them, by their indices."""
        return LandmarkRays(
            *(part[chosen] for part in (self.origins, self.directions, self.inverses, self.variances, self.noise))
        )

    def placed(self, poses: Array) -> "LandmarkRays":
        """Return them in another frame, given the pose there of the frame of each, shape (n, 3) [m, m, rad]."""
        return LandmarkRays(
            _turned(self.origins, poses[:, 2]) + np.concatenate([poses[:, :2], np.zeros((len(poses), 1))], axis=1),
            _turned(self.directions, poses[:, 2]),
            self.inverses,
            self.variances,
            self.noise,
        )


def _turned(vectors: Array, headings: Array) -> Array:
    """Return vectors (n, 3) turned about the vertical by angles (n,) [rad]."""
    c, s = np.cos(headings), np.sin(headings)
    x, y, z = vectors.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def seen_from(rays: LandmarkRays, state: Array, robot_from_camera: Array) -> tuple[Array, Array, Array]:
    """Return where a camera sees points, with derivatives.

    Args:
        rays: The points.
        state: Pose of the robot in their frame, and pitch and roll of its body, shape (5,) [m, m, rad, rad, rad].
        robot_from_camera: Pose of the camera in the frame of an upright robot, shape (4, 4) [m].

    Returns:
        z: (x / z, y / z, 1 / z) in the optical frame, shape (n, 3); the inverse depth of points behind it is negative.
        H: Derivative by the state, shape (n, 3, 5).
        H_inverse: Derivative by the inverse depth of each, shape (n, 3).
    """
    x, y, heading, pitch, roll = state.tolist()
    rho = rays.inverses[:, None]
    # All vectors are scaled by the inverse depth, so that points at infinity need no special case.
    offset = rays.origins - (x, y, 0.0)
    level = _turned(rays.directions + rho * offset, np.full(len(rays.inverses), -heading))
    body = level - _leant(level, pitch, roll)
    R, arm = robot_from_camera[:3, :3], robot_from_camera[:3, 3]
    camera = (body - rho * arm) @ R
    c, s = np.cos(heading), np.sin(heading)
    by_state = np.zeros((len(level), 3, STATES))
    by_state[:, :2, 0], by_state[:, :2, 1] = -rho * (c, -s), -rho * (s, c)
    by_state[:, 0, 2], by_state[:, 1, 2] = level[:, 1], -level[:, 0]
    by_state[:, 0, 3], by_state[:, 2, 3] = -level[:, 2], level[:, 0]
    by_state[:, 1, 4], by_state[:, 2, 4] = level[:, 2], -level[:, 1]
    by_inverse = _turned(offset, np.full(len(rho), -heading)) - arm
    depth = np.where(camera[:, 2] > CLOSE, camera[:, 2], np.minimum(camera[:, 2], -CLOSE))
    z = np.concatenate([camera[:, :2], rho], axis=1) / depth[:, None]
    # The quotient rule: (derivative of the numerator - quotient * derivative of the denominator) / denominator.
    moved, by_depth = R.T @ by_state, by_inverse @ R
    H, H_inverse = np.empty_like(moved), np.empty_like(by_depth)
    H[:, :2], H[:, 2] = moved[:, :2], 0.0
    H_inverse[:, :2], H_inverse[:, 2] = by_depth[:, :2], 1.0
    H = (H - z[:, :, None] * moved[:, 2:]) / depth[:, None, None]
    H_inverse = (H_inverse - z * by_depth[:, 2:]) / depth[:, None]
    return z, H, H_inverse


def rays_of(places: Array, state: Array, robot_from_camera: Array) -> tuple[Array, Array]:
    """Return origins (n, 3) and directions (n, 3) in the level frame of the robot, of places (x / z, y / z) (n, 2).

    Args:
        places: In the picture, shape (n, 2).
        state: As for `seen_from`; only pitch and roll count.
        robot_from_camera: Pose of the camera in the frame of an upright robot, shape (4, 4) [m].
    """
    pitch, roll = state[3:].tolist()
    directions = np.concatenate([places, np.ones((len(places), 1))], axis=1) @ robot_from_camera[:3, :3].T
    origin = robot_from_camera[None, :3, 3]
    origin = origin + _leant(origin, pitch, roll)
    return np.repeat(origin, len(places), axis=0), directions + _leant(directions, pitch, roll)


def _leant(vectors: Array, pitch: float, roll: float) -> Array:
    """Return the change of vectors (n, 3) by a small rotation of the body."""
    x, y, z = vectors.T
    return np.stack([pitch * z, -roll * z, roll * y - pitch * x], axis=1)
