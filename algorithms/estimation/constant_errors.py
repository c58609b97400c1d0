"""Constant errors of odometry and sensor: the belief under any prior, and how well that explains the data.

The belief under one prior gives that under any other: errors are constant, so a change of their prior is like a
measurement of them. The Bayes factor of the other prior is the ratio of the densities of that measurement after and
before the data (Savage and Dickey).

References:
    Verdinelli, Wasserman, Computing Bayes Factors Using a Generalization of the Savage-Dickey Density Ratio,
    JASA 90(430), 1995.
"""

import math

import numpy as np

from mjsim.geometry import Array

from .odometry_errors import DELAY

LARGE_MOTION = 0.05, 0.05, 0.1, DELAY, math.radians(0.5)
"""Standard deviations of large errors of odometry: those of `OdometryErrors`, and a turn at rest [rad/s]."""
LARGE_SENSOR = 0.1, 0.04, math.radians(2.0)
"""Those of large errors of sightings: offset [m] and relative error of ranges, and offset of bearings [rad]."""
LARGE = np.array(LARGE_MOTION + LARGE_SENSOR) ** 2
DISTANCE, VEER, TURN, DELAYED, DRIFT, OFFSET, SCALE, BEARING = range(len(LARGE))
KINDS = ((DISTANCE,), (VEER,), (TURN,), (DRIFT,), (OFFSET, SCALE), (BEARING,), tuple(range(len(LARGE))))
"""Which errors are large together: one of odometry, those of ranges, that of bearings, or all."""
IS_LARGE = np.array([[error in kind for error in range(len(LARGE))] for kind in KINDS])
"""Whether each error is large in each of `KINDS`, shape (kinds, 8)."""
NEGLIGIBLE = 1e-6
"""Minimum variance of an error that is not large, in proportion to a large one."""
CAPPED = 1.0
"""Maximum evidence from one update: constant errors show in every update, spinning wheels only in a few."""
POSITIVE = 1.0
"""Logarithm of the Bayes factor from which evidence is positive (Kass, Raftery, Bayes Factors, JASA 90, 1995)."""
DECIDED = 20.0
"""Logarithm of a Bayes factor that is decisive."""
LARGE_ODDS = np.full(len(KINDS), 0.02)
"""Prior odds of each kind of large errors, against errors within the data sheets."""
DISPROVED = 7.0
"""Logarithm of the Bayes factor that disproves that there are no errors; if there are none, at most one run in exp(7) =
1100 ever exceeds it (Ville's inequality)."""
DOUBTED = 5.0
"""How much more probable errors beyond the data sheets are once that is disproved."""


def with_large(usual: Array) -> Array:
    """Return the prior variances of errors if those in each of `KINDS` are large, shape (kinds, 8)."""
    return np.where(IS_LARGE, LARGE, np.clip(usual, NEGLIGIBLE * LARGE, LARGE))


def reweighted(mean: Array, P: Array, prior: Array, others: Array) -> tuple[Array, Array]:
    """Return how a belief changes under other priors of constant errors e.

    Args:
        mean: Mean of e, shape (n,).
        P: Covariance of e, shape (n, n).
        prior: Variances of e before the data, shape (n,).
        others: Variances of k other priors, shape (k, n).

    Returns:
        A: Another prior reduces the mean of everything by P_e A e and the covariance by P_e A P_e^T, where P_e
            is the covariance of everything with e; shape (k, n, n).
        ratios: Logarithm of the Bayes factor of each against `prior`, shape (k,).
    """
    added = 1.0 / others - 1.0 / prior
    grown = np.eye(len(mean)) + P * added[:, None, :]
    A = added[:, :, None] * np.linalg.inv(grown)
    ratios = -np.einsum("i,kij,j->k", mean, A, mean) - np.linalg.slogdet(grown)[1]
    return A, 0.5 * (ratios + np.log1p(prior * added).sum(axis=1))


def averaged(P: Array, across: Array, mean: Array, weights: Array, shares: Array) -> tuple[Array, Array]:
    """Return the change of the mean (m,), and the covariance (m, m), of a belief averaged over priors of errors e.

    Args:
        P: Covariance of everything, shape (m, m).
        across: Covariance of everything with e, shape (m, n).
        mean: Mean of e, shape (n,).
        weights: A of `reweighted`, shape (k, n, n).
        shares: Probabilities of the priors, shape (k,).
    """
    steps = -across @ (weights @ mean).T  # (m, k)
    step = steps @ shares
    apart = steps - step[:, None]
    return step, P - across @ np.tensordot(shares, weights, 1) @ across.T + (apart * shares) @ apart.T
