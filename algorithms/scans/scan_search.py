"""Correlative scan search: tries all poses within a window against earlier walls, coarse to fine."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, wrap_angle, wrap_angles

from ..estimation.pose_matrices import inverse
from .scan_matching import BESIDE, Match, WallField, align
from .scan_noise import median
from .scan_walls import Surface

RADIUS = 0.3
"""Distance from a wall within which an element scores, at the finest level [m]."""
SCORED = 48
"""Number of elements of a scan used to rank hypotheses."""
CANDIDATES = 24
"""By default, the number of hypotheses passed to the next level in the smallest windows."""
MAX_HYPOTHESES = 30000
"""Maximum number of hypotheses at the coarsest level."""
AT_ONCE = 256
"""Number of hypotheses that are scored together: larger arrays do not stay in the processor's cache."""
SAME = (0.2, 0.05)
"""Hypotheses that differ by less are the same [m], [rad]."""
CLEAR = 8.0
"""An alternative with a cost less than this above the best one is not ruled out: a likelihood ratio of 55."""
NARROWEST, WIDEST = np.array([0.1, 0.1, 0.05]), np.array([0.6, 0.6, 0.4])
"""Smallest and largest first search window around odometry [m, m, rad]."""
LOST = np.array([1.2, 1.2, 0.6])
"""Search window if there is no match in the first [m, m, rad]."""
GATE = 16.3
"""99.9 % quantile of chi-square with three degrees of freedom."""
BEHIND = 0.1
"""By default, a hypothesis with a score this much below the best one is ruled out without an alignment."""
QUANTILE = 6.3
"""90 % quantile of chi-square with three degrees of freedom."""
CORNERS = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5]), axis=-1).reshape(-1, 3)
"""Corners of a cube of side 1 around the origin: where a cell of the lattice is tried at the next level."""
MUCH = 0.4
"""A match that explains this share of a scan is accepted near odometry."""
KNOWN, ENOUGH = 0.85, 40
"""A worse match is accepted too if this share of its elements near older walls is on them, and at least this number:
behind a door most of a scan is new."""
FEWEST = 20
"""Minimum number of elements of a scan and of the walls for a comparison."""
SLIPPED = (np.array([1.2, 1.2, np.pi]), np.diag([0.6, 0.6, 1.5]) ** 2)
"""Search window around odometry that walls contradict [m, m, rad], and the covariance of its error there."""
CONTRARY = 0.3
"""Walls contradict a pose if scans of either side have seen through more than this share of the other one's walls: at
most 0.17 where odometry is right in real logs, at least 0.5 for robots that were turned or carried away."""
THROUGH = 0.17
"""Maximum share of walls of either side that scans of the other one have seen through, for a place far from odometry;
0.155 in 471 correct loops of a real log, with doors and people."""
ANYWHERE = np.diag([10.0, 10.0, math.pi / math.sqrt(3.0)]) ** 2
"""Covariance of the step of a lost robot: any heading, and an unknown position."""


Through = Callable[[Array], tuple[float, float]]
"""Returns for a pose of a scan (3,) the shares of its walls, and of older ones, that scans of the other side saw
through."""


class Fit(Enum):
    """How a scan fits older walls."""

    NEAR = "near odometry, or too few walls are known to say"
    SLIPPED = "in one place that is not where odometry says"
    LOST = "nowhere: older walls contradict odometry"


@dataclass(frozen=True, slots=True, eq=False)
class MatchedPose:
    """The pose of a new scan in the frame of older walls."""

    pose: Array
    """Pose of the scan's frame in that of the walls, shape (3,) [m, m, rad]."""
    covariance: Array
    """Covariance of the pose, shape (3, 3)."""
    own: Array
    """Covariance of the pose given the systematic errors of odometry, shape (3, 3)."""
    lasting: Array
    """The part of `own` that accumulates along consecutive poses, shape (3, 3)."""
    follows: Array
    """Derivative of the pose by the step of odometry, shape (3, 3): 1 in directions without information from walls."""
    fit: Fit = Fit.NEAR


def _unknown(pose: Array) -> tuple[float, float]:
    return 0.0, 0.0


def match_pose(
    scan: Surface,
    walls: Surface,
    step: Array,
    noise: Array,
    *,
    systematic: Array | None = None,
    through: Through = _unknown,
    field: WallField | None = None,
) -> MatchedPose:
    """Return the pose of a new scan in the frame of older walls from walls and odometry, with its covariance.

    A match must explain much of the scan, or of what it shows of older walls, and be compatible with odometry. If there
    is none, the window is enlarged, and a match that contradicts odometry is accepted only if most of the scan fits and
    the match is unambiguous. Competing hypotheses of nearly equal likelihood increase the covariance. Without any
    match, the result is that of odometry; if walls contradict that, all headings are searched, and if none fits, the
    robot is lost.

    Args:
        scan: Scan in its own frame.
        walls: Seen before.
        step: Motion by odometry, shape (3,) [m, m, rad].
        noise: Covariance of its errors that are independent at each step, shape (3, 3).
        systematic: Covariance of its systematic errors, shape (3, 3); by default zero.
        through: Returns what scans of either side have seen through.
        field: Field of the walls, if it is known already.
    """
    covariance = noise if systematic is None else noise + systematic
    if len(walls.points) < FEWEST or len(scan.points) < FEWEST:
        return MatchedPose(step, covariance, noise, noise, np.eye(3))
    field, information = field or WallField(walls), inverse(covariance)
    window = np.clip(3.0 * np.sqrt(np.diag(covariance)), NARROWEST, WIDEST)
    found = hypotheses(field, scan, step, information, window)
    held = _explains(found[0], len(scan.points)) and _surprise(found[0], step, covariance) < GATE
    # Odometry may have slipped: it counts for a tenth of its standard deviation's inverse.
    weak = 0.01 * information
    if held and not _pulled(field, scan, found[0], step, covariance, weak):
        return _matched(found, noise)
    freed = hypotheses(field, scan, step, weak, LOST, limit=5)
    if is_only_place(freed) and (held or min(through(freed[0].pose)) < CONTRARY):
        return replace(_matched(freed, 100.0 * noise), fit=Fit.SLIPPED)
    if held:
        return _matched(found, noise)
    if min(through(found[0].pose)) < CONTRARY:
        slipped = 4.0 * noise
        return MatchedPose(step, slipped + covariance - noise, slipped, slipped, np.eye(3))
    window, unknown = SLIPPED
    turned = hypotheses(field, scan, step, inverse(unknown), window, limit=6)
    if is_only_place(turned) and max(through(turned[0].pose)) < THROUGH:
        return replace(_matched(turned, unknown), fit=Fit.SLIPPED)
    return MatchedPose(step, ANYWHERE, ANYWHERE, ANYWHERE, np.zeros((3, 3)), Fit.LOST)


def is_only_place(found: list[Match]) -> bool:
    """Return whether most of a scan fits the best one of some hypotheses, and none of the others."""
    return found[0].share > 0.6 and found[0].conflict < 0.2 and not is_ambiguous(found)


def _explains(match: Match, elements: int) -> bool:
    """Return whether a match explains enough of a scan, or of its elements near older walls."""
    near = match.share + match.conflict
    return match.share > MUCH or (match.share > KNOWN * near and match.share * elements >= ENOUGH)


def _pulled(field: WallField, scan: Surface, best: Match, step: Array, covariance: Array, weak: Array) -> bool:
    """Return whether odometry has pulled a match off the walls and is incompatible with the fit to the walls alone."""
    if _surprise(best, step, covariance) < QUANTILE:
        return False
    (free,) = align(field, scan, step, weak, best.pose[None])
    return free.share > 0.6 and _surprise(free, step, covariance) > GATE


def hypotheses(
    field: WallField,
    scan: Surface,
    guess: Array,
    information: Array,
    window: Array,
    *,
    limit: int = 3,
    behind: float = BEHIND,
    kept: int = CANDIDATES,
    unseen: float = 1.0,
) -> list[Match]:
    """Return the best alignments of a scan within a window around a guess, distinct ones, the best first.

    Args:
        field: Field of the walls seen before.
        scan: Scan in its own frame; at least one element.
        guess: Guess of its pose, shape (3,).
        information: Inverse of the guess's covariance, shape (3, 3).
        window: Half extents of the search in x, y and heading, shape (3,) [m, m, rad].
        limit: Maximum number of alignments to try.
        behind: A hypothesis with a score this much below the best one is ruled out without an alignment.
        kept: As in `search`.
        unseen: Cost of an element where no wall is near, relative to one beside a wall, when choosing what to align.
    """
    found: list[Match] = []
    thin = scan.thinned(SCORED)
    poses, scores = search(field, thin, guess, window, kept=kept)
    likely = scores > scores[0] - behind
    poses, scores = poses[likely], scores[likely]
    if unseen < 1.0:
        far = (field.distance.take(_placed(field, thin, poses)) > BESIDE).mean(axis=1)
        poses = poses[np.argsort(-scores - (1.0 - unseen) * far, kind="stable")]
    starts = distinct(poses, limit)
    for match in align(field, scan, guess, information, np.array(starts)):
        if not any(is_same(match.pose, other.pose) for other in found):
            found.append(match)
    return sorted(found, key=lambda match: match.cost)


def is_ambiguous(found: list[Match]) -> bool:
    """Return whether another hypothesis is nearly as likely as the first, which is the best."""
    return any(match.cost - found[0].cost < CLEAR for match in found[1:])


def search(
    field: WallField, scan: Surface, guess: Array, window: Array, *, kept: int = CANDIDATES
) -> tuple[Array, Array]:
    """Return the poses within a window at which most of a scan is near walls, the best first, (k, 3); their scores.

    Args:
        field: Field of the walls seen before.
        scan: Scan in its own frame.
        guess: Middle of the window, shape (3,).
        window: Its half extents, shape (3,) [m, m, rad].
        kept: Number of hypotheses passed to the next level, doubled with each coarser first level.

    References:
        Olson, Real-Time Correlative Scan Matching, ICRA 2009: a coarse level bounds the scores of the fine one.
    """
    coarse = int(np.clip(np.ceil(np.log2(max(window[0], window[1]) / 0.3)), 0, 3))
    cells, kept = 2**coarse, kept * 2**coarse
    step = cells * field.cell
    turn = min(0.12, step / max(1.5, median(np.hypot(*scan.points.T))))
    poses, score = _lattice_scores(field, scan, guess, window, cells, turn)
    while True:
        # Among equally good places, prefer the one nearest to the guess.
        x, y, heading = (np.abs(poses - guess) * (0.02 / np.maximum(window, 1e-9))).T
        score = score - np.maximum(np.maximum(x, y), heading)
        best = np.argpartition(score, -kept)[-kept:] if len(score) > kept else np.arange(len(score))
        best = best[np.argsort(-score[best], kind="stable")]
        poses = poses[best]
        if step <= 1.1 * field.cell:
            return poses, score[best]
        step, turn = 0.5 * step, 0.5 * turn
        poses = (poses[:, None] + CORNERS * (step, step, turn)).reshape(-1, 3)
        score = _scores(field, scan, poses, RADIUS + 0.5 * step)


def distinct(poses: Array, limit: int) -> list[Array]:
    """Return at most this many of the poses (k, 3), without duplicates."""
    chosen: list[Array] = []
    while len(poses) and len(chosen) < limit:
        chosen.append(poses[0])
        differences = np.abs(poses - poses[0])
        poses = poses[
            (np.hypot(differences[:, 0], differences[:, 1]) >= SAME[0])
            | (np.abs(wrap_angles(differences[:, 2])) >= SAME[1])
        ]
    return chosen


def is_same(one: Array, other: Array) -> bool:
    """Return whether two poses (3,) are the same hypothesis."""
    x, y, heading = (one - other).tolist()
    return bool(x * x + y * y < SAME[0] ** 2 and abs(wrap_angle(heading)) < SAME[1])


def _surprise(match: Match, step: Array, covariance: Array) -> float:
    """Return the squared Mahalanobis distance of a match from odometry."""
    difference = match.pose - step
    difference[2] = wrap_angle(float(difference[2]))
    # Along a bare corridor walls give no information; a metre and a radian stand for none.
    return float(difference @ inverse(covariance + inverse(match.seen + np.eye(3))) @ difference)


def _matched(found: list[Match], noise: Array) -> MatchedPose:
    """Return the best of some hypotheses, with a covariance that includes the others, weighted by likelihood.

    The error of a pose matched to walls of the last n scans is the mean of their errors plus an independent error; the
    error of a pose by odometry is that of the last pose plus an independent error. An independent error persists with
    the factor 1 / m, where m is the number of steps over which the pose is measured: (n + 1) / 2 on average for walls,
    one for odometry. Features along a corridor, such as edges of doors, are often seen by the last scan alone.

    References:
        Beveridge, Nelson, A new approach to decomposition of economic time series, Journal of Monetary Economics 7,
        1981: the lasting part of an autoregression with a unit root.
    """
    best, others = found[0], _second_moment(found)
    covariance, by_odometry = covariance_of(found), inverse(noise)
    P = inverse(best.seen + by_odometry)
    share = np.linalg.inv(np.eye(3) + P @ best.older)
    return MatchedPose(best.pose, covariance, P + others, share @ P @ share.T + others, np.asarray(P @ by_odometry))


def covariance_of(found: list[Match]) -> Array:
    """Return the covariance of the first of some hypotheses, which includes the others, shape (3, 3)."""
    return inverse(found[0].information) + _second_moment(found)


def _second_moment(found: list[Match]) -> Array:
    """Return the second moment of hypotheses about the first, weighted by likelihood, shape (3, 3)."""
    moment = np.zeros((3, 3))
    for other in found[1:]:
        difference = other.pose - found[0].pose
        difference[2] = wrap_angle(float(difference[2]))
        moment = moment + np.exp(-0.5 * (other.cost - found[0].cost)) * np.outer(difference, difference)
    return moment


def _lattice_scores(
    field: WallField, scan: Surface, guess: Array, window: Array, cells: int, turn: float
) -> tuple[Array, Array]:
    """Return poses at regular steps within a window, at most `MAX_HYPOTHESES`, shape (k, 3), and the score of each.

    Steps are whole cells: the cells of a scan are found once for each heading, and shifted.

    Args:
        field: Field of the walls.
        scan: Scan in its own frame.
        guess: Middle of the window, shape (3,).
        window: Its half extents, shape (3,) [m, m, rad].
        cells: Step in x and y [cells].
        turn: Step in heading [rad].
    """
    step = cells * field.cell
    counts = np.ceil(window / (step, step, turn)).astype(int)
    while np.prod(2 * counts + 1) > MAX_HYPOTHESES:
        counts = np.maximum(counts - 1, 0)
    x, y, heading = (np.arange(-count, count + 1) for count in counts.tolist())
    poses = np.empty((len(heading), len(y), len(x), 3))
    poses[..., 0], poses[..., 1] = guess[0] + step * x, guess[1] + step * y[:, None]
    angles = guess[2] + turn * heading
    poses[..., 2] = angles[:, None, None]
    c, s = np.cos(angles)[:, None], np.sin(angles)[:, None]
    px, py = scan.points.T
    column = np.floor((c * px - s * py + (guess[0] - field.lower[0])) / field.cell).astype(np.intp)
    row = np.floor((s * px + c * py + (guess[1] - field.lower[1])) / field.cell).astype(np.intp)
    # Cells at the edge of the grid are farther from walls than any that score.
    columns = np.minimum(np.maximum(column[:, None] + cells * x[:, None], 0), field.columns - 1)
    rows = np.minimum(np.maximum(row[:, None] + cells * y[:, None], 0), field.rows - 1) * field.columns
    proximity = _proximities(field.distance, RADIUS + 0.5 * step)
    # One heading at a time, for the cache.
    scores = [_means(proximity.take(up[:, None] + along)) for up, along in zip(rows, columns, strict=True)]
    return poses.reshape(-1, 3), np.array(scores).ravel()


def _scores(field: WallField, scan: Surface, poses: Array, radius: float) -> Array:
    """Return the score of each pose (k, 3): the mean proximity of a scan to walls, 1 on them, 0 beyond a radius [m]."""
    parts = np.split(poses, range(AT_ONCE, len(poses), AT_ONCE))
    return np.concatenate(
        [_means(_proximities(field.distance.take(_placed(field, scan, part)), radius)) for part in parts]
    )


def _placed(field: WallField, scan: Surface, poses: Array) -> NDArray[np.intp]:
    """Return the cells of the n elements of a scan at each pose (k, 3), shape (k, n)."""
    c, s = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
    shift, (x, y) = poses[:, :2] - field.lower, scan.points.T
    return field.cells(np.array([c * x - s * y + shift[:, :1], s * x + c * y + shift[:, 1:]]))


def _proximities(distances: NDArray[np.float32], radius: float) -> NDArray[np.float32]:
    """Return the proximity to walls at some distances [m]: 1 on them, 0 beyond a radius [m]."""
    proximity = distances * np.float32(-1.0 / radius)
    proximity += np.float32(1.0)
    np.maximum(proximity, np.float32(0.0), out=proximity)
    return proximity


def _means(values: NDArray[np.float32]) -> Array:
    """Return the means over the last axis."""
    count = values.shape[-1]
    return np.asarray(values @ np.full(count, 1.0 / count, dtype=np.float32), dtype=float)
