"""Reads worlds of Webots: solids with their bounding objects, joints, lamps, robots, and PROTO nodes of its library."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.scene_meshes import MeshFiles, MeshName, boxed, parts_of
from mjsim.exchange.scenes.scene_solids import Light, Scene, ScenePart, SceneSolid, SceneThing
from mjsim.exchange.scenes.sdf_files import Folders
from mjsim.exchange.scenes.wbt_text import Parser, WbtNode, filled, turned
from mjsim.exchange.scenes.webots_protos import LAMPS, guessed_size, plain_node
from mjsim.geometry import Array
from mjsim.inventory import Fate
from mjsim.models import SceneJoint, hex_of

MAX_TEXT = 50_000_000
"""Maximum size of a file [bytes]."""
MAX_PROTOS = 20
"""Maximum nesting of PROTO nodes."""
DENSITY = 1000.0
"""Density of a body without a mass [kg/m^3]."""
GROUPS = ("Group", "Transform", "Pose", "Billboard")
MOVING = {"HingeJoint": "hinge", "SliderJoint": "slide"}
SEEN = ("Shape", "CadShape")
SILENT = ("WorldInfo", "Viewpoint", "Background", "Fog", "Slot", *SEEN, "Muscle", "TexturedBackground")
"""Nodes without a meaning in a world of mjsim, or read by other code; likewise nodes whose names begin with these."""
ENU_YEAR = 2022
"""From this year's versions on, z points up unless a world says otherwise."""
LAMP_REACH = 10.0
"""Default range of a lamp [m]."""


@dataclass(slots=True, eq=False)
class _Body:
    """Solids that move together, and the parts that joints move on them."""

    solids: list[SceneSolid] = field(default_factory=list)
    mass: float = 0.0
    parts: list[ScenePart] = field(default_factory=list)


def read_wbt(path: Path) -> Scene:
    """Return the scene of a world of Webots.

    Raises:
        UsageError: The file cannot be read, or is malformed.
        ValueError: A number in it makes no sense.
    """
    text = read_bounded(path, limit=MAX_TEXT, kind="a world of Webots").decode("utf-8-sig", "replace")
    if not text.lstrip().startswith("#VRML_SIM"):
        raise UsageError(f"'{path}' does not begin with #VRML_SIM; name a world of Webots")
    parser = Parser(text, str(path))
    nodes = list(parser.nodes())
    info = next((node for node in nodes if node.kind == "WorldInfo"), WbtNode("WorldInfo"))
    version = re.match(r"#VRML_SIM\s+R(\d{4})", text.lstrip())
    recent = version is not None and int(version[1]) >= ENU_YEAR
    axes = info.text("coordinateSystem", "ENU" if recent else "NUE")
    if axes not in ("ENU", "NUE"):
        raise UsageError(f"'{path}' has the axes {axes[:20]}; mjsim reads ENU and NUE")
    done: set[int] = set()
    for node in nodes if axes == "NUE" else ():
        turned(node, done)
    reader = _Reader(path, parser.protos, turns=axes == "NUE", usual=0.05 if recent else 1.0)
    for node in nodes:
        reader.top(node, np.eye(4))
    return reader.scene


class _Reader:
    """Collects the scene of one file; poses are of shape (4, 4), with the scales of nodes in their columns [m]."""

    def __init__(self, path: Path, protos: Sequence[str], *, turns: bool, usual: float) -> None:
        self.scene, self._path, self._turns = Scene(), path, turns
        self._usual = usual
        """Radius of a round shape that does not state it [m]."""
        self._folders, self._meshes = Folders(path, []), MeshFiles(self.scene)
        self._protos = {Path(address).stem: address for address in protos}

    def top(self, node: WbtNode, world_from_outer: Array, depth: int = 0) -> None:
        """Take a node of the world, or of a group in it."""
        if node.kind in GROUPS:
            pose = world_from_outer @ _pose(node)
            for child in node.nodes("children"):
                self.top(child, pose, depth)
        elif node.kind == "Robot":
            self._robot(node, world_from_outer)
        elif node.kind in ("PointLight", "SpotLight", "DirectionalLight") or node.kind in LAMPS:
            self._light(node, world_from_outer)
        elif node.kind == "Solid":
            self._solid(node, world_from_outer)
        elif node.kind.startswith(SILENT):
            return
        elif (found := self._of_proto(node, depth)) is not None:
            self.top(found, world_from_outer, depth + 1)

    def _of_proto(self, node: WbtNode, depth: int) -> WbtNode | None:
        """Return the contents of a PROTO node; None for a robot, or an unknown node, which is reported."""
        if depth > MAX_PROTOS:
            raise UsageError(f"'{self._path}' nests PROTO nodes more than {MAX_PROTOS} deep; is it a loop?")
        name = node.text("name") or node.kind
        own = self._from_file(node)
        if own is not None:
            return own
        if "controller" in node.fields:
            return WbtNode("Robot", node.fields)
        size = guessed_size(node)
        if size is not None:
            shape = " x ".join(f"{value:g}" for value in size)
            self.scene.tell(Fate.GUESSED, f"{node.kind} PROTO", name, f"a box of {shape} m")
        if node.kind == "Door":
            self.scene.tell(Fate.GUESSED, "frame of a door", name, "part of the doorway")
        found = plain_node(node)
        if found is None:
            why = "unknown to mjsim; for a PROTO, put NAME.proto beside the world, or in 'protos' there"
            self.scene.tell(Fate.LEFT_OUT, "node", node.kind, why)
        return found

    def _from_file(self, node: WbtNode) -> WbtNode | None:
        """Return the contents of a node by a PROTO file beside the world."""
        above = self._path.absolute().parent
        address = self._protos.get(node.kind, "")
        candidates = [address] if address and "://" not in address else []
        candidates += [f"{node.kind}.proto", f"protos/{node.kind}.proto", f"../protos/{node.kind}.proto"]
        place = next((found for each in candidates if (found := self._folders.find(each, above))), None)
        if place is None or not place.is_file():
            return None
        text = read_bounded(place, limit=MAX_TEXT, kind="a PROTO").decode("utf-8-sig", "replace")
        if "%<" in text or "%{" in text:
            name = node.text("name") or node.kind
            why = f"mjsim's own '{name}' is used, if it has one"
            self.scene.tell(Fate.LEFT_OUT, "template of a PROTO", place.name, why)
            return None
        fields, body = Parser(text, str(place)).proto()
        made = filled(body, {**fields, **node.fields})
        if self._turns and "controller" not in made.fields:
            # Values of the world are converted to z up already, those of the file are not.
            turned(made, {id(item) for items in node.fields.values() for item in items if isinstance(item, WbtNode)})
            for key in ("translation", "rotation"):
                if key in node.fields:
                    made.fields[key] = node.fields[key]
        return made

    def _robot(self, node: WbtNode, world_from_outer: Array) -> None:
        pose = world_from_outer @ _pose(node)
        self.scene.starts.append((float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])))
        why = "its start is kept; import it with mjsim new --robot-from, from its URDF"
        self.scene.tell(Fate.LEFT_OUT, "robot", node.text("name") or node.kind, why)

    def _light(self, node: WbtNode, world_from_outer: Array) -> None:
        name = node.text("name") or node.kind
        if node.kind == "DirectionalLight":
            self.scene.tell(Fate.LEFT_OUT, "directional light", name, "a world has ambient light and lamps")
            return
        if node.kind != "PointLight":
            self.scene.tell(Fate.GUESSED, node.kind, name, "a lamp that shines in all directions")
        place = node.numbers("location", (0.0, 0.0, 0.0)) if node.kind not in LAMPS else None
        at = (world_from_outer @ (_pose(node) if place is None else _shift(place)))[:3, 3]
        color = hex_of(node.numbers(LAMPS.get(node.kind, "color"), (1.0, 1.0, 1.0)))
        self.scene.lights.append(Light(name, at, color, node.number("radius", LAMP_REACH)))

    def _solid(self, node: WbtNode, world_from_outer: Array) -> None:
        """Take a solid with everything in it as one thing."""
        name, body = node.text("name") or node.kind.lower(), _Body()
        world_from_solid = world_from_outer @ _pose(node)
        moves = node.node("physics") is not None
        self._fill(body, node, world_from_solid, name)
        if body.solids or body.parts:
            mass = max(body.mass, 1e-3) if moves else None
            self.scene.add(SceneThing(name, body.solids, _rigid(world_from_solid)[0], mass, body.parts))

    def _fill(self, body: _Body, node: WbtNode, world_from_solid: Array, name: str, depth: int = 0) -> None:
        """Add a solid, and the solids and joints in it, to a body."""
        bound, color = node.node("boundingObject"), _color(node)
        before = len(body.solids)
        if bound is not None:
            body.solids += self._shapes(bound, world_from_solid, color, name)
        elif any(child.kind in SEEN for child in node.nodes("children")) and not _is_flat(node):
            self.scene.tell(Fate.LEFT_OUT, "visible solid", name, "it has no boundingObject")
        physics = node.node("physics")
        if physics is not None:
            body.mass += _mass(physics, body.solids[before:])
        self._children(body, node, world_from_solid, name, depth)

    def _children(self, body: _Body, node: WbtNode, world_from_node: Array, name: str, depth: int) -> None:
        for child in node.nodes("children"):
            if child.kind in GROUPS:
                self._children(body, child, world_from_node @ _pose(child), name, depth)
            elif child.kind == "Solid":
                self._fill(body, child, world_from_node @ _pose(child), child.text("name") or name, depth)
            elif child.kind in MOVING:
                self._joint(body, child, world_from_node, name, depth)
            elif child.kind in ("PointLight", "SpotLight"):
                self._light(child, world_from_node)
            elif child.kind in ("Hinge2Joint", "BallJoint"):
                self.scene.tell(Fate.GUESSED, child.kind, name, "held")
                end = child.node("endPoint")
                if end is not None and end.kind == "Solid":
                    self._fill(body, end, world_from_node @ _pose(end), name, depth)
            elif not child.kind.startswith(SILENT) and (found := self._of_proto(child, depth)) is not None:
                if found.kind == "Robot":
                    self._robot(found, world_from_node)
                else:
                    wrapped = WbtNode("Group", {"children": [found]})
                    self._children(body, wrapped, world_from_node, name, depth + 1)

    def _joint(self, body: _Body, node: WbtNode, world_from_node: Array, name: str, depth: int) -> None:
        """Add the part that a hinge or a slide moves."""
        end, given = node.node("endPoint"), node.node("jointParameters") or WbtNode("JointParameters")
        if end is not None and end.kind not in ("Solid", "SolidReference"):
            end = self._of_proto(end, depth)
        if end is None or end.kind != "Solid":
            self.scene.tell(Fate.LEFT_OUT, node.kind, name, "it holds no solid")
            return
        part, label = _Body(), end.text("name") or name
        self._fill(part, end, world_from_node @ _pose(end), label, depth + 1)
        usual = [1.0, 0.0, 0.0] if MOVING[node.kind] == "hinge" else [0.0, 0.0, 1.0]
        axis = world_from_node[:3, :3] @ given.numbers("axis", tuple(np.roll(usual, 1) if self._turns else usual))
        anchor = np.array(given.numbers("anchor", (0.0, 0.0, 0.0)))
        low, high, now = (given.number(key, 0.0) for key in ("minStop", "maxStop", "position"))
        if low > high:
            self.scene.tell(Fate.GUESSED, "stops of joint", label, "minStop is above maxStop; it gets no stops")
        length = float(np.linalg.norm(axis))
        joint = SceneJoint(
            kind=MOVING[node.kind],
            anchor=(world_from_node @ np.append(anchor, 1.0))[:3],
            axis=axis / length if length > 0.0 else np.array([0.0, 0.0, 1.0]),
            # Stops of 0 and 0 mean none.
            range=(low - now, high - now) if low < high else None,
            damping=max(given.number("dampingConstant", 0.0), 0.0),
            friction=max(given.number("staticFriction", 0.0), 0.0),
            stiffness=max(given.number("springConstant", 0.0), 0.0),
            rest=-now,
        )
        if part.solids or part.parts:
            body.parts.append(ScenePart(f"{name}-{label}", [joint], part.solids, part.mass, part.parts))

    def _shapes(self, node: WbtNode, pose: Array, color: str | None, name: str) -> Iterator[SceneSolid]:
        """Yield the solids of a bounding object."""
        if node.kind in GROUPS:
            for child in node.nodes("children"):
                yield from self._shapes(child, pose @ _pose(node), color, name)
        elif node.kind == "Shape":
            geometry = node.node("geometry")
            if geometry is not None:
                yield from self._shapes(geometry, pose, color, name)
        elif node.kind == "Box":
            yield _plain("box", node.numbers("size", (2.0 * self._usual,) * 3), pose, color)
        elif node.kind in ("Cylinder", "Capsule", "Cone"):
            radius = node.number("bottomRadius" if node.kind == "Cone" else "radius", self._usual)
            high = node.number("height", 2.0 * self._usual) + (2.0 * radius if node.kind == "Capsule" else 0.0)
            if node.kind != "Cylinder":
                self.scene.tell(Fate.GUESSED, node.kind.lower(), name, "a cylinder of its size")
            yield _plain("cylinder", (radius, high), pose, color)
        elif node.kind == "Sphere":
            yield _plain("sphere", (node.number("radius", self._usual),), pose, color)
        elif node.kind == "IndexedFaceSet":
            yield from self._faces(node, pose, color, name)
        elif node.kind == "Mesh":
            yield from self._mesh(node, pose, color, name)
        elif node.kind != "Plane":
            self.scene.tell(Fate.LEFT_OUT, node.kind, name, "mjsim has no such shape; the floor is level")

    def _mesh(self, node: WbtNode, pose: Array, color: str | None, name: str) -> Iterator[SceneSolid]:
        uri = node.text("url")
        place = self._folders.find(uri, self._path.absolute().parent)
        if place is None or not place.is_file():
            self.scene.tell(Fate.LEFT_OUT, "mesh", uri or name, "not found beside the world")
            return
        rigid, scale = _rigid(pose)
        yield from self._meshes.solids(MeshName(place, node.text("name")), scale, rigid, color)

    def _faces(self, node: WbtNode, pose: Array, color: str | None, name: str) -> Iterator[SceneSolid]:
        """Yield the connected parts of an IndexedFaceSet; its polygons become fans of triangles."""
        numbers = (node.node("coord") or WbtNode("Coordinate")).values("point")
        points = np.array(numbers[: len(numbers) // 3 * 3]).reshape(-1, 3)
        corners: list[int] = []
        fans: list[list[int]] = []
        for index in (int(value) for value in (*node.values("coordIndex"), -1.0)):
            if index >= 0:
                corners.append(index)
                continue
            fans += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
            corners = []
        if not fans or max(map(max, fans)) >= len(points):
            self.scene.tell(
                Fate.LEFT_OUT, node.kind, name, "it has no faces, or a face with a point that does not exist"
            )
            return
        rigid, scale = _rigid(pose)
        order = slice(None, None, -1 if np.prod(scale) < 0.0 else 1)
        for vertices, faces in parts_of(points[np.array(fans)] * scale):
            yield boxed(SceneSolid("mesh", (), rigid, color, vertices, faces[:, order]))


def _pose(node: WbtNode) -> Array:
    """Return translation, rotation and scale of a node, shape (4, 4) [m].

    Raises:
        ValueError: A scale is 0.
    """
    from scipy.spatial.transform import Rotation

    pose, scale = _shift(node.numbers("translation", (0.0, 0.0, 0.0))), node.numbers("scale", (1.0, 1.0, 1.0))
    if 0.0 in scale:
        raise ValueError(f"{node.kind} '{node.text('name')}' has a scale of 0; it must not be 0")
    x, y, z, angle = node.numbers("rotation", (0.0, 0.0, 1.0, 0.0))
    length = math.hypot(x, y, z)
    if length > 0.0:
        pose[:3, :3] = Rotation.from_rotvec(np.array([x, y, z]) * (angle / length)).as_matrix()
    pose[:3, :3] *= scale
    return pose


def _rigid(pose: Array) -> tuple[Array, Array]:
    """Return a pose without the scales in its columns, and these, the first below 0 if it is mirrored, shape (3,)."""
    scale = np.linalg.norm(pose[:3, :3], axis=0)
    scale[0] *= np.sign(np.linalg.det(pose[:3, :3]))
    rigid = pose.copy()
    rigid[:3, :3] /= scale
    return rigid, scale


def _plain(
    kind: Literal["box", "cylinder", "sphere"], size: Sequence[float], pose: Array, color: str | None
) -> SceneSolid:
    """Return a solid of some size at a pose with scales."""
    rigid, scale = _rigid(pose)
    x, y, z = np.abs(scale).tolist()
    factors = {"box": (x, y, z), "cylinder": (max(x, y), z), "sphere": (max(x, y, z),)}[kind]
    return SceneSolid(kind, tuple(a * b for a, b in zip(size, factors, strict=True)), rigid, color)


def _shift(place: tuple[float, ...]) -> Array:
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


def _color(node: WbtNode) -> str | None:
    """Return the colour of a solid: of its own appearance, or of the first shape in it."""
    for child in [*node.nodes("appearance"), *node.nodes("children")]:
        if child.kind in ("Shape", *GROUPS):
            found = _color(child)
        else:
            found = next(
                (
                    hex_of(each.numbers(key, (0.8, 0.8, 0.8)))
                    for each in (child, *child.nodes("material"))
                    for key in ("baseColor", "colorOverride", "diffuseColor")
                    if key in each.fields
                ),
                None,
            )
        if found is not None:
            return found
    return None


def _is_flat(node: WbtNode) -> bool:
    """Return whether all visible shapes of a solid are planes, as for a floor."""
    seen = [child for child in node.nodes("children") if child.kind in SEEN]
    shapes = [child.node("geometry") for child in seen if child.kind == "Shape"]
    return len(shapes) == len(seen) and all(shape is None or shape.kind == "Plane" for shape in shapes)


def _mass(physics: WbtNode, solids: Sequence[SceneSolid]) -> float:
    """Return the mass that a Physics node gives some solids [kg]."""
    mass = physics.number("mass", -1.0)
    density = physics.number("density", DENSITY)
    if mass > 0.0:
        return mass
    return (density if density > 0.0 else DENSITY) * sum(8.0 * float(np.prod(solid.half)) for solid in solids)
