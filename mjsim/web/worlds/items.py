"""A world in JSON for the page: items with their outlines, their values, and their positions in the text."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan import (
    ORIGIN,
    PlanItem,
    beacon_shapes,
    lamp_shapes,
    leaf_shapes,
    obstacle_shapes,
    patch_shape,
    person_shapes,
    robot_shapes,
    route_shapes,
    start_of,
    wall_shapes,
    window_shapes,
)
from mjsim.sentences import Sentence
from mjsim.web.worlds.mechanism_poses import outlines, plan_joints, start_values
from mjsim.world import (
    Hung,
    Mechanism,
    Model,
    Node,
    Opening,
    Person,
    Wall,
    World,
    extent,
    hung,
    item_names,
    leaves,
    solid_pieces,
)

THICKNESS = 0.03
"""Thickness of the outline by which a beacon is dragged [m]."""
LISTS = ("walls", "obstacles", "beacons", "lamps", "robots", "mechanisms", "people")
_DECIMALS = 4


Path = tuple[str | int, ...]
Json = dict[str, Any]
Thing = tuple[Path, str, Model, Sequence[PlanItem], Pose | None]
"""Path, kind, model, what is drawn of it, and pose."""


def scene_of(world: World, raw: Node | None = None) -> Json:
    """Return the plan of a world.

    Args:
        world: A world read from text, or built in Python.
        raw: Its text as written; by default its expanded form.

    Returns:
        `items`: each with path, kind, name, label, at [m], heading_deg, polygons [m] (world frame), shapes, values,
        written, raw, computed, type, fixed, origin and line. `bounds`: [x0, y0, x1, y1] [m].
    """
    text = _Text(world.source.written, raw)
    values = world.model_dump(mode="json")
    things = list(_things(world))
    items = [
        text.item(
            path,
            kind,
            model=model,
            values={**_at(values, path), **(_starts(world, path) if kind == "joint" else {})},
            shapes=shapes,
            place=place,
        )
        for path, kind, model, shapes, place in things
    ]
    return {"items": items, "bounds": _bounds(world, things)}


def world_values(world: World, raw: Node | None = None) -> Json:
    """Return the values of a world that belong to no item: `values`, `written` and `raw`."""
    node = world.source.written
    keys = list(node.items) if isinstance(node, Node) else []
    written = [key for key in (keys if raw is None else raw.items) if key not in LISTS]
    source = node if raw is None else raw
    plain = {key: source.value[key] for key in written} if isinstance(source, Node) else {}
    return {"values": world.model_dump(mode="json", exclude={*LISTS}), "written": written, "raw": plain}


def _bounds(world: World, things: Sequence[Thing]) -> list[float]:
    """Return the bounding box of all outlines and positions, at least 1 m wide; 10 x 10 m for an empty world."""
    outlines = [outline for thing in things for outline in _outlines(thing[3])]
    outlines += [np.array([[place.x, place.y]]) for *_, place in things if place is not None]
    outlines += [extent(obstacle) for obstacle in world.obstacles if obstacle.path is not None]
    if not outlines:
        return [-5.0, -5.0, 5.0, 5.0]
    points = np.concatenate(outlines)
    low, high = points.min(axis=0), points.max(axis=0)
    short = np.maximum(1.0 - (high - low), 0.0) / 2
    return [_short(value) for value in (*(low - short).tolist(), *(high + short).tolist())]


def _things(world: World) -> Iterator[Thing]:
    for index, patch in enumerate(world.floor.patches):
        place = Pose(patch.at[0], patch.at[1], math.radians(patch.heading_deg))
        yield ("floor", "patches", index), "patch", patch, [patch_shape(patch)], place
    yield from _walls(world)
    for index, (obstacle, name) in enumerate(zip(world.obstacles, item_names(world.obstacles), strict=True)):
        place = Pose(obstacle.at[0], obstacle.at[1], math.radians(obstacle.heading_deg))
        kind = "mover" if obstacle.path is not None else "obstacle"
        shapes = [*obstacle_shapes(obstacle, name), *route_shapes(obstacle, name)]
        yield ("obstacles", index), kind, obstacle, shapes, place
    for index, item in enumerate(hung(world)):
        kind = "beacon" if item.beacon.marker is None else "marker"
        yield ("beacons", index), kind, item.beacon, _beacon(item), item.place
    for index, (lamp, name) in enumerate(zip(world.lamps, item_names(world.lamps), strict=True)):
        yield ("lamps", index), "light", lamp, list(lamp_shapes(lamp, name)), Pose(lamp.at[0], lamp.at[1], 0.0)
    for index, robot in enumerate(world.robots):
        yield ("robots", index), "robot", robot, list(robot_shapes(robot)), start_of(robot)
    for kind in ("people", "mechanisms"):
        for index, thing in enumerate(getattr(world, kind)):
            yield from _moving(world, thing, (kind, index))


def _beacon(item: Hung) -> list[PlanItem]:
    """Return a beacon with an outline for dragging instead of the line of its face."""
    half, thin = item.beacon.width / 2, THICKNESS / 2
    outline = np.array([[-thin, -half], [thin, -half], [thin, half], [-thin, half]])
    first, *others = beacon_shapes(item)
    role = "beacon" if item.beacon.has_face else "reflector"
    held = replace(first, role=role, kind="area", parts=(outline,), symbol=False)
    return [held, *(shape for shape in (first, *others) if shape.role != "beacon")]


def _moving(world: World, thing: Mechanism | Person, path: Path) -> Iterator[Thing]:
    """Yield a person, or a mechanism and those of its joints that can be moved on the plan."""
    if isinstance(thing, Person):
        yield path, "person", thing, list(person_shapes(world, thing)), thing.place()
        return
    bodies = [
        PlanItem(role="obstacle", parts=(outline,), tint=thing.body(name).color) for name, outline in outlines(thing)
    ]
    yield path, "mechanism", thing, bodies, Pose(thing.at[0], thing.at[1], math.radians(thing.heading_deg))
    for number, body, outline, place in plan_joints(thing):
        shape = PlanItem(role="obstacle", parts=(outline,), tint=thing.body(body).color)
        yield (*path, "joints", number), "joint", thing.joints[number], [shape], place


def moving_items(world: World, thing: Mechanism | Person, path: Path) -> Iterator[Json]:
    """Yield path, polygons, at and heading_deg of the plan items that make up a mechanism or a person."""
    for own, _, _, shapes, place in _moving(world, thing, path):
        yield {"path": list(own), **_placed(shapes, place)}


def _placed(shapes: Sequence[PlanItem], place: Pose | None) -> Json:
    return {
        "at": None if place is None else [_short(place.x), _short(place.y)],
        "heading_deg": None if place is None else _degrees(place.heading),
        "polygons": [_rounded(outline) for outline in _outlines(shapes)],
    }


def _outlines(shapes: Iterable[PlanItem]) -> Iterator[Array]:
    """Yield the outlines of all areas to scale, world frame, shape (n, 2) each [m]."""
    for shape in shapes:
        if shape.kind == "area" and not shape.symbol:
            yield from shape.placed(0.0)


def _shape(shape: PlanItem, place: Pose | None) -> Json:
    """Return a shape as `PlanShape`, from the pose of its item."""
    drawn: Json = {"role": shape.role}
    if shape.tint:
        drawn["tint"] = shape.tint
    if shape.level != 1.0:
        drawn["level"] = _short(shape.level)
    if not shape.frame:
        drawn["fixed"] = True
    elif place is not None and math.dist(
        _pose(place), _pose(carrier := shape.place @ shape.frame_from_shape.inverse())
    ):
        drawn["carrier"] = _pose(carrier)
    if shape.kind == "area" and not shape.symbol:
        return {**drawn, "count": len(shape.parts)}
    local = (place or ORIGIN).inverse() @ shape.place
    if shape.symbol:
        drawn["anchor"] = _pose(local)
    parts = shape.parts if shape.symbol else [local.transform(part) for part in shape.parts]
    return {
        **drawn,
        "parts": [_rounded(part) for part in parts],
        **({"closed": True} if shape.kind == "area" else {}),
    }


def _pose(pose: Pose) -> list[float]:
    return [_short(pose.x), _short(pose.y), _degrees(pose.heading)]


def _rounded(points: Array) -> list[list[float]]:
    rounded: list[list[float]] = (np.round(points, _DECIMALS) + 0.0).tolist()
    return rounded


def _starts(world: World, path: Path) -> Json:
    """Return the start value of a joint, written or computed: `start` and `start_deg`."""
    return start_values(world.mechanisms[int(path[1])], int(path[3]))


def _walls(world: World) -> Iterator[Thing]:
    doors = iter(leaves(world))
    for index, (wall, pieces) in enumerate(zip(world.walls, solid_pieces(world.walls), strict=True)):
        yield ("walls", index), "wall", wall, list(wall_shapes(pieces)), None
        for number, opening in enumerate(wall.openings):
            shapes, place = _gap(wall, opening)
            shapes += window_shapes(wall, opening) if shapes else ()
            if opening.door is not None and place is not None:
                leaf = next(doors, None)
                if leaf is not None:
                    shapes += leaf_shapes(world, leaf)
            yield ("walls", index, "openings", number), "opening", opening, shapes, place


def _gap(wall: Wall, opening: Opening) -> tuple[list[PlanItem], Pose | None]:
    """Return the gap that an opening cuts out of its wall, and its centre; nothing if it is outside the wall."""
    start, end = wall.segments()[opening.segment]
    length = math.dist(start, end)
    first, last = min(opening.at, length), min(opening.at + opening.width, length)
    if last - first < 1e-6:
        return [], None
    heading = math.atan2(end[1] - start[1], end[0] - start[0])
    half, across = (last - first) / 2, wall.thickness / 2
    middle = Pose(start[0], start[1], heading) @ Pose((first + last) / 2, 0.0, 0.0)
    corners = np.array([[-half, -across], [half, -across], [half, across], [-half, across]])
    return [PlanItem(role="gap", parts=(corners,), place=middle)], middle


class _Text:
    """Positions of items in a text."""

    def __init__(self, written: Any, raw: Node | None) -> None:
        """Store the expanded text, None for a world built in Python, and the text as written."""
        self._written = written
        own = () if raw is None else _mappings(raw)
        self._own = {(node.line, node.column): node for node in own}

    def item(
        self, path: Path, kind: str, *, model: Model, values: Json, shapes: Sequence[PlanItem], place: Pose | None
    ) -> Json:
        """Return an item in JSON form, with its position in the text.

        Args:
            path: Its path in the world.
            kind: Its kind on the page.
            model: Its model.
            values: All its fields.
            shapes: What is drawn of it.
            place: Its pose, world frame; None for an item without a single position.
        """
        node, fixed, origin = self._node(path)
        own = self._own.get((node.line, node.column)) if node is not None and fixed is None else None
        plain = own.value if own is not None else node.value if node is not None else {}
        name = getattr(model, "name", None)
        return {
            "path": list(path),
            "kind": kind,
            "name": name,
            "label": name or f"{kind} {int(path[-1]) + 1}",
            **_placed(shapes, place),
            "shapes": [_shape(shape, place) for shape in shapes],
            "values": values,
            "written": list(plain),
            "raw": plain,
            "computed": [key for key, value in plain.items() if _is_computed(value)] if own is not None else [],
            "type": type(model).__name__,
            "fixed": fixed,
            "origin": origin,
            "line": 1 if node is None else node.line,
        }

    def _node(self, path: Path) -> tuple[Node | None, str | None, str | None]:
        """Return the node of an item, why it cannot be changed in this text, and which of the two causes applies."""
        node, fixed, origin = self._written, None, None
        for step in path:
            if not isinstance(node, Node):
                return None, None, None
            node = node.items.get(step)
            if isinstance(node, Node) and node.origin is not None and isinstance(step, int):
                # A repeated item of an included file counts as included.
                origin = origin or ("repeat" if node.origin.file is None else "include")
                fixed = _held(node, node.origin.file, repeated=bool(node.origin.repetition))
        return (node, fixed, origin) if isinstance(node, Node) else (None, None, None)


def _held(node: Node, file: str | None, *, repeated: bool) -> str:
    """Return why an item of an included file, or a repeated one, cannot be changed in this text."""
    if not repeated:
        return Sentence("is written in {file}; change it there", file)
    place, target = ("", "in the text") if file is None else (Sentence(" of {file}", file), "there")
    return Sentence("one repetition of the item in line {line}{place}; change it {target}", node.line, place, target)


def _mappings(node: Node) -> Iterator[Node]:
    """Yield the mappings in all lists of a text."""
    for item in node.items.values():
        if isinstance(node.value, list) and isinstance(item.value, dict):
            yield item
        if item.items:
            yield from _mappings(item)


def _is_computed(value: Any) -> bool:
    """Return whether a value contains an expression."""
    if isinstance(value, Mapping):
        return any(map(_is_computed, value.values()))
    return any(map(_is_computed, value)) if isinstance(value, list) else isinstance(value, str) and "${" in value


def _at(values: Any, path: Path) -> Any:
    for step in path:
        values = values[step]
    return values


def _degrees(heading: float) -> float:
    """Return an angle [rad] in degrees, in (-180, 180]."""
    turned = _short(math.degrees(heading) % 360.0)
    return _short(turned - 360.0) if turned > 180.0 else turned


def _short(value: float) -> float:
    return round(value, _DECIMALS) + 0.0
