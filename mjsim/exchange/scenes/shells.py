"""Walls of hollow meshes, such as a house in one file: its section is traced like the map of a robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mjsim.exchange.maps import world_from_grid
from mjsim.exchange.scenes.scene_solids import SceneSolid
from mjsim.geometry import Array, Pose
from mjsim.world import BoxObstacle, CylinderObstacle, Grid, Wall

LEVEL, MARGIN = 0.3, 0.05
"""Height of the section, and its minimum distance from the ends of the mesh [m]."""
MIN_SHELL_WIDTH, MIN_SHELL_HEIGHT = 2.5, 0.1
"""Minimum width and height above the floor of such a mesh [m]."""
MIN_PORTAL_HEIGHT = 1.8
"""Minimum height of the top of a frame that a person walks through [m]."""
MAX_HOLLOW_SHARE = 0.5
"""A mesh whose section fills less than this fraction of its convex hull is hollow."""
MAX_THICKNESS = 0.3
"""Maximum distance between the two faces of a wall [m]."""
CELL_SIDE, MAX_CELLS = 0.025, 2000
"""Side of a cell of the traced picture [m], and the maximum number along a side."""


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """Results for the hollow meshes of a thing."""

    walls: Sequence[Wall] = ()
    things: Sequence[BoxObstacle | CylinderObstacle] = ()
    used: Sequence[SceneSolid] = ()
    """The meshes that these replace."""
    dropped: Sequence[SceneSolid] = ()
    """Hollow meshes that begin above the section, such as rails along walls."""


def traced(solids: Sequence[SceneSolid]) -> Traced:
    """Return the walls, boxes and discs of the wide meshes of a thing, if they are hollow as a whole.

    An outer shell and the rooms in it are separate parts of a mesh, with walls between them.
    """
    meshes = [solid for solid in solids if solid.kind == "mesh"]
    wide = [solid for solid in meshes if _is_wide(solid)]
    low = [solid for solid in wide if float(solid.corners()[:, 2].min()) <= LEVEL]
    dropped = [solid for solid in wide if solid not in low and _is_hollow(_cut(solid))]
    segments = np.concatenate([np.zeros((0, 2, 2)), *map(_cut, low)])
    if not _is_hollow(segments):
        return Traced(dropped=dropped)
    frames = [solid for solid in meshes if solid not in wide and _is_portal(solid)]
    low += frames
    segments = np.concatenate([segments, *map(_cut, frames)])
    world = world_from_grid(_grid(segments))
    keys: dict[str, Any] = {"height": round(max(float(solid.corners()[:, 2].max()) for solid in low), 3)}
    if low[0].color is not None:
        keys |= {"color": low[0].color}
    walls = [wall.model_copy(update=keys) for wall in world.walls]
    things = [thing for thing in world.obstacles if isinstance(thing, (BoxObstacle, CylinderObstacle))]
    return Traced(walls, things, low, dropped)


def _is_wide(solid: SceneSolid) -> bool:
    low, high = solid.corners().min(axis=0), solid.corners().max(axis=0)
    return bool(max((high - low)[:2]) >= MIN_SHELL_WIDTH and high[2] - max(low[2], 0.0) >= MIN_SHELL_HEIGHT)


def _is_portal(solid: SceneSolid) -> bool:
    """Return whether a mesh on the floor can be walked through, like a door frame and unlike a table."""
    low, high = solid.corners()[:, 2].min(), solid.corners()[:, 2].max()
    return bool(low <= LEVEL and high >= MIN_PORTAL_HEIGHT) and _is_hollow(_cut(solid))


def _cut(solid: SceneSolid) -> Array:
    """Return the section of a mesh, near the usual level; shape (n, 2, 2) [m]."""
    points = solid.corners()
    margin = min(MARGIN, float(np.ptp(points[:, 2])) / 2)
    level = float(np.clip(LEVEL, points[:, 2].min() + margin, points[:, 2].max() - margin))
    return _section(points[solid.faces], level)


def _is_hollow(segments: Array) -> bool:
    """Return whether outlines, shape (n, 2, 2) [m], surround little of their convex hull."""
    return len(segments) > 0 and _filled(_grid(segments)) < MAX_HOLLOW_SHARE


def _section(triangles: Array, level: float) -> Array:
    """Return where triangles, shape (n, 3, 3), meet a horizontal plane: lines (m, 2, 2), solid to the left [m].

    The corners of a triangle are counter-clockwise from outside, so its normal points out of the solid.
    """
    above = triangles[:, :, 2] > level
    crossed = triangles[above.any(axis=1) & ~above.all(axis=1)]
    if not len(crossed):
        return np.zeros((0, 2, 2))
    above = crossed[:, :, 2] > level
    # Turn each triangle so that its first corner is alone on its side of the plane.
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    turned = np.take_along_axis(crossed, order[:, :, None], axis=1)
    first, others = turned[:, :1], turned[:, 1:]
    share = (level - first[..., 2:]) / (others[..., 2:] - first[..., 2:])
    lines = np.asarray((first + share * (others - first))[..., :2])
    normals = np.cross(crossed[:, 1] - crossed[:, 0], crossed[:, 2] - crossed[:, 0])[:, :2]
    along = lines[:, 1] - lines[:, 0]
    wrong = along[:, 0] * normals[:, 1] - along[:, 1] * normals[:, 0] > 0.0
    lines[wrong] = lines[wrong][:, ::-1]
    return lines


def _grid(segments: Array) -> Grid:
    """Return a map on which lines, shape (m, 2, 2) [m], are occupied and all else is unknown."""
    import cv2

    low, high = segments.reshape(-1, 2).min(axis=0), segments.reshape(-1, 2).max(axis=0)
    cell = max(CELL_SIDE, float(max(high - low)) / MAX_CELLS)
    corner = low - 8 * cell
    columns, rows = (np.ceil((high - corner) / cell) + 8).astype(int).tolist()
    picture = np.zeros((rows, columns), dtype=np.uint8)
    ends = np.floor((segments - corner) / cell).astype(np.int32)
    cv2.polylines(picture, list(ends), False, 1)
    # A doorway without jambs looks like a part of its wall along it, but not across it.
    thin = int(MAX_THICKNESS / cell)
    near = np.zeros_like(picture)
    for shape in ((1, thin), (thin, 1)):
        near |= cv2.morphologyEx(picture, cv2.MORPH_CLOSE, np.ones(shape, dtype=np.uint8))
    by_row = _inside(segments, corner, cell, (rows, columns))
    by_column = _inside(segments[:, ::-1, ::-1], corner[::-1], cell, (columns, rows)).T
    inside = np.ascontiguousarray((by_row & by_column) | ((by_row | by_column) & near & (1 - picture)))
    # Lines that bound filled cells do not count: they would enlarge these by half a cell.
    alone = picture & (1 - cv2.dilate(inside, np.ones((3, 3), dtype=np.uint8)))
    occupied = _between_faces(inside | alone, cell)
    return Grid(occupied, ~occupied, cell, Pose(float(corner[0]), float(corner[1]), 0.0))


def _inside(segments: Array, corner: Array, cell: float, shape: tuple[int, int]) -> Any:
    """Return which cells are inside of the solid, 0 or 1; 0 in rows where its outlines are open.

    A room whose walls have only inner faces is not a solid: its outline has the solid outside.

    Args:
        segments: The outlines, solid to the left, shape (n, 2, 2) [m].
        corner: Lower left corner of the picture, shape (2,) [m].
        cell: Side of a cell [m].
        shape: Rows and columns.
    """
    places = (segments - corner) / cell
    # The left of a downward line, which is solid, has greater x.
    signs = np.where(places[:, 1, 1] < places[:, 0, 1], 1, -1).astype(np.int32)
    places = places[np.arange(len(places))[:, None], np.argsort(places[:, :, 1], axis=1)]
    low, high = np.ceil(places[:, 0, 1] - 0.5).astype(int), np.ceil(places[:, 1, 1] - 0.5).astype(int)
    counts = high - low
    owner = np.repeat(np.arange(len(places), dtype=np.int64), counts)
    rows = low[owner] + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    (x, y), (to_x, to_y) = places[owner, 0].T, places[owner, 1].T
    columns = np.floor(x + (rows + 0.5 - y) / np.maximum(to_y - y, 1e-12) * (to_x - x)).astype(int)
    cells = rows * shape[1] + columns.clip(0, shape[1] - 1)
    turns = np.bincount(cells.astype(np.int64), weights=signs[owner], minlength=shape[0] * shape[1])
    inside = np.cumsum(turns.reshape(shape), axis=1)
    inside[inside[:, -1] != 0] = 0
    return (inside > 0).astype(np.uint8)


def _between_faces(picture: Any, cell: float) -> Any:
    """Return occupied cells, with those between the two faces of a wall."""
    import cv2

    outside = np.pad(picture == 0, 1, constant_values=True).astype(np.uint8)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(outside, connectivity=4)
    depth = cv2.distanceTransform(outside, cv2.DIST_L2, 5)
    deepest = np.zeros(len(stats))
    np.maximum.at(deepest, parts.ravel().astype(np.int64), depth.ravel())
    thin = deepest * cell <= MAX_THICKNESS / 2 + cell
    thin[0] = True
    return np.asarray(thin[parts])[1:-1, 1:-1]


def _filled(grid: Grid) -> float:
    """Return the occupied fraction of the convex hull of the occupied cells."""
    import cv2

    places = np.argwhere(grid.occupied)[:, ::-1].astype(np.float32)
    hull = float(cv2.contourArea(cv2.convexHull(places)))
    return len(places) / max(hull, 1.0)
