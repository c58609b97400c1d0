"""Draws the plan of a world as SVG, to scale: walls, windows, doors, obstacles, beacons, people, robots, names."""

import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.svg_in import UNIT
from mjsim.geometry import Array, Pose
from mjsim.output import write_file
from mjsim.posture import from_above
from mjsim.world import (
    MITRE_LIMIT,
    SLICE,
    THICKNESS,
    Leaf,
    Opening,
    Wall,
    World,
    hung,
    item_names,
    leaves,
    prisms,
)

NAMESPACE = "http://www.w3.org/2000/svg"
PER_METRE = 100.0
"""Units of the drawing per metre."""
REDUCTION = 100.0
"""Scale denominator: one metre is a centimetre on paper."""
MARGIN = 1.0
"""Margin around everything [m]."""
LETTERS, TITLE = 0.22, 0.4
"""Height of letters [m]."""
HAIR = 0.02
"""Width of thin lines [m]."""
AHEAD = 0.4
"""Length of the line that shows a robot's heading [m]."""
INK, SOFT, ROBOT, BEACON = "#23272e", "#8a93a0", "#c8402f", "#0b7a53"
"""Colours of lines."""


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
    root = _sheet(world)
    for name, draw in (("things", _things), ("walls", _walls), ("windows", _windows), ("doors", _doors)):
        draw(_group(root, name), world)
    _beacons(_group(root, "beacons"), world)
    if world.people:
        _people(_group(root, "people"), world)
    _robots(_group(root, "robots"), world)
    indent(root)
    register_namespace("", NAMESPACE)
    return write_file(path, tostring(root, encoding="utf-8", xml_declaration=True), overwrite=overwrite)


def _sheet(world: World) -> Element:
    """Return an empty drawing sized to a world, with its name, its size and a scale bar of one metre."""
    corners = [point for wall in world.walls for point in wall.points] + [robot.at for robot in world.robots]
    corners += [tuple(point) for thing in world.obstacles for part in prisms(thing) for point in part[0].tolist()]
    corners += [
        tuple(point)
        for person in world.people
        for outline, _ in from_above(world, person)
        for point in outline.tolist()
    ]
    if not corners:
        raise UsageError("this world has no walls, things, people or robots; there is no plan to draw")
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    left, top = low[0] - MARGIN, -high[1] - MARGIN - 2 * TITLE
    size = high - low + 2 * MARGIN + [0.0, 2 * TITLE]
    paper = (size * 1000.0 / REDUCTION).tolist()
    box = " ".join(_number(value) for value in (left, top, *size.tolist()))
    root = _element("svg", width=f"{paper[0]:g}mm", height=f"{paper[1]:g}mm", viewBox=box)
    root.set(UNIT, f"{1 / PER_METRE:g}")
    SubElement(root, f"{{{NAMESPACE}}}title").text = world.name
    root.append(_element("rect", x=_number(left), y=_number(top), width="100%", height="100%", fill="#ffffff"))
    title = _group(root, "title")
    wide, deep = (high - low).tolist()
    _write(title, f"{world.name}, {wide:.1f} x {deep:.1f} m, 1 : {REDUCTION:g}", low[0], -top - 1.6 * TITLE, TITLE)
    y = float(low[1]) - MARGIN / 2
    _line(title, np.array([[low[0], y], [low[0] + 1.0, y]]), INK, 2 * HAIR)
    _write(title, "1 m", low[0] + 1.1, y, LETTERS)
    return root


def _walls(group: Element, world: World) -> None:
    group.set("stroke-miterlimit", f"{MITRE_LIMIT:.6f}")
    for wall in world.walls:
        doorways = [opening for opening in wall.openings if opening.sill <= SLICE < opening.head]
        for points, closed in solid_runs(wall, doorways):
            _line(group, points, INK, wall.thickness, closed=closed)


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


def _windows(group: Element, world: World) -> None:
    for wall in world.walls:
        for opening in wall.openings:
            if opening.sill > SLICE:
                first, last = (np.array(end) for end in wall.segments()[opening.segment])
                along = (last - first) / math.dist(first, last)
                ends = first + np.outer([opening.at, opening.at + opening.width], along)
                _line(group, ends, "#ffffff", wall.thickness * 0.7)
                _line(group, ends, INK, HAIR)


def _doors(group: Element, world: World) -> None:
    named = {opening.name for wall in world.walls for opening in wall.openings}
    for leaf in leaves(world):
        pose = leaf.pose(math.radians(leaf.door.angle_deg))
        _line(group, pose.transform(np.array([[0.0, 0.0], [leaf.width, 0.0]])), INK, THICKNESS)
        _line(group, _swing(leaf), SOFT, HAIR / 2)
        if leaf.name in named:
            x, y = leaf.pose(0.0).transform(np.array([leaf.width / 2, 0.0])).tolist()
            _write(group, leaf.name, x, y + LETTERS / 2, LETTERS, middle=True)


def _swing(leaf: Leaf) -> Array:
    """Return the swing of a leaf's edge from closed to its start angle, or to 90 degrees if closed, (n, 2) [m]."""
    far = math.radians(leaf.door.angle_deg or min(90.0, leaf.door.limit_deg))
    edges = [leaf.pose(angle).transform(np.array([leaf.width, 0.0])) for angle in np.linspace(0.0, far, 16).tolist()]
    return np.array(edges)


def _things(group: Element, world: World) -> None:
    for thing in world.obstacles:
        for outline, _, _ in prisms(thing):
            _line(group, outline, INK, HAIR, closed=True, fill=thing.color)
        if thing.name is not None:
            _write(group, thing.name, thing.at[0], thing.at[1], LETTERS, middle=True)


def _beacons(group: Element, world: World) -> None:
    for item in hung(world):
        half, reach = item.beacon.width / 2, max(0.1, LETTERS)
        _line(group, item.place.transform(np.array([[0.0, -half], [0.0, half]])), BEACON, 2 * HAIR)
        x, y = item.place.transform(np.array([reach, 0.0])).tolist()
        _write(group, item.beacon.name, x, y, LETTERS * 0.8, middle=True, ink=BEACON)


def _people(group: Element, world: World) -> None:
    for person in world.people:
        for outline, color in from_above(world, person):
            _line(group, outline, SOFT, HAIR, closed=True, fill=color)
        place = person.place()
        _write(group, person.name, place.x, place.y - 2 * LETTERS, LETTERS, middle=True)


def _robots(group: Element, world: World) -> None:
    for robot, name in zip(world.robots, item_names(world.robots), strict=True):
        place = Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg))
        _line(group, place.transform(robot.body.outline()), ROBOT, HAIR, closed=True)
        _line(group, place.transform(np.array([[0.0, 0.0], [AHEAD, 0.0]])), ROBOT, HAIR)
        _write(group, name, robot.at[0], robot.at[1] - 2 * LETTERS, LETTERS, middle=True, ink=ROBOT)


def _group(root: Element, name: str) -> Element:
    group = _element("g", id=name)
    root.append(group)
    return group


def _element(tag: str, **attributes: str) -> Element:
    return Element(f"{{{NAMESPACE}}}{tag}", attributes)


def _number(metres: float) -> str:
    return f"{metres * PER_METRE + 0.0:.7g}"


def _line(group: Element, points: Array, ink: str, width: float, *, closed: bool = False, fill: str = "none") -> None:
    """Add a polyline through corners, shape (n, 2), with a width [m]."""
    shape = _element("polygon" if closed else "polyline", fill=fill, stroke=ink)
    shape.set("stroke-width", _number(width))
    shape.set("points", " ".join(f"{_number(x)},{_number(-y)}" for x, y in points.tolist()))
    group.append(shape)


def _write(
    group: Element, text: str, x: float, y: float, height: float, *, middle: bool = False, ink: str = INK
) -> None:
    """Add a line of text that starts at a point, or is centred on it [m]."""
    words = _element("text", x=_number(x), y=_number(-y), fill=ink)
    words.set("font-size", _number(height))
    words.set("font-family", "sans-serif")
    if middle:
        words.set("text-anchor", "middle")
    words.text = text
    group.append(words)
