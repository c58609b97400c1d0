"""Start position and path of a robot in an imported world."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.pixels import Cells
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.geometry import Array
from mjsim.world import Grid, Modules, Robot, Run, Use, World, cells_of, check_world, grid_of, sensor_names, solid

ROBOT = "scout"
"""What the robot is called."""
PRESET = "pioneer3dx"
ELBOW_ROOM, TIGHT = 0.15, 0.05
"""Between the robot and what it passes on its way, and where there is no such way [m]."""
LONGEST_WAY = 15.0
"""In a straight line [m]."""
LEGS, SHORTEST_LEG = 4, 1.0
"""The most straight lines of a way, and how long each is at least [m]."""
STARTS = 24
"""The most places that are tried."""
MAST, HIGHEST = 0.04, 0.45
"""How far a lidar stands above the body, and how high at most: it should see things, not only walls [m]."""
ODOMETRY_NOISE = {"distance": 0.01, "turn": 0.02}
"""Of a robot that must find out where it is [m/sqrt(m), rad/sqrt(rad)]."""
SPECK = 0.02
"""What is not known to be free on so little ground does not stand in the way when nothing solid is there [m^2]."""
MOST_CELLS = 4_000_000
"""Of the grid on which a place is looked for."""
DIRECTIONS = 72
ESTIMATORS = {
    "monte_carlo": "mjsim.algorithms.monte_carlo:MonteCarloLocalization",
    "lidar_slam": "mjsim.algorithms.lidar_slam:LidarSlam",
}
"""Short names of estimators that need a lidar and nothing else."""
WAYPOINTS = "mjsim.algorithms.waypoints:Waypoints"


@dataclass(frozen=True, slots=True)
class Newcomer:
    """The robot that is put into a world that was brought in, as `with_robot` takes it."""

    preset: str = PRESET
    lidar: str | None = None
    estimator: Use | None = None
    folder: Path | None = None
    """Of the new world, in which the file of a preset lies."""


def with_newcomer(world: World, robot: Newcomer | None, *, grid: Grid | None = None) -> World:
    """Return a world with a robot; as it is without one.

    Raises:
        UsageError: The world has no place for it, or there is no such preset.
    """
    if robot is None:
        return world
    return with_robot(
        world, preset=robot.preset, lidar=robot.lidar, estimator=robot.estimator, grid=grid, folder=robot.folder
    )


def without_way(world: World) -> list[str]:
    """Return the sentence that tells of a robot for which no way was found; none where it drives, or there is none."""
    if not world.robots:
        return []
    (robot,) = world.robots
    way = world.run.drivers[robot.name].navigator
    if way is None or any(tuple(point) != robot.at for point in way.model_dump()["points"]):
        return []
    return [f"no straight path of {SHORTEST_LEG:g} m is wide enough for the {robot.preset}; it does not drive"]


def with_robot(
    world: World,
    *,
    preset: str = PRESET,
    lidar: str | None = None,
    estimator: Use | None = None,
    grid: Grid | None = None,
    folder: Path | None = None,
) -> World:
    """Return a world with a robot far from everything solid, and a way to drive.

    It starts at the free place that is farthest from what is solid, of those from which it can drive; where there is no
    such place it stands still. With an estimator the robot's odometry errs, and the estimator has the map unless its
    name says SLAM.

    Args:
        world: It has no robot yet.
        preset: A robot of `assets/robots`, or the file of one in the folder of the world.
        lidar: A lidar of `assets/sensors/lidar`, mounted on top; by default none.
        estimator: Module that finds out where the robot is; by default the truth is used.
        grid: What is known to be free; by default the inside of the walls.
        folder: In which the world will be.

    Raises:
        UsageError: The world has no place for it, or there is no such preset.
    """
    away, grid = _clearance(world, grid)
    robot = _robot(preset, lidar, at=(0.0, 0.0), heading=0.0, errs=estimator is not None, folder=folder)
    need, widest = robot.body.radius + ELBOW_ROOM, float(away.max())
    if widest < need:
        raise UsageError(
            f"the widest free place of this world is {widest * 2:.2f} m across;"
            f" the {preset} needs {need * 2:.2f} m, leave it out with --no-robot"
        )
    if estimator is not None and not any(sensor.kind == "lidar" for sensor in robot.sensors):
        raise UsageError(
            f"the {preset} has no lidar to localise with; add --lidar, one of {', '.join(sensor_names('lidar'))}"
        )
    tight = need - ELBOW_ROOM + TIGHT
    tours = (_tour(away, grid, start, room) for room in (need, tight) for start in _starts(away, grid, room))
    at, *tour = next((tour for tour in tours if len(tour) > 1), _starts(away, grid, need)[:1] * 2)
    heading = round(math.degrees(math.atan2(*(tour[0] - at)[::-1])), 1)
    robot = _robot(preset, lidar, at=_place(at), heading=heading, errs=estimator is not None, folder=folder)
    back = [*tour[-2::-1], at]
    points = [np.round(point, 2).tolist() for point in [*tour, *back]]
    way = Use.model_validate({"use": WAYPOINTS, "points": points})
    driver = Modules(navigator=way, avoidance=True)
    if estimator is not None:
        driver = driver.model_copy(update={"estimator": estimator})
    known = estimator is not None and "slam" not in estimator.use.lower()
    run = Run(drivers={ROBOT: driver}, map="known" if known else "unknown")
    whole = inhabited(world, robot, run, folder)
    if problems := check_world(whole):
        raise UsageError(f"there is no place for a robot: {problems[0].message}")
    return whole


def _robot(
    preset: str, lidar: str | None, *, at: tuple[float, float], heading: float, errs: bool, folder: Path | None
) -> Robot:
    """Return the robot at a place, with a lidar on top and odometry that errs where these are asked for.

    Raises:
        UsageError: The preset does not exist.
    """
    keys: dict[str, Any] = {"name": ROBOT, "preset": preset, "at": list(at), "heading_deg": heading}
    bare = robot_of(keys, folder)
    if lidar is not None:
        height = round(min(bare.body.height + MAST, HIGHEST), 3)
        scan = {"lidar": "scan", "preset": lidar, "at": [0.0, 0.0, height]}
        others = [sensor for sensor in bare.sensors if sensor.kind != "lidar"]
        # The scan of a robot that leans is made level by what an inertial sensor tells.
        lean = [bare.own_imu.model_copy(update={"imu": "imu"})] if bare.own_imu is not None else []
        keys["sensors"] = [*(sensor.model_dump(exclude_unset=True) for sensor in [*others, *lean]), scan]
    if errs:
        keys["odometry"] = {**bare.odometry.model_dump(exclude_unset=True), "noise": ODOMETRY_NOISE}
    return robot_of(keys, folder)


def _clearance(world: World, grid: Grid | None) -> tuple[Array, Grid]:
    """Return how far each middle of a cell is from what is solid or unknown [m], and the grid."""
    import cv2

    shape = solid(world)
    if grid is None and shape.is_empty:
        size = np.zeros((200, 200), dtype=bool)
        from mjsim.geometry import Pose

        grid = Grid(size, ~size, 0.05, Pose(-5.0, -5.0, 0.0))
    elif grid is None:
        grid = grid_of(world, most_cells=MOST_CELLS)
    taken = cells_of(shape, grid)
    free: Cells = (grid.free | _specks(~grid.free & ~taken, SPECK / grid.resolution**2)) & ~taken
    if (inside := free & cells_of(shape.convex_hull, grid)).any():
        # The paper around a plan is as white as its rooms.
        free = inside
    padded = np.pad(free.astype(np.uint8), 1)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]
    # From a middle to the nearest face, not to the next middle.
    return np.asarray(np.maximum(away - 0.5, 0.0) * grid.resolution, dtype=float), grid


def _specks(cells: Cells, largest: float) -> Cells:
    """Return the cells of parts with at most so many: noise, of which the world has nothing."""
    import cv2

    _, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    small = stats[:, cv2.CC_STAT_AREA] <= largest
    small[0] = False
    return np.asarray(small[parts], dtype=bool)


def _place(point: Array) -> tuple[float, float]:
    """Return a place as worlds write it."""
    x, y = np.round(point, 2).tolist()
    return x, y


def _starts(away: Array, grid: Grid, need: float) -> list[Array]:
    """Return free places, the widest first, no two near to each other, shape (2,) each [m]."""
    import cv2

    left, found = away.copy(), list[Array]()
    while len(found) < STARTS and left.max() >= need:
        row, column = (int(index) for index in np.unravel_index(int(np.argmax(left)), left.shape))
        found.append(np.round(grid.corners(np.array([column + 0.5, row + 0.5])), 2))
        cv2.circle(left, (column, row), round(SHORTEST_LEG / grid.resolution), 0.0, -1)
    return found


def _tour(away: Array, grid: Grid, start: Array, need: float) -> list[Array]:
    """Return the start and places to drive to in turn, each far from those before and seen from the last [m]."""
    seen = [start]
    for _ in range(LEGS):
        ahead = _farthest(away, grid, seen, need)
        if math.dist(ahead, seen[-1]) < SHORTEST_LEG:
            break
        seen.append(ahead)
    return seen


def _farthest(away: Array, grid: Grid, seen: Sequence[Array], need: float) -> Array:
    """Return the place farthest from all that were seen which is a straight drive from the last, shape (2,) [m]."""
    start, steps = seen[-1], np.arange(0.0, LONGEST_WAY, grid.resolution)
    best, most = start, 0.1
    for heading in np.arange(DIRECTIONS) * (2 * math.pi / DIRECTIONS):
        points = start + steps[:, None] * [math.cos(heading), math.sin(heading)]
        cells = np.floor(grid.cells(points)).astype(int)
        rows, columns = away.shape
        there = (cells >= 0).all(axis=1) & (cells[:, 0] < columns) & (cells[:, 1] < rows)
        cells = cells.clip(0, (columns - 1, rows - 1))
        clear = there & (away[cells[:, 1], cells[:, 0]] >= need)
        last = len(clear) if clear.all() else int(np.argmin(clear))
        if not last:
            continue
        apart = np.min([np.hypot(*(points[:last] - place).T) for place in seen], axis=0)
        if (farthest := int(np.argmax(apart))) and apart[farthest] > most:
            best, most = points[farthest], float(apart[farthest])
    return np.asarray(best)
