"""Buildings for `hard_logs.py` as in well-known old logs: small rooms, halls of an exhibition, an open laboratory."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from carmen_logs import Building, box, rectangle, world

from mjsim.geometry import Array

Points = list[tuple[float, float]]

DOOR = 0.9
"""Width of a door [m]."""
FREE = 0.75
"""Furniture is at least this far from where the robot goes [m]."""


def rooms() -> Building:
    """Return a corridor of 38 m with small rooms on both sides, full of furniture, as in building 079 in Freiburg."""
    rng, walls, things, ways = np.random.default_rng(31), [rectangle(0, -5.2, 38, 12.4)], list[str](), list[Points]()
    for front, back in ((0.0, -5.2), (2.0, 7.2)):
        x = 0.0
        while x < 38.0:
            width = float(rng.uniform(3.0, 4.4))
            width = 38.0 - x if 38.0 - x - width < 3.0 else width
            door = x + float(rng.uniform(0.5, width - 0.5 - DOOR))
            middle = door + 0.5 * DOOR
            walls += [[(x, front), (door, front)], [(door + DOOR, front), (x + width, front)], [(x, front), (x, back)]]
            way = [(middle, 1.0), (middle, front + 0.5 * (back - front)), (middle, 1.0)]
            ways.append(way)
            low, high = sorted((front, back))
            things += _things(rng, (x, low), (x + width, high), way, desks=5, legs=6)
            x += width
    some = [way for number, way in enumerate(ways) if number % 3 != 1]
    half = len(some) // 2
    out, home = [p for each in some[:half] for p in each], [p for each in some[half:][::-1] for p in each]
    again = [p for each in ways[:half:2] for p in each]
    return Building(world("rooms", walls, (), things), (1.0, 1.0), [*out, (37.0, 1.0), *home, (1.0, 1.0), *again])


def halls() -> Building:
    """Return four halls of an exhibition with apses, partitions on arcs, show-cases and pillars, as in Belgioioso."""
    rng, walls, things = np.random.default_rng(32), list[Points](), list[str]()
    centres = [(8.0, 6.5), (24.0, 6.5), (24.0, 19.5), (8.0, 19.5)]
    ways = [[(x, y), (x, 13.0 + 11.0 * np.sign(y - 13.0)), (x, y)] for x, y in centres]
    lap = [*ways[1], *ways[2], *ways[3], *ways[0]]
    outline = Points()
    for (a, b), apses in zip(pairwise(rectangle(0, 0, 32, 26)), (2, 1, 2, 1), strict=True):
        outline += _with_apses(np.array(a, dtype=float), np.array(b, dtype=float), apses)
    walls.append([*outline, outline[0]])
    for a, b in (
        ((16, 0), (16, 5)),
        ((16, 8), (16, 18)),
        ((16, 21), (16, 26)),
        ((0, 13), (6, 13)),
        ((10, 13), (22, 13)),
    ):
        walls.append([a, b])
    walls.append([(26, 13), (32, 13)])
    for x, y in centres:
        for sx, sy in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
            at = np.array([x + 4.6 * sx, y + 3.8 * sy])
            if rng.random() < 0.6:
                begin = float(rng.uniform(0.0, 2.0 * np.pi))
                walls.append(_arc(at, float(rng.uniform(1.0, 2.0)), begin, begin + float(rng.uniform(1.5, 4.0))))
            else:
                things.append(f"{{cylinder: [{rng.uniform(0.2, 0.7):.2f}, 2.0], at: {at.tolist()}}}")
        things += _things(
            rng, (x - 7, y - 5.5), (x + 7, y + 5.5), [(x - 8, y), (x + 8, y), (x, y), (x, y - 6.5), (x, y + 6.5)], 3, 0
        )
    lap = [*lap, (8.0, 13.0), centres[3], centres[2], centres[1], centres[0]]
    return Building(world("halls", walls, (), things), centres[0], [*lap, *lap[::-1], *lap[:6]])


def _with_apses(a: Array, b: Array, number: int) -> Points:
    """Return a wall from one corner to another, the second left out, with semicircular niches on its right."""
    length = float(np.hypot(*(b - a)))
    ahead = (b - a) / length
    points = [tuple(a.tolist())]
    for k in range(number):
        middle = a + (k + 0.5) * length / number * ahead
        heading = float(np.arctan2(ahead[1], ahead[0]))
        points += _arc(middle, 2.5, heading + np.pi, heading + 2.0 * np.pi)
    return points


def _arc(middle: Array, radius: float, begin: float, end: float) -> Points:
    """Return points on an arc."""
    angles = np.linspace(begin, end, max(4, int(abs(end - begin) * radius / 0.35)))
    points = middle + radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    return [tuple(point) for point in points.round(3).tolist()]


def laboratory() -> Building:
    """Return a ring of oblique corridors around an open space with partitions, as at CSAIL in Cambridge."""
    rng = np.random.default_rng(33)
    ring = np.array([(0, 0), (20, 4), (34, -4), (50, 3), (47, 22), (27, 28), (5, 21)], dtype=float)
    outer, inner = _offset(ring, -1.2), _offset(ring, 1.2)
    walls: list[Points] = [[*outer, outer[0]]]
    openings = {1: 0.5, 3: 0.4, 5: 0.55}
    for number, (a, b) in enumerate(pairwise([*inner, inner[0]])):
        one, other = np.array(a), np.array(b)
        if number not in openings:
            walls.append([a, b])
            continue
        length = float(np.hypot(*(other - one)))
        gap = one + (openings[number] + np.array([-3.0, 3.0])[:, None] / length) * (other - one)
        walls += [[a, tuple(gap[0].tolist())], [tuple(gap[1].tolist()), b]]
    middles = [tuple((ring[k] + at * (ring[k + 1] - ring[k])).tolist()) for k, at in openings.items()]
    middle = (28.0, 12.0)
    spokes = [*middles[:1], middle, *middles[1:2], middle, *middles[2:3]]
    things = list[str]()
    for _ in range(60):
        at = rng.uniform([8.0, 5.0], [44.0, 22.0])
        size = (float(rng.uniform(0.8, 2.4)), float(rng.uniform(0.06, 0.6)))
        clear = _distance(at, spokes) > FREE + 0.7 * size[0]
        if clear and _distance(at, [*map(tuple, ring.tolist()), tuple(ring[0].tolist())]) > 3.2:
            things.append(box((float(at[0]), float(at[1])), size, float(rng.uniform(0.0, 180.0))))
    lap = [tuple(point) for point in ring.tolist()]
    way = [*lap[1:], lap[0], *lap[1:2], *spokes, *lap[6:], *lap[:4], *spokes[2:], *lap[6:], lap[0]]
    return Building(world("laboratory", walls, (), things), lap[0], way)


def _offset(corners: Array, distance: float) -> Points:
    """Return the corners of a counter-clockwise polygon (n, 2) with its sides moved to the inside [m]."""
    found = Points()
    for before, here, after in zip(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0), strict=True):
        one, other = (here - before) / np.hypot(*(here - before)), (after - here) / np.hypot(*(after - here))
        normals = np.array([[-one[1], one[0]], [-other[1], other[0]]])
        found.append(tuple((here + np.linalg.solve(normals, [distance, distance])).round(3).tolist()))
    return found


def _distance(at: Array, way: Sequence[tuple[float, float]]) -> float:
    """Return the distance of a point from a way [m]."""
    found = []
    for a, b in pairwise(np.array(way)):
        share = np.clip((at - a) @ (b - a) / max((b - a) @ (b - a), 1e-9), 0.0, 1.0)
        found.append(np.hypot(*(at - a - share * (b - a))))
    return float(min(found))


def _things(
    rng: np.random.Generator,
    low: tuple[float, float],
    high: tuple[float, float],
    way: Sequence[tuple[float, float]],
    desks: int,
    legs: int,
) -> list[str]:
    """Return desks or show-cases and legs of chairs in a room, away from where the robot goes."""
    found = list[str]()
    for _ in range(desks):
        size = rng.uniform([0.5, 0.3], [1.4, 0.7])
        at = rng.uniform(np.array(low) + 0.4, np.array(high) - 0.4)
        if _distance(at, way) > FREE + 0.6 * size[0]:
            found.append(box((at[0], at[1]), size, float(rng.choice([0.0, 90.0, rng.uniform(-20.0, 20.0)]))))
    for _ in range(legs):
        at = rng.uniform(np.array(low) + 0.3, np.array(high) - 0.3)
        if _distance(at, way) > FREE:
            found.append(f"{{cylinder: [0.03, 1.0], at: [{at[0]:.3f}, {at[1]:.3f}]}}")
    return found
