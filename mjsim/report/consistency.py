"""Consistency of an estimator: NEES and NIS compared with chi-square bounds.

References:
    Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation (2001), section 5.4.2.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.record import Track
from mjsim.report.metrics import normalised_squares
from mjsim.sentences import Sentence

STATES = 3
"""Number of states of a pose: x, y, heading."""
PROBABILITY = 0.95
"""Probability that a value of a consistent estimator is between two-sided bounds."""
NIS_FINE = 4.0
"""Largest mean NIS that counts as expected: errors of range and bearing within a factor of root 2."""
NO_ESTIMATOR = "no estimator"
"""Reason why tables do not show the NEES of a robot with dead reckoning alone."""


def chi_square_bounds(freedom: float, *, count: float = 1.0) -> tuple[float, float]:
    """Return the two-sided 95 % bounds of the mean of independent chi-square values.

    Args:
        freedom: Degrees of freedom of each value.
        count: Number of values in the mean.

    References:
        Bar-Shalom, Li, Kirubarajan (2001), eq. 5.4.2-10: the sum of `count` values is chi-square with `freedom` x
        `count` degrees of freedom.
    """
    from scipy.special import chdtri

    tail = (1.0 - PROBABILITY) / 2.0
    low, high = (float(chdtri(freedom * count, above)) / count for above in (1.0 - tail, tail))
    return low, high


def independent_count(values: Array) -> float:
    """Return the effective number of independent values of an autocorrelated series.

    Args:
        values: Shape (N,), finite, equally spaced in time.

    Returns:
        N / (1 + 2 (rho_1 + rho_2 + ...)), in [1, N], where rho_k is the autocorrelation at lag k; summed in pairs
        up to the first that is not positive.

    References:
        Geyer, Practical Markov Chain Monte Carlo, Statistical Science 7(4), 1992, section 3.3: the initial positive
        sequence.
    """
    count = len(values)
    centred = values - values.mean() if count else values
    if count < 2 or not centred.any():
        return float(max(count, 1))
    size = 2 ** int(np.ceil(np.log2(2 * count)))
    products = np.fft.irfft(np.abs(np.fft.rfft(centred / np.abs(centred).max(), size)) ** 2)[:count]
    rho = products / products[0]
    pairs = rho[: count // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(pairs <= 0.0)
    time = 2.0 * float(pairs[: ends[0] if len(ends) else None].sum()) - 1.0
    return float(np.clip(count / max(time, 1.0), 1.0, count))


def nees_figures(nees: Array, *, estimated: bool = True) -> dict[str, Any]:
    """Return statistics of the NEES of a run.

    Args:
        nees: NEES of each tick, shape (N,); NaN where the covariance is singular.
        estimated: Whether an estimator gave it; otherwise it is that of dead reckoning with the data sheet's noise.

    Returns:
        `mean`; `in_band`, the proportion of ticks between the bounds `band` of one tick; `singular`, the number of
        ticks without NEES; `mean_band`, the bounds of the mean for the effective number of `independent` values;
        `reason`, why tables and comparisons do not show it, or None.
    """
    regular = nees[np.isfinite(nees)]
    independent = independent_count(regular)
    without = None if len(regular) else "no covariance is regular"
    return {
        **_figures(regular, STATES, independent),
        "singular": int(len(nees) - len(regular)),
        "independent": independent if len(regular) else None,
        "reason": without if estimated else NO_ESTIMATOR,
    }


def nis_figures(nis: Array, *, freedom: int = 2) -> dict[str, Any]:
    """Return statistics of the NIS of a run; values of a consistent estimator are independent.

    Args:
        nis: NIS of each innovation, shape (M,); NaN where its covariance is singular.
        freedom: Degrees of freedom of each innovation, 2 for range and bearing.

    Returns:
        `mean`, `in_band`, `band`, `mean_band` and `singular` as for the NEES; `count` of innovations.
    """
    regular = nis[np.isfinite(nis)]
    return {
        **_figures(regular, freedom, len(regular)),
        "singular": int(len(nis) - len(regular)),
        "count": len(nis),
    }


def picture_share(track: Track) -> float | None:
    """Return the share of sightings that come from pictures; None without sightings."""
    seen = [sighting.corners is not None for tick in track.sightings for sighting in tick]
    return float(np.mean(seen)) if seen else None


def shared_errors(nees: float | None, nis: float | None, pictures: float | None) -> str:
    """Return why an estimator is overconfident although its innovations are as expected; '' if that is not shown.

    Args:
        nees: Mean NEES.
        nis: Mean NIS of ranges and bearings.
        pictures: Share of sightings that come from pictures.
    """
    far = nees is not None and nees > chi_square_bounds(STATES)[1]
    fine = nis is not None and nis <= NIS_FINE
    if not (far and fine and pictures):
        return ""
    return Sentence(
        "NEES {nees:.1f} with NIS {nis:.1f}: the sightings come from pictures, whose errors are shared"
        " within an image and from one image to the next; a filter that takes them as independent is"
        " overconfident, and NIS does not show it. PictureErrors of mjsim.algorithms.picture_errors"
        " models them",
        nees,
        nis,
    )


def normalised_innovations(track: Track) -> tuple[Array, Array]:
    """Return the row of the tick and the NIS of each innovation of a track, shape (M,); NaN where S is singular."""
    ticks = [row for row, items in enumerate(track.innovations) for _ in items]
    nu = _stack([nu for items in track.innovations for _, nu, _ in items], 2)
    S = _stack([S for items in track.innovations for _, _, S in items], 2, 2)
    return np.array(ticks, dtype=int), normalised_squares(nu, S)


def _figures(regular: Array, freedom: int, independent: float) -> dict[str, Any]:
    low, high = chi_square_bounds(freedom)
    if not len(regular):
        return {"mean": None, "in_band": None, "band": [low, high], "mean_band": None}
    return {
        "mean": float(regular.mean()),
        "in_band": float(np.mean((regular >= low) & (regular <= high))),
        "band": [low, high],
        "mean_band": list(chi_square_bounds(freedom, count=independent)),
    }


def _stack(arrays: Sequence[Array], *shape: int) -> Array:
    return np.array(arrays, dtype=float).reshape(-1, *shape)
