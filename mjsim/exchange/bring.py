"""Worlds from files that people have, as text with a word on where they are from."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.exchange.clutter import clutter_size, clutter_world
from mjsim.exchange.drawing import extent, world_from_drawing
from mjsim.exchange.dxf_in import read_dxf
from mjsim.exchange.grid import read_grid
from mjsim.exchange.maps import explained, name_of, specks, world_from_grid
from mjsim.exchange.maze import maze_size, maze_world
from mjsim.exchange.place import with_robot
from mjsim.exchange.svg_in import read_svg
from mjsim.exchange.template import template_text
from mjsim.exchange.text import world_text
from mjsim.world.model import World


@dataclass(frozen=True, slots=True)
class Brought:
    """A new world."""

    text: str
    """Of the world file."""
    report: Sequence[str] = ()
    """What people should know about it."""


def bring_map(path: Path, *, preset: str | None) -> Brought:
    """Return the world of a ROS map_server or Nav2 map, with a robot of a preset unless that is None.

    Raises:
        UsageError: It is not a map, it is too large, or there is no place for the robot.
    """
    grid = read_grid(path)
    world = world_from_grid(grid, name=name_of(path))
    found, there, invented = explained(world, grid)
    noise = specks(grid)
    rows, columns = grid.occupied.shape
    share = 100.0 * found / max(1, there - noise)
    report = [
        f"{path}: {columns} x {rows} cells of {grid.resolution:g} m; {_counted(world)}",
        f"they explain {found} of {there - noise} occupied cells ({min(share, 100.0):.1f} %); {noise} more are specks,"
        f" left out; {invented} cells that the map calls free are in something solid",
    ]
    notes = [
        f"From the map {path.name}: {columns} x {rows} cells of {grid.resolution:g} m.",
        "A map tells neither heights nor colours; those here are guesses.",
    ]
    if preset is not None:
        world = with_robot(world, preset=preset, grid=grid)
    return Brought(world_text(world, notes=notes), report)


def bring_drawing(
    path: Path, *, preset: str | None, scale: float | None, thickness: float | None, layers: Sequence[str]
) -> Brought:
    """Return the world of an SVG or DXF drawing of walls, with a robot of a preset unless that is None.

    Raises:
        UsageError: It cannot be read, does not show the walls of a building, or there is no place for the robot.
    """
    drawing = (read_dxf if path.suffix.lower() == ".dxf" else read_svg)(path, layers=layers)
    world = world_from_drawing(drawing, name=name_of(path), scale=scale, thickness=thickness)
    low, high = extent(world)
    report = [
        f"{path}: {len(drawing.lines)} lines; {_counted(world)}, {high[0] - low[0]:.2f} x {high[1] - low[1]:.2f} m",
        *(f"{path}: {note}" for note in drawing.notes),
    ]
    notes = [f"From the drawing {path.name}.", "It does not tell how high the walls are; that is a guess."]
    if preset is not None:
        world = with_robot(world, preset=preset)
    return Brought(world_text(world, notes=notes), report)


def bring_file(
    path: Path, *, preset: str | None, scale: float | None, thickness: float | None, layers: Sequence[str]
) -> Brought:
    """Return the world of a map's YAML file, or of an SVG or DXF drawing.

    Raises:
        UsageError: It is none of these, or cannot be read as one.
    """
    kind = path.suffix.lower()
    if kind in (".yaml", ".yml"):
        return bring_map(path, preset=preset)
    if kind in (".pgm", ".png", ".jpg", ".jpeg"):
        raise UsageError(f"'{path}' is the picture of a map; name the YAML file beside it")
    if kind in (".svg", ".dxf"):
        return bring_drawing(path, preset=preset, scale=scale, thickness=thickness, layers=layers)
    raise UsageError(f"'{path}' is of no kind that can be read; name a map's .yaml, an .svg or a .dxf file")


def bring_maze(size: str, *, preset: str | None, seed: int, cell: float, beacons: int, name: str | None) -> Brought:
    """Return a maze, with a robot of a preset unless that is None.

    Args:
        size: Like '9x9': cells from west to east, and from south to north.
        preset: Of the robot.
        seed: The same gives the same maze.
        cell: Side of a cell [m].
        beacons: Markers along the robot's way.
        name: Of the world.

    Raises:
        UsageError: It would be too large, or labmaze is not there.
    """
    sides = maze_size(size)
    world = maze_world(sides, seed=seed, cell=cell, preset=preset, beacons=beacons, name=name or "maze")
    notes = [f"A maze of {sides[0]} x {sides[1]} cells of {cell:g} m, dug with the seed {seed}."]
    return Brought(world_text(world, notes=notes), [f"a maze of {sides[0]} x {sides[1]} cells; {_counted(world)}"])


def bring_clutter(size: str, *, preset: str | None, seed: int, name: str | None) -> Brought:
    """Return a room full of things, with a robot of a preset, told only to go ahead, unless that is None.

    Args:
        size: Like '12x10': metres from west to east, and from south to north.
        preset: Of the robot.
        seed: The same gives the same room.
        name: Of the world.

    Raises:
        UsageError: The room would be too small or too large.
    """
    sides = clutter_size(size)
    world = clutter_world(sides, seed=seed, preset=preset, name=name or "clutter")
    notes = [f"A room of {sides[0]:g} x {sides[1]:g} m, full of things at places drawn with the seed {seed}."]
    return Brought(world_text(world, notes=notes), [f"a room of {sides[0]:g} x {sides[1]:g} m; {_counted(world)}"])


def bring_template(template: str, *, name: str | None) -> Brought:
    """Return a shipped world under a name of one's own.

    Raises:
        UsageError: There is no such template.
    """
    return Brought(template_text(template, name=name))


def _counted(world: World) -> str:
    segments = sum(len(wall.segments()) for wall in world.walls)
    return f"{len(world.walls)} walls of {segments} segments, {len(world.obstacles)} things"
