"""Contents of PROTO nodes of Webots' library, as nodes that collide: walls, doors, arenas, furniture.

Sizes are those of the library (x is depth, y width, z height); furniture without sizes in its fields becomes a box.
"""

import math
import re
from collections.abc import Callable, Mapping

from mjsim.exchange.scenes.wbt_text import Parser, WbtNode, WbtText

FURNITURE: Mapping[str, tuple[float, float, float]] = {
    "Armchair": (0.8, 0.9, 0.8),
    "BathroomSink": (0.5, 0.6, 0.85),
    "Bathtube": (0.75, 1.7, 0.6),
    "Bed": (2.0, 1.6, 0.6),
    "CardboardBox": (0.6, 0.6, 0.6),
    "Chair": (0.5, 0.45, 0.9),
    "ConveyorBelt": (2.0, 0.5, 0.6),
    "Desk": (0.7, 1.2, 0.73),
    "FireExtinguisher": (0.2, 0.2, 0.6),
    "Fridge": (0.7, 0.65, 1.9),
    "OfficeChair": (0.6, 0.6, 1.1),
    "Oven": (0.6, 0.6, 0.85),
    "PlasticCrate": (0.6, 0.4, 0.3),
    "PottedTree": (0.4, 0.4, 1.3),
    "Radiator": (0.12, 1.0, 0.7),
    "RoundTable": (0.8, 0.8, 0.74),
    "SimpleChair": (0.45, 0.45, 0.9),
    "Sofa": (0.9, 1.9, 0.8),
    "Toilet": (0.7, 0.4, 0.8),
    "WashingMachine": (0.6, 0.6, 0.85),
    "WoodenBox": (0.6, 0.6, 0.6),
    "WoodenChair": (0.45, 0.45, 0.9),
    "WoodenPallet": (1.2, 0.8, 0.14),
}
"""Furniture -> its usual depth, width and height [m]."""
LAMPS: Mapping[str, str] = {
    "CeilingLight": "pointLightColor",
    "CeilingSpotLight": "spotLightColor",
    "FloorLight": "pointLightColor",
    "DoubleFluorescentLamp": "color",
    "ConstructionLamp": "color",
    "DeskLamp": "pointLightColor",
}
"""Lamps -> the field with their colour."""
ARC_SIDES = 24
"""Number of sides of a round arena."""
Sizes = tuple[float, ...]


def plain_node(node: WbtNode) -> WbtNode | None:
    """Return the nodes that a PROTO of the library consists of; None for one that is not known."""
    made = _MAKERS.get(node.kind)
    if made is None:
        return None
    (found,) = Parser(made(node), node.kind).nodes()
    for key in ("translation", "rotation", "name", "physics"):
        if key in node.fields:
            found.fields[key] = node.fields[key]
    found.fields.setdefault("name", [WbtText(re.sub(r"(?<!^)(?=[A-Z])", " ", node.kind).lower())])
    if (mass := node.number("mass", 0.0)) > 0.0:
        found.fields["physics"] = [WbtNode("Physics", {"density": [-1.0], "mass": [mass]})]
    for key in ("appearance", "wallAppearance", "trayAppearance", "primaryAppearance"):
        if node.nodes(key):
            found.fields.setdefault("appearance", list(node.nodes(key)))
    return found


def guessed_size(node: WbtNode) -> tuple[float, float, float] | None:
    """Return the size of furniture that has none in its fields [m]; None for all else."""
    return FURNITURE.get(node.kind) if "size" not in node.fields else None


def _box(size: Sizes, x: float = 0.0, y: float = 0.0, z: float | None = None) -> str:
    """Return a box; without z it stands on the floor."""
    middle = size[2] / 2 if z is None else z
    text = " ".join(f"{value:.9g}" for value in size)
    return f"Pose {{ translation {x:.9g} {y:.9g} {middle:.9g} children [ Box {{ size {text} }} ] }}"


def _solid(*shapes: str, more: str = "") -> str:
    return f"Solid {{ boundingObject Group {{ children [ {' '.join(shapes)} ] }} {more} }}"


def _wall(node: WbtNode) -> str:
    return _solid(_box(node.numbers("size", (0.2, 1.0, 2.4))))


def _window(node: WbtNode) -> str:
    deep, wide, high = node.numbers("size", (0.2, 0.8, 2.4))
    sill, pane = node.number("bottomWallHeight", 0.7), node.number("windowHeight", 1.4)
    top = high - sill - pane
    shapes = [_box((deep, wide, sill))] if sill > 0.0 else []
    return _solid(*shapes, *([_box((deep, wide, top), z=high - top / 2)] if top > 0.0 else []))


def _door(node: WbtNode) -> str:
    """Return the wall above a door, and its leaf on a hinge; the frame belongs to the doorway."""
    deep, wide, high = node.numbers("size", (0.2, 1.0, 2.4))
    tall, thick = min(node.number("frameHeight", 2.0), high), node.number("doorThickness", 0.05)
    frame = node.numbers("frameSize", (0.05, 0.05, 0.05))
    leaf = _box((thick, wide - frame[1], tall - frame[2] / 2), deep / 2 + frame[0] + thick / 2, z=tall / 2)
    side = -1.0 if node.said("jointAtLeft", usual=True) else 1.0
    stops = "minStop -1.57 maxStop 0.01" if side < 0.0 else "minStop -0.01 maxStop 1.57"
    mass = node.number("mainMaterialDensity", 200.0) * thick * wide * tall
    anchor = f"{deep / 2 + frame[0]:.9g} {side * (wide - frame[1]) / 2:.9g} {tall / 2:.9g}"
    hinge = f"axis 0 0 1 anchor {anchor} {stops} dampingConstant 10 position {node.number('position', 0.0):.9g}"
    moves = f'HingeJoint {{ jointParameters HingeJointParameters {{ {hinge} }} endPoint Solid {{ name "leaf" '
    moves += f"boundingObject {leaf} physics Physics {{ density -1 mass {mass:.9g} }} }} }}"
    top = [_box((deep, wide, high - tall), z=(high + tall) / 2)] if high - tall > 1e-6 else []
    if not node.said("canBeOpen", usual=True):
        return _solid(*top, leaf)
    return _solid(*top, more=f"children [ {moves} ]")


def _arena(node: WbtNode) -> str:
    deep, wide = node.numbers("floorSize", (1.0, 1.0))
    high, thick = node.number("wallHeight", 0.1), node.number("wallThickness", 0.01)
    return _solid(
        *(_box((thick, wide + 2 * thick, high), x=side * (deep + thick) / 2) for side in (-1.0, 1.0)),
        *(_box((deep, thick, high), y=side * (wide + thick) / 2) for side in (-1.0, 1.0)),
    )


def _round_arena(node: WbtNode) -> str:
    radius, high, thick = node.number("radius", 1.0), node.number("wallHeight", 0.1), node.number("wallThickness", 0.01)
    long = 2.0 * (radius + thick) * math.tan(math.pi / ARC_SIDES)
    angles = [2.0 * math.pi * side / ARC_SIDES for side in range(ARC_SIDES)]
    return _solid(
        *(
            f"Pose {{ rotation 0 0 1 {angle:.9g} children [ {_box((thick, long, high), x=radius + thick / 2)} ] }}"
            for angle in angles
        )
    )


def _solid_box(node: WbtNode) -> str:
    return _solid(_box(node.numbers("size", (1.0, 1.0, 1.0)), z=0.0))


def _table(node: WbtNode) -> str:
    """Return a slab on four legs."""
    deep, wide, high = node.numbers("size", (1.0, 1.8, 0.74))
    foot = min(*node.numbers("feetSize", (0.1, 0.1)), deep / 2, wide / 2)
    thick = min(node.number("frameThickness", 0.05), high / 2)
    legs = (
        _box((foot, foot, high - thick), x * (deep - foot) / 2, y * (wide - foot) / 2) for x in (-1, 1) for y in (-1, 1)
    )
    return _solid(_box((deep, wide, thick), z=high - thick / 2), *legs)


def _cabinet(node: WbtNode) -> str:
    """Return the box of a cabinet, whose back is at its origin; its doors are closed."""
    deep, thick = node.number("depth", 0.5), node.number("outerThickness", 0.02)
    wide, high = (sum(node.values(key)) or usual for key, usual in (("columnsWidths", 0.9), ("rowsHeights", 1.0)))
    return _solid(_box((deep, wide + 2 * thick, high + 2 * thick), x=deep / 2))


def _barrel(node: WbtNode) -> str:
    return _solid(f"Cylinder {{ radius {node.number('radius', 0.305):.9g} height {node.number('height', 0.88):.9g} }}")


def _furniture(node: WbtNode) -> str:
    sizes = node.numbers("size", FURNITURE[node.kind])
    centred = node.kind in ("CardboardBox", "WoodenBox")
    return _solid(_box(sizes, z=0.0 if centred else None))


def _floor(node: WbtNode) -> str:
    return "Group { }"


_MAKERS: Mapping[str, Callable[[WbtNode], str]] = {
    **dict.fromkeys(FURNITURE, _furniture),
    "Cabinet": _cabinet,
    "CircleArena": _round_arena,
    "Door": _door,
    "Floor": _floor,
    "OilBarrel": _barrel,
    "RectangleArena": _arena,
    "SolidBox": _solid_box,
    "Table": _table,
    "Wall": _wall,
    "Window": _window,
}
