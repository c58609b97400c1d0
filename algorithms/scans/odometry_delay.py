"""The delay of odometry relative to scans, estimated from turns that both have measured."""

import math
from collections import deque
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array, wrap_angles
from mjsim.interface import Odometry

from ..estimation.pose_graph import step_between
from ..estimation.recent_motion import SAME, RecentMotion
from .scan_noise import median

MAX_DELAY, STEP = 0.4, 0.04
"""Largest delay, of odometry or of scans, and distance between two delays that are compared [s]."""
TRIED = np.arange(-round(MAX_DELAY / STEP), round(MAX_DELAY / STEP) + 1) * STEP
"""The delays that are compared, shape (k,) [s]."""
SLIP = 9.0
"""A turn whose squared normalised difference is larger for all delays is a slip and is ignored."""
PRIOR = np.diag([1.0 / 0.1**2, 1.0 / 0.02**2])
"""Information of the errors that are fitted with each delay: relative error of a turn, and turn per second [rad/s]."""
RECENT = 100
"""Number of steps from which the noise of odometry is estimated, relative to that of its data sheet."""
MIDDLE = 0.455
"""Median of chi-square with one degree of freedom."""
MEMORY = 400.0
"""Number of steps after which a step counts less by a factor of e, because clocks drift."""
CLEAR, CHANCE = 20.0, 2.0
"""A delay is accepted if its cost (minus twice the log-likelihood) is lower than without one by the first, plus the
second times the root of the number of steps, by which sums of squares differ by chance."""
STALL, FASTEST = 0.3, np.array([2.0, 2.0, 3.0])
"""Minimum rest, and maximum speeds in the first tick after it [s, m/s, m/s, rad/s]: faster odometry had stalled, and
then arrived all at once."""
WINDOW = 0.2
"""Late odometry is extrapolated with its mean velocity over this time [s]."""
UNFORESEEN = np.array([0.2, 0.05, 0.3])
"""Standard deviation of the change of velocity while odometry is late [m/s, m/s, rad/s]."""
BESIDE = 3
"""Number of delays on either side of the best one to whose costs a parabola is fitted."""
FIT = np.linalg.pinv(np.vander(np.arange(-BESIDE, BESIDE + 1.0), 3, increasing=True))
"""Matrix that gives the coefficients of this parabola from the costs."""


class OdometryDelay:
    """Compares turns between scans with those by odometry shifted by several delays.

    Both are often stamped on arrival, and one of them was delayed longer. While the robot begins or ends a turn,
    odometry from a different time than the scan has a different heading.

    References:
        Kelly, Sukhatme, A General Framework for Temporal Calibration of Multiple Proprioceptive and Exteroceptive
        Sensors, ISER 2010: the delay at which the turns of two sensors fit best.
    """

    def __init__(self) -> None:
        """Start without a delay."""
        self.seconds = 0.0
        """Age of odometry relative to scans with the same stamp; negative if it is newer [s]."""
        self._times, self._headings = deque[float]([-1e9]), deque[float]([0.0])
        # Normal equations of the other errors of turns, and the sum of squares, the latter two for each delay.
        self._H: Array = np.zeros((2, 2))
        self._b, self._squares = np.zeros((len(TRIED), 2)), np.zeros(len(TRIED))
        self._count = 0.0
        self._recent = deque[float](maxlen=RECENT)
        self._waiting = deque[tuple[float, float, float, float]]()
        self._before: Array | None = None

    def move(self, turn: float, time: float) -> None:
        """Add the turn by odometry since the last tick [rad] and the time of its end [s]."""
        self._times.append(time)
        self._headings.append(self._headings[-1] + turn)
        while self._waiting and self._waiting[0][0] + MAX_DELAY < time:
            self._compare(*self._waiting.popleft())
        keep = min(time, self._waiting[0][0] if self._waiting else time) - 2.0 * MAX_DELAY
        while len(self._times) > 2 and self._times[1] < keep:
            self._times.popleft()
            self._headings.popleft()

    def heading(self, time: float) -> float:
        """Return the heading by odometry at a time of its clock [rad]."""
        return float(np.interp(time, self._times, self._headings))

    def add(self, stamp: float, turn: float, seconds: float, variance: float) -> None:
        """Add a scan.

        Args:
            stamp: Its time [s].
            turn: Turn by scans since the scan that was added before [rad]; NaN if unknown.
            seconds: How long the robot moved since then [s].
            variance: Variance of the difference of turns by scans and by odometry [rad^2].
        """
        self._waiting.append((stamp, turn, seconds, variance))

    def _compare(self, stamp: float, turn: float, seconds: float, variance: float) -> None:
        """Compare a turn with odometry, now that it is known for all delays."""
        headings = np.interp(stamp + TRIED, self._times, self._headings)
        before, self._before = self._before, headings
        if before is None or not np.isfinite(turn):
            return
        difference = (headings - before - turn + np.pi) % (2.0 * np.pi) - np.pi
        # Relative to the turn by scans: that by odometry contains its noise.
        slopes = np.array([turn, seconds])
        squared = (difference - self._errors() @ slopes) ** 2 / variance
        # Use the best delay so far: the minimum over several delays is too small by chance.
        self._recent.append(float(squared[self._costs().argmin()]))
        scale = max(1.0, median(np.array(self._recent)) / MIDDLE)
        if squared.min() > SLIP * scale:
            return
        kept = 1.0 - 1.0 / MEMORY
        self._H = kept * self._H + np.outer(slopes, slopes) / variance
        self._b = kept * self._b + difference[:, None] * slopes / variance
        self._count = kept * self._count + 1.0
        self._squares = kept * self._squares + difference**2 / variance
        self.seconds = _best(self._costs() / scale, CLEAR + CHANCE * math.sqrt(self._count))

    def _costs(self) -> Array:
        """Return minus twice the log-likelihood of each delay with the errors that fit best, shape (k,)."""
        return np.asarray(self._squares - (self._b * self._errors()).sum(axis=1))

    def _errors(self) -> Array:
        """Return the other errors that fit best with each delay, in the order of `PRIOR`, shape (k, 2)."""
        return np.asarray(np.linalg.solve(self._H + PRIOR, self._b.T).T)


class SynchronousOdometry:
    """Odometry at the time of the scans: the estimator waits for late odometry, and holds early odometry back."""

    def __init__(self) -> None:
        """Start at rest."""
        self.delay = OdometryDelay()
        self.time = -math.inf
        """Time up to which odometry is used, by its own clock [s]."""
        self._recent, self._newest = RecentMotion(), -math.inf
        self._place, self._total = np.zeros(3), np.zeros((3, 3))
        self._rest, self._begin = -math.inf, -math.inf

    def update(self, told: Odometry, moment: float) -> Odometry:
        """Return the motion to be used in a tick: that of the tick itself unless odometry is newer than the scans.

        Args:
            told: Motion since the last tick.
            moment: Time of its end [s].
        """
        self._move(told, moment)
        self.delay.move(told.turn, moment)
        waits, self._newest = self.time < self._newest, moment
        self.time = max(self.time, moment + min(self.delay.seconds, 0.0))
        before, known = self._place, self._total
        self._place, self._total = self._recent.at(self.time)
        if not waits and self.time == moment:
            return told
        forward, left, turn = step_between(before, self._place).tolist()
        return Odometry(forward, left, turn, self._total - known)

    def _move(self, told: Odometry, moment: float) -> None:
        """Add the motion of a tick; motion that arrives at once after a stall is spread evenly over it."""
        since, before = self._rest, self._begin
        moved, self._begin = np.array([told.forward, told.left, told.turn]), moment
        self._recent.move(told, moment)
        is_jump = (np.abs(moved) > FASTEST * max(moment - before, 1e-3)).any() and before - since > STALL
        if is_jump:
            self._recent.spread(since)
        elif moved.any():
            self._rest = moment

    def time_of(self, stamp: float) -> float:
        """Return the time from which odometry covers that of a scan [s]."""
        return stamp + self.delay.seconds

    def since(self, stamp: float) -> Array:
        """Return the motion in use since the time of a scan, shape (3,); zero if that is the newest."""
        then = self.time_of(stamp)
        return np.zeros(3) if then > self.time - SAME else step_between(self._recent.at(then)[0], self._place)

    def turn_since(self, stamp: float) -> float:
        """Return the turn of that motion [rad]."""
        return self.delay.heading(self.time) - self.delay.heading(self.time_of(stamp))

    def overdue(self) -> tuple[Array, Array]:
        """Return the motion that late odometry does not contain yet, shape (3,), and its covariance, shape (3, 3)."""
        late = max(self.delay.seconds, 0.0)
        return late * self._recent.velocity(WINDOW), np.diag((late * UNFORESEEN) ** 2)


def retimed(times: Array, true: Array, poses: Sequence[Array]) -> Array:
    """Return the poses at other times, interpolated, shape (n, 3).

    Args:
        times: Times, ascending, shape (n,) [s].
        true: Times of the poses, shape (n,) [s].
        poses: n of shape (3,).
    """
    found = np.array(poses).reshape(-1, 3)
    if (times != true).any():
        found[:, 2] = np.unwrap(found[:, 2])
        found = np.column_stack([np.interp(times, np.maximum.accumulate(true), column) for column in found.T])
    found[:, 2] = wrap_angles(found[:, 2])
    return found


def _best(costs: Array, clear: float) -> float:
    """Return the delay with the lowest cost, between those that are compared; 0 unless none costs more by `clear`."""
    best, none = int(costs.argmin()), len(costs) // 2
    if costs[none - 1 : none + 2].min() - costs[best] < clear or not BESIDE <= best < len(costs) - BESIDE:
        return 0.0
    _, slope, curvature = (FIT @ costs[best - BESIDE : best + BESIDE + 1]).tolist()
    return float(TRIED[best] - np.clip(0.5 * slope / max(curvature, 1e-9), -BESIDE, BESIDE) * STEP)
