"""Start position and path of a robot in an imported world."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.exchange.maps import Cells
from mjsim.exchange.preset_files import NO_NOISE, inhabited, robot_of
from mjsim.exchange.world_import import PRESET, Newcomer
from mjsim.geometry import Array, Pose
from mjsim.world import (
    SLICE,
    Grid,
    Modules,
    Robot,
    Run,
    Use,
    World,
    cells_of,
    check_world,
    grid_of,
    sensor_names,
    solid,
    thickened,
)

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

ROBOT = "scout"
"""Name of the robot."""
ELBOW_ROOM, REDUCED_CLEARANCE = 0.15, 0.05
"""Clearance between the robot and what it passes, and the reduced clearance used if there is no such path [m]."""
MAX_DISTANCE = 15.0
"""Maximum length of a straight leg [m]."""
LEGS, MIN_LEG = 4, 1.0
"""Maximum number of legs, and minimum length of each [m]."""
MAX_STARTS = 24
"""Maximum number of start positions tried."""
HEIGHTS = (0.01, 0.06, 0.35)
"""Further heights at which things and low walls count as obstacles [m]."""
MAST, HIGHEST = 0.04, 0.45
"""Height of a lidar above the body, and its maximum height above the floor, at which it also sees low objects [m]."""
ODOMETRY_NOISE = {"distance": 0.01, "turn": 0.02}
"""Odometry noise of a robot with an estimator [m/sqrt(m), rad/sqrt(rad)]."""
MIN_UNKNOWN_AREA = 0.02
"""An area of unknown cells smaller than this is not an obstacle if nothing solid is there [m^2]."""
ROOM, MAX_ROOMS = 1.0, 5
"""Minimum size of an area that is reported as unreachable [m^2], and the number of such areas that are listed."""
ENCLOSED = 0.5
"""Minimum share of the free space within the outline of a world that walls enclose."""
FLOOR_MARGIN = 5.0
"""Width of the floor around things that no wall encloses [m]."""
MAX_FAR = 100.0
"""Maximum distance of a start from all that is solid [m]."""
MAX_CELLS = 4_000_000
"""Maximum size of the search grid [cells]."""
DIRECTIONS = 72
ESTIMATORS = {
    "monte_carlo": "mjsim.algorithms.monte_carlo:MonteCarloLocalization",
    "lidar_slam": "mjsim.algorithms.lidar_slam:LidarSlam",
}
"""Short names of estimators that need only a lidar."""
WAYPOINTS = "mjsim.algorithms.waypoints:Waypoints"


class NoSpaceError(UsageError):
    """A world has no space for a robot."""


def with_newcomer(
    world: World,
    robot: Newcomer | None,
    *,
    grid: Grid | None = None,
    start: tuple[float, float, float] | None = None,
) -> tuple[World, Sequence[str]]:
    """Return the world with a robot, or unchanged if `robot` is None, and notes on its place for the user.

    Args:
        world: A world without a robot.
        robot: The robot to add.
        grid: Grid of known free space; by default the inside of the walls.
        start: Where it should start if there is space: x, y [m], heading [rad].

    Raises:
        UsageError: There is no space for the robot, or the preset does not exist.
    """
    if robot is None:
        return world, ()
    try:
        whole, cut_off = _with_robot(world, robot, grid, start)
    except NoSpaceError as error:
        if not robot.is_usual:
            raise
        return world, [f"no robot: {error}"]
    return whole, [*without_route(whole), *cut_off]


def without_route(world: World) -> list[str]:
    """Return a note that no path was found for the robot; empty if it has one, or if there is no robot."""
    if not world.robots:
        return []
    (robot,) = world.robots
    navigator = world.run.drivers[robot.name].navigator
    if navigator is None or any(tuple(point) != robot.at for point in navigator.model_dump()["points"]):
        return []
    return [f"no straight path of {MIN_LEG:g} m is wide enough for the {robot.preset}; it does not drive"]


def with_robot(
    world: World,
    *,
    preset: str = PRESET,
    lidar: str | None = None,
    estimator: Use | None = None,
    grid: Grid | None = None,
    folder: Path | None = None,
) -> World:
    """Return a world with a robot far from all obstacles, and a path to drive.

    The robot starts in the largest area that it can drive through, at the place farthest from all obstacles among those
    from which it can drive; if there is none, it stands still. With an estimator, the robot's odometry is noisy, and
    the estimator gets the map unless its name contains SLAM.

    Args:
        world: A world without a robot.
        preset: A robot in `assets/robots`, or a preset file in the folder of the world.
        lidar: A lidar in `assets/sensors/lidar`, mounted on top; by default none.
        estimator: The estimator; by default the driver uses ground truth.
        grid: Grid of known free space; by default the inside of the walls.
        folder: Folder in which the world will be saved.

    Raises:
        UsageError: There is no space for the robot, or the preset does not exist.
    """
    return _with_robot(world, Newcomer(preset, lidar, estimator, folder), grid)[0]


def _with_robot(
    world: World, newcomer: Newcomer, grid: Grid | None, start: tuple[float, float, float] | None = None
) -> tuple[World, list[str]]:
    """Return a world with a robot, and a line on the areas that it cannot reach; see `with_robot`."""
    preset, lidar, estimator, folder = newcomer.preset, newcomer.lidar, newcomer.estimator, newcomer.folder
    robot = _robot(preset, lidar, at=(0.0, 0.0), heading=0.0, errs=estimator is not None, folder=folder)
    need = robot.body.radius + ELBOW_ROOM
    tight = need - ELBOW_ROOM + REDUCED_CLEARANCE
    away, grid = _clearance(world, grid, need, start=start, tight=tight)
    widest = float(away.max())
    if widest < need:
        raise NoSpaceError(
            f"the widest free space of this world is {widest * 2:.2f} m across;"
            f" the {preset} needs {need * 2:.2f} m; name a smaller one, or leave it out with --no-robot"
        )
    if estimator is not None and not any(sensor.kind == "lidar" for sensor in robot.sensors):
        raise UsageError(
            f"the {preset} has no lidar to localise with; add --lidar, one of {', '.join(sensor_names('lidar'))}"
        )
    wanted = [] if start is None or not _clear(away, grid, np.array([start[:2]]), tight)[0] else [np.array(start[:2])]
    away, cut_off = _connected(away, grid, tight, wanted)
    places = [*wanted, *_starts(away, grid, tight if wanted else need)]
    tours = (_tour(away, grid, place, room) for room in (need, tight) for place in wanted or _starts(away, grid, room))
    at, *tour = next((tour for tour in tours if len(tour) > 1), places[:1] * 2)
    heading = round(math.degrees(start[2] if wanted and start else math.atan2(*(tour[0] - at)[::-1])), 1)
    if start is not None and not wanted:
        cut_off.append(f"the start in the file, [{start[0]:.2f}, {start[1]:.2f}], is not free; the robot is elsewhere")
    robot = _robot(preset, lidar, at=_place(at), heading=heading, errs=estimator is not None, folder=folder)
    back = [*tour[-2::-1], at]
    points = [np.round(point, 2).tolist() for point in [*tour, *back]]
    navigator = Use.model_validate({"use": WAYPOINTS, "points": points})
    driver = Modules(navigator=navigator, avoidance=True)
    if estimator is not None:
        driver = driver.model_copy(update={"estimator": estimator})
    known = estimator is not None and "slam" not in estimator.use.lower()
    run = Run(drivers={ROBOT: driver}, map="known" if known else "unknown")
    whole = inhabited(world, robot, run, folder)
    if problems := check_world(whole):
        raise NoSpaceError(f"there is no space for a robot: {problems[0].message}")
    return whole, cut_off


def _robot(
    preset: str, lidar: str | None, *, at: tuple[float, float], heading: float, errs: bool, folder: Path | None
) -> Robot:
    """Return the robot at a place, optionally with a lidar on top; odometry has noise if it `errs`.

    Raises:
        UsageError: The preset does not exist.
    """
    keys: dict[str, Any] = {"name": ROBOT, "preset": preset, "at": list(at), "heading_deg": heading}
    bare = robot_of(keys, folder)
    if lidar is not None:
        height = round(min(bare.body.height + MAST, HIGHEST), 3)
        scan = {"lidar": "scan", "preset": lidar, "at": [0.0, 0.0, height]}
        others = [sensor for sensor in bare.sensors if sensor.kind != "lidar"]
        # On a robot that tilts, an inertial sensor is used to level the scan.
        lean = [bare.own_imu.model_copy(update={"imu": "imu"})] if bare.own_imu is not None else []
        keys["sensors"] = [*(sensor.model_dump(exclude_unset=True) for sensor in [*others, *lean]), scan]
    noise = ODOMETRY_NOISE if errs else NO_NOISE
    keys["odometry"] = {**bare.odometry.model_dump(exclude_unset=True), "noise": noise}
    return robot_of(keys, folder)


def _clearance(
    world: World, grid: Grid | None, need: float, *, start: tuple[float, float, float] | None, tight: float
) -> tuple[Array, Grid]:
    """Return the distance of each cell's centre from solid or unknown space [m], and the grid.

    If walls do not enclose most of the scene, and the space in it is narrower than `need` [m], the space around it
    counts, too; likewise for a `start` outside, with the clearance `tight` [m].
    """
    import shapely

    given = grid
    things = [thing.model_copy(update={"movable": False, "path": None}) for thing in world.obstacles]
    world = world.model_copy(update={"obstacles": tuple(things)})
    shape = section = solid(world)
    if things or any(wall.height < SLICE for wall in world.walls):
        shape = shapely.union_all([shape, *(solid(world, height=height) for height in HEIGHTS)])
    if grid is not None or not section.is_empty:
        grid = grid or grid_of(world, most_cells=MAX_CELLS)
        hull = shape.convex_hull
        away = _away(shape, grid, hull)
        outside = start is not None and given is None and _is_outside(start, shape, away, grid, tight)
        is_room = (away > 0).sum() * grid.resolution**2 > ENCLOSED * (hull.area - shape.area)
        if not outside and (away.max() >= need or given is not None or (world.walls and is_room)):
            return away, grid
    bounds = np.array((0.0,) * 4 if shape.is_empty else shape.bounds)
    if start is not None and np.abs(np.subtract(start[:2], bounds[:2])).max() < MAX_FAR:
        bounds = np.concatenate([np.minimum(bounds[:2], start[:2]), np.maximum(bounds[2:], start[:2])])
    low, high = bounds[:2] - FLOOR_MARGIN, bounds[2:] + FLOOR_MARGIN
    cell = max(0.05, math.sqrt(float(np.prod(high - low)) / MAX_CELLS))
    size = np.zeros(np.ceil((high - low) / cell).astype(int)[::-1], dtype=bool)
    grid = Grid(size, ~size, cell, Pose(float(low[0]), float(low[1]), 0.0))
    return _away(shape, grid, shapely.box(*low, *high)), grid


def _is_outside(
    start: tuple[float, float, float], shape: "BaseGeometry", away: Array, grid: Grid, tight: float
) -> bool:
    """Return whether a place that has no clearance inside is clear of all that is solid, and not far away."""
    from shapely import Point

    place = np.array([start[:2]])
    return not _clear(away, grid, place, tight)[0] and tight <= shape.distance(Point(*start[:2])) < MAX_FAR


def _away(shape: "BaseGeometry", grid: Grid, within: "BaseGeometry") -> Array:
    """Return the distance of each cell's centre from the nearest solid, unknown or outer place [m]."""
    import cv2

    taken = cells_of(shape, grid) | cells_of(thickened(shape, grid.resolution), grid)
    free: Cells = (grid.free | _specks(~grid.free & ~taken, MIN_UNKNOWN_AREA / grid.resolution**2)) & ~taken
    if (inside := free & cells_of(within, grid)).any():
        # The background of a plan is as white as its rooms.
        free = inside
    padded = np.pad(free.astype(np.uint8), 1)
    away = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]
    # From a centre to the nearest face, not to the next centre.
    return np.asarray(np.maximum(away - 0.5, 0.0) * grid.resolution, dtype=float)


def _clear(away: Array, grid: Grid, points: Array, need: float) -> NDArray[np.bool_]:
    """Return which points, shape (n, 2) [m], are in the grid and have the clearance that a robot needs [m]."""
    size = np.array(away.shape[::-1])
    # Clipped before the cast: coordinates in a file may exceed the range of integers.
    cells = np.floor(grid.cells(points)).clip(-1, size).astype(int)
    inside = np.asarray(((cells >= 0) & (cells < size)).all(axis=1))
    columns, rows = np.where(inside[:, None], cells, 0).T
    return np.asarray(inside & (away[rows, columns] >= need))


def _connected(away: Array, grid: Grid, need: float, wanted: Sequence[Array]) -> tuple[Array, list[str]]:
    """Return clearances in the area where a robot drives, 0 elsewhere, and a line on other areas.

    Args:
        away: Clearance of each cell [m].
        grid: The grid of these cells.
        need: Clearance that the robot needs [m].
        wanted: A clear place in this area, shape (2,) [m]; none for the largest one.
    """
    import cv2

    _, parts, stats, middles = cv2.connectedComponentsWithStats((away >= need).astype(np.uint8), connectivity=4)
    areas = stats[1:, cv2.CC_STAT_AREA] * grid.resolution**2
    order = (1 + np.argsort(-areas, kind="stable")).tolist()
    if not order:
        return away, []
    for place in wanted:
        column, row = np.floor(grid.cells(place)).astype(int)
        order.sort(key=lambda part: part != parts[row, column])
    others = [k for k in order[1:] if areas[k - 1] >= ROOM]
    places = [np.round(grid.corners(middles[k] + 0.5), 1).tolist() for k in others[:MAX_ROOMS]]
    more = ", and others" if len(others) > MAX_ROOMS else ""
    listed = ", ".join(f"{place} ({areas[k - 1]:.0f} m2)" for place, k in zip(places, others, strict=False))
    noun = "area has" if len(others) == 1 else "areas have"
    lines = [f"{len(others)} free {noun} no path to the robot that is wide enough: around {listed}{more}"]
    return np.where(parts == order[0], away, 0.0), lines if others else []


def _specks(cells: Cells, largest: float) -> Cells:
    """Return the cells of components with at most `largest` cells: noise, which the world does not contain."""
    import cv2

    _, parts, stats, _ = cv2.connectedComponentsWithStats(cells.astype(np.uint8), connectivity=8)
    small = stats[:, cv2.CC_STAT_AREA] <= largest
    small[0] = False
    return np.asarray(small[parts], dtype=bool)


def _place(point: Array) -> tuple[float, float]:
    """Return a point as written in world files."""
    x, y = np.round(point, 2).tolist()
    return x, y


def _starts(away: Array, grid: Grid, need: float) -> list[Array]:
    """Return free places, the widest first, none close to each other, shape (2,) each [m]."""
    import cv2

    left, found = away.copy(), list[Array]()
    while len(found) < MAX_STARTS and left.max() >= need:
        row, column = (int(index) for index in np.unravel_index(int(np.argmax(left)), left.shape))
        found.append(np.round(grid.corners(np.array([column + 0.5, row + 0.5])), 2))
        cv2.circle(left, (column, row), round(MIN_LEG / grid.resolution), 0.0, -1)
    return found


def _tour(away: Array, grid: Grid, start: Array, need: float) -> list[Array]:
    """Return the start and the waypoints, each far from the previous ones and visible from the last [m]."""
    seen = [start]
    for _ in range(LEGS):
        ahead = _farthest(away, grid, seen, need)
        if math.dist(ahead, seen[-1]) < MIN_LEG:
            break
        seen.append(ahead)
    return seen


def _farthest(away: Array, grid: Grid, seen: Sequence[Array], need: float) -> Array:
    """Return the place farthest from all given ones with a straight, free path from the last, shape (2,) [m]."""
    start, steps = seen[-1], np.arange(0.0, MAX_DISTANCE, grid.resolution)
    best, longest = start, 0.1
    for heading in np.arange(DIRECTIONS) * (2 * math.pi / DIRECTIONS):
        points = start + steps[:, None] * [math.cos(heading), math.sin(heading)]
        clear = _clear(away, grid, points, need)
        last = len(clear) if clear.all() else int(np.argmin(clear))
        if not last:
            continue
        separations = np.min([np.hypot(*(points[:last] - place).T) for place in seen], axis=0)
        if (farthest := int(np.argmax(separations))) and separations[farthest] > longest:
            best, longest = points[farthest], float(separations[farthest])
    return np.asarray(best)
