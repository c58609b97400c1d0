"""Repairs common faults of URDF files that MuJoCo rejects: sizes of shapes, scales of meshes, repeated elements."""

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from mjsim.models.inertia_repair import finite_number

AXES = 3
MIN_SIDE = 1e-3
"""Replacement for a side of length 0 [m]."""
SHAPES = ("box", "cylinder", "capsule", "sphere", "mesh")
_ONCE = {
    "link": ("inertial",),
    "joint": ("origin", "parent", "child", "axis", "limit", "dynamics", "mimic"),
    "visual": ("origin", "geometry", "material"),
    "collision": ("origin", "geometry"),
    "inertial": ("origin", "mass", "inertia"),
}
_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "capsule": ("radius", "length"), "sphere": ("radius",)}


def mend_scales(root: Element) -> Iterator[str]:
    """Write each mesh scale as three numbers, repeating a single one; yield notes on what was done."""
    count = 0
    for mesh in root.iter("mesh"):
        numbers = mesh.get("scale", "").replace(",", " ").split()
        if numbers and (len(numbers) != AXES or "," in mesh.get("scale", "")) and len(numbers) in (1, AXES, AXES + 1):
            mesh.set("scale", " ".join(numbers * AXES if len(numbers) == 1 else numbers[:AXES]))
            count += 1
    if count:
        yield f"the scale of {count} mesh{'es' * (count != 1)}, which did not have three numbers"


def firsts(root: Element, path: str) -> Iterator[str]:
    """Keep the first of each element that URDF allows once, as ROS does; yield notes on what was left out."""
    for owner in [*root.findall("link"), *root.findall("joint")]:
        repeated: list[Element] = []
        for item in list(owner.iter()):
            groups = [item.findall(tag) for tag in _ONCE.get(item.tag, ())]
            groups += [[shape for shape in item if shape.tag in SHAPES]] if item.tag == "geometry" else []
            for extra in (each for group in groups for each in group[1:]):
                item.remove(extra)
                repeated.append(extra)
        if repeated:
            tags = ", ".join(sorted({f"<{extra.tag}>" for extra in repeated}))
            called = f"{owner.tag} '{owner.get('name', '?')}'"
            yield f"left out: {path}: repeated {tags} in {called}; the first is used, as in ROS"


def mend_sizes(root: Element, path: str) -> Iterator[str]:
    """Remove shapes of size 0, and give sides of length 0 a small thickness; yield notes on what was done."""
    for link in root.findall("link"):
        for part in [*link.findall("visual"), *link.findall("collision")]:
            for shape in part.findall("geometry/*"):
                if note := _mended_size(shape):
                    yield f"{path}: a {shape.tag} of link '{link.get('name', '?')}' {note}"
                if note == _NO_SIZE:
                    link.remove(part)


_NO_SIZE = "has no size; left out"


def _mended_size(shape: Element) -> str | None:
    """Give a flat shape a small thickness; return a note, None if nothing was done."""
    sides = {key: [finite_number(word) for word in shape.get(key, "").split()] for key in _SIZES.get(shape.tag, ())}
    numbers = [number for side in sides.values() for number in side]
    if not numbers or any(number is None or number < 0.0 for number in numbers) or all(numbers):
        return None  # Values that are not numbers are reported, with their position, by the reader of the file.
    if not any(numbers):
        return _NO_SIZE
    if shape.tag != "box" and not numbers[0]:
        return None  # A rod of radius 0 is a mistake.
    for key, side in sides.items():
        shape.set(key, " ".join(format(number or MIN_SIDE, ".9g") for number in side))
    return f"is flat; made {MIN_SIDE:g} m thin"
