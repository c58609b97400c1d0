"""History of a run, downsampled to a bound, for late joiners and charts."""

import math
from array import array
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.record import Tick
from mjsim.report import metrics
from mjsim.web.run.news import TrackHistory

MAX_ROWS = 2000
"""Number of rows kept; when there are twice as many, every second one is dropped."""
NO_NEES = np.full(1, np.nan)
"""NEES of dead reckoning used as the estimate: there is no estimator to evaluate."""
WIDTH = 19
"""Numbers per row: time, truth, estimate and dead reckoning as (x, y, heading), covariance (3, 3)."""


class Past:
    """Path and errors of one robot; one row per tick at first, then per two ticks, four and so on."""

    def __init__(self) -> None:
        self._rows = array("d")
        self._timing: dict[str, array[float]] = {}
        self._stride, self._count = 1, 0

    def take(self, tick: Tick, robot: str) -> None:
        """Store a tick at which the robot was driven; this is fast."""
        self._count += 1
        if (self._count - 1) % self._stride:
            return
        order, truth = tick.orders[robot], tick.truth[robot]
        pose, reckoned = order.estimate.pose, order.dead_reckoning
        self._rows.extend((tick.time, truth.x, truth.y, truth.heading, pose.x, pose.y, pose.heading))
        self._rows.extend((reckoned.x, reckoned.y, reckoned.heading))
        self._rows.extend(order.estimate.covariance.ravel().tolist())
        rows = len(self._rows) // WIDTH
        for name, seconds in {**tick.timing, **order.timing}.items():
            column = self._timing.setdefault(name, array("d"))
            column.extend([math.nan] * (rows - 1 - len(column)))
            column.append(seconds)
        if rows >= 2 * MAX_ROWS:
            self._thin(rows)

    def copy(self) -> "Past":
        """Return a copy that no other thread modifies."""
        copied = Past()
        copied._rows = self._rows[:]
        copied._timing = {name: column[:] for name, column in self._timing.items()}
        return copied

    def as_json(self) -> TrackHistory:
        """Return it in JSON form: lists of at most MAX_ROWS rows, None for unknown values."""
        rows = np.array(self._rows).reshape(-1, WIDTH)
        keep = slice(None, None, max(1, math.ceil(len(rows) / MAX_ROWS)))
        timing = {name: [*column, *[math.nan] * (len(rows) - len(column))] for name, column in self._timing.items()}
        return track_json(
            rows[keep, 0],
            truth=rows[keep, 1:4],
            estimate=rows[keep, 4:7],
            odometry=rows[keep, 7:10],
            covariance=rows[keep, 10:],
            timing={name: np.array(column)[keep] for name, column in timing.items()},
            estimated="estimator" in timing,
        )

    def _thin(self, rows: int) -> None:
        self._stride *= 2
        self._rows = array("d", np.array(self._rows).reshape(rows, WIDTH)[::2].ravel().tolist())
        for name, column in self._timing.items():
            self._timing[name] = column[::2]


@np.errstate(over="ignore", invalid="ignore")  # an estimate may be anywhere
def track_json(
    time: Array,
    *,
    truth: Array,
    estimate: Array,
    odometry: Array,
    covariance: Array,
    timing: Mapping[str, Array],
    estimated: bool,
) -> TrackHistory:
    """Return a path in JSON form.

    Args:
        time: Shape (n,) [s].
        truth: Shape (n, 3) [m, m, rad].
        estimate: Shape (n, 3).
        odometry: Dead reckoning, shape (n, 3).
        covariance: Covariance of the estimate, shape (n, 9).
        timing: Wall-clock time of each module, shape (n,) [s].
        estimated: Whether an estimator gave the estimate; dead reckoning has no NEES.
    """
    P = covariance.reshape(-1, 3, 3)
    sigma = np.sqrt(np.einsum("nii->ni", P))
    nees = metrics.normalised_errors(truth, estimate, P) if estimated else np.repeat(NO_NEES, len(time))
    return {
        "time": plain(time),
        "truth": plain(truth),
        "estimate": plain(estimate),
        "odometry": plain(odometry),
        "sigma": plain(sigma),
        "error": plain(metrics.position_errors(truth, estimate)),
        "heading_error": plain(metrics.heading_errors(truth, estimate)),
        "nees": plain(nees, 3),
        "estimated": estimated,
        "timing": {name: plain(1e3 * seconds, 3) for name, seconds in timing.items()},
    }


def plain(values: Any, digits: int = 4) -> Any:
    """Return an array as rounded lists for JSON; None for non-finite values."""
    array = np.asarray(values, dtype=float)
    with np.errstate(over="ignore", invalid="ignore"):
        rounded = np.round(array, digits)
    if np.isfinite(rounded).all():
        return rounded.tolist()
    # The largest numbers overflow when rounded; they have no decimals anyway.
    rounded = np.where(np.isfinite(rounded), rounded, array)
    return list(_plain(rounded.tolist())) if array.ndim else _number(float(rounded))


def _plain(values: list[Any]) -> Iterator[Any]:
    for value in values:
        if isinstance(value, list):
            yield list(_plain(value))
        else:
            yield _number(value)


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
