"""Corrections of pose and landmarks that rotate the map as a whole, along the exponential of SE_(1+n)(2)."""

import math

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

BLOCK = 64
"""Rows of P that are changed at a time, so that they stay in the processor's cache."""

Rows = NDArray[np.intp]
"""Indices of x and y of points in the state, shape (n, 2)."""


def moved_along(mean: Array, step: Array, rows: Rows) -> Array:
    """Return the mean after a step along the exponential, shape (m,).

    Args:
        mean: Mean of x, y, heading and more, shape (m,).
        step: Step in the errors of the textbook, shape (m,).
        rows: Rows of the position and of the landmarks.
    """
    turn, new = float(step[2]), mean + step
    old = mean[rows]
    shifts = step[rows] - turn * turned_left(old)
    new[rows] = old @ _rotation(turn).T + shifts @ _arc(turn).T
    return np.asarray(new)


def derivatives_by_step(
    mean: Array, step: Array, columns: Rows, H_pose: Array, H_landmark: Array
) -> tuple[Array, Array]:
    """Return H times the derivative of R p + V (d - J p turn), to which the step has moved a point p."""
    turn, rows = float(step[2]), np.concatenate([np.arange(2)[None], columns])
    old, V = mean[rows], _arc(turn)
    shifts = step[rows] - turn * turned_left(old)
    by_turn = turned_left(old) @ (_rotation(turn) - V).T + shifts @ _arc_slope(turn).T
    by_pose = np.array(H_pose)
    by_pose[:, :, :2] = H_pose[:, :, :2] @ V
    by_pose[:, :, 2] += H_pose[:, :, :2] @ by_turn[0] + np.einsum("kij,kj->ki", H_landmark, by_turn[1:])
    return by_pose, H_landmark @ V


def shear(P: Array, moved: Array, rows: Rows, W: Array, spare: Array) -> None:
    """Subtract W^T W from P, then add `moved` times the heading's error to that of each point: P <- S P S^T.

    With c the column of S and h the heading's row of P, S P S^T = P + c h^T + h c^T, with half of its own multiple
    of c included in h. That is P + u u^T - v v^T, which is symmetric to the last bit and takes one pass over P.

    Args:
        P: Shape (m, m), changed in place.
        moved: Motion of each point, shape (n, 2) [m/rad].
        rows: Rows of the points.
        W: Shape (k, m).
        spare: Room for at least m m numbers.
    """
    size = len(P)
    column = np.zeros(size)
    column[rows] = moved
    loss = spare[: size * size].reshape(size, size)
    heading = P[2] - W[:, 2] @ W
    heading += 0.5 * heading[2] * column
    # Scaled to equal size, to lose few digits where u u^T and v v^T are nearly equal.
    sizes = float(np.linalg.norm(column)), float(np.linalg.norm(heading))
    scale = math.sqrt(sizes[0] / sizes[1]) if all(sizes) else 1.0
    along, across = column / scale, heading * scale
    u, v = (along + across) / math.sqrt(2.0), (along - across) / math.sqrt(2.0)
    taken = np.vstack([W, v])
    np.matmul(taken.T, taken, out=loss)
    given = np.empty((BLOCK, size))
    for start in range(0, size, BLOCK):
        some = slice(start, min(start + BLOCK, size))
        block = np.multiply(u[some, None], u, out=given[: some.stop - start])
        block -= loss[some]
        P[some] += block


def turned_left(points: Array) -> Array:
    """Return J times each point, shape (n, 2)."""
    return np.stack([-points[:, 1], points[:, 0]], axis=-1)


def _rotation(turn: float) -> Array:
    c, s = math.cos(turn), math.sin(turn)
    return np.array([[c, -s], [s, c]])


def _arc(turn: float) -> Array:
    """Return the integral of the rotation over the turn, shape (2, 2); Barrau and Bonnabel, appendix A."""
    if abs(turn) < 1e-6:
        along, across = 1.0, turn / 2
    else:
        along, across = math.sin(turn) / turn, (1.0 - math.cos(turn)) / turn
    return np.array([[along, -across], [across, along]])


def _arc_slope(turn: float) -> Array:
    """Return the derivative of `_arc` by the turn, shape (2, 2)."""
    if abs(turn) < 1e-4:
        along, across = -turn / 3, 0.5
    else:
        c, s = math.cos(turn), math.sin(turn)
        along, across = (turn * c - s) / turn**2, (turn * s + c - 1.0) / turn**2
    return np.array([[along, -across], [across, along]])
