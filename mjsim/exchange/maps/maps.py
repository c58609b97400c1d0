"""Converts maps made by robots to worlds."""

import math
import re
from pathlib import Path

import numpy as np

from mjsim.exchange.maps.cleaning import without_specks
from mjsim.exchange.maps.joined_walls import runs_of
from mjsim.exchange.maps.trace import trace
from mjsim.geometry import Array
from mjsim.world import BoxObstacle, CylinderObstacle, Grid, Wall, World, solid

WALL_HEIGHT = 2.5
"""Height of walls, which a map does not state [m]."""
THING_HEIGHT = 1.0
"""Height of obstacles other than walls [m]."""
MAX_WALL_RATIO, MAX_WALL_DISTANCE = 1.5, 0.05
"""Maximum thickness of a box as a multiple of the usual wall's, and distance to a wall [m], to be as high as walls."""
DIGITS = 3
"""Coordinates are rounded to the millimetre."""


def world_from_grid(grid: Grid, *, name: str = "world") -> World:
    """Return a world with walls and obstacles for the occupied cells of a grid, without a robot."""
    import shapely

    traced = trace(grid)
    walls = []
    for number, run in enumerate(runs_of(traced.walls), start=1):
        corners = distinct(grid.corners(run.points), closed=run.closed)
        if len(corners) > 1:
            thickness = round(run.thickness * grid.resolution, DIGITS)
            closed = run.closed and len(corners) > 2
            walls.append(
                Wall(name=f"wall-{number}", points=corners, closed=closed, thickness=thickness, height=WALL_HEIGHT)
            )
    close_to_walls = solid(World(walls=tuple(walls))).buffer(MAX_WALL_DISTANCE)
    usual = float(np.median([wall.thickness for wall in walls])) if walls else 0.0
    things: list[BoxObstacle | CylinderObstacle] = []
    for bar in traced.boxes:
        turn = math.degrees(bar.heading + grid.world_from_grid.heading)
        sizes = [max(1e-3, round(size * grid.resolution, DIGITS)) for size in (bar.length, bar.width)]
        at = _point(grid, bar.x, bar.y)
        heading = round((turn + 90.0) % 180.0 - 90.0, 2) + 0.0
        part_of_wall = sizes[1] <= MAX_WALL_RATIO * usual and close_to_walls.intersects(
            shapely.polygons(grid.corners(bar.outline()))
        )
        height = WALL_HEIGHT if part_of_wall else THING_HEIGHT
        things.append(BoxObstacle(name=f"thing-{len(things) + 1}", at=at, heading_deg=heading, box=(*sizes, height)))
    for disc in traced.discs:
        radius = round(disc.radius * grid.resolution, DIGITS)
        at = _point(grid, disc.x, disc.y)
        things.append(
            CylinderObstacle(name=f"thing-{len(things) + 1}", at=at, cylinder=(radius, THING_HEIGHT)),
        )
    return World(name=name, walls=tuple(walls), obstacles=tuple(things))


def specks(grid: Grid) -> int:
    """Return the number of occupied cells that are noise: small groups that chance explains in a map this noisy."""
    return int(np.count_nonzero(grid.occupied & ~without_specks(grid).cells))


def name_of(path: str | Path) -> str:
    """Return a name for a world from the name of a file."""
    path = Path(path)
    stem = path.resolve().parent.name if path.stem == "map" else path.stem
    plain = re.sub(r"[^A-Za-z0-9_.-]+", "-", stem).strip("-.")[:64]
    return plain or "world"


def distinct(points: Array, *, closed: bool) -> tuple[tuple[float, float], ...]:
    """Return corners rounded to the millimetre, shape (n, 2) [m], without consecutive duplicates."""
    corners: list[tuple[float, float]] = []
    for x, y in np.round(points, DIGITS).tolist():
        corner = (x + 0.0, y + 0.0)
        if not corners or corners[-1] != corner:
            corners.append(corner)
    if closed and len(corners) > 1 and corners[0] == corners[-1]:
        corners.pop()
    return tuple(corners)


def _point(grid: Grid, x: float, y: float) -> tuple[float, float]:
    at_x, at_y = np.round(grid.corners(np.array([x, y])), DIGITS).tolist()
    return at_x + 0.0, at_y + 0.0
