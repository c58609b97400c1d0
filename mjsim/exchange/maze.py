"""Mazes: dug by labmaze, with thin walls between square cells, and a robot that knows the way."""

import itertools
import math
import re
from collections import deque
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawing import Line, joined
from mjsim.exchange.pixels import Cells
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.world import Beacon, Floor, Marker, Modules, Run, Use, Wall, World

FEWEST, MOST = 3, 50
"""Cells to a side."""
NARROWEST, WIDEST = 0.9, 10.0
"""Side of a cell [m]."""
WALL_HEIGHT = 1.2
"""Low enough that a film from above shows the robot [m]."""
THICKNESS = 0.1
"""[m]"""
MOST_BEACONS = 50
"""As many markers has the dictionary."""
BEACON_WIDTH, BEACON_CENTER, OFF_WALL = 0.3, 0.8, 0.01
"""[m]"""
SPEED, LOOKAHEAD = 0.4, 0.3
"""Of the robot on its way [m/s], [m]."""
ROBOT = "theseus"

Cell = tuple[int, int]
"""Column from the west, row from the south."""
AROUND = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""East, north, west, south."""


def maze_world(
    size: tuple[int, int],
    *,
    seed: int,
    cell: float = 1.5,
    name: str = "maze",
    preset: str | None = "pioneer3dx",
    beacons: int = 0,
    folder: Path | None = None,
) -> World:
    """Return a maze of square cells, each of which can be reached.

    Args:
        size: Cells from west to east, and from south to north.
        seed: The same gives the same maze.
        cell: Side of a cell, from the middle of a wall to that of the next [m].
        name: Of the world.
        preset: Of the robot in the south-west corner, which drives to the farthest cell; None for none.
        beacons: So many markers hang along its way.
        folder: In which the world will be, with the file of the preset if it is one.

    Raises:
        UsageError: The maze would be too large, its cells too narrow, or labmaze is not there.
    """
    if not all(FEWEST <= side <= MOST for side in size):
        raise UsageError(f"the maze has {size[0]} x {size[1]} cells; a side has {FEWEST} to {MOST}")
    if not NARROWEST <= cell <= WIDEST:
        raise UsageError(f"a cell of {cell:g} m is no room for a robot; give {NARROWEST:g} to {WIDEST:g} m")
    if not 0 <= beacons <= MOST_BEACONS:
        raise UsageError(f"{beacons} markers are too many; a maze has 0 to {MOST_BEACONS}")
    rock = _dug(size, seed)
    way = _longest_way(rock)
    walls = tuple(
        Wall(
            name=f"wall-{number}",
            points=tuple((x + 0.0, y + 0.0) for x, y in np.round(line.points * cell, 3).tolist()),
            closed=line.closed,
            height=WALL_HEIGHT,
            thickness=THICKNESS,
            texture="walls/brick.jpg",
        )
        for number, line in enumerate(_wall_lines(rock), start=1)
    )
    hung = tuple(_beacon(rock, way, number, count=beacons, cell=cell) for number in range(beacons))
    world = World(name=name, walls=walls, beacons=hung, floor=Floor(texture="floors/stone.jpg"))
    return world if preset is None else _with_robot(world, way, preset=preset, cell=cell, folder=folder)


def maze_size(text: str) -> tuple[int, int]:
    """Return the cells from west to east and from south to north that a text like '9x9' says.

    Raises:
        UsageError: It says none.
    """
    match = re.fullmatch(r"(\d{1,4})[xX](\d{1,4})", text.strip())
    if match is None:
        raise UsageError(f"the size of the maze is '{text:.40}'; write it like 9x9")
    return int(match[1]), int(match[2])


def _dug(size: tuple[int, int], seed: int) -> Cells:
    """Return which places are rock, shape (2 rows + 1, 2 columns + 1): cells at odd places, walls between them.

    References:
        labmaze.RandomMaze: at most one room, and passages dug at random; without a room it takes most walls away.
    """
    try:
        from labmaze import RandomMaze
    except ImportError:
        raise UsageError(
            "mazes need labmaze, which is not installed; it is available for Python 3.11 and 3.12"
        ) from None
    width, height = (2 * side + 1 for side in size)
    maze = RandomMaze(width=width, height=height, max_rooms=1, simplify=False, random_seed=seed % 2**31)
    return np.array([[sign == "*" for sign in line] for line in str(maze.entity_layer).splitlines()], dtype=bool)


def _open(rock: Cells, cell: Cell) -> list[Cell]:
    """Return the neighbours that no wall parts from a cell."""
    column, row = cell
    return [(column + x, row + y) for x, y in AROUND if not rock[2 * row + 1 + y, 2 * column + 1 + x]]


def _walled(rock: Cells, cell: Cell) -> list[Cell]:
    """Return the directions in which a cell has a wall."""
    column, row = cell
    return [(x, y) for x, y in AROUND if rock[2 * row + 1 + y, 2 * column + 1 + x]]


def _longest_way(rock: Cells) -> list[Cell]:
    """Return the cells of the shortest way from the south-west corner to the cell that is farthest to drive."""
    came: dict[Cell, Cell | None] = {(0, 0): None}
    waiting = deque(came)
    last = (0, 0)
    while waiting:
        last = waiting.popleft()
        for ahead in _open(rock, last):
            if ahead not in came:
                came[ahead] = last
                waiting.append(ahead)
    way: list[Cell] = []
    here: Cell | None = last
    while here is not None:
        way.append(here)
        here = came[here]
    return way[::-1]


def _wall_lines(rock: Cells) -> list[Line]:
    """Return the middle lines of the walls as runs through corners [cells]."""
    lines = []
    for row, column in itertools.product(*(range(side // 2 + 1) for side in rock.shape)):
        for x, y in ((1, 0), (0, 1)):
            before = row - y >= 0 and column - x >= 0 and rock[2 * row - y, 2 * column - x]
            length = 0
            while not before and _stands(rock, 2 * row + y * (2 * length + 1), 2 * column + x * (2 * length + 1)):
                length += 1
            if length:
                ends = [(column, row), (column + x * length, row + y * length)]
                lines.append(Line(np.array(ends, dtype=float)))
    return joined(lines)


def _stands(rock: Cells, row: int, column: int) -> bool:
    return row < rock.shape[0] and column < rock.shape[1] and bool(rock[row, column])


def _beacon(rock: Cells, way: list[Cell], number: int, *, count: int, cell: float) -> Beacon:
    """Return a marker on a wall of a cell of the way, one of so many that are evenly apart."""
    beside = [(here, sides) for here in way if (sides := _walled(rock, here))]
    (column, row), sides = beside[round((number + 0.5) * len(beside) / count - 0.5)]
    x, y = sides[number % len(sides)]
    off = cell / 2 - THICKNESS / 2 - OFF_WALL
    return Beacon(
        name=f"tag-{number}",
        marker=Marker(id=number),
        at=(round((column + 0.5) * cell + x * off, 3), round((row + 0.5) * cell + y * off, 3)),
        heading_deg=math.degrees(math.atan2(-y, -x)) + 0.0,
        width=BEACON_WIDTH,
        center=BEACON_CENTER,
    )


def _with_robot(world: World, way: list[Cell], *, preset: str, cell: float, folder: Path | None) -> World:
    """Return a maze with a robot that drives its longest way, by dead reckoning and its avoidance."""
    corners = [
        here
        for before, here, after in zip(way, way[1:], [*way[2:], None], strict=False)
        if after is None or (before[0] + after[0], before[1] + after[1]) != (2 * here[0], 2 * here[1])
    ]
    points = [[round((column + 0.5) * cell, 3), round((row + 0.5) * cell, 3)] for column, row in corners]
    ahead = 0.0 if way[1][0] > way[0][0] else 90.0
    at = round(cell / 2, 3)
    robot = robot_of({"name": ROBOT, "preset": preset, "at": [at, at], "heading_deg": ahead}, folder)
    turns = {"points": points, "speed": SPEED, "lookahead": LOOKAHEAD}
    navigator = Use.model_validate({"use": "mjsim.algorithms.waypoints:Waypoints", **turns})
    seconds = round(30.0 + 2.0 * len(way) * cell / SPEED)
    run = Run(seconds=float(seconds), drivers={ROBOT: Modules(navigator=navigator)})
    return inhabited(world, robot, run, folder)
