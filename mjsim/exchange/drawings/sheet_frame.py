"""Separates the building from the rest of a sheet: its frame, scale bars, legends; in metres."""

from collections.abc import Sequence

import numpy as np

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.furnishing import touching
from mjsim.exchange.maps import fitted_rectangle
from mjsim.geometry import Array

MARGIN = 0.6
"""Minimum distance between the frame of a sheet and the building [m]."""
MIN_BUILDING_SHARE = 0.35
"""Minimum size of the building, as a fraction of the frame's."""
MIN_WHOLE_SHARE = 0.5
"""Minimum size of the largest part of the building that is connected, as a fraction of the building's."""
MAX_LINE_DISTANCE = 0.6
"""Lines within this distance of the building belong to it [m]."""
SMALL, SLIM = 0.2, 0.35
"""A group outside the building is dropped if it is smaller than this fraction of it, or narrower than this [m]."""


def without_frames(lines: Sequence[Line]) -> list[Line]:
    """Return lines without closed rectangles around all others, and without lines attached to these."""
    left = list(lines)
    while len(left) > 4:
        boxes = np.array([_box(line.points) for line in left])
        low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
        whole = np.flatnonzero((np.abs(boxes - [low, high]) <= 0.02 * (high - low).max()).all(axis=(1, 2)))
        frames = [left[k] for k in whole if left[k].closed and fitted_rectangle(left[k].points) is not None]
        inner = _separated(left, frames)
        if not frames or not _is_building(inner, left, low, high):
            break
        left = inner
    return left


def _separated(lines: Sequence[Line], frames: Sequence[Line]) -> list[Line]:
    """Return lines that do not touch a frame."""
    import shapely

    rings = shapely.union_all([shapely.LinearRing(line.points) for line in frames])
    return [line for line in lines if shapely.LineString(line.points).distance(rings) > 0.02]


def _is_building(inner: Sequence[Line], lines: Sequence[Line], low: Array, high: Array) -> bool:
    """Return whether lines keep clear of all sides of a frame, are most of its contents, and are connected.

    In a room, by contrast, things stand apart, and walls extend inwards from its outline.
    """
    import shapely

    if not inner:
        return False
    boxes = np.array([_box(line.points) for line in inner])
    first, last = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    away = min(*(first - low).tolist(), *(high - last).tolist()) >= MARGIN
    large = float(np.hypot(*(last - first))) >= MIN_BUILDING_SHARE * float(np.hypot(*(high - low)))
    if not (away and large and len(inner) >= 0.5 * len(lines)):
        return False
    kept, middle = {id(line) for line in inner}, shapely.box(*first, *last)
    attached = [line for line in lines if id(line) not in kept]
    if any(shapely.LineString(line.points).intersection(middle).length > MAX_LINE_DISTANCE for line in attached):
        return False
    groups = [np.concatenate([line.points for line in group]) for group in touching(inner, reach=MAX_LINE_DISTANCE)]
    widest = max(float(np.hypot(*np.ptp(points, axis=0))) for points in groups)
    return widest >= MIN_WHOLE_SHARE * float(np.hypot(*(last - first)))


def without_outliers(lines: Sequence[Line]) -> list[Line]:
    """Return lines without small groups outside the largest one."""
    import shapely

    groups = touching(lines)
    if len(groups) < 2:
        return list(lines)
    points = [np.concatenate([line.points for line in group]) for group in groups]
    sizes = [float(np.hypot(*np.ptp(each, axis=0))) for each in points]
    hull = shapely.MultiPoint(points[int(np.argmax(sizes))]).convex_hull.buffer(MAX_LINE_DISTANCE)
    # A large group beside the building is another part of it.
    large = [
        each
        for each, size in zip(points, sizes, strict=True)
        if size >= SMALL * max(sizes) and np.ptp(each, axis=0).min() > SLIM
    ]
    hull = shapely.union_all(
        [hull, *(shapely.MultiPoint(each).convex_hull.buffer(MAX_LINE_DISTANCE) for each in large)]
    )
    inside = [group for group, each in zip(groups, points, strict=True) if hull.intersects(shapely.MultiPoint(each))]
    chosen = {id(line) for group in inside for line in group}
    return [line for line in lines if id(line) in chosen]


def _box(points: Array) -> Array:
    return np.stack([points.min(axis=0), points.max(axis=0)])
