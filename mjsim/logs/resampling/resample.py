"""Resamples logs to ticks: integrates motion, and interpolates the truth."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose, places_at, wrap_angles
from mjsim.interface import Odometry
from mjsim.sim import arc_end, arc_end_slopes

PIVOT_DEVIATION = 1e-3
"""Standard deviation of the position of a robot that turns on the spot by one radian: the centre of rotation is not
exact, and estimators that invert the covariance need it to be regular [m/sqrt(rad)]."""

UNKNOWN = np.array([1.0, 1.0, 1.0])
"""Motion of a robot without odometry, as a random walk: that of walking pace [m/sqrt(s), m/sqrt(s), rad/sqrt(s)]."""

MIN_JUMP, FASTEST, TIMES_USUAL = (0.5, 0.5), (5.0, 2.0 * math.pi), 10.0
"""Steps of odometry that exceed the first, faster than the second and than this many times its usual speed, are jumps;
of position and of heading [m, rad], [m/s, rad/s], [1]."""
AT_START = 0.1
"""After a restart, odometry is within this of its start [m, rad]."""

MAX_TRUTH_GAP, MAX_TRUTH_STEPS = 0.1, 1.5
"""The truth is unknown between two poses farther apart than both of these [s, usual steps of the truth]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionNoise:
    """Noise of the logged motion: variances grow with distance and turn."""

    distance: float
    """Noise of the distance, for one metre driven [m/sqrt(m)]."""
    turn: float
    """Noise of the heading, for one radian turned [rad/sqrt(rad)]."""
    veer: float
    """Noise of the heading, for one metre driven, due to errors in steering and following commands [rad/sqrt(m)]."""
    aside: float = 0.004
    """Noise of the sideways position, for one metre driven, because tyres slip [m/sqrt(m)]."""


def motions(twists: Array, edges: Array, noise: MotionNoise) -> list[Odometry]:
    """Return the motion from each edge to the next, as an arc for each twist that held on the way.

    Args:
        twists: Rows of time [s], forward [m/s], turn [rad/s] and, if it can move sideways, left [m/s], shape (N, 3 or
            4), in order of time; each holds until the next, and the robot stands still before the first.
        edges: Times of the ticks, shape (K,), ascending [s].
        noise: Determines the covariances.

    Returns:
        K - 1 increments, each in the robot's frame at its beginning.
    """
    times = twists[:, 0]
    return [
        _motion(twists[max(first, 0) : last], begin, end, noise)
        for begin, end, first, last in zip(
            edges[:-1].tolist(),
            edges[1:].tolist(),
            (np.searchsorted(times, edges[:-1], side="right") - 1).tolist(),
            np.searchsorted(times, edges[1:], side="left").tolist(),
            strict=True,
        )
    ]


def track_motions(track: Array, edges: Array, noise: MotionNoise) -> list[Odometry]:
    """Return the motion from each edge to the next, from odometry with poses.

    Args:
        track: Rows of time [s], x, y [m] and heading [rad], in order of time; the robot stands still before the first
            and after the last.
        edges: Times of the ticks, shape (K,), ascending [s].
        noise: Determines the covariances.

    Returns:
        K - 1 increments, each in the robot's frame at its beginning.
    """
    if len(track) == 1:
        track = np.concatenate([track, track])
    places = places_at(edges.clip(track[0, 0], track[-1, 0]), track, gap=np.inf)
    steps = np.diff(places, axis=0)
    c, s = np.cos(places[:-1, 2]), np.sin(places[:-1, 2])
    forward, left = c * steps[:, 0] + s * steps[:, 1], c * steps[:, 1] - s * steps[:, 0]
    turn, lengths = wrap_angles(steps[:, 2]), np.hypot(steps[:, 0], steps[:, 1])
    return [
        Odometry(ahead, lateral, turned, _covariance(length, abs(turned), turned, noise))
        for ahead, lateral, turned, length in np.stack([forward, left, turn, lengths], axis=-1).tolist()
    ]


def unknown_motion(dt: float) -> Odometry:
    """Return the increment of a tick of `dt` [s] for a log without odometry: zero, with the covariance of `UNKNOWN`."""
    return Odometry(0.0, 0.0, 0.0, np.diag(UNKNOWN**2) * dt)


def track_of(twists: Array) -> Array:
    """Integrate twists from the origin: rows of time [s], x, y [m] and heading [rad], shape (N, 4).

    Args:
        twists: Twists as in `motions`, shape (N, 3 or 4).
    """
    place, rows = Pose(0.0, 0.0, 0.0), []
    exact = MotionNoise(distance=0.0, turn=0.0, veer=0.0, aside=0.0)
    rest = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    for time, step in zip(twists[:, 0].tolist(), [rest, *motions(twists, twists[:, 0], exact)], strict=True):
        place = place @ Pose(step.forward, step.left, step.turn)
        rows.append([time, place.x, place.y, place.heading])
    return np.array(rows)


def _motion(twists: Array, begin: float, end: float, noise: MotionNoise) -> Odometry:
    """Return the motion from one time to another under the twists between them."""
    place, heading, distance, turned = Pose(0.0, 0.0, 0.0), 0.0, 0.0, 0.0
    rows = twists.tolist()
    for (since, forward, turn, *left), until in zip(rows, [row[0] for row in rows[1:]] + [end], strict=False):
        seconds, lateral = max(until - max(since, begin), 0.0), sum(left)
        x, y = arc_end(forward * seconds, turn * seconds)
        # The same arc, starting to the left.
        ahead, back = arc_end(lateral * seconds, turn * seconds)
        place = place @ Pose(x - back, y + ahead, turn * seconds)
        heading += turn * seconds
        distance, turned = distance + math.hypot(forward, lateral) * seconds, turned + abs(turn) * seconds
    return Odometry(place.x, place.y, heading, _covariance(distance, turned, heading, noise))


def _covariance(distance: float, turned: float, heading: float, noise: MotionNoise) -> Array:
    """Return the covariance of (forward, left, turn) of one arc, to first order, shape (3, 3)."""
    along, around = noise.distance**2 * distance, noise.turn**2 * turned + noise.veer**2 * distance
    (f_d, f_t), (l_d, l_t) = arc_end_slopes(distance, heading)
    G = np.array([[f_d, f_t], [l_d, l_t], [0.0, 1.0]])
    return np.asarray(G @ np.diag([along, around]) @ G.T + _least(distance, turned, noise), dtype=float)


def _least(distance: float, turned: float, noise: MotionNoise) -> Array:
    """Return the covariance added to every arc: tyres slip sideways, and a turn shifts the robot a little."""
    pivot = PIVOT_DEVIATION**2 * turned
    return np.diag([pivot, noise.aside**2 * distance + pivot, 0.0])


def restarts_of(track: Array) -> NDArray[np.intp]:
    """Return the rows at which odometry starts again: it jumps to the origin, or to where the log begins.

    Other jumps stay: times of old logs come in bursts, so that a fast step may be a real motion.

    Args:
        track: Rows of time [s], x, y [m] and heading [rad], in order of time, shape (K, 4).
    """
    if len(track) < 3:
        return np.zeros(0, dtype=np.intp)
    steps = np.diff(track, axis=0)
    lasting = np.maximum(steps[:, 0], float(steps[:, 0].mean()) or 1e-3)
    jumped = np.zeros(len(steps), dtype=bool)
    amounts = np.hypot(steps[:, 1], steps[:, 2]), np.abs(wrap_angles(steps[:, 3]))
    for amount, least, fastest in zip(amounts, MIN_JUMP, FASTEST, strict=True):
        rates = amount / lasting
        # Most robots stand or drive slowly most of the time: the usual speed is that of the steps in which they move at
        # all.
        usual = float(np.quantile(rates[rates > 0.0], 0.9)) if rates.any() else 0.0
        jumped |= (amount > least) & (rates > fastest) & (rates > TIMES_USUAL * usual)
    begins = np.zeros(len(steps), dtype=bool)
    for start in (np.zeros(3), track[0, 1:]):
        off = track[1:, 1:] - start
        begins |= (np.hypot(off[:, 0], off[:, 1]) < AT_START) & (np.abs(wrap_angles(off[:, 2])) < AT_START)
    return np.asarray(np.flatnonzero(jumped & begins) + 1, dtype=np.intp)


def continuous(track: Array) -> tuple[Array, str]:
    """Return odometry without restarts, and a note about them, '' if there are none."""
    restarts = restarts_of(track)
    if not len(restarts):
        return track, ""
    at = ", ".join(f"{track[row, 0]:.3f}" for row in restarts[:5].tolist())
    return joined(track, restarts), f"{len(restarts)}; it begins again at {at} s"


def joined(track: Array, restarts: NDArray[np.intp]) -> Array:
    """Return odometry that continues where it was before each restart, shape (K, 4).

    Args:
        track: Track as in `restarts_of`.
        restarts: Rows at which it starts again.
    """
    whole = track.copy()
    for row in restarts.tolist():
        before, after = Pose.from_array(whole[row - 1, 1:]), Pose.from_array(whole[row, 1:])
        moved = before @ after.inverse()
        c, s = math.cos(moved.heading), math.sin(moved.heading)
        x, y = whole[row:, 1].copy(), whole[row:, 2].copy()
        whole[row:, 1], whole[row:, 2] = moved.x + c * x - s * y, moved.y + s * x + c * y
        whole[row:, 3] = wrap_angles(whole[row:, 3] + moved.heading)
    return whole


def longest_gap(truth: Array | None) -> float:
    """Return the maximum time between two poses of the truth to interpolate [s].

    Args:
        truth: Rows that begin with the time [s], in order of time, shape (N, ...); None for no truth.
    """
    steps = np.diff(truth[:, 0]) if truth is not None else np.zeros(0)
    return max(MAX_TRUTH_GAP, MAX_TRUTH_STEPS * float(np.median(steps))) if len(steps) else MAX_TRUTH_GAP
