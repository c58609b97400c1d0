"""Covariances and information of planar poses, inverted in closed form.

NumPy's general routines take ten times as long for a 3 x 3 matrix, and an estimator inverts dozens per scan.
"""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array


def inverse(P: Array) -> Array:
    """Return the inverse of a symmetric positive definite matrix, shape (3, 3); only its upper triangle is read.

    References:
        Golub, Van Loan, Matrix Computations (2013), section 4.1: the LDL^T factorisation, stable for such matrices.
    """
    (a, b, c), (_, d, e), (_, _, f) = P.tolist()
    p, m = b / a, c / a
    d, e = d - p * b, e - p * c
    n = e / d
    k, i, j, h = p * n - m, 1.0 / a, 1.0 / d, 1.0 / (f - m * c - n * e)
    xy, x, y = -p * j - k * n * h, k * h, -n * h
    return np.array([[i + p * p * j + k * k * h, xy, x], [xy, j + n * n * h, y], [x, y, h]])


def solution(H: Sequence[Sequence[float]], right: Sequence[float]) -> list[float]:
    """Return the solution of H x = a right side (3,), H symmetric and positive definite, shape (3, 3)."""
    (a, b, c), (_, d, e), (_, _, f) = H
    u, v, w = right
    p, m = b / a, c / a
    d, e = d - p * b, e - p * c
    n = e / d
    v = v - p * u
    z = (w - m * u - n * v) / (f - m * c - n * e)
    y = v / d - n * z
    return [u / a - p * y - m * z, y, z]
