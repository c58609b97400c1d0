"""Free space of scans: walls that other scans saw through contradict a match."""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array, Pose

from .level_scan import LevelScan
from .scan_walls import Surface

MARGIN = 0.4
"""A beam that ends farther than this behind a wall has passed through it; one that ends nearer has hit it [m]."""
STEEP = 0.4
"""Cosine of the angle of incidence below which a beam is ignored: it may just pass beside the wall."""
RANGE = 15.0
"""Walls farther from the lidar are ignored: errors of the heading move them too far [m]."""

Views = Sequence[tuple[Array, LevelScan]]
"""Poses of the robot in some frame, shape (3,), and scans from there."""


def seen_through(walls: Surface, views: Views) -> float:
    """Return the ratio of walls that scans have seen through to all that they have hit or seen through.

    Args:
        walls: Elements, in one frame.
        views: Poses of the robot in this frame, shape (3,), and scans from there; beams without a return are ignored,
            since glass and black walls give none.
    """
    lidars = [Pose.from_array(pose) @ view.robot_from_lidar for pose, view in views]
    x, y, heading = (np.array(column)[:, None] for column in zip(*[(p.x, p.y, p.heading) for p in lidars], strict=True))
    dx, dy = walls.points[:, 0] - x, walls.points[:, 1] - y
    distance = np.maximum(np.hypot(dx, dy), 1e-6)
    least, farthest = _ends([view for _, view in views], np.arctan2(dy, dx) - heading)
    # A wall stops beams from either side.
    across = np.abs(walls.normals[:, 0] * dx + walls.normals[:, 1] * dy) > STEEP * distance
    known = across & (distance < RANGE)
    through = (known & (least > distance + MARGIN)).sum(axis=0)
    hit = (known & (least < distance + MARGIN) & (farthest > distance - MARGIN)).sum(axis=0)
    seen = np.maximum(through, hit) > 0
    return float(np.mean(through[seen] > hit[seen])) if seen.any() else 0.0


def both_seen_through(one: Surface, ones: Views, other: Surface, others: Views) -> tuple[float, float]:
    """Return the shares of walls of either side that scans of the other one saw through.

    Args:
        one: Walls of one side, in the frame of both.
        ones: Its poses and scans.
        other: Walls of the other side.
        others: Its poses and scans.
    """
    return seen_through(one, others), seen_through(other, ones)


def _ends(views: Sequence[LevelScan], bearings: Array) -> tuple[Array, Array]:
    """Return the shortest and the longest range of the beams beside each bearing; 0 where there is none.

    Args:
        views: k scans.
        bearings: Some for each, shape (k, n) [rad].

    Returns:
        Shape (k, n) each [m].
    """
    scans = [view.scan for view in views]
    beams = np.array([len(scan.ranges) for scan in scans])
    every = np.concatenate([scan.ranges for scan in scans])
    ranges = np.where(np.isfinite(every), every, 0.0)
    begin, increment = (
        np.array(column)[:, None] for column in zip(*[(s.angle_min, s.angle_increment) for s in scans], strict=True)
    )
    turns = (bearings - begin + np.pi) % (2.0 * np.pi) - np.pi
    turns = np.where((increment > 0.0) & (turns < -0.5 * increment), turns + 2.0 * np.pi, turns)
    at, count = turns / increment, beams[:, None]
    inside = (at > 0.0) & (at < count - 1.0)
    first = np.clip(at.astype(np.intp), 0, count - 2) + (np.cumsum(beams) - beams)[:, None]
    one, other = ranges[first], ranges[first + 1]
    return np.where(inside, np.minimum(one, other), 0.0), np.where(inside, np.maximum(one, other), 0.0)
