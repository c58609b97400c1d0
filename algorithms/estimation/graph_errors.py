"""Constant errors of odometry and sensor in a graph, and the belief averaged over assumptions about them.

The graph estimates all errors (`constant_errors`), usually with priors from the data sheets. Estimating errors that do
not exist costs accuracy, so the belief without errors gets weight once the data support it. Errors far beyond the data
sheets have their own hypotheses; one that becomes more probable than all others gets its prior in the graph.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Odometry, Sighting

from .constant_errors import (
    CAPPED,
    DECIDED,
    DISPROVED,
    DOUBTED,
    IS_LARGE,
    KINDS,
    LARGE,
    LARGE_MOTION,
    LARGE_ODDS,
    NEGLIGIBLE,
    OFFSET,
    POSITIVE,
    averaged,
    reweighted,
    with_large,
)
from .ekf_models import corrected
from .graph_factors import SharedPrior
from .odometry_errors import OdometryErrors
from .range_errors import RANGE_ERRORS, RangeErrors
from .recent_motion import RecentMotion

CHANGED = 1.2
"""The prior in the graph is replaced when a variance has changed by this factor."""
SURE, FORGOTTEN = 1.0, 0.01
"""Odds of large errors above which they get their prior in the graph, and below which they lose it."""
MOTION = len(LARGE_MOTION)
"""Number of errors of odometry; those of the sensor follow them."""


class GraphErrors:
    """Constant errors of odometry (5,) and sensor (3,): their priors in a graph, and the belief about them."""

    def __init__(self, gtsam: Any, *, length: float, scale: float) -> None:
        """Start without errors.

        Args:
            gtsam: The module.
            length: Distance over which usual errors of odometry equal its noise [m]; infinite for no errors at all.
            scale: Factor on the standard deviation of sightings.
        """
        self.possible = not math.isinf(length)
        self.keys = gtsam.symbol("e", 0), gtsam.symbol("r", 0)
        self.solved, self.mean, self.covariance = (
            np.zeros(len(LARGE)),
            np.zeros(len(LARGE)),
            np.zeros((len(LARGE),) * 2),
        )
        """Errors in the graph's solution; mean and covariance of the averaged belief."""
        self.evidence = np.zeros(len(KINDS))
        """Logarithm of the Bayes factor of each of `KINDS` against usual errors; at most 1 per update."""
        self._odometry, self._ranges = OdometryErrors(length), RangeErrors(scale=scale)
        self._priors = [SharedPrior(gtsam, key, changed=CHANGED) for key in self.keys]
        self._usual, self._large = np.zeros(len(LARGE)), np.zeros(len(LARGE), dtype=bool)
        self._most, self._before = 0.0, np.zeros(len(KINDS))
        self.variances, self.chosen = self._usual, self.solved
        """Prior variances and mean of the errors in the most probable hypothesis."""
        self.usual = self.mean, self.covariance
        """Mean and covariance of the errors if they are of usual size."""

    def step(self, moved: Odometry, seconds: float) -> tuple[Array, Array]:
        """Return (forward, left, turn) of a tick, shape (3,), and its derivative by the errors of odometry, (3, 5)."""
        control, slopes, gained = self._odometry.step(moved, moved.covariance, seconds, delay=float(self.solved[3]))
        self._usual[: len(gained)] += gained
        return control, np.column_stack([slopes, [0.0, 0.0, seconds if self.possible else 0.0]])

    def see(self, sightings: Sequence[Sighting], recent: RecentMotion) -> None:
        """Use the scatter of named sightings, which bounds the usual errors of ranges."""
        if self.possible:
            self._ranges.begin(sightings)
            self._ranges.constraint(sightings, recent)
            self._usual[OFFSET : OFFSET + RANGE_ERRORS] = self._ranges.variances

    def mended(self, sighting: Sighting, errors: Array | None = None) -> Sighting:
        """Return a sighting corrected for the sensor's part of the errors (8,), by default those of the graph."""
        errors = self.solved if errors is None else errors
        true, _, _ = corrected(np.array([sighting.range, sighting.bearing]), errors[MOTION:])
        return replace(sighting, range=float(true[0]), bearing=float(true[1]))

    def renew(self, graph: Any) -> list[int]:
        """Add changed priors to a graph of new factors; return the indices of the outdated ones."""
        variances = np.where(self._large, LARGE, np.maximum(self._usual, NEGLIGIBLE * LARGE))
        outdated = self._priors[0].renew(graph, variances[:MOTION])
        return outdated + (self._priors[1].renew(graph, variances[MOTION:]) if self.possible else [])

    def added(self, factors: Any) -> None:
        """Remember the indices that the solver has given to added priors; `factors` has all new indices."""
        for prior in self._priors:
            prior.added(factors)

    def average(self, solved: Array, P: Array, *, rough: float) -> tuple[Array, Array]:
        """Average a belief of the graph over the hypotheses about its errors.

        Args:
            solved: The errors, shape (8,).
            P: Covariance of errors and everything else, in this order, shape (8 + m, 8 + m).
            rough: Odds of rough odometry.

        Returns:
            step: Change of the mean of everything else, shape (m,).
            P: Covariance of everything else, shape (m, m).
        """
        size = len(LARGE)
        self.solved = solved
        prior = np.concatenate([each.variances for each in self._priors])
        usual = np.maximum(self._usual, NEGLIGIBLE * LARGE)
        others = np.concatenate([[NEGLIGIBLE * LARGE, usual], with_large(usual)])
        A, ratios = reweighted(solved, P[:size, :size], prior, others)
        shares = self._shares(ratios - ratios[1], rough)
        chosen, errors = int(np.argmax(shares)), P[:size, :size]
        self.variances, self.chosen = others[chosen], solved - errors @ A[chosen] @ solved
        self.usual = solved - errors @ A[1] @ solved, errors - errors @ A[1] @ errors
        step, average = averaged(P, P[:, :size], solved, A, shares)
        self.mean, self.covariance = solved + step[:size], average[:size, :size]
        return step[size:], average[size:, size:]

    def _shares(self, ratios: Array, rough: float) -> Array:
        """Return the probabilities of no errors, usual and each kind of large errors from their Bayes factors."""
        none, explained = float(ratios[0]), ratios[2:]
        self._most = max(self._most, none)
        self.evidence += np.minimum(explained - self._before, CAPPED)
        self._before = explained
        without = 1.0 / (1.0 + math.exp(-min(none, 700.0))) if self._most >= POSITIVE else 0.0
        prior = DOUBTED * LARGE_ODDS if none < -DISPROVED else LARGE_ODDS
        odds = prior * np.exp(np.minimum(self.evidence - max(none, 0.0), DECIDED)) / (1.0 + rough)
        self._large = IS_LARGE[odds > SURE].any(axis=0) | (self._large & IS_LARGE[odds > FORGOTTEN].any(axis=0))
        return np.asarray(np.array([without, 1.0 - without, *odds]) / (1.0 + odds.sum()))
