"""Draws the plan of a world as SVG, to scale: walls, windows, doors, obstacles, beacons, people, robots, names."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawings import UNIT
from mjsim.geometry import Array
from mjsim.output import write_file
from mjsim.plan import SVG_NAMESPACE, SvgPlan, add_line, bounds_of, color, hex_of, world_shapes, world_words
from mjsim.plan import SVG_UNITS as PER_METRE
from mjsim.world import MITRE_LIMIT, SLICE, Opening, Wall, World

SCALE_DENOMINATOR = 100.0
"""Scale denominator: one metre is a centimetre on paper."""
MARGIN = 1.0
"""Margin around everything [m]."""
LETTER_HEIGHT, TITLE_HEIGHT = 0.22, 0.4
"""Height of letters [m]."""


def write_svg(world: World, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write the plan of a world as SVG at 1 : 100 and return the path of the file.

    Walls are lines with the width of the walls, broken at doorways, in the group `walls`; `world_from_svg` recovers the
    same walls from them.

    Args:
        world: The world.
        path: Output file.
        overwrite: Whether an existing file may be replaced.

    Raises:
        UsageError: The world is empty, or the file exists or cannot be written.
    """
    shapes = world_shapes(world)
    if not shapes:
        raise UsageError("this world has no walls, things, people or robots; there is no plan to draw")
    bounds = bounds_of(shape for shape in shapes if shape.group != "beacons")
    plan = SvgPlan(
        bounds + np.array([[-MARGIN, -MARGIN], [MARGIN, MARGIN + 2 * TITLE_HEIGHT]]), ratio=SCALE_DENOMINATOR
    )
    plan.root.set(UNIT, f"{1 / PER_METRE:g}")
    SubElement(plan.root, f"{{{SVG_NAMESPACE}}}title").text = world.name
    _head(plan, world.name, bounds)
    plan.draw(shape for shape in shapes if shape.group == "things")
    _walls(plan.group("walls"), world)
    plan.draw(shape for shape in shapes if shape.group not in ("things", "walls", "low walls"))
    plan.name([each for each in world_words(world) if each.of != "wall"])
    return write_file(path, plan.data(), overwrite=overwrite)


def _head(plan: SvgPlan, name: str, bounds: Array) -> None:
    """Write name and size of a world, and a scale bar of one metre."""
    title, (wide, deep) = plan.group("title"), np.ptp(bounds, axis=0).tolist()
    at = np.array([bounds[0, 0], bounds[1, 1] + 1.6 * TITLE_HEIGHT])
    plan.write(title, f"{name}, {wide:.1f} x {deep:.1f} m, 1 : {SCALE_DENOMINATOR:g}", at, TITLE_HEIGHT)
    foot, metre = bounds[0] - np.array([0.0, MARGIN / 2]), np.array([1.0, 0.0])
    add_line(title, np.stack([foot, foot + metre]), hex_of(color("ink")), 0.04)
    plan.write(title, "1 m", foot + 1.1 * metre, LETTER_HEIGHT)


def _walls(group: Element, world: World) -> None:
    group.set("stroke-miterlimit", f"{MITRE_LIMIT:.6f}")
    for wall in world.walls:
        doorways = [opening for opening in wall.openings if opening.sill <= SLICE < opening.head]
        for points, closed in solid_runs(wall, doorways):
            add_line(group, points, hex_of(color("wall")), wall.thickness, closed=closed)


def solid_runs(wall: Wall, openings: Sequence[Opening]) -> list[tuple[Array, bool]]:
    """Return the sections of a wall's centreline between openings: corners, shape (n, 2) [m], and whether closed."""
    corners = np.array([*wall.points, *(wall.points[:1] if wall.closed else ())])
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    gaps = sorted(
        (along[o.segment] + min(o.at, lengths[o.segment]), along[o.segment] + min(o.at + o.width, lengths[o.segment]))
        for o in openings
    )
    parts, begin = [], 0.0
    for first, last in gaps:
        parts += [(begin, first)] if first - begin > 1e-6 else []
        begin = max(begin, last)
    parts += [(begin, along[-1])] if along[-1] - begin > 1e-6 else []
    runs = [_between(corners, along, *part) for part in parts]
    if wall.closed and parts == [(0.0, along[-1])]:
        return [(corners[:-1], True)]
    if wall.closed and len(runs) > 1 and parts[0][0] == 0.0 and parts[-1][1] == along[-1]:
        runs = [np.concatenate([runs.pop(), runs[0][1:]]), *runs[1:]]
    return [(run, False) for run in runs]


def _between(corners: Array, along: Array, begin: float, end: float) -> Array:
    """Return the polyline from one position to another along corners."""
    inner = corners[(along > begin + 1e-9) & (along < end - 1e-9)]
    ends = [[float(np.interp(place, along, corners[:, axis])) for axis in (0, 1)] for place in (begin, end)]
    return np.concatenate([ends[:1], inner, ends[1:]])
