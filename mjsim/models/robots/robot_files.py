"""Reads robot files as published by manufacturers: skips and reports missing files, and finds sensors in the text.

Objects in a room must be complete; a robot is accepted as it is. Meshes that are missing or unreadable are left out,
and collision shapes replace them; invalid inertias are repaired. Everything is reported.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from xml.etree import ElementTree

import mujoco
import numpy as np

from mjsim.inventory import Fate, FileItem
from mjsim.models.inertia_repair import mend_guessed, mend_impossible, mend_inertias, mend_weightless
from mjsim.models.lenient_files import INSTEAD, LenientGatherer
from mjsim.models.model_reader import compiled
from mjsim.models.model_sources import ROBOT, Element, ModelFiles, Read
from mjsim.models.robot_meshes import without_shapes
from mjsim.models.robots.drive_tags import SaidDrive, drives_in_tags
from mjsim.models.robots.mjcf_scenes import without_mjcf_rails, without_scenery
from mjsim.models.robots.said_sensors import SaidSensor, said_sensors
from mjsim.models.robots.urdf_joints import freed_wheels, joint_speeds, rolling_wheels, without_limits, without_rails
from mjsim.models.robots.xml_positions import ElementOrigin, PlacedError, element_of, numbered, plainly, starts
from mjsim.models.urdf_repair import firsts, mend_scales, mend_sizes
from mjsim.sentences import Sentence

MAX_RETRIES = 64
"""Maximum number of meshes of a robot that MuJoCo may reject."""
SIDEWAYS = re.compile(r"mecanum|omni|planar_?move|force_based_move", re.IGNORECASE)
"""Plugins that move a robot in all directions."""
GHOST = {"type": "sphere", "size": "0.005", "contype": "0", "conaffinity": "0", "rgba": "0 0 0 0"}
"""Replaces a mesh that is left out, so that its mass stays."""


@dataclass(frozen=True, slots=True, eq=False)
class RobotFiles:
    """A robot's file with all files that it names, ready to compile."""

    files: ModelFiles
    model: mujoco.MjModel
    sensors: tuple[SaidSensor, ...]
    driven: frozenset[str]
    """Names of joints with a motor."""
    speeds: Mapping[str, float]
    """Maximum speeds of joints, where the file states them [rad/s] or [m/s]."""
    notes: tuple[str, ...]
    """Notes on what was repaired."""
    items: tuple[FileItem, ...] = ()
    """What was left out or simplified."""
    unlimited: frozenset[str] = frozenset()
    """Names of hinges with limits of 0 to 0, which mean none."""
    drives: tuple[SaidDrive, ...] = ()
    """What plug-ins and ros2_control state about its drive."""
    sideways: str = ""
    """Name of the plugin of a simulator or of ros2_control that also moves it sideways; '' if there is none."""


def gather_robot(path: str, read: Read, *, up_axis: bool = True) -> RobotFiles:
    """Return a robot's file with all files that it names.

    Args:
        path: The MJCF or URDF file.
        read: Returns files.
        up_axis: Whether Collada is turned as its `<up_axis>` says; Gazebo does not turn it.

    Raises:
        ValueError: It is not a robot that MuJoCo can read; the message names the file.
    """
    gatherer = _RobotGatherer(path, read, up_axis=up_axis)
    root = gatherer.parse(path)
    if root.tag == "mujoco":
        gatherer.put_includes_in(root, 0)
    cleared = [*firsts(root, path), *without_scenery(root, path), *without_mjcf_rails(root, path)]
    sensors = said_sensors(root)
    driven, sideways, drives = frozenset(_driven(root)), _sideways(root), tuple(drives_in_tags(root))
    speeds, unlimited = dict(joint_speeds(root)), without_limits(root)
    mended = [*mend_scales(root), *mend_sizes(root, path), *rolling_wheels(root, path), *mend_weightless(root, path)]
    mended += [*without_rails(root, path), *freed_wheels(root, path), *mend_inertias(root, path)]
    gatherer.keep(root, ROBOT)
    _allow_light_links(root)
    gatherer.leave_out(root)
    # One element per line, so that line numbers in MuJoCo's errors identify the element.
    ElementTree.indent(root)
    files = ModelFiles(root, gatherer.assets, tuple(gatherer.paths), frozenset(gatherer.sums))
    mended += mend_guessed(root, path, partial(_compiled, files, gatherer))
    model = _compiled(files, gatherer)
    if beyond := [*mend_impossible(root, path, model)]:
        mended += beyond
        model = _compiled(files, gatherer)
    _check_finite(model, path)
    speeds |= dict(_servo_speeds(model))
    return RobotFiles(
        files, model, sensors, driven, speeds, (*cleared, *mended), tuple(gatherer.items()), unlimited, drives, sideways
    )


class _RobotGatherer(LenientGatherer):
    """Reads the files of a robot, and tells where in them MuJoCo found an error."""

    def __init__(self, path: str, read: Read, *, up_axis: bool) -> None:
        super().__init__(path, read, up_axis=up_axis)
        self._origins: dict[Element, ElementOrigin] = {}

    def parse(self, path: str) -> Element:
        """Return the root of an XML file, and store the positions of its elements."""
        root = super().parse(path)
        self._origins |= numbered(root, path)
        return root

    def placed(self, error: str, root: Element) -> PlacedError | None:
        """Return MuJoCo's error with its position in the files; None if it names none."""
        element = element_of(error, root)
        origin = self._origins.get(element) if element is not None else None
        if element is None or origin is None:
            return None
        begun = starts(super().file(origin.path))
        if origin.number >= len(begun):
            return None
        return PlacedError(origin.path, begun[origin.number], plainly(error.partition("': ")[2] or error, element))

    def drop(self, flat: str) -> None:
        """Leave out a mesh that MuJoCo rejects."""
        self._amiss.append(FileItem(Fate.LEFT_OUT, "mesh", flat, f"MuJoCo cannot read it; {INSTEAD['mesh']}"))
        self.missing.add(flat)
        del self.assets[flat]

    def leave_out(self, root: Element) -> None:
        """Remove the elements that refer to files that are left out."""
        if root.tag == "robot":
            without_shapes(root, self.missing)
        else:
            _without_assets(root, self.missing)


def _without_assets(root: Element, missing: set[str]) -> None:
    """Remove MJCF assets that are left out, and replace their geoms by small ones of the same mass."""
    names: set[str] = set()
    for section in root.findall("asset"):
        for item in list(section):
            if any(value in missing for key, value in item.attrib.items() if key.startswith("file")):
                names.add(f"{item.tag}:{item.get('name', '')}")
                section.remove(item)
    for section in root.findall("asset"):
        for item in section.iter("material"):
            if f"texture:{item.get('texture', '')}" in names:
                del item.attrib["texture"]
    known = {item.get("name") for section in root.findall("asset") for item in section.iter("mesh")}
    for body in root.iter():
        lost = [geom for geom in body.findall("geom") if geom.get("mesh") is not None and geom.get("mesh") not in known]
        for geom in lost:
            for key in ("mesh", "fitscale", "material"):
                geom.attrib.pop(key, None)
            geom.attrib.update(GHOST)
        for geom in body.findall("geom") if lost else ():
            if geom not in lost:
                geom.set("group", "0")


def _allow_light_links(root: Element) -> None:
    """Make MuJoCo give massless frames the minimum mass."""
    for compiler in (*root.findall("compiler"), *root.findall("mujoco/compiler")):
        compiler.set("boundmass", "1e-6")
        compiler.set("boundinertia", "1e-10")
        compiler.set("balanceinertia", "true")


def _compiled(files: ModelFiles, gatherer: _RobotGatherer) -> mujoco.MjModel:
    """Return the compiled robot, without the meshes that MuJoCo rejects."""
    for _ in range(MAX_RETRIES):
        try:
            return compiled(files)
        except ValueError as error:
            flat = _rejected(files, str(error))
            if flat is None:
                raise gatherer.placed(str(error), files.root) or error from None
            if files.urdf or not _as_shell(files.root, flat):
                gatherer.drop(flat)
            gatherer.leave_out(files.root)
    return compiled(files)


def _rejected(files: ModelFiles, error: str) -> str | None:
    """Return the asset that an error of MuJoCo is about: that of the element it names, or one named in its text."""
    element = element_of(error, files.root)
    flat = element.get("file") if element is not None and element.tag == "mesh" else None
    return flat or next((name for name in files.assets if name.rpartition(".")[0] in error), None)


def _as_shell(root: Element, flat: str) -> bool:
    """Compute a mesh's mass from its surface, which need not be closed; return whether this is a change."""
    for mesh in root.iter("mesh"):
        if mesh.get("file") == flat and mesh.get("inertia") != "shell":
            mesh.set("inertia", "shell")
            return True
    return False


def _driven(root: Element) -> Iterator[str]:
    """Yield the joints with a motor: from actuators in MJCF, from transmissions and ros2_control in URDF."""
    for actuator in root.findall("actuator/*"):
        yield actuator.get("joint") or actuator.get("jointinparent") or ""
    for transmission in root.findall("transmission"):
        yield from (joint.get("name", "") for joint in transmission.iter("joint"))
    for joint in root.iterfind("ros2_control/joint"):
        if joint.find("command_interface") is not None:
            yield joint.get("name", "")
    for gazebo in root.iter("gazebo"):
        # Gazebo's drives name their joints in elements of many spellings.
        for item in gazebo.iter():
            if "joint" in item.tag.lower() and item.text and len(item.text) < 200:
                yield item.text.strip()


def _check_finite(model: mujoco.MjModel, path: str) -> None:
    """Raise ValueError if a part has a position that is not finite."""
    bad = np.flatnonzero(~np.isfinite(model.body_pos).all(axis=1))
    if len(bad):
        raise ValueError(
            Sentence("'{path}': the position of '{name}' is not finite; correct it", path, model.body(int(bad[0])).name)
        )


def _servo_speeds(model: mujoco.MjModel) -> Iterator[tuple[str, float]]:
    """Yield the maximum speeds of joints with velocity servos in MJCF."""
    for number in range(model.nu):
        moves_joint = int(model.actuator_trntype[number]) == int(mujoco.mjtTrn.mjTRN_JOINT)
        # The force of a velocity servo is gain * (command - gear * speed).
        gain, damping = float(model.actuator_gainprm[number, 0]), -float(model.actuator_biasprm[number, 2])
        gear, top = abs(float(model.actuator_gear[number, 0])), float(model.actuator_ctrlrange[number, 1])
        if model.actuator_biasprm[number, 1] != 0.0:
            continue  # a position servo
        if moves_joint and model.actuator_ctrllimited[number] and damping > 0.0 and gear > 0.0 and top > 0.0:
            yield model.joint(int(model.actuator_trnid[number, 0])).name, gain / damping * top / gear


def _sideways(root: Element) -> str:
    """Return the name of a plugin that moves a robot sideways as well."""
    names = (plugin.get(key, "") for plugin in root.iter("plugin") for key in ("filename", "name"))
    return next((name for name in names if SIDEWAYS.search(name)), "")


def robot_text(files: ModelFiles) -> str:
    """Return the indented text of a robot, which reads back the same with its assets beside it."""
    root = ElementTree.fromstring(ElementTree.tostring(files.root))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
