"""Reads arms from MJCF and URDF files: the chain of joints, masses, motors and shapes, as plain numbers.

The file's actuators and springs are ignored: each joint gets a torque motor with the limits in the file, unless it is
coupled to another one. Joints outside the chain are rigid.
"""

import posixpath
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType

import mujoco
import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.inventory import Fate, FileItem, inventory
from mjsim.models.arms.arm_checks import ArmFileError, check_joints, check_numbers, checked_inertias
from mjsim.models.arms.arm_couplings import JointCoupling, coupled, equalities, mimics
from mjsim.models.arms.arm_motors import Motors, motors_of
from mjsim.models.arms.arm_tree import ArmTree, carried_by, chain_to, tree_of
from mjsim.models.arms.arm_xacro import expanded
from mjsim.models.inertia_repair import mend_guessed, mend_impossible
from mjsim.models.lenient_files import LenientGatherer
from mjsim.models.model_reader import compiled
from mjsim.models.model_sources import ROBOT, Element, ModelFiles, Read
from mjsim.models.proven import one_trial_child
from mjsim.models.rigid import weighed
from mjsim.models.robot_meshes import without_shapes
from mjsim.models.rotations import frame_at
from mjsim.models.urdf_repair import firsts, mend_scales, mend_sizes
from mjsim.sentences import Sentence

MIN_MASS = 1e-9
"""A link with a smaller mass counts as one without mass in its file [kg]."""
ENDS = ("tcp", "tool0", "tool", "attachment_site", "end_effector", "eef", "ee", "flange")
TOOLS = [re.compile(rf"(^|_){word}(_link|_frame)?$") for word in ENDS]
"""Names of the frame at the end of an arm, in order of precedence."""
ELEMENT_NAME = re.compile(r"(?:Element name|mesh|joint) '([^']+)'")
"""How MuJoCo names the element that it rejects."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FileLink:
    """A joint of the file and the body that it moves; frames have shape (4, 4) [m]."""

    name: str
    """Name of the joint."""
    parent: int
    """Index of the link that carries it, -1 for the base."""
    before: Array
    """Frame of the joint at value 0 in that of the carrying link; it rotates about z, or slides along z."""
    after: Array
    """Frame of the link, which is that of its body, in that of the joint."""
    slide: bool
    bounds: tuple[float, float]
    """Limits [rad, m]; infinite if there are none."""
    mass: float | None
    """Mass [kg]; None if the file has none."""
    center: Array
    """Centre of mass, frame of the link, shape (3,) [m]."""
    inertia: Array
    """Inertia about the centre of mass, shape (3, 3) [kg m^2]."""
    armature: float
    damping: float
    friction: float
    max_torque: float
    max_velocity: float


@dataclass(frozen=True, slots=True, eq=False)
class FileShape:
    """The pose of a geom in the file."""

    number: int
    link: int
    """Index of the link that carries it, -1 for the base."""
    pose: Array
    """Frame of the geom in that of the link, shape (4, 4) [m]."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FileArm:
    """An arm as in its file."""

    files: ModelFiles
    model: mujoco.MjModel
    """The model that MuJoCo compiles from the files."""
    links: tuple[FileLink, ...]
    end: int
    """Index of the link that carries the flange."""
    flange: Array
    """Frame of the flange in that of this link, shape (4, 4) [m]."""
    shapes: tuple[FileShape, ...]
    base: tuple[float, Array, Array]
    """Mass [kg], centre (3,) [m] and inertia about it (3, 3) [kg m^2] of the parts that no joint moves."""
    apart: frozenset[tuple[int, int]]
    """Pairs of links that may pass through each other."""
    couplings: tuple[tuple[int, int, float, float], ...]
    """Index of a link whose joint another one moves, index of that one, ratio and offset [rad, m]."""
    notes: tuple[str, ...]
    """Notes on what was assumed."""
    changed: tuple[str, ...]
    """Notes on what was repaired or left out."""


def read_arm(
    path: str, read: Read, end: str | None = None, arguments: Mapping[str, str] = MappingProxyType({})
) -> FileArm:
    """Return the arm of a file.

    Args:
        path: An MJCF or URDF file, as accepted by `read`.
        read: Returns a file by its path relative to the folder of the world.
        end: Body, site or joint at the end of the chain; may be omitted if unambiguous.
        arguments: Values of `xacro:arg`, for a file with xacro.

    Raises:
        ValueError: The file cannot be read, or is not an arm; the message names it.
    """
    gatherer = _ArmGatherer(path, read, arguments)
    root = gatherer.parse(path)
    if root.tag == "mujoco":
        gatherer.put_includes_in(root, 0)
    check_joints(root, path)
    check_numbers(root, path)
    repairs = (*firsts(root, path), *mend_scales(root), *mend_sizes(root, path))
    changed = [*(note.replace(f"{path}: ", "", 1) for note in repairs), *checked_inertias(root, path)]
    motors, couplings = motors_of(root), [*mimics(root)]
    gatherer.keep(root, ROBOT)
    if root.tag == "robot":
        without_shapes(root, gatherer.missing)
    for compiler in (*root.findall("compiler"), *root.findall("mujoco/compiler")):
        # Massless links are checked later; MuJoCo rejects them.
        compiler.set("boundmass", str(1e-3 * MIN_MASS))
        compiler.set("boundinertia", str(1e-3 * MIN_MASS))
    files = ModelFiles(root, gatherer.assets, tuple(gatherer.paths), frozenset(gatherer.sums))
    changed += [note.removeprefix(f"{path}: ") for note in mend_guessed(root, path, partial(_compiled, files))]
    model = _compiled(files)
    if beyond := [*mend_impossible(root, path, model)]:
        changed += [note.removeprefix(f"{path}: ") for note in beyond]
        model = _compiled(files)
    tree = tree_of(model)
    last, flange, found = _end(model, tree, path, end)
    changed += inventory(gatherer.items())
    notes = [f"flange: at '{found}', chosen by its name; name another frame with end"] if found else []
    couplings += equalities(model)
    return _arm(files, model, tree, last, flange, motors, couplings, notes, changed)


class _ArmGatherer(LenientGatherer):
    """Reads the files of an arm: those of MJCF must all exist, as for MuJoCo."""

    def __init__(self, path: str, read: Read, arguments: Mapping[str, str]) -> None:
        super().__init__(path, read, guarded=True)
        self._main, self._arguments = path, arguments
        self._absent: tuple[tuple[str, str], ...] = ()

    def file(self, path: str) -> bytes:
        """Return a file; that of the arm with its xacro expanded."""
        data = super().file(path)
        if path != self._main or not (path.lower().endswith(".xacro") or self._arguments):
            return data
        found = expanded(path, data, self._arguments, resolve=self._from_root, contents=super().file)
        self._absent = found.missing
        return found.text.encode()

    def _from_root(self, name: str) -> str:
        """Return the path of a file that xacro names, by its path from the root or in a package."""
        return self._resolved(name) if "://" in name else posixpath.normpath(name)

    def keep_urdf(self, root: Element) -> None:
        """Keep only the elements that make up a robot, with meshes that MuJoCo reads."""
        with one_trial_child():
            super().keep_urdf(root)

    def _gone(self, name: str, error: ValueError, kind: str = "mesh") -> str:
        if not self._urdf:
            raise error
        return super()._gone(name, error, kind)

    def items(self) -> Iterator[FileItem]:
        """Yield what was left out or simplified."""
        yield from super().items()
        yield from (FileItem(Fate.LEFT_OUT, "include", place, why) for place, why in self._absent)


def _compiled(files: ModelFiles) -> mujoco.MjModel:
    """Return the compiled model; errors name the element concerned."""
    try:
        return compiled(files)
    except ValueError as error:
        message = str(error)
        found = ELEMENT_NAME.search(message)
        # Line numbers refer to the text passed to MuJoCo, not to the file.
        raise ArmFileError(re.sub(r",? (Element '\w+', )?line \d+$", "", message), found[1] if found else "") from None


def _end(model: mujoco.MjModel, tree: ArmTree, path: str, end: str | None) -> tuple[int, Array, str]:
    """Return the body at the end of the chain, which a joint moves, and the flange's frame in it, shape (4, 4).

    Also returned is the name of the frame that was chosen as flange by its name; '' if none was.
    """
    if not tree.moving:
        raise ArmFileError(Sentence("'{path}' has no joint that turns or slides; an arm has at least one", path))
    if end is None:
        last, branches = chain_to(tree)
        if branches:
            names = ", ".join(f"'{model.body(body).name}'" for body in branches)
            branched = "'{path}' branches, to {names}; name the body that carries the tool by end, or --end"
            raise ArmFileError(Sentence(branched, path, names))
        frame = _tool_frame(model, tree, last)
        return (last, np.eye(4), "") if frame is None else (*_placed(model, tree, *frame[:2]), frame[2])
    for kind, count in (("body", model.nbody), ("site", model.nsite), ("joint", model.njnt)):
        for number in range(count):
            if getattr(model, kind)(number).name == end:
                root, flange = _placed(model, tree, kind, number)
                if not root:
                    still = "'{end}' of '{path}' does not move with any joint; name what the last joint moves"
                    raise ArmFileError(Sentence(still, end, path), end)
                return root, flange, ""
    known = [model.body(n).name for n in range(1, model.nbody)] + [model.site(n).name for n in range(model.nsite)]
    raise ArmFileError(
        Sentence("'{path}' has no body or site '{end}'{did_you_mean}", path, end, did_you_mean(end, known))
    )


def _tool_frame(model: mujoco.MjModel, tree: ArmTree, last: int) -> tuple[str, int, str] | None:
    """Return kind, number and name of the frame on the last link with the name of a tool frame; None without one."""
    frames = [("body", number, model.body(number).name) for number in tree.bodies_of(last) if number != last]
    frames += [
        ("site", number, model.site(number).name)
        for number in range(model.nsite)
        if tree.root_of[int(model.site_bodyid[number])] == last
    ]
    for word in TOOLS:
        for frame in frames:
            if word.search(frame[2]):
                return frame
    return None


def _placed(model: mujoco.MjModel, tree: ArmTree, kind: str, number: int) -> tuple[int, Array]:
    """Return the moving body that carries an element, and the element's frame in it, shape (4, 4)."""
    body, pose = _named(model, tree.data, kind, number)
    root = tree.root_of[body]
    return root, _inverse(tree.frame(root)) @ pose


def _named(model: mujoco.MjModel, data: mujoco.MjData, kind: str, number: int) -> tuple[int, Array]:
    """Return the body to which an element belongs, and the element's frame, shape (4, 4)."""
    if kind == "site":
        return int(model.site_bodyid[number]), frame_at(data.site_xpos[number], data.site_xmat[number])
    body = number if kind == "body" else int(model.jnt_bodyid[number])
    return body, frame_at(data.xpos[body], data.xmat[body])


def _arm(
    files: ModelFiles,
    model: mujoco.MjModel,
    tree: ArmTree,
    last: int,
    flange: Array,
    motors: Motors,
    couplings: Sequence[JointCoupling],
    notes: list[str],
    changed: Sequence[str],
) -> FileArm:
    chain, fingers = tree.path_to(last), carried_by(tree, last)
    active = [*chain, *fingers]
    if held := [body for body in tree.moving if body not in active]:
        notes.append(f"rigid: {len(held)} joints outside the chain")
    if (model.jnt_stiffness > 0.0).any():
        notes.append("left out: springs of joints")
    tree = tree.with_rigid(held)
    links, number_of = _links(model, tree, active, motors)
    if bare := [link.name for link in links if link.mass is None]:
        notes.append(f"no mass: links of {', '.join(bare)}; capsules of 1000 kg/m^3 instead")
    pairs = coupled(couplings, [link.name for link in links])
    for moved, moving, ratio, offset in pairs:
        more = f" + {offset:g}" if offset else ""
        notes.append(f"coupled: '{links[moved].name}' is {ratio:g} times '{links[moving].name}'{more}")
    if len(pairs) < model.neq + model.ntendon + len(couplings) - len([*equalities(model)]):
        notes.append("left out: other couplings of joints, each has a motor of its own")
    still = [body for body in range(1, model.nbody) if not tree.root_of[body]]
    return FileArm(
        files=files,
        model=model,
        links=tuple(links),
        end=number_of[last],
        flange=flange,
        shapes=tuple(_shapes(model, tree, number_of)),
        base=weighed(model, tree.data, still or [0]),
        couplings=pairs,
        apart=frozenset(_separate_pairs(model, tree, number_of)),
        notes=tuple(notes),
        changed=tuple(changed),
    )


def _links(
    model: mujoco.MjModel, tree: ArmTree, bodies: Sequence[int], motors: Motors
) -> tuple[list[FileLink], dict[int, int]]:
    """Return the links of bodies, and the index of the last link of each body; -1 for the base."""
    links: list[FileLink] = []
    number_of = {0: -1}
    for body in bodies:
        links += _links_of(model, tree, body, number_of[tree.parent_of(body)], len(links), motors)
        number_of[body] = len(links) - 1
    return links, number_of


def _links_of(
    model: mujoco.MjModel, tree: ArmTree, body: int, parent: int, count: int, motors: Motors
) -> Iterator[FileLink]:
    """Yield a link for each joint of a body; if there are several, only the last has the body's mass."""
    ahead = _inverse(tree.frame(tree.parent_of(body))) @ tree.frame(body)
    mass, center, inertia = weighed(model, tree.data, tree.bodies_of(body))
    turn, place = tree.frame(body)[:3, :3], tree.frame(body)[:3, 3]
    joints = tree.joints_of(body)
    for index, joint in enumerate(joints):
        whole = index == len(joints) - 1
        joint_in_body = _axis_frame(model.jnt_pos[joint], model.jnt_axis[joint])
        slide = int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
        dof, start = int(model.jnt_dofadr[joint]), float(model.qpos0[model.jnt_qposadr[joint]])
        low, high = model.jnt_range[joint].tolist() if model.jnt_limited[joint] else (-np.inf, np.inf)
        name = model.joint(joint).name
        yield FileLink(
            name=name or f"joint{count + index + 1}",
            parent=parent if index == 0 else count + index - 1,
            before=ahead @ joint_in_body @ _moved(slide, -start),
            after=_inverse(joint_in_body),
            slide=slide,
            bounds=(low, high),
            mass=0.0 if not whole else mass if mass > MIN_MASS else None,
            center=turn.T @ (center - place) if whole else np.zeros(3),
            inertia=turn.T @ inertia @ turn if whole else np.zeros((3, 3)),
            armature=float(model.dof_armature[dof]),
            damping=float(model.dof_damping[dof]),
            friction=float(model.dof_frictionloss[dof]),
            max_torque=motors.torque(model, joint),
            max_velocity=motors.velocities.get(name, np.inf),
        )
        ahead = np.eye(4)


def _inverse(pose: Array) -> Array:
    """Return inner_from_outer of a rigid outer_from_inner, shape (4, 4)."""
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = pose[:3, :3].T, -pose[:3, :3].T @ pose[:3, 3]
    return result


def _axis_frame(at: Array, axis: Array) -> Array:
    """Return a frame at a point whose z axis is a unit vector, shape (4, 4)."""
    frame = np.eye(4)
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    frame[:3, :3], frame[:3, 3] = np.column_stack([x, np.cross(axis, x), axis]), at
    return frame


def _moved(slide: bool, value: float) -> Array:
    """Return a motion about z, or along it, shape (4, 4)."""
    pose, c, s = np.eye(4), np.cos(value), np.sin(value)
    if slide:
        pose[2, 3] = value
    else:
        pose[:2, :2] = [[c, -s], [s, c]]
    return pose


def _shapes(model: mujoco.MjModel, tree: ArmTree, number_of: dict[int, int]) -> Iterator[FileShape]:
    data = tree.data
    for number in range(model.ngeom):
        root = tree.root_of[int(model.geom_bodyid[number])]
        pose = frame_at(data.geom_xpos[number], data.geom_xmat[number])
        yield FileShape(number, number_of[root], _inverse(tree.frame(root)) @ pose)


def _separate_pairs(model: mujoco.MjModel, tree: ArmTree, number_of: dict[int, int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of links, lower index first, that the file excludes, or whose contact bit masks never match."""
    link_of = {body: number_of[root] for body, root in enumerate(tree.root_of)}
    for signature in model.exclude_signature.tolist():
        first, second = link_of[signature >> 16], link_of[signature & 0xFFFF]
        yield min(first, second), max(first, second)
    links = np.array([link_of[int(body)] for body in model.geom_bodyid], dtype=int)
    bits = model.geom_contype[:, None] & model.geom_conaffinity[None, :]
    meets = (bits | bits.T) != 0
    for first in range(-1, max(number_of.values()) + 1):
        for second in range(first + 1, max(number_of.values()) + 1):
            both = meets[np.ix_(links == first, links == second)]
            if both.size and not both.any():
                yield first, second
