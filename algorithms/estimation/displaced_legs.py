"""Legs of odometry in which a robot was displaced: pushed, carried, or with wheels that spun.

A graph that trusts its odometry spreads such a displacement over minutes, and bends the path and the map. All other
measurements together predict each leg: the one that differs most from its prediction is the displaced one.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from mjsim.geometry import Array

from .relocation import CARRIED

DISPLACED = np.eye(3)
"""Covariance of a displacement [m^2, m^2, rad^2]."""
CHUNK = 100
"""Number of legs compared at once, which bounds the memory that long drives need."""


class Factors(NamedTuple):
    """Measurements of one kind, linearised: each depends on two blocks of the state."""

    residuals: Array
    """Expected minus measured, shape (k, m)."""
    jacobians: Array
    """Derivatives of the expected values by both blocks, shape (k, m, a + b)."""
    information: Array
    """Inverse covariances, shape (k, m, m)."""
    columns: NDArray[np.intp]
    """Indices of the state that they depend on, shape (k, a + b)."""

    def equations(self, size: int) -> tuple[csc_array, Array]:
        """Return their part of the normal equations: matrix (size, size) and gradient (size,)."""
        weighted = self.jacobians.transpose(0, 2, 1) @ self.information
        blocks, width = weighted @ self.jacobians, self.columns.shape[1]
        rows, columns = np.repeat(self.columns, width, axis=1), np.tile(self.columns, (1, width))
        pulls = (weighted @ self.residuals[:, :, None]).ravel()
        matrix = csc_array((blocks.ravel(), (rows.ravel(), columns.ravel())), shape=(size, size))
        return matrix, np.asarray(np.bincount(self.columns.ravel(), pulls, size), dtype=float)


def displacement_odds(poses: Array, first: Array, legs: Factors, sightings: Factors, size: int) -> Array:
    """Return for each leg the logarithm of the odds that the robot was displaced in it.

    They are prior odds, divided among the legs, times the ratio of the likelihoods of all measurements with and without
    a displacement, after one Gauss-Newton step. A displacement moves all poses after the leg as one rigid body.

    Args:
        poses: The poses of the graph, at the beginning of the state, shape (n, 3) [m, m, rad].
        first: Information of the first pose, shape (3, 3).
        legs: Odometry from each pose to the next, n - 1 of them.
        sightings: Robustly weighted.
        size: Of the state.

    References:
        Baarda, A Testing Procedure for Use in Geodetic Networks, Netherlands Geodetic Commission, 1968.
    """
    number = len(poses)
    H, pull = sightings.equations(size)
    trusted, gradient = legs.equations(size)
    corner = csc_array((first.ravel(), (np.repeat(range(3), 3), np.tile(range(3), 3))), shape=(size, size))
    solve = splu((H + trusted + corner).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0).solve
    step = solve(-(pull + gradient))
    # Motion of each pose when everything turns and shifts as one, about the origin.
    body = np.tile(np.eye(3), (number, 1, 1))
    body[:, 0, 2], body[:, 1, 2] = -poses[:, 1], poses[:, 0]
    odds = np.empty(number - 1)
    for begin in range(0, number - 1, CHUNK):
        chunk = np.arange(begin, min(begin + CHUNK, number - 1))
        moves = np.zeros((size, 3, len(chunk)))
        after = np.arange(number)[:, None] > chunk
        moves[: 3 * number] = (body[:, :, :, None] * after[:, None, None]).reshape(3 * number, 3, -1)
        flat = moves.reshape(size, -1)
        pulled = H @ flat
        followed = solve(pulled).reshape(moves.shape)
        Q = np.einsum("six,sjx->xij", moves, pulled.reshape(moves.shape))
        Q -= np.einsum("six,sjx->xij", pulled.reshape(moves.shape), followed)
        force = (flat.T @ pull + pulled.T @ step).reshape(3, -1).T
        # A displacement turns about the pose after the leg.
        about = np.tile(np.eye(3), (len(chunk), 1, 1))
        about[:, 0, 2], about[:, 1, 2] = poses[chunk + 1, 1], -poses[chunk + 1, 0]
        Q, force = about.transpose(0, 2, 1) @ Q @ about, about.transpose(0, 2, 1) @ force[:, :, None]
        gained = 0.5 * force.transpose(0, 2, 1) @ np.linalg.solve(Q + np.linalg.inv(DISPLACED), force)
        odds[chunk] = (
            np.log(CARRIED / (number - 1)) + gained[:, 0, 0] - 0.5 * np.linalg.slogdet(np.eye(3) + DISPLACED @ Q)[1]
        )
    return odds
