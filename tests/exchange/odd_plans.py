"""One small flat, drawn in the many ways that people have."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import shapely
from shapely import LineString, Point

OUTER, INNER = 0.3, 0.12
WALLS = [
    ((0.15, 0.15), (7.85, 0.15), OUTER),
    ((7.85, 0.15), (7.85, 5.85), OUTER),
    ((7.85, 5.85), (0.15, 5.85), OUTER),
    ((0.15, 5.85), (0.15, 0.15), OUTER),
    ((4.0, 0.15), (4.0, 5.85), INNER),
    ((4.0, 3.0), (7.85, 3.0), INNER),
]
"""Ends and thickness [m]."""
DOORS = [
    ((4.0, 1.0), (0.0, 1.0), 0.9, (-1.0, 0.0)),
    ((5.0, 3.0), (1.0, 0.0), 0.8, (0.0, 1.0)),
    ((1.2, 0.15), (1.0, 0.0), 1.0, (0.0, 1.0)),
]
"""Where the leaf hangs, where its wall goes, its width, where it opens to [m]."""
WINDOWS = [((5.2, 0.15), (1.0, 0.0), 1.6), ((0.15, 2.5), (0.0, 1.0), 1.4)]
"""Where it begins, where its wall goes, its width [m]."""
Space = Any
"""The model space of a drawing."""
Place = Callable[[Any], tuple[float, float]]
"""From metres to the units of a drawing."""


def thickness_at(point: tuple[float, float]) -> float:
    """Return how thick the wall is that a door or a window is in [m]."""
    return min((LineString([a, b]).distance(Point(point)), size) for a, b, size in WALLS)[1]


def walls() -> shapely.Geometry:
    """Return what the walls of the flat cover, with holes for doors and windows."""
    shape = shapely.union_all([LineString([a, b]).buffer(size / 2, cap_style="square") for a, b, size in WALLS])
    holes = [LineString([at, np.add(at, np.multiply(to, wide))]) for at, to, wide, *_ in [*DOORS, *WINDOWS]]
    return shape.difference(shapely.union_all([hole.buffer(0.2, cap_style="flat") for hole in holes]))


def outlines() -> list[np.ndarray]:
    """Return the outlines of the walls, shape (n, 2) each [m]."""
    rings = [ring for part in shapely.get_parts(walls()) for ring in (part.exterior, *part.interiors)]
    return [shapely.get_coordinates(ring)[:-1] for ring in rings]


def faces(space: Space, place: Place, layer: str = "WALLS") -> None:
    """Draw the walls by lines along their faces."""
    for ring in outlines():
        for start, end in zip(ring, np.roll(ring, -1, axis=0), strict=True):
            space.add_line(place(start), place(end), dxfattribs={"layer": layer})


def leaves(space: Space, place: Place, layer: str = "DOORS") -> None:
    """Draw the doors by their leaf and its way."""
    for at, to, wide, swing in DOORS:
        hinge = np.array(at) + np.array(swing) * thickness_at(at) / 2
        space.add_line(place(hinge), place(hinge + np.array(swing) * wide), dxfattribs={"layer": layer})
        turns = [np.linspace(0, 1, 12)[:, None], np.linspace(1, 0, 12)[:, None]]
        ways = np.array(swing) * np.sin(turns[1] * math.pi / 2) + np.array(to) * np.cos(turns[1] * math.pi / 2)
        space.add_lwpolyline([place(hinge + way * wide) for way in ways], dxfattribs={"layer": layer})


def panes(space: Space, place: Place, layer: str = "WINDOWS") -> None:
    """Draw the windows by four lines each."""
    for at, to, wide in WINDOWS:
        left = np.array([-to[1], to[0]])
        for off in (-0.15, -0.03, 0.03, 0.15):
            start = np.array(at) + left * off
            space.add_line(place(start), place(start + np.array(to) * wide), dxfattribs={"layer": layer})


def dxf(path: Path, draw: Callable[[Any, Space, Place], None], *, units: int = 4, metre: float = 1000.0) -> Path:
    """Write a drawing; `draw` takes the document, its model space, and how metres become units."""
    document = ezdxf.new(units=units)
    draw(document, document.modelspace(), lambda point: (float(point[0]) * metre, float(point[1]) * metre))
    document.saveas(path)
    return path
