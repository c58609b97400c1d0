"""Inverses of matrices that data may leave singular."""

import numpy as np

from mjsim.geometry import Array

WORST_CONDITION = 1e11
"""Condition number above which nothing of an inverse is right: the sums of squares come from 32-bit numbers."""


def inverse_of(matrix: Array) -> Array | None:
    """Return the inverse of a square matrix; None if it is singular, nearly so, or not finite.

    References:
        Golub, Van Loan, Matrix Computations (2013), section 2.6.2: the condition number, here in the 1-norm.
    """
    try:
        inverse: Array = np.asarray(np.linalg.inv(matrix), dtype=float)
    except np.linalg.LinAlgError:
        return None
    condition = np.abs(matrix).sum(axis=0).max() * np.abs(inverse).sum(axis=0).max()
    return inverse if condition < WORST_CONDITION else None
