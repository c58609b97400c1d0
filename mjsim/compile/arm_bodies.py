"""Arms as MuJoCo bodies: links `ROBOT/ARM/link1`, joints and motors `ROBOT/ARM/joint1`, sites `flange` and `tool`.

The frame of a link's body is that of its row in the table. A link whose mass or inertia MuJoCo's compiler refuses gets
the nearest valid one; `set_exact_masses` sets those of the table in the compiled model.
"""

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from mjsim.compile.arm_shapes import add_shapes, add_stand, original_of, passing
from mjsim.compile.geom_groups import DARK, MATERIAL, SEEN, make_decor
from mjsim.compile.mechanism_bodies import set_mass
from mjsim.compile.mechanism_specs import solids_of
from mjsim.compile.models import LoadedFile
from mjsim.compile.textures import color_of
from mjsim.geometry import Array
from mjsim.mechanics import Arm, Link, inverted, is_valid, tensor
from mjsim.models import matrix_of, pose_keys
from mjsim.world import NoBody, Robot, RobotArm, World

MIN_SEGMENT_LENGTH = 1e-6
"""A segment of a link shorter than this is a sphere [m]."""
MIN_RADII = 2.5
"""Links joined by a piece of arm shorter than this many radii do not collide."""
HUB = (1.25, 1.4)
"""Radius and half length of the visual shape of a joint, in radii of its link."""
DIGITS = 12
"""Decimals of angles in degrees, so that 30 degrees stay 30 after conversion through radians."""


NO_TORQUE = 1e-9
"""Maximum torque of the motor of a joint that follows another one [N m, N]."""


def add_arms(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, originals: dict[str, LoadedFile]) -> None:
    """Add the arms of a robot to its base in their initial configuration.

    Args:
        spec: The scene.
        base: The body of the robot.
        robot: Robot of the world file.
        originals: Files of arms already in the scene, by path; new ones are added.
    """
    for item in robot.arms:
        name = f"{robot.name}/{item.name}"
        bodies = _add_links(spec, base, item, name)
        carrier, arm = bodies[item.arm.carrier], item.arm
        carrier.add_site(name=f"{name}/flange", size=[0.005] * 3, group=4, **pose_keys(arm.flange))
        carrier.add_site(name=f"{name}/tool", size=[0.005] * 3, group=4, **pose_keys(arm.flange @ arm.tool))
        if item.model is None:
            _add_visuals(spec, base, bodies, item, name)
            if robot.base == "fixed":
                _clear_of_ground(spec, robot, item, bodies)
        else:
            _add_model(spec, base, bodies, item, name, originals)


def _add_links(spec: mujoco.MjSpec, base: mujoco.MjsBody, item: RobotArm, name: str) -> list[mujoco.MjsBody]:
    arm = item.arm
    bodies: list[mujoco.MjsBody] = []
    for number, (link, start, parent) in enumerate(zip(arm.links, item.start(), arm.parents, strict=True), start=1):
        carrier, previous = (base, arm.base) if parent < 0 else (bodies[parent], np.eye(4))
        pose = previous @ link.before @ _motion(link, start) @ link.after
        body = carrier.add_body(name=f"{name}/link{number}", **pose_keys(pose))
        set_mass(body, link.solid)
        _add_joint(body, link, f"{name}/joint{number}", start)
        _add_motor(spec, link, f"{name}/joint{number}")
        bodies.append(body)
    if item.model is not None:
        _couple(spec, item, name)
    return bodies


def _couple(spec: mujoco.MjSpec, item: RobotArm, name: str) -> None:
    """Couple the joints of an arm as its file does; the motor of one that follows another has no torque."""
    start = item.start()
    for joint, leader, ratio, offset in item.file_arm.couplings:
        called, other = f"{name}/joint{joint + 1}", f"{name}/joint{leader + 1}"
        # MuJoCo's equality is relative to the positions at the start.
        equal = spec.add_equality(type=mujoco.mjtEq.mjEQ_JOINT, name1=called, name2=other)
        equal.objtype = mujoco.mjtObj.mjOBJ_JOINT
        equal.data[:2] = ratio * start[leader] + offset - start[joint], ratio
        equal.data[2:] = 0.0
        motor = spec.actuator(called)
        motor.ctrllimited, motor.ctrlrange = True, [-NO_TORQUE, NO_TORQUE]


def _add_visuals(
    spec: mujoco.MjSpec, base: mujoco.MjsBody, bodies: list[mujoco.MjsBody], item: RobotArm, name: str
) -> None:
    """Add the shapes of an arm of a table."""
    for number, (body, link) in enumerate(zip(bodies, item.arm.links, strict=True), start=1):
        _add_shape(body, link, f"{name}/link{number}", item.color)
    _add_column(base, item, name)
    _add_excludes(spec, [base, *bodies], item.arm)


def _add_model(
    spec: mujoco.MjSpec,
    base: mujoco.MjsBody,
    bodies: list[mujoco.MjsBody],
    item: RobotArm,
    name: str,
    originals: dict[str, LoadedFile],
) -> None:
    """Add the shapes of an arm from a file."""
    key = f"arm:{item.model}"
    if key not in originals:
        originals[key] = original_of(spec, item.file_arm, key=f"arm:model{len(originals) + 1}")
    stand = add_stand(base, item.file_arm, name=name, placed=pose_keys(item.arm.base))
    add_shapes(spec, stand, bodies, item, originals[key], name=name)
    # The carrier of an arm may overlap its first links, as the base of an arm from a table does.
    pairs = {("world", bodies[0].name), (base.name, bodies[0].name)}
    for first, second in passing(item):
        pairs.add((stand.name if first < 0 else bodies[first].name, bodies[second].name))
    for first, second in sorted(pairs):
        spec.add_exclude(bodyname1=first, bodyname2=second)


def _motion(link: Link, value: float) -> Array:
    """Return the transform of a link by its joint, shape (4, 4)."""
    pose = np.eye(4)
    if link.slide:
        pose[2, 3] = value
    else:
        c, s = math.cos(value), math.sin(value)
        pose[:2, :2] = [[c, -s], [s, c]]
    return pose


def _add_joint(body: mujoco.MjsBody, link: Link, name: str, start: float) -> None:
    joint_in_link = inverted(link.after)
    limited = math.isfinite(link.lower) or math.isfinite(link.upper)
    joint = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if link.slide else mujoco.mjtJoint.mjJNT_HINGE,
        pos=joint_in_link[:3, 3],
        axis=joint_in_link[:3, 2],
        ref=_spec_value(link, start),
        limited=limited,
        armature=link.armature,
        # A motor's dry friction depends on direction; the scene has the mean.
        frictionloss=abs(link.gear) * (link.coulomb[0] - link.coulomb[1]) / 2.0,
    )
    joint.damping[0] = link.viscous * link.gear**2
    if limited:
        # A missing limit is replaced by a distant one.
        joint.range = [_spec_value(link, max(link.lower, -1e3)), _spec_value(link, min(link.upper, 1e3))]


def _spec_value(link: Link, value: float) -> float:
    """Return a value in the units of an MjSpec: angles of joints in degrees."""
    return value if link.slide else round(math.degrees(value), DIGITS)


def _add_motor(spec: mujoco.MjSpec, link: Link, name: str) -> None:
    """Add a motor, whose command is the torque on its own side of the gear."""
    motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    motor.gear[0] = link.gear
    if math.isfinite(link.max_torque):
        limit = link.max_torque / abs(link.gear)
        motor.ctrllimited, motor.ctrlrange = True, [-limit, limit]


def _add_shape(body: mujoco.MjsBody, link: Link, name: str, color: str) -> None:
    """Add the visual and collision shape of a link, and the purely visual hub of its joint."""
    start, end = map(np.array, link.bone)
    _add_bone(body, start, end, link.radius, name=name, color=color)
    frame = inverted(link.after)
    hub = body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[HUB[0] * link.radius, HUB[1] * link.radius, 0.0], **pose_keys(frame)
    )
    make_decor(hub, DARK)


def _add_bone(body: mujoco.MjsBody, start: Array, end: Array, radius: float, *, name: str, color: str) -> None:
    common = {"name": name, "group": SEEN, "material": MATERIAL, "rgba": color_of(color), "mass": 0.0}
    if np.linalg.norm(end - start) < MIN_SEGMENT_LENGTH:
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, pos=start, size=[radius, 0.0, 0.0], **common)
    else:
        ends = [*start, *end]
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=ends, size=[radius, 0.0, 0.0], **common)


def _add_column(base: mujoco.MjsBody, item: RobotArm, name: str) -> None:
    """Add a column between the base of an arm and its first joint if they are apart."""
    foot, head = item.arm.base[:3, 3], (item.arm.base @ item.arm.links[0].before)[:3, 3]
    if np.linalg.norm(head - foot) >= MIN_SEGMENT_LENGTH:
        _add_bone(base, foot, head, item.arm.links[0].radius, name=f"{name}/column", color=item.color)


def _add_excludes(spec: mujoco.MjSpec, bodies: list[mujoco.MjsBody], arm: Arm) -> None:
    """Exclude collisions of links that overlap because too little arm joins them."""
    lengths = [_least_length(link) for link in arm.links]
    widest = max(link.radius for link in arm.links)
    for first in range(len(bodies)):
        for second in range(first + 1, len(bodies)):
            if sum(lengths[first : second - 1]) < MIN_RADII * widest:
                spec.add_exclude(bodyname1=bodies[first].name, bodyname2=bodies[second].name)


def _least_length(link: Link) -> float:
    """Return the minimum distance between a link's neighbours [m]; a sliding link passes through the one before."""
    if not link.slide:
        return math.dist(*link.bone)
    start = link.before[:3, 3] + link.before[:3, :3] @ link.after[:3, 3]
    along = link.before[:3, 2]
    nearest = np.clip(-float(start @ along), link.lower, link.upper)
    return float(np.linalg.norm(start + nearest * along))


def _clear_of_ground(spec: mujoco.MjSpec, robot: Robot, item: RobotArm, bodies: list[mujoco.MjsBody]) -> None:
    """Exclude collisions of an arm's first link with its support; of all links if one starts below the floor.

    A table of joints alone, as in textbooks, often has its origin on the floor and reaches below it.
    """
    posture, links = item.arm.posture(item.start()), item.arm.links
    ends = np.array([[[*end, 1.0] for end in link.bone] for link in links])
    lowest = (ends @ np.swapaxes(posture.links, -1, -2))[..., 2].min(axis=-1) - [link.radius for link in links]
    below = isinstance(robot.body, NoBody) and bool((lowest[1:] < 0.0).any())
    for body in bodies if below else bodies[:1]:
        spec.add_exclude(bodyname1="world", bodyname2=body.name)


def links_of(world: World) -> Iterator[tuple[str, Link]]:
    """Yield the links of all arms, each with the name of its body."""
    for robot in world.robots:
        for item in robot.arms:
            for number, link in enumerate(item.arm.links, start=1):
                yield f"{robot.name}/{item.name}/link{number}", link


def refused_links(world: World) -> tuple[str, ...]:
    """Return the names of links whose mass or inertia MuJoCo's compiler refuses."""
    return tuple(name for name, link in links_of(world) if not is_valid(link.solid))


def set_exact_masses(model: mujoco.MjModel, world: World) -> None:
    """Give the links of all arms the masses and inertias of their tables, which the compiler rounds or refuses."""
    solids = [*((name, link.solid) for name, link in links_of(world)), *solids_of(world)]
    if not solids:
        return
    for name, solid in solids:
        body = model.body(name)
        # The principal axes are the compiled ones: the bounding boxes of geoms, used for finding contacts, are aligned
        # with them.
        axes = matrix_of(body.iquat)
        principal = axes.T @ tensor(solid.inertia) @ axes
        body.mass[0], body.inertia[:] = solid.mass, np.diagonal(principal)
    # It also recomputes statistics, which mjsim sets itself for cameras.
    extent, center = model.stat.extent, model.stat.center.copy()
    mujoco.mj_setConst(model, mujoco.MjData(model))
    model.stat.extent, model.stat.center[:] = extent, center


def reached(robot: Robot) -> Array:
    """Return two corners of a box around the arms of a robot at the start, world frame, shape (2, 3) [m]."""
    points = np.concatenate([item.arm.posture(item.start()).links[:, :3, 3] for item in robot.arms])
    c, s = math.cos(math.radians(robot.heading_deg)), math.sin(math.radians(robot.heading_deg))
    points = points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + [*robot.at, 0.0]
    return np.array([points.min(axis=0), points.max(axis=0)])
