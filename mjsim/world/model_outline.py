"""What a model fills, told from its file alone, as plans, checks and maps need it.

MuJoCo reads the file too when a scene is compiled (`mjsim.compile.models`), and what is said here must be what it
makes of it; a test holds both together. It is read here a second time because a plan, a report or a check of a world
does without MuJoCo. Joints are as the file has them at rest.
"""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from xml.etree.ElementTree import Element

import numpy as np

from mjsim.geometry import Array
from mjsim.world.model_files import ModelFiles

LAST_SEEN_GROUP = 2
"""MuJoCo's viewers show the groups up to this one unless told otherwise."""
ROUND = 32
"""Corners of a circle."""
MOST_CORNERS = 1_200_000
"""Of all parts of a model together; a ball has 544."""
LARGEST = 1e6
"""No thing reaches so far [units of its file]."""
_TURNS = ("quat", "axisangle", "xyaxes", "zaxis", "euler")

Attributes = Mapping[str, str]
Placed = tuple[Array, Array]
"""Rotation (3, 3) and translation (3,) of an inner frame in the model's."""
HERE: Placed = (np.eye(3), np.zeros(3))


def filled(path: str, files: ModelFiles) -> list[Array]:
    """Return what can be bumped into of a model, or what is seen of one where nothing can.

    Returns:
        Of each part points whose hull holds it, frame and units of the model, shape (n, 3).

    Raises:
        ValueError: A value cannot be understood, or there is no part; a sentence that names the file.
    """
    try:
        reader = _Urdf(files) if files.urdf else _Mjcf(files)
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            parts = list(_counted(reader.parts()))
    except (ArithmeticError, KeyError, IndexError, TypeError, ValueError) as error:
        raise ValueError(f"'{path}' cannot be understood: {_said(error)}") from None
    solid = [corners for corners, touches in parts if touches] or [corners for corners, _ in parts]
    if not solid:
        raise ValueError(f"'{path}' has no shape that could stand in a room; give it geoms")
    farthest = max(float(np.abs(corners).max()) for corners in solid)
    if not farthest < LARGEST:
        raise ValueError(f"'{path}' reaches {farthest:g} units far; that is no thing")
    return solid


def _counted(parts: Iterable[tuple[Array, bool]]) -> Iterator[tuple[Array, bool]]:
    """Yield parts until they have more corners than a thing may have."""
    count = 0
    for corners, touches in parts:
        count += len(corners)
        if count > MOST_CORNERS:
            raise ValueError(f"its parts have more than {MOST_CORNERS} corners; simplify its meshes")
        yield corners, touches


def _said(error: Exception) -> str:
    return f"no '{error.args[0]}'" if isinstance(error, KeyError) else str(error)


class _Mjcf:
    """Reads the geoms of MJCF."""

    def __init__(self, files: ModelFiles) -> None:
        self._files = files
        root = files.root
        compiler = root.find("compiler")
        settings: Attributes = {} if compiler is None else compiler.attrib
        self._unit = 1.0 if settings.get("angle") == "radian" else math.pi / 180
        self._order = settings.get("eulerseq", "xyz")
        self._classes: dict[str, dict[str, dict[str, str]]] = {"main": {}}
        for section in root.findall("default"):
            self._take_defaults(section, "main", self._classes["main"])
        self._meshes = {item.get("name", ""): item for item in root.findall("asset/mesh")}
        self._corners: dict[str, Array] = {}

    def parts(self) -> Iterator[tuple[Array, bool]]:
        """Yield the corners of each geom, shape (n, 3), and whether it can be touched."""
        for world in self._files.root.findall("worldbody"):
            yield from self._inside(world, HERE, "main")

    def _take_defaults(self, section: Element, name: str, above: Mapping[str, dict[str, str]]) -> None:
        own = {tag: dict(values) for tag, values in above.items()}
        for child in section:
            if child.tag != "default":
                own[child.tag] = _over(own.get(child.tag, {}), child.attrib)
        self._classes[name] = own
        for child in section.findall("default"):
            self._take_defaults(child, child.get("class", ""), own)

    def _attributes(self, item: Element, outer: str) -> dict[str, str]:
        """Return what an item says, and what its class says for it."""
        return _over(self._classes[item.get("class", outer)].get(item.tag, {}), item.attrib)

    def _inside(self, element: Element, place: Placed, outer: str) -> Iterator[tuple[Array, bool]]:
        for child in element:
            if child.tag == "geom":
                yield from self._geom(self._attributes(child, outer), place)
            elif child.tag in ("body", "frame"):
                there = _within(place, self._place(child.attrib))
                yield from self._inside(child, there, child.get("childclass", outer))
            elif child.tag == "replicate":
                step = self._rotation({"euler": child.get("euler", "0 0 0")}), _numbers(child.get("offset", "0 0 0"), 3)
                there = place
                for _ in range(int(child.get("count", "0"))):
                    yield from self._inside(child, there, child.get("childclass", outer))
                    there = _within(there, step)

    def _geom(self, geom: Attributes, place: Placed) -> Iterator[tuple[Array, bool]]:
        shape, touches = (
            geom.get("type", "sphere"),
            geom.get("contype", "1") != "0" or geom.get("conaffinity", "1") != "0",
        )
        seen = int(geom.get("group", "0")) <= LAST_SEEN_GROUP and _numbers(geom.get("rgba", "1 1 1 1"))[-1] > 0
        if shape == "plane" or not (touches or seen):
            return
        size = _numbers(geom.get("size", "0 0 0"))
        if "mesh" in geom:
            corners = self._mesh(geom["mesh"])
        elif "fromto" in geom:
            ends = _numbers(geom["fromto"], 6)
            yield self._between(shape, size, ends, place), touches
            return
        else:
            corners = shape_corners(shape, size)
        yield _moved(corners, _within(place, self._place(geom))), touches

    def _between(self, shape: str, size: Array, ends: Array, place: Placed) -> Array:
        """Return the corners of a shape that goes from one point to another."""
        way = ends[3:] - ends[:3]
        half = float(np.linalg.norm(way)) / 2
        sizes = [size[0], half] if shape in ("capsule", "cylinder") else [size[0], size[0], half]
        # MuJoCo turns z to the end that is named first.
        there = _turned_to(-way), (ends[3:] + ends[:3]) / 2
        return _moved(shape_corners(shape, np.array(sizes)), _within(place, there))

    def _mesh(self, name: str) -> Array:
        if name not in self._corners:
            mesh = self._attributes(self._meshes[name], "main")
            corners = self._files.corners(mesh["file"]) if "file" in mesh else _numbers(mesh["vertex"]).reshape(-1, 3)
            corners = corners - _numbers(mesh.get("refpos", "0 0 0"), 3)
            corners = corners @ _from_quaternion(_numbers(mesh.get("refquat", "1 0 0 0"), 4))
            self._corners[name] = corners * _numbers(mesh.get("scale", "1 1 1"), 3)
        return self._corners[name]

    def _place(self, item: Attributes) -> Placed:
        return self._rotation(item), _numbers(item.get("pos", "0 0 0"), 3)

    def _rotation(self, item: Attributes) -> Array:
        if "quat" in item:
            return _from_quaternion(_numbers(item["quat"], 4))
        if "axisangle" in item:
            x, y, z, angle = _numbers(item["axisangle"], 4)
            return _about(np.array([x, y, z]), angle * self._unit)
        if "xyaxes" in item:
            axes = _numbers(item["xyaxes"], 6)
            x = _unit(axes[:3])
            y = _unit(axes[3:] - x * (x @ axes[3:]))
            return np.column_stack([x, y, np.cross(x, y)])
        if "zaxis" in item:
            return _turned_to(_numbers(item["zaxis"], 3))
        rotation = np.eye(3)
        for axis, angle in zip(self._order, _numbers(item.get("euler", "0 0 0"), 3), strict=True):
            turn = _about(np.eye(3)["xyz".index(axis.lower())], angle * self._unit)
            # A small letter is an axis that turns along, a capital one that stays.
            rotation = rotation @ turn if axis.islower() else turn @ rotation
        return rotation


class _Urdf:
    """Reads the links of URDF."""

    def __init__(self, files: ModelFiles) -> None:
        self._files = files
        self._links = {link.get("name", ""): link for link in files.root.findall("link")}
        self._joints: dict[str, list[Element]] = {}
        children = set()
        for joint in files.root.findall("joint"):
            parent, child = joint.find("parent"), joint.find("child")
            if parent is None or child is None:
                raise ValueError(f"joint '{joint.get('name', '')}' joins nothing")
            self._joints.setdefault(parent.attrib["link"], []).append(joint)
            children.add(child.attrib["link"])
        self._first = [name for name in self._links if name not in children]
        if len(self._first) != 1:
            raise ValueError(f"{len(self._first)} links hang on none; there must be one")

    def parts(self) -> Iterator[tuple[Array, bool]]:
        """Yield the corners of each shape, shape (n, 3), and whether it can be touched."""
        waiting: list[tuple[str, Placed]] = [(self._first[0], HERE)]
        for count in itertools.count():
            if not waiting:
                return
            if count > len(self._links):
                raise ValueError("its joints go round in a ring")
            name, place = waiting.pop()
            yield from self._link(self._links[name], place)
            for joint in self._joints.get(name, []):
                (child,) = joint.findall("child")
                waiting.append((child.attrib["link"], _within(place, _origin(joint))))

    def _link(self, link: Element, place: Placed) -> Iterator[tuple[Array, bool]]:
        for part in link:
            shape = part.find("geometry/*")
            if shape is not None:
                yield _moved(self._corners(shape), _within(place, _origin(part))), part.tag == "collision"

    def _corners(self, shape: Element) -> Array:
        if shape.tag == "box":
            return shape_corners("box", _numbers(shape.attrib["size"], 3) / 2)
        if shape.tag == "mesh":
            file = shape.attrib["filename"]
            return self._files.corners(file) * _numbers(shape.get("scale", "1 1 1"), 3)
        radius, length = _numbers(shape.attrib["radius"], 1), _numbers(shape.get("length", "0"), 1)
        return shape_corners(shape.tag, np.concatenate([radius, length / 2]))


def _origin(item: Element) -> Placed:
    origin = item.find("origin")
    said: Attributes = {} if origin is None else origin.attrib
    rotation = np.eye(3)
    for axis, angle in enumerate(_numbers(said.get("rpy", "0 0 0"), 3)):
        rotation = _about(np.eye(3)[axis], float(angle)) @ rotation
    return rotation, _numbers(said.get("xyz", "0 0 0"), 3)


def shape_corners(shape: str, size: Array) -> Array:
    """Return points whose hull is a simple shape (a round one nearly), in its own frame, shape (n, 3).

    Args:
        shape: As MuJoCo calls it.
        size: As MuJoCo has it: half sizes; radius; radius and half length.
    """
    turns = np.arange(ROUND) * (2 * math.pi / ROUND)
    if shape == "box":
        return np.array(list(itertools.product((-1, 1), repeat=3))) * size[:3]
    if shape == "cylinder":
        ring = size[0] * np.column_stack([np.cos(turns), np.sin(turns)])
        return np.concatenate([np.column_stack([ring, np.full(ROUND, side * size[1])]) for side in (-1, 1)])
    rises = np.linspace(-math.pi / 2, math.pi / 2, ROUND // 2 + 1)[:, None]
    ball = np.stack(
        np.broadcast_arrays(np.cos(turns) * np.cos(rises), np.sin(turns) * np.cos(rises), np.sin(rises)), -1
    )
    ball = ball.reshape(-1, 3)
    if shape == "sphere":
        return np.asarray(ball * size[0], dtype=float)
    if shape == "ellipsoid":
        return np.asarray(ball * size[:3], dtype=float)
    if shape == "capsule":
        return np.concatenate([ball * size[0] + [0.0, 0.0, side * size[1]] for side in (-1, 1)])
    raise ValueError(f"a part is of the kind '{shape}'; it must be a box, a sphere, a cylinder or the like")


def _over(below: Attributes, above: Attributes) -> dict[str, str]:
    """Return attributes over those of a class; another way to say how a part is turned takes the place of one."""
    for keys in (_TURNS, ("fromto", "pos")):
        if any(key in above for key in keys):
            below = {key: value for key, value in below.items() if key not in keys}
    merged = {**below, **above}
    if "size" in below and "size" in above:
        # Fewer sizes than the class has leave its others as they are.
        own, others = above["size"].split(), below["size"].split()
        merged["size"] = " ".join([*own, *others[len(own) :]])
    return merged


def _numbers(text: str, count: int | None = None) -> Array:
    values = np.array(text.split(), dtype=float)
    if (count is not None and len(values) != count) or not len(values):
        raise ValueError(f"'{text}' is not {count if count is not None else 'a list of'} numbers")
    if not (np.abs(values) <= LARGEST).all():
        raise ValueError(f"'{text}' is beyond all things; a number is at most {LARGEST:g}")
    return values


def _within(outer: Placed, inner: Placed) -> Placed:
    return outer[0] @ inner[0], outer[0] @ inner[1] + outer[1]


def _moved(points: Array, place: Placed) -> Array:
    return np.asarray(points @ place[0].T + place[1], dtype=float)


def _about(axis: Array, angle: float) -> Array:
    """Return the rotation about an axis [rad] (Rodrigues' formula)."""
    x, y, z = _unit(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + math.sin(angle) * K + (1.0 - math.cos(angle)) * K @ K, dtype=float)


def _unit(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    if length < 1e-12:
        raise ValueError("an axis has no length")
    return np.asarray(vector / length, dtype=float)


def _from_quaternion(quaternion: Array) -> Array:
    w, vector = float(quaternion[0]), quaternion[1:]
    length = float(np.linalg.norm(vector))
    return _about(vector, 2.0 * math.atan2(length, w)) if length > 0.0 else np.eye(3)


def _turned_to(axis: Array) -> Array:
    """Return the smallest rotation that turns z to an axis."""
    x, y, z = _unit(axis)
    across = math.hypot(x, y)
    if across < 1e-12:
        return np.eye(3) if z > 0 else np.diag([1.0, -1.0, -1.0])
    return _about(np.array([-y, x, 0.0]), math.atan2(across, z))
