"""Imports worlds from files, as text with a comment about their origin."""

from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawings import Drawing, FloorPlan, read_dxf, read_plan, read_svg
from mjsim.exchange.generated import barn_world, clutter_size, clutter_world, maze_size, maze_world, template_text
from mjsim.exchange.maps import fidelity, is_picture, name_of, read_grid, specks, world_from_grid
from mjsim.exchange.matlab import WAYPOINT_SPEED, read_landmarks, world_from_landmarks
from mjsim.exchange.scenes import bring_scene, is_scene
from mjsim.exchange.start_place import with_newcomer
from mjsim.exchange.world_comment import world_text
from mjsim.exchange.world_import import Brought, Newcomer, Reading
from mjsim.inventory import Fate, FileItem, inventory
from mjsim.sentences import number_of
from mjsim.world import World, solid


def bring_map(path: Path, *, robot: Newcomer | None, resolution: float | None = None) -> Brought:
    """Return the world of a ROS map_server or Nav2 map, with a robot unless `robot` is None.

    Args:
        path: The YAML file of the map, or an image without one.
        robot: The robot to add.
        resolution: Side of a cell, for an image without a YAML file [m].

    Raises:
        UsageError: The file is not a map, is too large, contains only noise, or leaves no space for the robot.
    """
    grid = read_grid(path, resolution=resolution)
    world = world_from_grid(grid, name=name_of(path))
    found, noise = fidelity(world, grid), specks(grid)
    if not found.occupied:
        raise UsageError(
            f"{path}: none of its cells is occupied; check the gray values of its walls, and its thresholds"
        )
    if grid.occupied.all():
        raise UsageError(
            f"{path}: all of its cells are occupied; check the gray values of its floor, and its thresholds"
        )
    if found.occupied == noise:
        raise UsageError(f"{path}: all of its {noise} occupied cells are noise; it has no walls")
    rows, columns = grid.occupied.shape
    report = [
        f"{path}: {columns} x {rows} cells of {grid.resolution:g} m; {_counted(world)}",
        f"the world explains {found.explained} of {found.occupied} occupied cells ({100 * found.share:.1f} %), which"
        f" are at most one cell from a solid"
        + (f" ({100 * found.explained / (found.occupied - noise):.1f} % without noise)" if noise else "")
        + f"; {found.covered} free cells are inside a solid",
    ]
    items = [FileItem(Fate.GUESSED, "heights and colours", why="a map has none")]
    if found.false_walls >= 0.001:
        closing = f"{100 * found.false_walls:.1f} % of the length of the walls"
        items.append(FileItem(Fate.GUESSED, closing, why="no occupied cell is nearby"))
    if noise:
        cells = "1 occupied cell" if noise == 1 else f"{noise} occupied cells"
        items.append(FileItem(Fate.LEFT_OUT, cells, why="noise, smaller than any object"))
    notes = [
        f"From the map {path.name}: {columns} x {rows} cells of {grid.resolution:g} m.",
        "A map has no heights or colours; these are guesses.",
    ]
    whole, told = with_newcomer(world, robot, grid=grid)
    return Brought(world_text(whole, notes=notes), [*report, *told, *inventory(items)])


def drawing_of(path: Path, reading: Reading) -> Drawing:
    """Return the lines of an SVG or DXF drawing.

    Raises:
        UsageError: The file cannot be read.
    """
    return (read_dxf if path.suffix.lower() == ".dxf" else read_svg)(path, layers=reading.layers)


def plan_of(path: Path, reading: Reading) -> tuple[FloorPlan, Drawing]:
    """Return the floor plan made from an SVG or DXF drawing, and the drawing itself.

    Raises:
        UsageError: The file cannot be read, or does not show the walls of a building.
    """
    drawing = drawing_of(path, reading)
    name, furniture = name_of(path), reading.furniture
    return read_plan(drawing, name=name, scale=reading.scale, thickness=reading.thickness, furniture=furniture), drawing


def bring_drawing(path: Path, *, robot: Newcomer | None, reading: Reading) -> Brought:
    """Return the world of an SVG or DXF drawing of walls, with a robot unless `robot` is None.

    Raises:
        UsageError: The file cannot be read, does not show the walls of a building, or leaves no space for the robot.
    """
    plan, drawing = plan_of(path, reading)
    low_x, low_y, high_x, high_y = solid(plan.world).bounds
    drawn = f"{len(drawing.lines)} line{'s' * (len(drawing.lines) != 1)}"
    report = [f"{path}: {drawn}; {_counted(plan.world)}, {high_x - low_x:.2f} x {high_y - low_y:.2f} m"]
    x, y = plan.corner
    notes = [
        f"From the drawing {path.name}: {plan.scale:.9g} m to its unit, its place [{x:.9g}, {y:.9g}] is [0, 0] here.",
        "It has no heights; these are guesses.",
    ]
    whole, told = with_newcomer(plan.world, robot)
    return Brought(world_text(whole, notes=notes), [*report, *told, *inventory(plan.items)])


def bring_landmarks(path: Path, *, robot: Newcomer | None, reading: Reading) -> Brought:
    """Return the world of a MATLAB configuration, with a robot that follows its waypoints unless `robot` is None.

    Raises:
        UsageError: The file is not such a map, or the robot's preset does not exist.
    """
    if robot is not None and robot.lidar is not None:
        raise UsageError("the robot of a landmark map has a beacon sensor; leave out --lidar")
    map = read_landmarks(path, scale=reading.scale or 1.0, rows=reading.rows)
    preset, estimator, folder = (None,) * 3 if robot is None else (robot.preset, robot.estimator, robot.folder)
    world = world_from_landmarks(map, name=name_of(path), preset=preset, estimator=estimator, folder=folder)
    wide, high = np.ptp(map.points, axis=0)
    counted = f"; {_counted(world)}" if world.walls else ""
    way = (
        f"the path is {map.length():.1f} m long, {map.length() / WAYPOINT_SPEED:.0f} s at {WAYPOINT_SPEED} m/s; "
        if map.length()
        else ""
    )
    pictures = sum(beacon.image is not None for beacon in world.beacons)
    report = [
        f"{path}: {number_of(len(map.landmarks), 'landmark')}, {number_of(len(map.waypoints), 'waypoint')}"
        f", {wide:.1f} x {high:.1f} m{f'; {pictures} with a picture' if pictures else ''}{counted}",
        f"{way}--scale changes the size",
        *inventory(map.items),
    ]
    notes = [f"From the configuration {path.name}: landmarks without a picture are reflectors."]
    return Brought(world_text(world, notes=notes), report)


def bring_file(path: Path, *, robot: Newcomer | None, reading: Reading | None = None) -> Brought:
    """Return the world of a map's YAML file, a drawing, a MATLAB landmark map, or a scene of Gazebo, MuJoCo or Webots.

    Raises:
        UsageError: The file is none of these, or cannot be read.
    """
    kind = path.suffix.lower()
    if kind in (".yaml", ".yml") or is_picture(path):
        return bring_map(path, robot=robot, resolution=reading.scale if reading else None)
    if kind in (".mat", ".m"):
        return bring_landmarks(path, robot=robot, reading=reading or Reading())
    if kind in (".svg", ".dxf"):
        return bring_drawing(path, robot=robot, reading=reading or Reading())
    if is_scene(path):
        given = reading or Reading()
        return bring_scene(path, robot=robot, search=[*given.models], folder=given.folder or f"{name_of(path)}_models")
    raise UsageError(
        f"'{path}' is not a supported file; name a map's .yaml, a drawing (.svg, .dxf), MATLAB data (.mat, .m) or"
        " a scene (.world, .sdf, .xml, .wbt)"
    )


def bring_maze(
    size: str,
    *,
    preset: str | None,
    seed: int,
    cell: float,
    beacons: int,
    name: str | None,
    folder: Path | None = None,
) -> Brought:
    """Return a maze, with a robot unless `preset` is None.

    Args:
        size: Cells from west to east and from south to north, as in '9x9'.
        preset: Preset of the robot.
        seed: The same seed gives the same maze.
        cell: Side of a cell [m].
        beacons: Number of markers along the robot's path.
        name: Name of the world.
        folder: Folder in which the world will be saved.

    Raises:
        UsageError: The maze would be too large, or labmaze is not installed.
    """
    sides = maze_size(size)
    name = name or "maze"
    world = maze_world(sides, seed=seed, cell=cell, preset=preset, beacons=beacons, name=name, folder=folder)
    notes = [f"A maze of {sides[0]} x {sides[1]} cells of {cell:g} m, generated with the seed {seed}."]
    return Brought(world_text(world, notes=notes), [f"a maze of {sides[0]} x {sides[1]} cells; {_counted(world)}"])


def bring_clutter(size: str, *, preset: str | None, seed: int, name: str | None, folder: Path | None = None) -> Brought:
    """Return a cluttered room, with a robot that drives straight ahead unless `preset` is None.

    Args:
        size: Metres from west to east and from south to north, as in '12x10'.
        preset: Preset of the robot.
        seed: The same seed gives the same room.
        name: Name of the world.
        folder: Folder in which the world will be saved.

    Raises:
        UsageError: The room would be too small or too large.
    """
    sides = clutter_size(size)
    world = clutter_world(sides, seed=seed, preset=preset, name=name or "clutter", folder=folder)
    notes = [f"A room of {sides[0]:g} x {sides[1]:g} m, with clutter at random places, generated with the seed {seed}."]
    return Brought(world_text(world, notes=notes), [f"a room of {sides[0]:g} x {sides[1]:g} m; {_counted(world)}"])


def bring_barn(number: int, *, preset: str | None, name: str | None, folder: Path | None = None) -> Brought:
    """Return a world of the BARN benchmark, with a robot that drives to its goal unless `preset` is None.

    Args:
        number: Number of the world, 1 to 299, but not a multiple of 6.
        preset: Preset of the robot.
        name: Name of the world.
        folder: Folder in which the world will be saved.

    Raises:
        UsageError: There is no such world.
    """
    world = barn_world(number, preset=preset, name=name, folder=folder)
    notes = [
        f"World {number} of the Benchmark for Autonomous Robot Navigation (Perille, Truong, Xiao, Stone 2020; MIT"
        " licence).",
        "The robot has to come within 1 m of its goal in 100 s and must not touch anything.",
    ]
    return Brought(world_text(world, notes=notes), [f"BARN world {number}; {_counted(world)}"])


def bring_template(template: str, *, name: str | None) -> Brought:
    """Return a shipped world under a new name.

    Raises:
        UsageError: The template does not exist.
    """
    return Brought(template_text(template, name=name))


def _counted(world: World) -> str:
    segments = sum(len(wall.segments()) for wall in world.walls)
    things = number_of(len(world.obstacles), "thing")
    return f"{number_of(len(world.walls), 'wall')} of {number_of(segments, 'segment')}, {things}"
