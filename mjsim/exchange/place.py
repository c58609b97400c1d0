"""Where a robot starts in a world that was brought in, and a way that it can drive there."""

import math

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.grid import Cells, Grid
from mjsim.exchange.raster import cells_of, grid_of
from mjsim.geometry import Array
from mjsim.world.check import check_world
from mjsim.world.model import World
from mjsim.world.plan import solid
from mjsim.world.robots import Robot
from mjsim.world.running import Modules, Run, Use

ROBOT = "scout"
"""What the robot is called."""
PRESET = "pioneer3dx"
ELBOW_ROOM = 0.15
"""Between the robot and what it passes on its way [m]."""
LONGEST_WAY = 15.0
"""[m]"""
MOST_CELLS = 4_000_000
"""Of the grid on which a place is looked for."""
DIRECTIONS = 72
WAYPOINTS = "mjsim.algorithms.waypoints:Waypoints"


def with_robot(world: World, *, preset: str = PRESET, grid: Grid | None = None) -> World:
    """Return a world with a robot at the free place farthest from everything solid, and a way to drive.

    Args:
        world: It has no robot yet.
        preset: A robot of `assets/robots`.
        grid: What is known to be free; the inside of the walls unless given.

    Raises:
        UsageError: The world has no place for it.
    """
    away, grid = _clearance(world, grid)
    row, column = (int(index) for index in np.unravel_index(int(np.argmax(away)), away.shape))
    start = grid.corners(np.array([column + 0.5, row + 0.5]))
    at = tuple(np.round(start, 2).tolist())
    robot = Robot(name=ROBOT, preset=preset, at=at)
    need = _radius(robot) + ELBOW_ROOM
    if away[row, column] < need:
        raise UsageError(
            f"the widest free place of this world is {away[row, column] * 2:.2f} m across;"
            f" the {preset} needs {need * 2:.2f} m, leave it out with --no-robot"
        )
    goal = _farthest(away, grid, np.array(at), need)
    heading = round(math.degrees(math.atan2(goal[1] - at[1], goal[0] - at[0])), 1)
    robot = Robot(name=ROBOT, preset=preset, at=at, heading_deg=heading)
    way = Use.model_validate({"use": WAYPOINTS, "points": [np.round(goal, 2).tolist(), list(at)]})
    run = Run(drivers={ROBOT: Modules(navigator=way, avoidance=True)})
    whole = world.model_copy(update={"robots": (robot,), "run": run})
    if problems := check_world(whole):
        raise UsageError(f"there is no place for a robot: {problems[0].message}")
    return whole


def _radius(robot: Robot) -> float:
    body = robot.body
    return float(getattr(body, "radius", None) or math.hypot(*getattr(body, "size", (0.8, 0.8))[:2]) / 2)


def _clearance(world: World, grid: Grid | None) -> tuple[Array, Grid]:
    """Return how far each middle of a cell is from what is solid or unknown [m], and the grid."""
    import cv2

    shape = solid(world)
    if grid is None and shape.is_empty:
        size = np.zeros((200, 200), dtype=bool)
        from mjsim.geometry import Pose

        grid = Grid(size, ~size, 0.05, Pose(-5.0, -5.0, 0.0))
    elif grid is None:
        low_x, low_y, high_x, high_y = shape.bounds
        area = (high_x - low_x + 2.0) * (high_y - low_y + 2.0)
        grid = grid_of(world, resolution=max(0.05, math.sqrt(area / MOST_CELLS)))
    free: Cells = grid.free & ~cells_of(shape, grid)
    padded = np.pad(free.astype(np.uint8), 1)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]
    # From a middle to the nearest face, not to the next middle.
    return np.asarray(np.maximum(away - 0.5, 0.0) * grid.resolution, dtype=float), grid


def _farthest(away: Array, grid: Grid, start: Array, need: float) -> Array:
    """Return the farthest place that can be driven to in a straight line, shape (2,) [m]."""
    steps = np.arange(0.0, LONGEST_WAY, grid.resolution)
    headings = np.arange(DIRECTIONS) * (2 * math.pi / DIRECTIONS)
    best = start
    for heading in headings:
        points = start + steps[:, None] * [math.cos(heading), math.sin(heading)]
        cells = np.floor(grid.cells(points)).astype(int)
        rows, columns = away.shape
        there = (cells >= 0).all(axis=1) & (cells[:, 0] < columns) & (cells[:, 1] < rows)
        cells = cells.clip(0, (columns - 1, rows - 1))
        clear = there & (away[cells[:, 1], cells[:, 0]] >= need)
        last = len(clear) if clear.all() else int(np.argmin(clear))
        if last and math.dist(points[last - 1], start) > math.dist(best, start) + 0.1:
            best = points[last - 1]
    return np.asarray(best)
