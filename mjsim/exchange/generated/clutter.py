"""Cluttered rooms with boxes, cylinders and concave obstacles, placed so that a robot can reach all free space."""

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.random import Generator

from mjsim.errors import UsageError
from mjsim.exchange.preset_files import inhabited, robot_of
from mjsim.geometry import Array
from mjsim.world import BoxObstacle, CylinderObstacle, Floor, Modules, Obstacle, Run, Use, Wall, World, footprint

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

MIN_ROOM_SIDE, MAX_ROOM_SIDE = 3.0, 40.0
"""Shortest and longest side of the room [m]."""
AREA_OF_ONE = 5.0
"""Floor area per obstacle [m^2]."""
MAX_TRIES = 60
"""Attempts to place an obstacle; if all fail, it is left out."""
MIN_GAP = 0.25
"""Minimum distance between obstacles, and between an obstacle and a wall [m]."""
MIN_PASSAGE = 0.8
"""Minimum width of the passages that connect all free space [m]."""
MIN_FREE_AREA = 0.05
"""Free areas smaller than this are ignored [m^2]."""
WALL_HEIGHT, THICKNESS = 1.2, 0.1
"""Height and thickness of the walls [m]."""
COLORS = ("#5b7a99", "#b0664f", "#8c8878", "#6a8f6b", "#c2a05a", "#7d6a94")
ROBOT, SPEED = "scout", 0.7
"""Name of the robot, and the forward speed it is commanded [m/s]."""

Bar = tuple[float, float, float, float]
"""A box from above, in the frame of its obstacle: length, width, and x, y of its centre [m]."""


def clutter_world(
    size: tuple[float, float],
    *,
    seed: int,
    name: str = "clutter",
    preset: str | None = "pioneer3dx",
    folder: Path | None = None,
) -> World:
    """Return a room with convex and concave obstacles at random places, and a robot commanded to drive straight ahead.

    Boxes and cylinders are convex; the L, U and cross shapes, made of boxes, are not. All free space is connected by
    passages at least 0.8 m wide.

    Args:
        size: Distance of the walls from west to east and from south to north [m].
        seed: The same seed gives the same room.
        name: Name of the world.
        preset: Preset of the robot; None for no robot.
        folder: Folder in which the world will be saved; the preset may be a file in it.

    Raises:
        UsageError: The room would be too small or too large.
    """
    import shapely

    if not all(MIN_ROOM_SIDE <= side <= MAX_ROOM_SIDE for side in size):
        raise UsageError(
            f"the room is {size[0]:g} x {size[1]:g} m; each side must be {MIN_ROOM_SIDE:g} to {MAX_ROOM_SIDE:g} m"
        )
    rng = np.random.default_rng(seed)
    room = shapely.box(0.0, 0.0, *size)
    count = round(size[0] * size[1] / AREA_OF_ONE)
    things: list[Obstacle] = []
    taken: BaseGeometry = shapely.Polygon()
    for number in range(1, count + 1):
        for _ in range(MAX_TRIES):
            thing = _thing(rng, number, at=rng.uniform((0.0, 0.0), size), color=COLORS[number % len(COLORS)])
            shape = shapely.union_all([shapely.Polygon(footprint(part)) for part in thing])
            if _fits(shape, taken, room):
                things, taken = [*things, *thing], taken.union(shape)
                break
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    outer = np.where(corners > 0.0, np.add(size, THICKNESS / 2), -THICKNESS / 2)
    wall = Wall(
        name="room",
        points=tuple((x, y) for x, y in np.round(outer, 3).tolist()),
        closed=True,
        height=WALL_HEIGHT,
        thickness=THICKNESS,
    )
    world = World(name=name, walls=(wall,), obstacles=tuple(things), floor=Floor(texture="floors/concrete.jpg"))
    return world if preset is None else _with_robot(world, room.difference(taken), rng, preset=preset, folder=folder)


def clutter_size(text: str) -> tuple[float, float]:
    """Return the sides of a room from a text like '12x10' [m].

    Raises:
        UsageError: The text has another form.
    """
    match = re.fullmatch(r"(\d{1,4}(?:\.\d{1,3})?)[xX](\d{1,4}(?:\.\d{1,3})?)", text.strip())
    if match is None:
        raise UsageError(f"the size of the room is '{text:.40}'; write it like 12x10")
    return float(match[1]), float(match[2])


def _thing(rng: Generator, number: int, *, at: Array, color: str) -> list[Obstacle]:
    """Return an obstacle of random kind, size and heading: a cylinder, or boxes."""
    kind = int(rng.integers(5))
    height, heading = float(np.round(rng.uniform(0.4, 1.0), 2)), float(np.round(rng.uniform(-180.0, 180.0)))
    long, wide, deep = np.round(rng.uniform((0.8, 0.2, 0.6), (1.6, 0.35, 1.1)), 2).tolist()
    if kind == 0:
        x, y = np.round(at, 3).tolist()
        radius = round(0.25 * long, 2)
        return [CylinderObstacle(name=f"drum-{number}", at=(x, y), cylinder=(radius, height), color=color)]
    name, bars = (
        ("box", [(0.7 * long, 0.6 * deep, 0.0, 0.0)]),
        ("angle", [(long, wide, 0.0, 0.0), (wide, deep, (wide - long) / 2, (wide + deep) / 2)]),
        ("bay", _bay(max(long, MIN_PASSAGE + 0.1) + 2 * wide, wide, deep)),
        ("cross", [(long, wide, 0.0, 0.0), (wide, deep + wide, 0.0, 0.0)]),
    )[kind - 1]
    turned = np.array([[_cosine(heading), -_sine(heading)], [_sine(heading), _cosine(heading)]])
    boxes: list[Obstacle] = []
    for part, (length, width, *offset) in enumerate(bars, start=1):
        x, y = np.round(at + turned @ np.array(offset), 3).tolist()
        boxes.append(
            BoxObstacle(
                name=f"{name}-{number}" if len(bars) == 1 else f"{name}-{number}-{part}",
                at=(x, y),
                heading_deg=heading,
                box=(round(length, 3), round(width, 3), height),
                color=color,
            )
        )
    return boxes


def _bay(long: float, wide: float, deep: float) -> list[Bar]:
    """Return a U shape: a back and two sides, between which a robot fits."""
    lateral, ahead = (long - wide) / 2, (wide + deep) / 2
    return [(long, wide, 0.0, 0.0), (wide, deep, -lateral, ahead), (wide, deep, lateral, ahead)]


def _cosine(degrees: float) -> float:
    return math.cos(math.radians(degrees))


def _sine(degrees: float) -> float:
    return math.sin(math.radians(degrees))


def _fits(shape: "BaseGeometry", taken: "BaseGeometry", room: "BaseGeometry") -> bool:
    """Return whether a shape fits: inside the room, clear of all others, and without cutting off any free space."""
    import shapely

    if not room.buffer(-MIN_GAP).contains(shape) or taken.distance(shape) < MIN_GAP:
        return False
    free = room.buffer(-MIN_PASSAGE / 2).difference(taken.union(shape).buffer(MIN_PASSAGE / 2))
    return bool(np.sum(shapely.area(shapely.get_parts(free)) > MIN_FREE_AREA) == 1)


def _with_robot(world: World, free: "BaseGeometry", rng: Generator, *, preset: str, folder: Path | None) -> World:
    """Return the room with a robot at a free place, commanded to drive straight ahead with avoidance enabled."""
    import shapely

    elbow_room = free.buffer(-MIN_PASSAGE / 2 - 0.1)
    low_x, low_y, high_x, high_y = elbow_room.bounds
    while True:
        x, y = np.round(rng.uniform((low_x, low_y), (high_x, high_y)), 2).tolist()
        if elbow_room.contains(shapely.Point(x, y)):
            break
    heading = float(np.round(rng.uniform(-180.0, 180.0)))
    robot = robot_of({"name": ROBOT, "preset": preset, "at": [x, y], "heading_deg": heading}, folder)
    ahead = Use.model_validate({"use": "mjsim.algorithms.constant:ConstantCommand", "forward": SPEED})
    run = Run(seconds=900.0, drivers={ROBOT: Modules(navigator=ahead, avoidance=True)})
    return inhabited(world, robot, run, folder)
