"""A robot of Gazebo (SDF) as URDF: links, joints, sensors and plug-ins of a model and of the models in it.

References:
    SDFormat specification 1.12, http://sdformat.org/spec; URDF, http://wiki.ros.org/urdf/XML
"""

import copy
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.robots.sdf_tree import WORLD, Branch, SdfJoint, branches
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem
from mjsim.mechanics import inverted, rpy_of
from mjsim.models import (
    MAX_HINGE_LIMIT,
    SdfFrames,
    axis_of,
    color_of,
    finite_number,
    floats,
    has_joint_frames,
    is_robot,
    link_named,
    mesh_of,
    sizes_of,
)

Opened = Callable[[str], tuple[Element, str] | None]
"""Returns the root of the SDF file that a URI names, and the URI of its folder; None if it cannot be read."""
MAX_NESTED = 12
"""Maximum nesting of models."""
AXES = {"revolute": 1, "continuous": 1, "prismatic": 1, "revolute2": 2, "universal": 2}
"""Joints that URDF can have -> number of their axes."""
KNOWN = {"link", "joint", "plugin", "model", "include", "pose", "frame", "static", "self_collide", "enable_wind"}
KNOWN |= {"allow_auto_disable"}
"""Elements of a model that are read, or mean nothing here."""
TENSOR = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """A model, which may be nested in another."""

    element: Element
    frames: SdfFrames
    robot_from_model: Array
    """Shape (4, 4) [m]."""
    names: str = ""
    """Prefix of the names of its parts."""
    folder: str = ""
    """URI of its folder; '' for the folder of the robot."""
    depth: int = 0

    def named(self, name: str) -> str:
        """Return the name that a part of this model has in the whole robot."""
        return self.names + name.strip().replace("::", "_")


@dataclass(frozen=True, slots=True, eq=False)
class _Link:
    element: Element
    model: _Model

    def pose(self) -> Array:
        return np.asarray(self.model.robot_from_model @ self.model.frames.pose_of(self.element))

    def pose_in(self, part: Element, where: str) -> Array:
        return np.asarray(self.model.robot_from_model @ self.model.frames.pose_in(self.element, part, where))


def urdf_of_sdf(root: Element, where: str, opened: Opened, *, model: str = "") -> tuple[str, list[FileItem]]:
    """Return the URDF of the robot in an SDF file, and what was guessed or left out.

    Args:
        root: Root of the file.
        where: Its path, for messages.
        opened: Returns included models.
        model: Name of the robot, if there are several.

    Raises:
        UsageError: The file has no such robot or several, or something that is not valid SDF.
    """
    maker = _Maker(where, opened, has_joint_frames(root))
    robot, folder = maker.robot_in(root, model)
    maker.take(robot, np.eye(4), _Model(robot, maker.frames(robot), np.eye(4), folder=folder))
    return tostring(maker.urdf(robot.get("name", "robot")), encoding="unicode"), maker.items


@dataclass(slots=True)
class _Maker:
    """Collects the parts of a robot, and writes them as URDF."""

    where: str
    opened: Opened
    modern: bool
    items: list[FileItem] = field(default_factory=list)
    links: dict[str, _Link] = field(default_factory=dict)
    joints: list[SdfJoint] = field(default_factory=list)
    plugins: list[Element] = field(default_factory=list)

    def robot_in(self, root: Element, name: str) -> tuple[Element, str]:
        """Return the model of this name, the only one of a file, or the only robot in its world; and its folder's URI.

        Raises:
            UsageError: There is none, or there are several.
        """
        models = [(model, "") for model in root.findall("model")]
        worlds = [child for world in root.findall("world") for child in world]
        robots = models if len(models) == 1 else []
        for tag in ("model", "include") if not robots else ():
            found = [self._opened(child, "") for child in worlds if child.tag == tag]
            models += [each for each in found if each is not None]
            robots = robots or [(model, folder) for model, folder in models if is_robot(model)]
        # The user may choose a model that does not look like a robot.
        chosen = [each for each in models if each[0].get("name") == name] if name else robots
        if len(chosen) != 1:
            names = [model.get("name", "?") for model, _ in robots or models]
            what = "robots in it" if robots or not names else "no robot is in it, but models"
            advice = "choose one with --model NAME" if names else "name another file"
            raise UsageError(f"{self.where}: {what}: {', '.join(names[:5]) or 'none'}; {advice}")
        return chosen[0]

    def frames(self, element: Element) -> SdfFrames:
        """Return the frames of a model."""

        def inner(child: Element) -> SdfFrames | None:
            found = self._opened(child, "")
            return None if found is None else self.frames(found[0])

        return SdfFrames(element, self.where, inner)

    def _opened(self, element: Element, folder: str) -> tuple[Element, str] | None:
        """Return the model in an element, which may include a file, and the URI of its folder."""
        if element.tag == "model":
            return element, folder
        found = self.opened((element.findtext("uri") or "").strip())
        model = None if found is None else found[0].find("model")
        return None if found is None or model is None else (model, found[1])

    def take(self, element: Element, robot_from_model: Array, model: _Model) -> None:
        """Take the parts of a model, and of the models in it."""
        if model.depth > MAX_NESTED:
            raise UsageError(f"{self.where}: models are nested more than {MAX_NESTED} deep; is it a loop?")
        for link in element.findall("link"):
            self.links[model.named(link.get("name", ""))] = _Link(link, model)
        for child in element:
            if child.tag in ("model", "include"):
                self._nested(child, model)
            elif child.tag == "plugin":
                self.plugins.append(_renamed(child, model))
            elif child.tag not in KNOWN:
                self._left_out(f"<{child.tag}>", model.named(child.get("name", "")), "no such part of a robot in mjsim")
        self.joints += [self._joint(joint, model) for joint in element.findall("joint")]

    def _nested(self, child: Element, outer: _Model) -> None:
        found = self._opened(child, outer.folder)
        uri = (child.findtext("uri") or "").strip()
        if found is None:
            why = "not found; put its folder beside the robot's, or in a folder of GAZEBO_MODEL_PATH"
            self._left_out("included model", uri, why)
            return
        model, folder = found
        own = (child.findtext("name") or "").strip() or child.get("name") or model.get("name") or ""
        merged = child.get("merge") in ("true", "1")
        names = outer.names if merged else f"{outer.named(own)}_"
        placed = model if child.tag == "include" and child.find("pose") is None else child
        pose = outer.robot_from_model @ outer.frames.pose_of(placed)
        self.take(model, pose, _Model(model, self.frames(model), pose, names, folder, outer.depth + 1))

    def _joint(self, joint: Element, model: _Model) -> SdfJoint:
        """Return a joint with its axes in the frame of the robot."""
        name, kind = joint.get("name", ""), joint.get("type", "")
        parent, child = (self._link_of(joint.findtext(end) or "", model) for end in ("parent", "child"))
        # A joint at a link that does not exist has no pose; this is reported when its links are checked.
        own = model.frames.pose_of(joint) if child in self.links else np.eye(4)
        for sensor in joint.findall("sensor"):
            self._left_out(f"{sensor.get('type', '')} sensor", sensor.get("name", ""), "mjsim has no sensor in joints")
        axes = [each for tag in ("axis", "axis2") for each in joint.findall(tag)][: AXES.get(kind, 0)]
        vectors = [self._axis(axis, model, own, f"{self.where}: joint '{name}': axis") for axis in axes]
        return SdfJoint(model.named(name), kind, parent, child, model.robot_from_model @ own, axes, vectors)

    def _axis(self, axis: Element, model: _Model, pose: Array, where: str) -> Array:
        """Return an axis in the frame of the robot; `pose` is that of its joint in the model."""
        own = axis_of(axis, model.frames, pose, where, in_joint=self.modern)
        return np.asarray(model.robot_from_model[:3, :3] @ own)

    def _link_of(self, name: str, model: _Model) -> str:
        """Return the link that the end of a joint names; 'world' for the world."""
        found = link_named(model.element, name)
        return WORLD if found == WORLD else model.named(found)

    def urdf(self, name: str) -> Element:
        """Return the robot as URDF."""
        robot = Element("robot", name=name)
        tree, items = branches(self.links, self.joints)
        self.items += items
        inward = {tree[0].link: np.eye(4)} if tree else {}
        for branch in tree:
            joint = branch.joint
            if joint is not None:
                inward[branch.link] = inverted(joint.pose if joint.axes else self.links[branch.link].pose())
                robot.extend(_joints(branch, inward))
        bare = [each.link for each in tree if self._add_link(robot, each.link, inward[each.link])]
        for link in bare:
            self.items.append(FileItem(Fate.GUESSED, "mass of link", link, "0, as none is stated; Gazebo takes 1 kg"))
        robot.extend(_gazebo(self.plugins))
        return robot

    def _add_link(self, robot: Element, name: str, urdf_from_robot: Array) -> bool:
        """Add a link and its sensors; return whether it has shapes but no mass."""
        link, made = self.links[name], SubElement(robot, "link", name=name)
        mass = _inertial(made, link, urdf_from_robot, f"{self.where}: link '{name}'")
        for tag in ("visual", "collision"):
            for part in link.element.findall(tag):
                self._shapes(made, link, part, urdf_from_robot)
        sensors = [copy.deepcopy(sensor) for sensor in link.element.findall("sensor")]
        for sensor in sensors:
            pose = urdf_from_robot @ link.pose_in(sensor, f"{self.where}: sensor '{sensor.get('name', '')}'")
            for old in sensor.findall("pose"):
                sensor.remove(old)
            SubElement(sensor, "pose").text = _text([*pose[:3, 3], *rpy_of(pose)])
        robot.extend(_gazebo(sensors, reference=name))
        for light in link.element.findall("light"):
            self._left_out("light", light.get("name", ""), "mjsim has no lamps on robots")
        return not mass and link.element.find("collision") is not None

    def _shapes(self, made: Element, link: _Link, part: Element, urdf_from_robot: Array) -> None:
        """Add a visual or a collision to a link of URDF."""
        name = part.get("name", "")
        where = f"{self.where}: {part.tag} '{name}'"
        pose = urdf_from_robot @ link.pose_in(part, where)
        for shape in part.findall("geometry/*"):
            keys = self._shape_keys(shape, link, name, where)
            if keys is None:
                continue
            item = SubElement(made, part.tag)
            _add_origin(item, pose)
            SubElement(SubElement(item, "geometry"), shape.tag, keys)
            if part.tag == "visual":
                self._paint(item, part, name)

    def _shape_keys(self, shape: Element, link: _Link, name: str, where: str) -> dict[str, str] | None:
        """Return the attributes of a shape in URDF; None if URDF has no such shape."""
        if shape.tag == "box":
            return {"size": _text(sizes_of(shape, where))}
        if shape.tag in ("cylinder", "capsule", "sphere"):
            return dict(zip(("radius", "length"), map(repr, sizes_of(shape, where)), strict=False))
        if shape.tag == "mesh":
            uri, scale = mesh_of(shape, where)
            if not uri:
                self._left_out("mesh", name, "it names no file; give it a <uri>")
                return None
            if shape.find("submesh") is not None:
                self._left_out("mesh part", shape.findtext("submesh/name") or uri, "mjsim uses only whole meshes")
                return None
            return {"filename": uri if "://" in uri else link.model.folder + uri, "scale": _text(scale)}
        if shape.tag != "empty":
            self._left_out(f"shape <{shape.tag}>", name, "a robot has boxes, cylinders, capsules, spheres and meshes")
        return None

    def _paint(self, item: Element, part: Element, name: str) -> None:
        """Give a visual of URDF the colour of its original in SDF."""
        if part.find("material//albedo_map") is not None or part.find("material//texture") is not None:
            self._left_out("texture", name, "its colour is kept")
        color = color_of(part)
        if color is not None:
            rgba = [*(int(color[k : k + 2], 16) / 255 for k in (1, 3, 5)), 1.0]
            SubElement(SubElement(item, "material", name=f"sdf {color}"), "color", rgba=_text(rgba))

    def _left_out(self, kind: str, name: str, why: str) -> None:
        self.items.append(FileItem(Fate.LEFT_OUT, kind, name, why))


def _joints(branch: Branch, inward: dict[str, Array]) -> Iterator[Element]:
    """Yield the joints of URDF that carry a link: one for each axis, with links between, and a fixed one for none."""
    joint = branch.joint
    assert joint is not None, "the root has none"
    outer = inward[branch.parent] @ inverted(inward[branch.link])
    axes: list[tuple[Element | None, Array | None]] = list(zip(joint.elements, joint.axes, strict=True))
    axes = axes[:: -1 if branch.backward else 1] or [(None, None)]
    above = branch.parent
    for number, (element, axis) in enumerate(axes):
        last = number == len(axes) - 1
        name = joint.name if number == 0 else f"{joint.name}_{number + 1}"
        below = branch.link if last else f"{joint.name}_between"
        made = Element("joint", name=name, type="fixed")
        SubElement(made, "parent", link=above)
        SubElement(made, "child", link=below)
        _add_origin(made, outer if number == 0 else np.eye(4))
        if element is not None and axis is not None:
            turned = (inward[branch.link][:3, :3] @ axis) * (-1.0 if branch.backward else 1.0)
            SubElement(made, "axis", xyz=_text(turned))
            _limit(made, element, slides=joint.kind == "prismatic")
        yield made
        if not last:
            yield Element("link", name=below)
        above = below


def _limit(made: Element, axis: Element, *, slides: bool) -> None:
    """Give a joint of URDF its type and limits."""
    found = {key: finite_number(axis.findtext(f"limit/{key}")) for key in ("lower", "upper", "velocity", "effort")}
    lower, upper = found["lower"], found["upper"]
    endless = lower is None or upper is None or max(abs(lower), abs(upper)) > MAX_HINGE_LIMIT
    made.set("type", "prismatic" if slides else "continuous" if endless else "revolute")
    keys = {key: repr(value) for key, value in found.items() if value is not None and abs(value) < 1e15}
    if endless:
        keys = {key: value for key, value in keys.items() if key not in ("lower", "upper")}
    if keys:
        SubElement(made, "limit", keys)


def _inertial(made: Element, link: _Link, urdf_from_robot: Array, where: str) -> bool:
    """Give a link of URDF its mass and inertia; return whether the file states a mass."""
    inertial = link.element.find("inertial")
    mass = None if inertial is None else inertial.findtext("mass")
    if inertial is None or mass is None:
        return False
    item = SubElement(made, "inertial")
    _add_origin(item, urdf_from_robot @ link.pose_in(inertial, where))
    SubElement(item, "mass", value=repr(floats(mass, 1, f"{where}: mass")[0]))
    inertia = inertial.find("inertia")
    if inertia is not None:
        values = {key: floats(inertia.findtext(key, "0"), 1, f"{where}: {key}")[0] for key in TENSOR}
        SubElement(item, "inertia", {key: repr(value) for key, value in values.items()})
    return True


def _renamed(plugin: Element, model: _Model) -> Element:
    """Return a plug-in that names its joints as in the whole robot."""
    copied = copy.deepcopy(plugin)
    for item in copied.iter():
        if "joint" in item.tag.lower() and item.text and item.text.strip():
            item.text = model.named(item.text)
    return copied


def _gazebo(parts: Sequence[Element], **keys: str) -> Iterator[Element]:
    """Yield a `<gazebo>` with parts, if there are any."""
    if parts:
        gazebo = Element("gazebo", keys)
        gazebo.extend(parts)
        yield gazebo


def _add_origin(element: Element, pose: Array) -> None:
    SubElement(element, "origin", xyz=_text(pose[:3, 3]), rpy=_text(rpy_of(pose)))


def _text(numbers: Sequence[float] | Array) -> str:
    return " ".join(f"{float(number):.12g}" for number in numbers)
