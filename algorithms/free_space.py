"""Free space of scans: walls that earlier or later scans saw through contradict a match."""

from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array, Pose

from .level_scan import LevelScan
from .scan_walls import Surface

MARGIN = 0.4
"""A beam that ends farther than this behind a wall has passed through it, one that ends nearer to it has met it [m]."""
STEEP = 0.4
"""Cosine of the angle of incidence below which a beam tells nothing: the wall may be a little farther aside."""
NEAR = 15.0
"""Walls farther from the lidar tell nothing: errors of the heading move them too far [m]."""


def seen_through(walls: Surface, looks: Sequence[tuple[Array, LevelScan]]) -> float:
    """Return the ratio of walls that scans have seen through to all that they have met or seen through.

    Args:
        walls: Elements, in one frame.
        looks: Poses of the robot in this frame, shape (3,), and scans from there; beams without a return tell nothing,
            since glass and black walls give none.
    """
    through, met = np.zeros(len(walls.points)), np.zeros(len(walls.points))
    for pose, look in looks:
        lidar = Pose.from_array(pose) @ look.robot_from_lidar
        away = walls.points - (lidar.x, lidar.y)
        distance = np.maximum(np.hypot(*away.T), 1e-6)
        least, most = _ends(look, np.arctan2(away[:, 1], away[:, 0]) - lidar.heading)
        # A wall keeps beams from either side.
        across = np.abs(np.einsum("ni,ni->n", walls.normals, away)) > STEEP * distance
        known = across & (distance < NEAR)
        through += known & (least > distance + MARGIN)
        met += known & (least < distance + MARGIN) & (most > distance - MARGIN)
    known = np.maximum(through, met) > 0.0
    return float(np.mean(through[known] > met[known])) if known.any() else 0.0


def _ends(look: LevelScan, bearings: Array) -> tuple[Array, Array]:
    """Return the shortest and the longest range of the beams beside each bearing; 0 where there is none, (n,) each."""
    scan = look.scan
    ranges = np.where(np.isfinite(scan.ranges), scan.ranges, 0.0)
    turns = (bearings - scan.angle_min + np.pi) % (2.0 * np.pi) - np.pi
    if scan.angle_increment > 0.0:
        turns = np.where(turns < -0.5 * scan.angle_increment, turns + 2.0 * np.pi, turns)
    at = turns / scan.angle_increment
    inside = (at > 0.0) & (at < len(ranges) - 1.0)
    first = np.clip(at.astype(np.intp), 0, len(ranges) - 2)
    one, other = ranges[first], ranges[first + 1]
    return np.where(inside, np.minimum(one, other), 0.0), np.where(inside, np.maximum(one, other), 0.0)
