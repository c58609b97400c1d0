"""Buildings for `hard_logs.py`: rings that close late, places that look alike, and two as in well-known old logs."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from carmen_logs import Building, box, jagged, niched, rectangle, world

from mjsim.geometry import Array

Points = list[tuple[float, float]]

NICHE, DOOR = 0.12, 0.9
"""Depth of the niche of a door, and its width [m]."""
CUT = 2.0
"""How far a cut corner of a block reaches along its sides [m]."""
OPEN, CHANGED = 0.4, 0.5
"""Share of doors that stand open, and of doors and furniture that are otherwise at the second visit."""


def buildings() -> dict[str, Building]:
    """Return all buildings by their names."""
    return {
        "loop": loop(),
        "wings": wings(),
        "campus": campus(),
        "lofts": lofts(),
        "square": square(),
        "courts": courts(),
    }


def loop() -> Building:
    """Return a ring of bare corridors."""
    walls = [rectangle(0, 0, 62, 40), rectangle(2.2, 2.2, 57.6, 35.6)]
    ring = [(60.9, 1.1), (60.9, 38.9), (1.1, 38.9), (1.1, 1.1)]
    return Building(world("loop", walls), (3.0, 1.1), [*ring, *ring[:2], (20.0, 38.9), (60.9, 38.9), *ring[:1]])


def wings() -> Building:
    """Return four wings with identical rooms around a hall: the building looks the same from four sides."""
    middle, quarter = np.array([22.0, 22.0]), np.array([[0.0, -1.0], [1.0, 0.0]])
    lines, doors, way = list[list[tuple[float, float]]](), list[str](), list[tuple[float, float]]()
    R = np.eye(2)
    for _ in range(4):

        def at(*points: tuple[float, float], R: Array = R) -> list[tuple[float, float]]:
            return [tuple((middle + R @ point).round(3).tolist()) for point in points]

        lines += [at((4, -4), (4, -1), (20, -1)), at((20, -6), (20, 6)), at((20, 1), (4, 1), (4, 4))]
        for x in (4.0, 8.0, 12.0, 16.0):
            lines += [at((x, 1.0), (x, 6.0)), at((x, -1.0), (x, -6.0))]
        lines += [at((4.0, 6.0), (20.0, 6.0)), at((4.0, -6.0), (20.0, -6.0))]
        way += at((18.5, 0.0), (2.5, 0.0))
        R = quarter @ R
    return Building(world("wings", lines, doors), (22.0, 22.0), [*way, *way[:6], (22.0, 22.0)])


def campus() -> Building:
    """Return two rings with long corridors, doors in niches, and a hall with pillars between them."""
    rng = np.random.default_rng(11)
    walls = [niched(rectangle(2, 2, 42, 26), rng, inward=True), niched(rectangle(66, 2, 24, 26), rng, inward=True)]
    walls.append(niched(rectangle(0, 0, 92, 30), rng, inward=False))
    things = [f"{{cylinder: [0.3, 2.0], at: [{x}, {y}]}}" for x in (49.0, 55.0, 61.0) for y in (6.0, 15.0, 24.0)]
    left, right = [(1.0, 29.0), (1.0, 1.0)], [(91.0, 1.0), (91.0, 29.0)]
    way = [(46.0, 1.0), (64.0, 1.0), *right, (46.0, 29.0), *left, (46.0, 1.0), (52.0, 12.0), (52.0, 27.0), (46.0, 29.0)]
    return Building(world("campus", walls, (), things), (3.0, 1.0), [*way, *left, (46.0, 1.0), (64.0, 1.0), *right])


def lofts() -> Building:
    """Return rooms with uneven walls and furniture; doors are narrow."""
    rng, doors, things = np.random.default_rng(12), list[str](), list[str]()
    for i in range(1, 4):
        doors.append(
            f"{{points: [[{9 * i}, 0], [{9 * i}, 16]], openings: [{{at: 3, width: 1}}, {{at: 12, width: 1}}]}}"
        )
    for i in range(4):
        doors.append(f"{{points: [[{9 * i}, 8], [{9 * i + 9}, 8]], openings: [{{at: 5, width: 1.0}}]}}")
    for _ in range(40):
        spot = rng.uniform([0.8, 0.8], [35.2, 15.2])
        if abs(spot[1] - 3.5) > 1.2 and abs(spot[1] - 12.5) > 1.2 and abs((spot[0] - 5.5) % 9.0) > 1.1:
            things.append(box((spot[0], spot[1]), rng.uniform([0.2, 0.2], [0.9, 0.5]), float(rng.uniform(0, 90))))
    way = [(5.5, 3.5), (5.5, 12.5), (14.5, 12.5), (14.5, 3.5), (23.5, 3.5), (23.5, 12.5), (32.5, 12.5), (32.5, 3.5)]
    walls = [jagged(rectangle(0, 0, 36, 16), rng)]
    return Building(world("lofts", walls, doors, things), (2.0, 3.5), [*way, *way[::-1], *way, (5.5, 3.5)])


def square() -> Building:
    """Return corridors as a square with a cross in it, with offices along them, as on one floor of ACES in Austin.

    Loops of 51 m; doors stand open or not, and change between the two halves of the drive, as furniture does.
    """
    x, y, half = (1.1, 14.1, 27.1), (1.1, 13.6, 26.1), 1.1
    sides = [_Side((0.0, 0.0), (28.2, 0.0), 4.0), _Side((28.2, 0.0), (28.2, 27.2), 4.0)]
    sides += [_Side((28.2, 27.2), (0.0, 27.2), 4.0), _Side((0.0, 27.2), (0.0, 0.0), 4.0)]
    for i in range(2):
        for j in range(2):
            left, right, low, high = x[i] + half, x[i + 1] - half, y[j] + half, y[j + 1] - half
            corners = [(left, low), (left, high), (right, high), (right, low)]
            sides += _block(corners, middle=(x[1], y[1]), depth=4.4)
    way = [(x[2], y[0]), (x[2], y[2]), (x[0], y[2]), (x[0], y[0]), (x[1], y[0]), (x[1], y[2]), (x[0], y[2])]
    way += [(x[0], y[1]), (x[2], y[1])]
    later = [(x[2], y[2]), (x[1], y[2]), (x[1], y[1]), (x[0], y[1]), (x[0], y[0]), (x[1], y[0]), (x[1], y[1])]
    later += [(x[2], y[1]), (x[2], y[0]), (x[0], y[0]), (x[0], y[2]), (x[2], y[2]), (x[2], y[1]), (x[1], y[1])]
    texts = _texts("square", sides, seed=21, every=(1.0, 4.5), things=26)
    return Building(texts[0], (3.0, y[0]), [*way, *later], (texts[1], len(way)))


def courts() -> Building:
    """Return two rings of 250 m around courts and the corridor that joins them, as in the old logs of Killian Court.

    Corridors are 3 m wide and have stretches of 20 m without a door.
    """
    far, across, half, second = 78.0, 46.0, 1.5, 112.0
    outline = [(-half, -half), (second - half, -half), (second - half, -across - half)]
    outline += [(second + far + half, -across - half), (second + far + half, half), (far + half, half)]
    outline += [(far + half, across + half), (-half, across + half)]
    # Offices at the two corners where corridors meet would overlap.
    bare = {outline[1], outline[5]}
    sides = [_Side(a, b, 0.0 if a in bare else 4.0) for a, b in pairwise([*outline, outline[0]])]
    for left, low in ((0.0, 0.0), (second, -across)):
        right, high = left + far - half, low + across - half
        corners = [(left + half, low + half), (left + half, high), (right, high), (right, low + half)]
        sides += _block(corners, depth=4.0)
    way = [(far, 0.0), (far, across), (0.0, across), (0.0, 0.0), (second, 0.0), (second, -across)]
    way += [(second + far, -across), (second + far, 0.0), (far, 0.0)]
    later = [(far, across), (0.0, across), (0.0, 0.0), (150.0, 0.0)]
    texts = _texts("courts", sides, seed=22, every=(2.0, 22.0), things=30)
    return Building(texts[0], (40.0, 0.0), [*way, *later], (texts[1], len(way)))


@dataclass(frozen=True, slots=True)
class _Side:
    """One side of a corridor, which is to its left; offices lie to its right."""

    start: tuple[float, float]
    end: tuple[float, float]
    depth: float
    """Of the offices; 0 for none [m]."""


def _block(corners: Points, *, depth: float, middle: tuple[float, float] | None = None) -> list[_Side]:
    """Return the sides of a block between corridors, with offices on two of them.

    Args:
        corners: Clockwise.
        depth: Of the offices [m].
        middle: The corner nearest to it is cut off; None for no corner.
    """
    points = Points()
    for number, corner in enumerate(corners):
        here = np.array(corner)
        if middle is None or np.hypot(*(here - middle)) > 2.0:
            points.append(corner)
            continue
        for other in (np.array(corners[number - 1]), np.array(corners[(number + 1) % 4])):
            points.append(tuple((here + CUT * (other - here) / np.hypot(*(other - here))).tolist()))
    # Offices of neighbouring sides would overlap.
    return [_Side(a, b, depth if a[1] == b[1] else 0.0) for a, b in pairwise([*points, points[0]])]


def _texts(name: str, sides: Sequence[_Side], *, seed: int, every: tuple[float, float], things: int) -> tuple[str, str]:
    """Return the world at the first and at the second visit.

    Args:
        name: Of the world.
        sides: Of all corridors.
        seed: Of what is where.
        every: Least and largest distance between two doors [m].
        things: Number of pieces of furniture along the walls.
    """
    rng, texts = np.random.default_rng(seed), []
    doors = [(side, at, rng.random() < OPEN) for side in sides for at in _doors(side, rng, every)]
    pieces = [_piece(sides, rng) for _ in range(things)]
    for _ in range(2):
        walls = [
            wall
            for side in sides
            for wall in _walls(side, [(at, is_open) for one, at, is_open in doors if one is side])
        ]
        inside = [
            _inside(side, at, number) for number, (side, at, is_open) in enumerate(doors) if is_open and side.depth
        ]
        texts.append(world(name, [*walls, *[office for office, _ in inside]], (), [*pieces, *[t for _, t in inside]]))
        doors = [(side, at, rng.random() < OPEN if rng.random() < CHANGED else was) for side, at, was in doors]
        pieces = [_piece(sides, rng) if rng.random() < CHANGED else piece for piece in pieces]
    return texts[0], texts[1]


def _frame(side: _Side) -> tuple[Array, Array, Array, float]:
    """Return the start of a side, the unit vectors along it and into its offices, and its length."""
    start, end = np.array(side.start), np.array(side.end)
    length = float(np.hypot(*(end - start)))
    ahead = (end - start) / length
    return start, ahead, np.array([ahead[1], -ahead[0]]), length


def _doors(side: _Side, rng: np.random.Generator, every: tuple[float, float]) -> list[float]:
    """Return where the doors of a side begin [m]."""
    *_, length = _frame(side)
    found, at = list[float](), float(rng.uniform(0.8, every[1]))
    while at + DOOR < length - 0.8:
        found.append(at)
        at += DOOR + float(rng.uniform(*every))
    return found


def _walls(side: _Side, doors: Sequence[tuple[float, bool]]) -> list[Points]:
    """Return the walls of a side; a door that stands open leaves a gap if there is an office behind."""
    start, ahead, into, length = _frame(side)

    def at(along: float, deep: float) -> tuple[float, float]:
        return tuple((start + along * ahead + deep * into).round(3).tolist())

    walls, wall = list[Points](), [at(0.0, 0.0)]
    for door, is_open in doors:
        wall += [at(door, 0.0), at(door, NICHE)]
        if is_open and side.depth:
            walls.append(wall)
            wall = []
        wall += [at(door + DOOR, NICHE), at(door + DOOR, 0.0)]
    return [*walls, [*wall, at(length, 0.0)]]


def _inside(side: _Side, door: float, number: int) -> tuple[Points, str]:
    """Return the walls of the office behind a door, and its desk."""
    start, ahead, into, _ = _frame(side)
    rng = np.random.default_rng(number)
    left, right = rng.uniform(0.3, 1.0, 2)
    ends = [
        (door - left, NICHE),
        (door - left, side.depth),
        (door + DOOR + right, side.depth),
        (door + DOOR + right, NICHE),
    ]
    office = [tuple((start + along * ahead + deep * into).round(3).tolist()) for along, deep in ends]
    at = start + (door + rng.uniform(0.0, DOOR)) * ahead + rng.uniform(0.5, 0.8) * side.depth * into
    return office, box(tuple(at.tolist()), rng.uniform([0.4, 0.4], [1.2, 0.7]), float(rng.choice([0.0, 90.0, 30.0])))


def _piece(sides: Sequence[_Side], rng: np.random.Generator) -> str:
    """Return a piece of furniture at a wall of a corridor."""
    lengths = np.array([_frame(side)[3] for side in sides])
    side = sides[int(rng.choice(len(sides), p=lengths / lengths.sum()))]
    start, ahead, into, length = _frame(side)
    size = rng.uniform([0.3, 0.25], [0.9, 0.4])
    at = start + rng.uniform(0.5, max(0.6, length - 0.5)) * ahead - (0.5 * size[1] + 0.08) * into
    heading = float(np.degrees(np.arctan2(ahead[1], ahead[0])))
    return box(tuple(at.tolist()), size, heading + float(rng.choice([0.0, 0.0, rng.uniform(-15.0, 15.0)])))
