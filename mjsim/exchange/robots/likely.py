"""Maximum likelihood estimate of the tyre slip of a robot from errors of its dead reckoning."""

import numpy as np
from scipy.optimize import minimize

from mjsim.geometry import Array, wrap_angles
from mjsim.sim import slip_shares
from mjsim.world import Slip

JUDGED_TICKS = 10
"""Errors are evaluated every this many ticks."""
MIN_VARIANCE = 1e-10
"""Minimum variance [m^2], [rad^2]."""
START = {"forward": 0.019, "left": 0.015, "turn": 0.028, "outward": 0.03, "surge": 0.029, "swing": 0.02}
SMALLEST, LARGEST = 1e-4, 2.0
EVEN_WEIGHT = 10.0
"""Penalty weight: cost at each time if the mean normalised error of all drives is off by a factor of e."""
DIGITS = 3


def likely_slip(odometry: Array, poses: Array, *, dt: float) -> Slip:
    """Return the slip that maximises the likelihood of the dead reckoning errors.

    The covariance of a pose is a sum of shares, one for each component of the slip, proportional to its square. The
    likelihood is that of a normal distribution of the error at each evaluated time; the times are treated as
    independent, which keeps the estimate consistent (a composite likelihood). As no such slip fits real drives exactly,
    the many later times would make the covariance shortly after the start too small; therefore the mean normalised
    error at each time is also kept near its expectation.

    Args:
        odometry: Measured distances along the arc and to the left [m] and turns [rad] of all ticks, shape
            (robots, ticks, 3).
        poses: True poses including the start, world frame, shape (robots, ticks + 1, 3) [m, m, rad].
        dt: Period of the loop [s].

    References:
        Varin, Reid, Firth, An overview of composite likelihood methods, Statistica Sinica 21 (2011).
    """
    names = list(Slip.model_fields)
    errors, shares = _reckoned(odometry, poses, dt=dt)
    start = np.log([START[name] for name in names])
    bounds = [(np.log(SMALLEST), np.log(LARGEST))] * len(names)
    given = errors, shares, len(odometry)
    found = minimize(_unlikely, start, args=given, jac=True, method="L-BFGS-B", bounds=bounds)
    values = np.exp(found.x)
    return Slip(**{name: float(f"{value:.{DIGITS}g}") for name, value in zip(names, values, strict=True)})


def _unlikely(logs: Array, errors: Array, shares: Array, drives: int) -> tuple[float, Array]:
    """Return minus twice the mean log-likelihood plus the unevenness penalty, and the gradient by the log slips.

    Args:
        logs: Logarithms of the slip components, shape (parts,).
        errors: Errors of all drives at one time, then at the next, shape (n, 3).
        shares: Covariance per unit slip, shape (n, parts, 3, 3).
        drives: Number of drives.
    """
    squares = np.exp(2.0 * logs)
    covariances = np.einsum("k,nkij->nij", squares, shares) + np.eye(3) * MIN_VARIANCE
    inverses = np.linalg.inv(covariances)
    solved = np.einsum("nij,nj->ni", inverses, errors)
    nees = np.einsum("ni,ni->n", errors, solved)
    value = float(np.mean(np.linalg.slogdet(covariances)[1] + nees))
    expected = np.einsum("nij,nkij->nk", inverses, shares)
    erred = np.einsum("ni,nkij,nj->nk", solved, shares, solved)
    at_times = nees.reshape(-1, drives).mean(axis=1)
    ratios = np.log(at_times / errors.shape[1])
    falls = erred.reshape(len(ratios), drives, -1).mean(axis=1) / at_times[:, None]
    slopes = (expected - erred).mean(axis=0) - 2.0 * EVEN_WEIGHT * (ratios[:, None] * falls).mean(axis=0)
    return value + EVEN_WEIGHT * float(np.mean(ratios**2)), 2.0 * squares * slopes


def _reckoned(odometry: Array, poses: Array, *, dt: float) -> tuple[Array, Array]:
    """Return the errors of dead reckoning, shape (n, 3), and the shares of their covariance, (n, parts, 3, 3)."""
    believed, errors, found = poses[:, 0].copy(), [], []
    increments = slip_shares(odometry, dt=dt)
    covariances = np.zeros((len(odometry), increments.shape[-2], 3, 3))
    for tick in range(odometry.shape[1]):
        believed, F, G = _stepped(believed, odometry[:, tick])
        new = G[:, None] * increments[:, tick, :, None, :] @ np.swapaxes(G, 1, 2)[:, None]
        covariances = F[:, None] @ covariances @ np.swapaxes(F, 1, 2)[:, None] + new
        if tick % JUDGED_TICKS == JUDGED_TICKS - 1:
            error = believed - poses[:, tick + 1]
            error[:, 2] = wrap_angles(error[:, 2])
            errors.append(error)
            found.append(covariances)
    return np.concatenate(errors), np.concatenate(found)


def _stepped(poses: Array, step: Array) -> tuple[Array, Array, Array]:
    """Return poses after one tick, and their Jacobians by the previous poses and by the odometry.

    Args:
        poses: World frame, shape (robots, 3) [m, m, rad].
        step: Odometry, shape (robots, 3) [m, m, rad].
    """
    distance, _, turn = step.T
    half = poses[:, 2] + turn / 2
    # The chord of an arc points along half the turn.
    chord = distance * np.sinc(turn / (2.0 * np.pi))
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    moved = poses + np.stack([chord * np.cos(half), chord * np.sin(half), turn], axis=-1)
    F, G = np.tile(np.eye(3), (len(poses), 1, 1)), np.tile(np.eye(3), (len(poses), 1, 1))
    F[:, 0, 2], F[:, 1, 2] = -chord * np.sin(half), chord * np.cos(half)
    G[:, 0, 0], G[:, 0, 1], G[:, 1, 0], G[:, 1, 1] = c, -s, s, c
    return moved, F, G
