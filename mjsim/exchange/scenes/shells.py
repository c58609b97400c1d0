"""Walls of hollow meshes, such as a house in one file: its section is traced like the map of a robot."""

from typing import Any

import numpy as np

from mjsim.exchange.maps import world_from_grid
from mjsim.exchange.scenes.solids import Solid
from mjsim.geometry import Array, Pose
from mjsim.world import BoxObstacle, CylinderObstacle, Grid, Wall

LEVEL, MARGIN = 0.3, 0.05
"""Height of the section, and its minimum distance from the ends of the mesh [m]."""
WIDE, HIGH = 2.5, 0.25
"""Minimum width and height above the floor of such a mesh [m]."""
HOLLOW = 0.5
"""A mesh whose section fills less than this fraction of its convex hull is hollow."""
THICKEST = 0.3
"""Maximum distance between the two faces of a wall [m]."""
CELL, MOST_CELLS = 0.025, 2000
"""Side of a cell of the traced picture [m], and the maximum number along a side."""

Traced = tuple[list[Wall], list[BoxObstacle | CylinderObstacle]]


def walls_of_shell(solid: Solid) -> Traced:
    """Return the walls, boxes and discs of a hollow mesh; none if it is not hollow."""
    points = solid.corners()
    low, high = points.min(axis=0), points.max(axis=0)
    if solid.kind != "mesh" or max((high - low)[:2]) < WIDE or high[2] - max(low[2], 0.0) < HIGH:
        return [], []
    level = float(np.clip(LEVEL, low[2] + MARGIN, high[2] - MARGIN))
    segments = _section(points[solid.faces], level)
    if not len(segments):
        return [], []
    grid = _grid(segments)
    if _filled(grid) >= HOLLOW:
        return [], []
    world = world_from_grid(grid)
    height = {"height": round(float(high[2]), 3)}
    if solid.color is not None:
        height |= {"color": solid.color}  # type: ignore[dict-item]  # a colour
    walls = [wall.model_copy(update=height) for wall in world.walls]
    return walls, [thing for thing in world.obstacles if isinstance(thing, (BoxObstacle, CylinderObstacle))]


def _section(triangles: Array, level: float) -> Array:
    """Return where triangles, shape (n, 3, 3), meet a horizontal plane: lines of shape (m, 2, 2) [m]."""
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
    return np.asarray((first + share * (others - first))[..., :2])


def _grid(segments: Array) -> Grid:
    """Return a map on which lines, shape (m, 2, 2) [m], are occupied and all else is unknown."""
    import cv2

    low, high = segments.reshape(-1, 2).min(axis=0), segments.reshape(-1, 2).max(axis=0)
    cell = max(CELL, float(max(high - low)) / MOST_CELLS)
    corner = low - 8 * cell
    columns, rows = (np.ceil((high - corner) / cell) + 8).astype(int).tolist()
    picture = np.zeros((rows, columns), dtype=np.uint8)
    ends = np.floor((segments - corner) / cell).astype(np.int32)
    cv2.polylines(picture, list(ends), False, 1)
    occupied = _between_faces(picture | _inside(segments, corner, cell, picture.shape), cell)
    return Grid(occupied, ~occupied, cell, Pose(float(corner[0]), float(corner[1]), 0.0))


def _inside(segments: Array, corner: Array, cell: float, shape: tuple[int, ...]) -> Any:
    """Return which cells are inside of closed outlines by the even-odd rule, as integers; 0 in rows of open ones.

    Args:
        segments: The outlines, shape (n, 2, 2) [m].
        corner: Lower left corner of the picture, shape (2,) [m].
        cell: Side of a cell [m].
        shape: Rows and columns.
    """
    turns = np.zeros(shape, dtype=np.uint8)
    places = (segments - corner) / cell
    places = places[np.arange(len(places))[:, None], np.argsort(places[:, :, 1], axis=1)]
    low, high = np.ceil(places[:, 0, 1] - 0.5), np.ceil(places[:, 1, 1] - 0.5)
    counts = (high - low).astype(int)
    owner = np.repeat(np.arange(len(places)), counts)
    rows = low[owner].astype(int) + np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    (x, y), (to_x, to_y) = places[owner, 0].T, places[owner, 1].T
    columns = np.floor(x + (rows + 0.5 - y) / np.maximum(to_y - y, 1e-12) * (to_x - x)).astype(int)
    np.bitwise_xor.at(turns, (rows, columns.clip(0, shape[1] - 1)), 1)
    inside = np.bitwise_xor.accumulate(turns, axis=1)
    inside[inside[:, -1] == 1] = 0
    return inside


def _between_faces(picture: Any, cell: float) -> Any:
    """Return occupied cells with what lies between the two faces of a wall."""
    import cv2

    outside = np.pad(picture == 0, 1, constant_values=True).astype(np.uint8)
    _, parts, stats, _ = cv2.connectedComponentsWithStats(outside, connectivity=4)
    depth = cv2.distanceTransform(outside, cv2.DIST_L2, 5)
    deepest = np.zeros(len(stats))
    np.maximum.at(deepest, parts.ravel(), depth.ravel())
    thin = deepest * cell <= THICKEST / 2 + cell
    thin[0] = True
    return np.asarray(thin[parts])[1:-1, 1:-1]


def _filled(grid: Grid) -> float:
    """Return the occupied fraction of the convex hull of the occupied cells."""
    import cv2

    places = np.argwhere(grid.occupied)[:, ::-1].astype(np.float32)
    hull = float(cv2.contourArea(cv2.convexHull(places)))
    return len(places) / max(hull, 1.0)
