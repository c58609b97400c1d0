"""Covariances that modules return: real, symmetric and positive semidefinite, within rounding.

Valid matrices pass a closed form (3 x 3 and 2 x 2) or one Cholesky factorisation (larger ones). Only the others are
checked in detail. Tolerances are relative to the standard deviations of the rows, so that they have the same meaning in
m^2 and in rad^2.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array
from mjsim.sentences import Sentence

TOLERANCE = 1e-6
"""Tolerance of asymmetry and of negative eigenvalues, after scaling every variance to 1; filters in double precision
stay far below it."""
SINGLE_TOLERANCE = 1e-3
"""The same for arrays in single precision or less."""
_MIN_DEVIATION, _MIN_DEVIATION_RATIO = 1e-4, 1e-9
"""Minimum standard deviation for scaling rows [m, rad], and relative to the largest one: after a measurement without
error, a variance is only rounding error of either sign."""
_SQUARE = TOLERANCE**2
_DETERMINANT_TOLERANCE = 1e-15
"""Tolerance of the determinant of a 3 x 3 covariance with variances of 1: that of a singular one is zero except for
rounding."""


class Unfit(ValueError):  # noqa: N818  # as the faults of `mjsim.errors`
    """An invalid result of a module; the message says what is wrong, and what would be right."""


def real_array(label: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return a value as an array of real, finite numbers.

    Args:
        label: Names the value in the message.
        value: Value from the module; an array of doubles is returned unchanged.
        shape: The required shape.

    Raises:
        Unfit: It has another shape, or contains something else.
    """
    given = _array(label, value)
    if given.shape != shape:
        raise Unfit(Sentence("returned {label} of shape {shape}; it must be {right}", label, given.shape, shape))
    array = _as_doubles(label, given)
    if not np.isfinite(array).all():
        raise Unfit(Sentence("returned {label} that is not finite: {entry}", label, _first_bad(array)))
    return array


def covariance(label: str, value: ArrayLike, size: int) -> Array:
    """Return a covariance as an array, shape (size, size).

    Raises:
        Unfit: It is not real, not symmetric, or not positive semidefinite.
    """
    if is_plainly_good(value, size):
        return np.asarray(value)
    P = real_array(label, value, (size, size))
    _check_entries(label, P, tolerance=_tolerance(value))
    return P


def has_good_diagonal(value: Any, size: int) -> bool:
    """Return whether a matrix of doubles is finite, with no negative variance: a quick check of a large covariance."""
    if not (type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (size, size)):
        return False
    return bool(np.isfinite(value).all()) and bool((value.diagonal() >= 0.0).all())


def is_plainly_good(value: Any, size: int) -> bool:
    """Return whether a small covariance is valid by its principal minors; False means that it needs a full check."""
    if not (type(value) is np.ndarray and value.dtype == np.float64 and value.shape == (size, size)):
        return False
    if size == 2:
        return _good_by_minors2(*value.ravel().tolist())
    return size == 3 and _good_by_minors3(*value.ravel().tolist())


def _good_by_minors2(a: float, p: float, p2: float, b: float) -> bool:
    ab = a * b
    return a >= 0.0 and b >= 0.0 and a + b < math.inf and ab >= p * p2 and (p - p2) ** 2 <= _SQUARE * ab


def _good_by_minors3(
    a: float, p: float, q: float, p2: float, b: float, r: float, q2: float, r2: float, c: float
) -> bool:
    # NaN and infinity make one of the comparisons false.
    return (
        _good_by_minors2(a, p, p2, b)
        and _good_by_minors2(a, q, q2, c)
        and _good_by_minors2(b, r, r2, c)
        and a * (b * c - r * r2) - p * (p2 * c - r * q2) + q * (p2 * r2 - b * q2) >= -_DETERMINANT_TOLERANCE * a * b * c
    )


def _check_entries(label: str, P: Array, *, tolerance: float) -> None:
    """Check that a finite matrix is symmetric and positive semidefinite within a tolerance; raises Unfit otherwise."""
    least = max(_MIN_DEVIATION, _MIN_DEVIATION_RATIO * math.sqrt(float(np.abs(P).max())))
    deviations = np.maximum(np.sqrt(np.abs(P.diagonal())), least)
    scaled = P / deviations[:, None] / deviations
    asymmetry = np.abs(scaled - scaled.T)
    if asymmetry.max() > tolerance:
        i, j = divmod(int(asymmetry.argmax()), len(P))
        raise Unfit(
            Sentence(
                "returned {label} that is not symmetric: entry [{i}, {j}] is {p:.6g}, [{j}, {i}] is {q:.6g}",
                *(label, i, j, P[i, j], P[j, i]),
            )
        )
    symmetric = 0.5 * (scaled + scaled.T)
    if _has_cholesky(symmetric, tolerance):
        return
    worst = float(np.linalg.eigvalsh(symmetric)[0])
    if worst < -tolerance:
        own = float(np.linalg.eigvalsh(0.5 * (P + P.T))[0])
        value = f"{own:g}" if own < 0.0 else Sentence("{worst:g} once scaled by its standard deviations", worst)
        raise Unfit(
            Sentence("returned {label} with the eigenvalue {value}; a covariance has none below 0", label, value)
        )


def _has_cholesky(S: Array, tolerance: float) -> bool:
    try:
        np.linalg.cholesky(S + 0.5 * tolerance * np.eye(len(S)))
    except np.linalg.LinAlgError:
        return False
    return True


def _tolerance(value: ArrayLike) -> float:
    kind = getattr(value, "dtype", None)
    return SINGLE_TOLERANCE if kind is not None and kind.kind == "f" and kind.itemsize < 8 else TOLERANCE


def _array(label: str, value: ArrayLike) -> NDArray[Any]:
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(value):
        raise Unfit(Sentence("returned {label} with masked numbers; fill them", label))
    try:
        return np.asarray(value)
    except ValueError:
        raise Unfit(Sentence("returned {label} whose rows differ in length", label)) from None


def _as_doubles(label: str, array: NDArray[Any]) -> Array:
    if array.dtype.kind == "c":
        raise Unfit(Sentence("returned {label} that is complex; it must be real", label))
    if array.dtype.kind not in "biufO":
        raise Unfit(
            Sentence("returned {label} that holds something other than numbers: {sample}", label, _sample(array))
        )
    try:
        return np.asarray(array, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise Unfit(
            Sentence("returned {label} that holds something other than numbers: {sample}", label, _sample(array))
        ) from None


def _sample(array: NDArray[Any]) -> str:
    return repr(array.ravel()[:3].tolist())[:80]


def _first_bad(array: Array) -> str:
    """Return a small array, or the first entry of a large one that is not finite."""
    if array.size <= 9:
        return str(array.tolist())
    index = np.unravel_index(int(np.flatnonzero(~np.isfinite(array))[0]), array.shape)
    return Sentence("entry [{index}] is {value:g}", ", ".join(map(str, index)), array[index])
