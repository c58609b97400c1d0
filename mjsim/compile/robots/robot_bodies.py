"""Robots as MuJoCo bodies: collision shape, wheels and motors, sensors.

The robot's frame has x ahead and y to the left, its origin on the floor at its drive's center of rotation.
A robot with a user-defined drive comes from an MJCF file.
"""

import math
from functools import partial

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DECOR, MATERIAL, RUNNING_GEAR, SEEN
from mjsim.compile.models import LoadedFile, original
from mjsim.compile.physics import set_physics
from mjsim.compile.robot_shapes import PlainBody, add_body
from mjsim.compile.robots.model_robots import add_model_robot
from mjsim.compile.robots.running_gear import add_running_gear, clearance
from mjsim.compile.robots.sensor_bodies import add_sensor
from mjsim.compile.robots.stability import drives, likely_cause
from mjsim.compile.robots.wheels import KNUCKLE_SHARE, SAGS, WHEEL_SHARE
from mjsim.compile.textures import add_matte
from mjsim.errors import WorldError
from mjsim.geometry import Array
from mjsim.models import no_warnings, spec_of
from mjsim.sentences import Sentence
from mjsim.world import BalancingDrive, Fault, ModelBody, NoBody, Robot, World, problems_at

WHEEL_RADIUS = 0.1
"""Radius of the wheels of a drive that does not set it [m]."""


def add_robot(spec: mujoco.MjSpec, robot: Robot, originals: dict[str, LoadedFile]) -> None:
    """Add a robot at its start; its parts are named `ROBOT/base`, `ROBOT/wheel_left`, `ROBOT/CAMERA` and so on.

    Args:
        spec: The scene.
        robot: Robot of the world file.
        originals: Files of robots already in the scene, by path; new ones are added.

    Raises:
        ValueError: MuJoCo refuses the file of the robot; the message is a sentence.
    """
    boxes: list[tuple[Array, Array]] = []
    if isinstance(robot.body, ModelBody) and not robot.body.ready:
        heading = math.radians(robot.heading_deg)
        quaternion = np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)])
        base = add_user_robot(spec, robot.body, name=robot.name, at=robot.at, quaternion=quaternion)
    else:
        base = _add_base(spec, robot)
        if isinstance(robot.body, ModelBody):
            if robot.body.model not in originals:
                key = f"robot:model{len(originals) + 1}"
                originals[robot.body.model] = original(spec, robot.body.shape, key=key)
            boxes = add_model_robot(spec, base, robot, robot.body, originals[robot.body.model])
        elif not isinstance(robot.body, NoBody):
            _add_own(spec, base, robot, robot.body)
    if robot.arms:
        from mjsim.compile.arm_bodies import add_arms

        add_arms(spec, base, robot, originals)
    for sensor in robot.sensors:
        add_sensor(base, robot, sensor, boxes)


def add_robots(spec: mujoco.MjSpec, world: World) -> None:
    """Add the robots of a world.

    Raises:
        WorldError: MuJoCo refuses the files of some; each is listed.
    """
    originals: dict[str, LoadedFile] = {}
    faults: list[Fault] = []
    for index, robot in enumerate(world.robots):
        try:
            add_robot(spec, robot, originals)
        except ValueError as error:
            faults.append((("robots", index, "body", "model"), partial(str, error)))
    if faults:
        raise WorldError(problems_at(world.source.written, world.source.file, faults))


def check_robots(world: World) -> None:
    """Raise WorldError when MuJoCo refuses the files of robots, each as the only object in a world."""
    faults: list[Fault] = []
    for index, robot in enumerate(world.robots):
        if isinstance(robot.body, ModelBody):
            try:
                _try_robot(robot, step=world.run.step)
            except ValueError as error:
                faults.append((("robots", index, "body", "model"), partial(str, error)))
    if faults:
        raise WorldError(problems_at(world.source.written, world.source.file, faults))


def _try_robot(robot: Robot, *, step: float) -> None:
    """Raise ValueError when the physics of a robot from a file fails, at rest or driving on an empty floor."""
    assert isinstance(robot.body, ModelBody)
    spec = mujoco.MjSpec()
    set_physics(spec, step)
    add_matte(spec, MATERIAL)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 0.01])
    add_robot(spec, robot, {})
    with no_warnings(robot.body.model):
        model = spec.compile()
    radius = robot.drive.driven_radius or WHEEL_RADIUS
    if not drives(model, speed=robot.drive.max_speed / radius):
        cause = likely_cause(model) or "its parts push each other apart"
        raise ValueError(Sentence("the physics of '{model}' fails; likely cause: {cause}", robot.body.model, cause))


def _add_base(spec: mujoco.MjSpec, robot: Robot) -> mujoco.MjsBody:
    """Add the base body of a robot; that of a mobile one is free."""
    start = leaning_start(robot)
    base = spec.worldbody.add_body(name=f"{robot.name}/base", pos=start[:3], quat=start[3:])
    if robot.base != "fixed":
        base.add_freejoint(name=f"{robot.name}/free")
    elif isinstance(robot.body, NoBody):
        # For a massless body, MuJoCo misplaces the bounding box of its geoms, which rays use.
        base.explicitinertial, base.mass, base.inertia = True, robot.body.mass, [robot.body.mass] * 3
        base.ipos, base.iquat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    return base


def leaning_start(robot: Robot) -> list[float]:
    """Return the initial pose of a leaning robot's base, x, y, z [m] and a quaternion: it leans about its axle."""
    heading, lean = math.radians(robot.heading_deg), math.radians(robot.lean_deg)
    back, up = -robot.drive.driven_radius * math.sin(lean), robot.drive.driven_radius * (1.0 - math.cos(lean))
    (cy, sy), (cp, sp) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in (heading, lean))
    x, y = robot.at[0] + back * math.cos(heading), robot.at[1] + back * math.sin(heading)
    return [x, y, up, cy * cp, 0.0 - sy * sp, cy * sp, sy * cp]  # no -0.0 for an upright one


def _add_own(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, body: PlainBody) -> None:
    """Add the body and the running gear of a robot of one of mjsim's kinds."""
    if robot.base == "fixed":
        add_body(spec, base, body, name=f"{robot.name}/body", low=0.0, mass=body.mass, balanced=False)
        return
    low = clearance(body, robot.drive)
    shared = sum((wheel.mass is None) + KNUCKLE_SHARE * (wheel.steer is not None) for wheel in robot.drive.wheels)
    mass = body.mass * (1.0 - shared * WHEEL_SHARE)
    add_body(spec, base, body, name=f"{robot.name}/body", low=low, mass=mass, balanced=robot.drive.on_casters)
    add_running_gear(spec, base, robot)
    if isinstance(robot.drive, BalancingDrive):
        # Its axle is lower by the depth to which its wheels penetrate the floor, and its centre of mass is above the
        # axle.
        base.ipos = [*base.ipos[:2], base.ipos[2] - SAGS["light"] / 2]


BASE = "base"
"""Name of the body in the file that becomes the robot's."""


def add_user_robot(
    spec: mujoco.MjSpec, body: ModelBody, *, name: str, at: tuple[float, ...], quaternion: Array
) -> mujoco.MjsBody:
    """Add the body `base` of a file with its servos, all names prefixed with `ROBOT/`; return it.

    Its wheels are visible to cameras but not to rays, as those of all robots.

    Raises:
        ValueError: MuJoCo cannot read the file, or it has no such body; the message is a sentence.
    """
    files = body.files
    if files.urdf:
        raise ValueError(
            Sentence(
                "'{model}' is URDF, which has no servos for a drive of your own; mjsim new --robot-from "
                "{model} -o ROBOT.yaml makes it a robot",
                body.model,
            )
        )
    with no_warnings(body.model):
        spec_of(files).compile()
        model = spec_of(files)
    base = model.body(BASE)
    if base is None:
        raise ValueError(
            Sentence("'{model}' has no body named '{base}'; give that name to the body of the robot", body.model, BASE)
        )
    for joint in list(base.joints):
        model.delete(joint)
    base.pos, base.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    _take_assets(spec, model, name)
    frame = spec.worldbody.add_frame(pos=[*at, 0.0], quat=quaternion)
    placed = frame.attach_body(base, f"{name}/", "")
    placed.add_freejoint(name=f"{name}/free")
    for geom in placed.geoms:
        geom.group = SEEN if geom.contype or geom.conaffinity else DECOR
    for part in placed.find_all(mujoco.mjtObj.mjOBJ_BODY):
        for geom in list(part.geoms):
            _hide_from_rays(part, geom)
    return placed


def _take_assets(spec: mujoco.MjSpec, model: mujoco.MjSpec, name: str) -> None:
    """Add the meshes and textures of a robot to the scene under unique names."""
    for item in (*model.meshes, *model.textures):
        if item.file:
            key = f"{name}-{item.file}"
            spec.assets[key] = model.assets[item.file]
            item.file = key


def _hide_from_rays(wheel: mujoco.MjsBody, geom: mujoco.MjsGeom) -> None:
    """Move a part of the running gear to the group that only collides, and add a visual copy of it."""
    if not (geom.contype or geom.conaffinity):
        geom.group = DECOR
        return
    geom.group = RUNNING_GEAR
    seen = wheel.add_geom(type=geom.type, size=geom.size, pos=geom.pos, quat=geom.quat, rgba=geom.rgba)
    seen.meshname, seen.material = geom.meshname, geom.material
    seen.group, seen.contype, seen.conaffinity, seen.mass = DECOR, 0, 0, 0.0
