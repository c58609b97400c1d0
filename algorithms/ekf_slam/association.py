"""Data association of unnamed sightings with landmarks of the map.

Both functions pair every sighting of one moment with at most one landmark, and no landmark with two sightings.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import gammaincinv

from mjsim.geometry import Array, wrap_angles

from ..estimation.ekf_models import solved
from .ekf_filter import EkfSlamFilter

MAX_STEPS = 20_000
"""Maximum number of steps; then the search returns the best pairing so far. A room needs some dozens per tick."""


def chi_square(share: float, freedoms: ArrayLike) -> Array:
    """Return the quantile of chi-square distributions with some degrees of freedom (...), shape (...).

    `scipy.stats.chi2.ppf` is the same, but slow to import.
    """
    return np.asarray(2.0 * gammaincinv(0.5 * np.asarray(freedoms, dtype=float), share))


def nearest_neighbour(
    slam: EkfSlamFilter,
    measurements: ArrayLike,
    measurement_covariance: ArrayLike,
    *,
    among: Sequence[Hashable] | None = None,
    confidence: float = 0.999,
) -> list[Hashable | None]:
    """Associate each sighting with its best landmark individually, within a gate.

    Args:
        slam: The belief.
        measurements: Range [m] and bearing [rad, left positive], shape (k, 2).
        measurement_covariance: Covariance of each (k, 2, 2), or one for all (2, 2).
        among: Candidate landmarks; all by default.
        confidence: Probability that the gate accepts a correct pair.

    Returns:
        The name of a landmark, or None, for each sighting. Among the pairings with the most pairs, the one with the
        smallest sum of squared Mahalanobis distances.

    References:
        Bar-Shalom, Li, Estimation and Tracking (1993), section 6.3: global nearest neighbour.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import, and not needed for named beacons

    candidates = _Candidates.of(slam, measurements, measurement_covariance, among=among, confidence=confidence)
    cost = np.where(candidates.fits, candidates.distance, 1e6)
    rows, columns = linear_sum_assignment(cost)
    names: list[Hashable | None] = [None] * len(cost)
    for row, column in zip(rows.tolist(), columns.tolist(), strict=True):
        if candidates.fits[row, column]:
            names[row] = candidates.names[column]
    return names


def joint_compatibility(
    slam: EkfSlamFilter,
    measurements: ArrayLike,
    measurement_covariance: ArrayLike,
    *,
    among: Sequence[Hashable] | None = None,
    confidence: float = 0.999,
) -> list[Hashable | None]:
    """Find the largest set of pairs that can be true together, by branch and bound.

    All sightings of one tick share the error of the robot's pose: a pairing that is plausible for each sighting alone
    may be impossible jointly. When a loop closes, only the joint test is decisive.

    Args:
        slam: The belief.
        measurements: Range [m] and bearing [rad, left positive], shape (k, 2).
        measurement_covariance: Covariance of each (k, 2, 2), or one for all (2, 2).
        among: Candidate landmarks; all by default.
        confidence: Probability that the joint gate accepts a correct pairing.

    Returns:
        The name of a landmark, or None, for each sighting; among the largest pairings, the one with the smallest joint
        Mahalanobis distance.

    References:
        Neira, Tardos, Data Association in Stochastic Mapping Using the Joint Compatibility Test,
        IEEE T-RA 17(6), 2001, section IV.
    """
    candidates = _Candidates.of(slam, measurements, measurement_covariance, among=among, confidence=confidence)
    search = _Search(candidates, confidence=confidence)
    search.go(_Hypothesis())
    names: list[Hashable | None] = [None] * len(candidates.fits)
    for row, column in search.best.pairs:
        names[row] = candidates.names[column]
    return names


@dataclass(frozen=True, slots=True, eq=False)
class _Candidates:
    """The n landmarks that match at least one of k sightings individually."""

    names: list[Hashable]
    nu: Array
    """Measured less expected, shape (k, n, 2) [m, rad]."""
    distance: Array
    """Squared Mahalanobis distance of each pair individually, shape (k, n)."""
    fits: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    """Whether it is within the gate, shape (k, n)."""
    expected_covariance: Array
    """Covariance of all expected measurements together, H P H^T, shape (2 n, 2 n)."""
    R: Array
    """Covariance of the measurements, shape (k, 2, 2)."""

    @classmethod
    def of(
        cls,
        slam: EkfSlamFilter,
        measurements: ArrayLike,
        measurement_covariance: ArrayLike,
        *,
        among: Sequence[Hashable] | None,
        confidence: float,
    ) -> "_Candidates":
        """Compare every sighting with every landmark, or with some."""
        Z = np.asarray(measurements, dtype=float).reshape(-1, 2)
        R = np.broadcast_to(np.asarray(measurement_covariance, dtype=float), (len(Z), 2, 2))
        names = list(slam.names() if among is None else among)
        expected, expected_covariance = slam.expect(names)
        nu = Z[:, None] - expected
        nu[..., 1] = wrap_angles(nu[..., 1])
        S = expected_covariance + R[:, None]
        distance = np.einsum("kni,kni->kn", nu, np.linalg.solve(S, nu[..., None])[..., 0])
        fits = distance < chi_square(confidence, 2)
        in_gate = np.flatnonzero(fits.any(axis=0))
        chosen = [names[i] for i in in_gate]
        return cls(chosen, nu[:, in_gate], distance[:, in_gate], fits[:, in_gate], slam.expect_together(chosen), R)


@dataclass(frozen=True, slots=True, eq=False)
class _Hypothesis:
    """Some pairs (sighting, landmark), with S = L L^T of their innovations nu."""

    pairs: tuple[tuple[int, int], ...] = ()
    distance: float = 0.0
    """Squared, joint."""
    L: Array = field(default_factory=lambda: np.zeros((0, 0)))
    """Lower triangular, shape (2 m, 2 m)."""
    whitened: Array = field(default_factory=lambda: np.zeros(0))
    """L^-1 nu, shape (2 m,)."""

    def with_pair(self, row: int, column: int, candidates: _Candidates) -> "_Hypothesis":
        """Return the hypothesis with one more pair; L grows by two rows."""
        at = [2 * c + i for _, c in self.pairs for i in (0, 1)]
        own = slice(2 * column, 2 * column + 2)
        C = candidates.expected_covariance
        S = C[own, own] + candidates.R[row]
        w = solved(self.L, C[at, own]) if at else np.zeros((0, 2))
        corner = np.linalg.cholesky(S - w.T @ w)
        more = np.linalg.solve(corner, candidates.nu[row, column] - w.T @ self.whitened)
        L = np.block([[self.L, np.zeros((len(at), 2))], [w.T, corner]])
        distance = self.distance + float(more @ more)
        return _Hypothesis((*self.pairs, (row, column)), distance, L, np.concatenate([self.whitened, more]))


class _Search:
    """Branch and bound over the pairings of simultaneous sightings."""

    def __init__(self, candidates: _Candidates, *, confidence: float) -> None:
        self.best = _Hypothesis()
        self._candidates = candidates
        rows = range(len(candidates.fits))
        self._choices = [
            sorted(np.flatnonzero(candidates.fits[row]), key=candidates.distance[row].item) for row in rows
        ]
        # The sightings with the fewest choices first: they narrow down the others.
        self._order = sorted((row for row in rows if self._choices[row]), key=lambda row: len(self._choices[row]))
        self._gates = chi_square(confidence, 2 * np.arange(len(self._order) + 1).clip(1))
        self._left = MAX_STEPS

    def go(self, hypothesis: _Hypothesis, depth: int = 0) -> None:
        """Examine all extensions of a pairing that may be better than the best."""
        self._left -= 1
        possible = len(hypothesis.pairs) + len(self._order) - depth
        best = self.best
        if possible < len(best.pairs) or (possible == len(best.pairs) and hypothesis.distance >= best.distance > 0):
            return
        if depth == len(self._order):
            self.best = hypothesis
            return
        row, taken = self._order[depth], {column for _, column in hypothesis.pairs}
        for column in self._choices[row]:
            if column not in taken and self._left > 0:
                longer = hypothesis.with_pair(row, int(column), self._candidates)
                if longer.distance < self._gates[len(longer.pairs)]:
                    self.go(longer, depth + 1)
        self.go(hypothesis, depth + 1)
