"""A small plan as SVG, for notebooks: of a world, with the paths of a run."""

import re
from collections.abc import Iterable, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.plan import PlanItem, SvgPlan, bounds_of
from mjsim.record import Track

LONGER_SIDE = 90.0
"""Length of the longer side of the picture [mm]."""
MARGIN = 0.04
"""Margin around everything, as a fraction of the longer side."""
MAX_POINTS = 300
"""Maximum number of points of a path."""


def svg_of(shapes: Iterable[PlanItem], tracks: Iterable[Track] = ()) -> str:
    """Return a plan with paths, true ones wide and light; empty if there is nothing to draw."""
    shapes, tracks = list(shapes), list(tracks)
    truths = [_path("true path", track.truth) for track in tracks]
    if not shapes and not any(len(part) for path in truths for part in path.parts):
        return ""
    bounds = bounds_of([*shapes, *truths])
    side = float(np.ptp(bounds, axis=0).max())
    plan = SvgPlan(bounds + np.array([[-1.0], [1.0]]) * MARGIN * side, ratio=1000.0 * side / LONGER_SIDE)
    paths = [path for track, truth in zip(tracks, truths, strict=True) for path in _paths(track, truth, bounds)]
    plan.draw([*shapes, *paths])
    svg = plan.data().decode().partition("?>")[2]
    # Millimetres are enough, and ids of several pictures on a page would be the same.
    return re.sub(r' id="[^"]*"|\n *', "", re.sub(r"(\.\d)\d+", r"\1", svg))


def _paths(track: Track, truth: PlanItem, bounds: Array) -> Sequence[PlanItem]:
    """Return the dead-reckoned, true and estimated path; those that leave the picture stay beside it."""
    reach = bounds + np.array([[-1.0], [1.0]]) * np.ptp(bounds, axis=0).max()
    odometry = _path("odometry path", np.clip(track.odometry, *np.pad(reach, ((0, 0), (0, 1)))))
    estimate = _path("estimated path", np.clip(track.estimate, *np.pad(reach, ((0, 0), (0, 1)))))
    return odometry, truth, estimate


def _path(role: str, poses: Array) -> PlanItem:
    """Return the known part of a path as a line, poses of shape (N, 3)."""
    known = poses[np.isfinite(poses).all(axis=1), :2]
    rows = np.unique(np.linspace(0, max(len(known) - 1, 0), MAX_POINTS).astype(int))
    return PlanItem(role=role, kind="line", parts=(known[rows[: len(known)]],))
