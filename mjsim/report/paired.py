"""Paired comparison: differences of pairs, and bootstrap intervals of their mean.

References:
    Efron, Tibshirani, An Introduction to the Bootstrap (1993), chapter 14: BCa intervals.
    Hesterberg, What Teachers Should Know About the Bootstrap, The American Statistician 69(4), 2015, section 5.4:
    wider quantiles for few values, because a sample is narrower than its population.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mjsim.sentences import Sentence

CONFIDENCE = 0.95
RESAMPLES = 9999
SEED = 20261121
"""Seed of the resampling, so that the same values have the same interval."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Difference:
    """Differences (second minus first) over pairs, such as runs with the same seed."""

    pairs: int
    mean: float | None
    """None if there is no pair."""
    low: float | None
    """Bounds of the mean; None for too few pairs."""
    high: float | None
    confidence: float
    """Confidence of the interval."""
    verdict: Literal["first", "second", ""]
    """Which is significantly better; empty if neither."""
    reason: str
    """Explanation of the verdict."""


def fewest_pairs(confidence: float = CONFIDENCE) -> int:
    """Return the minimum number of pairs for a verdict: 6 for 95 %.

    With fewer, even pairs that all differ in one direction do so by chance more often than the confidence allows: the
    signs of n pairs agree with probability 2^(1 - n) if neither is better.
    """
    return math.floor(1.0 - math.log2(1.0 - confidence)) + 1


def shared_confidence(confidence: float, pairs: int) -> float:
    """Return the confidence of each interval with which those of all pairs of groups hold together (Bonferroni)."""
    return 1.0 - (1.0 - confidence) / max(pairs, 1)


def mean_interval(values: ArrayLike, *, confidence: float = CONFIDENCE) -> tuple[float, float] | None:
    """Return a confidence interval for the mean of the population of values.

    Args:
        values: Independent values, shape (n,).
        confidence: In (0, 1).

    Returns:
        Low and high: the BCa bootstrap, with quantiles widened as Student's t is relative to the normal distribution.
        None for fewer values than `fewest_pairs`; for equal values that value, twice.
    """
    from scipy.special import ndtr, stdtrit
    from scipy.stats import bootstrap

    given = np.asarray(values, dtype=float)
    n = len(given)
    if n < fewest_pairs(confidence):
        return None
    if np.ptp(given) <= 1e-12 * float(np.abs(given).max()):
        return float(given[0]), float(given[0])
    outward = math.sqrt(n / (n - 1)) * float(stdtrit(n - 1, 0.5 + confidence / 2.0))
    found = bootstrap(
        (given,),
        np.mean,
        confidence_level=1.0 - 2.0 * float(ndtr(-outward)),
        n_resamples=RESAMPLES,
        batch=1000,
        vectorized=True,
        method="BCa",
        rng=np.random.default_rng(SEED),
    ).confidence_interval
    return float(found.low), float(found.high)


def paired_difference(
    first: Mapping[int, float],
    second: Mapping[int, float],
    *,
    better: Literal["lower", "higher", ""] = "lower",
    confidence: float = CONFIDENCE,
) -> Difference:
    """Return the difference of the second from the first, and which is significantly better, if any.

    Args:
        first: Value of each seed.
        second: Value of each seed; seeds that only one of them has are left out.
        better: Which direction is better; empty if neither is.
        confidence: Confidence of the interval.
    """
    seeds = sorted(first.keys() & second.keys())
    differences = np.array([second[seed] - first[seed] for seed in seeds], dtype=float)
    interval = mean_interval(differences, confidence=confidence) if seeds else None
    verdict: Literal["first", "second", ""] = ""
    if interval is not None and better and (interval[0] > 0.0 or interval[1] < 0.0):
        verdict = "second" if (interval[1] < 0.0) == (better == "lower") else "first"
    return Difference(
        pairs=len(seeds),
        mean=float(differences.mean()) if seeds else None,
        low=interval[0] if interval else None,
        high=interval[1] if interval else None,
        confidence=confidence,
        verdict=verdict,
        reason=_reason(differences, interval, better, confidence),
    )


def _reason(
    differences: "np.ndarray[tuple[int], np.dtype[np.float64]]",
    interval: tuple[float, float] | None,
    better: str,
    confidence: float,
) -> str:
    n = len(differences)
    if n == 0:
        return "no seed is in both; nothing can be paired"
    if not differences.any():
        return "no difference at all"
    if n == 1:
        return "one pair is too few for a verdict; run more seeds"
    if interval is None:
        return Sentence(
            "{n} pairs are too few to decide; at least {fewest_pairs} are needed", n, fewest_pairs(confidence)
        )
    if interval[0] <= 0.0 <= interval[1]:
        return "the interval contains 0: undecided"
    return "the interval excludes 0" if better else "they differ; neither direction is better"
