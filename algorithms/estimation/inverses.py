"""Inverses of matrices that data may leave singular."""

import cv2
import numpy as np

from mjsim.geometry import Array

WORST_CONDITION = 1e11
"""Condition number above which an inverse has no correct digits: the sums of squares come from 32-bit numbers."""


def inverse_of(matrix: Array) -> Array | None:
    """Return the inverse of a square matrix; None if it is singular, nearly so, or not finite.

    References:
        Golub, Van Loan, Matrix Computations (2013), section 2.6.2: the condition number, here in the Frobenius norm.
    """
    regular, inverse = cv2.invert(matrix)
    return np.asarray(inverse) if regular and cv2.norm(matrix) * cv2.norm(inverse) < WORST_CONDITION else None
