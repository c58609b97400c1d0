"""Robots from MJCF and URDF files, with mjsim's running gear in place of the wheels of the file.

MuJoCo compiles the file by itself, and the scene is built from the result, see `mjsim.compile.models`. Parts that no
joint moves become the body `ROBOT/base`. Wheels and steering are `ROBOT/wheel_left` and so on, as on all robots: with
the looks and masses of the file, and contacts with the floor as for mjsim's own robots. All other joints keep their
names below `ROBOT/` and their limits, each with an idle motor and a lock that holds it.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, DECOR, FITTINGS, RUNNING_GEAR, SEEN
from mjsim.compile.joint_motors import lock
from mjsim.compile.models import LoadedFile, copy_geom
from mjsim.compile.robot_shapes import BUMPER_FRICTION, TOUCHED
from mjsim.compile.robots.own_parts import exclude_parts
from mjsim.compile.robots.running_gear import add_motor
from mjsim.compile.robots.sensor_bodies import HOUSING_MARGIN
from mjsim.compile.robots.wheels import (
    FREE_INERTIA,
    SAGS,
    WHEEL_SHARE,
    WheelSpec,
    add_kingpin,
    add_roller_wheel,
    add_steady_caster,
    add_tread,
    add_tyre,
)
from mjsim.geometry import Array
from mjsim.models import AtRest, Rigid, at_rest, quaternion_of, seen_and_touched
from mjsim.world import Camera, ModelBody, Robot, Wheel

MIN_CONTACT_HEIGHT = 0.2
"""Geoms of a body below this height, relative to the wheels' radius, do not collide: casters replace them."""
MIN_MASS_RATIO = 1e-3
"""Minimum mass of a moving part, relative to the robot's."""
MAX_FITTING = 0.25
"""[m]"""
MIN_ARMATURE_RATIO = 1e-4
"""Minimum armature of a held joint, relative to the robot's mass at its radius."""


@dataclass(slots=True, eq=False)
class _Build:
    """Builds one robot in the scene."""

    spec: mujoco.MjSpec
    robot: Robot
    body: ModelBody
    original: LoadedFile
    rest: AtRest
    heavier: float
    """Factor of the masses of the file."""
    robot_from_file: Array
    """Shape (3, 4) [m]."""
    made: dict[int, mujoco.MjsBody] = field(default_factory=dict)
    """Bodies of the scene by the root of their rigid part."""
    frames: dict[int, tuple[Array, Array]] = field(default_factory=dict)
    """Origin and axes of each, robot frame."""
    taken: set[str] = field(default_factory=set)
    rolling: set[int] = field(default_factory=set)
    """Roots of wheels with rollers and of the parts on them."""

    def point(self, p_file: Array) -> Array:
        """Return a point in the robot's frame, shape (3,)."""
        return np.asarray(self.robot_from_file[:, :3] @ p_file + self.robot_from_file[:, 3])

    def name(self, own: str) -> str:
        """Return a unique name of a part below the robot's."""
        name = f"{self.robot.name}/{own}"
        number = 2
        while name in self.taken:
            name, number = f"{self.robot.name}/{own}-{number}", number + 1
        self.taken.add(name)
        return name


def add_model_robot(
    spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, body: ModelBody, original: LoadedFile
) -> list[tuple[Array, Array]]:
    """Add the parts of a robot from a file to its base, which is at the robot's pose.

    Returns:
        The lowest and the highest corner of each small visual geom, robot frame, shape (3,) each [m].
    """
    rest = at_rest(original.model)
    build = _Build(spec, robot, body, original, rest, heavier_by(body, rest), _robot_from_file(body))
    build.taken = {f"{robot.name}/{name}" for name in ("base", "free", *_reserved(robot))}
    build.made[0], build.frames[0] = base, (np.zeros(3), np.eye(3))
    wheels = {joint: wheel for wheel in robot.drive.wheels for joint in _joints_of(body, wheel)}
    steering = {joint: name for name, joint in body.steering.items()}
    for part in rest.parts:
        if part.parent in build.rolling:
            _add_roller_visual(build, part)
            continue
        hinges = [original.model.joint(joint).name for joint in part.joints]
        found = next((name for name in hinges if name in wheels), None)
        if found is not None:
            _add_wheels(build, part, found, [w for w in robot.drive.wheels if found in _joints_of(body, w)])
        elif any(name in steering for name in hinges):
            _add_knuckle(build, part, next(name for name in hinges if name in steering), steering)
        else:
            _add_part(build, part)
    _keep_total_mass(build)
    for x, y, radius in body.casters:
        add_steady_caster(base, x=x, y=y, radius=radius)
    exclude_parts(spec, base)
    return list(_fittings(build))


def _fittings(build: _Build) -> Iterator[tuple[Array, Array]]:
    """Yield boxes around visual geoms as small as a sensor, robot frame."""
    seen, _ = seen_and_touched(build.original.model, urdf=build.original.urdf)
    for number in np.flatnonzero(seen).tolist():
        low, high = _box(build, number)
        if float((high - low).max()) < MAX_FITTING:
            yield low, high


def _box(build: _Build, number: int) -> tuple[Array, Array]:
    """Return the lowest and the highest corner of a geom, robot frame, shape (3,) each [m]."""
    corners = build.rest.points(number) @ build.robot_from_file[:, :3].T + build.robot_from_file[:, 3]
    return corners.min(axis=0), corners.max(axis=0)


def _houses_camera(build: _Build, number: int) -> bool:
    """Return whether a geom is the housing of a camera, which must not block its view."""
    low, high = _box(build, number)
    cameras = [np.array(sensor.at) for sensor in build.robot.sensors if isinstance(sensor, Camera)]
    small = float((high - low).max()) < MAX_FITTING
    return small and any((low - HOUSING_MARGIN < at).all() and (at < high + HOUSING_MARGIN).all() for at in cameras)


def heavier_by(body: ModelBody, rest: AtRest) -> float:
    """Return the factor by which the masses of a file are multiplied."""
    total = sum(part.mass for part in rest.parts)
    return 1.0 if body.mass is None or total <= 0.0 else body.mass / total


def mass_of(body: ModelBody, rest: AtRest) -> float:
    """Return the mass of a whole robot [kg]."""
    return max(sum(part.mass for part in rest.parts), 1e-3) if body.mass is None else body.mass


def _robot_from_file(body: ModelBody) -> Array:
    """Return the transform from the frame of the file to that of the robot, shape (3, 4)."""
    angle = math.radians(body.forward_deg)
    turn = np.array([[math.cos(angle), math.sin(angle), 0.0], [-math.sin(angle), math.cos(angle), 0.0], [0, 0, 1.0]])
    return np.column_stack([turn, -turn @ np.array(body.origin)])


def _reserved(robot: Robot) -> Iterator[str]:
    yield from (f"wheel_{wheel.name}" for wheel in robot.drive.wheels)
    yield from robot.drive.steering


def _joints_of(body: ModelBody, wheel: Wheel) -> tuple[str, ...]:
    own = body.wheels[wheel.name]
    return own.joint, *own.follow


def _add_part(build: _Build, part: Rigid) -> None:
    """Add a part other than a wheel: the base, or a part on held joints."""
    turn = build.robot_from_file[:, :3] @ part.turn
    if part.root:
        model = build.original.model
        own = model.body(part.root).name or str(part.root)
        _make(build, part, build.name(own), build.point(part.place), turn)
        for joint in part.joints:
            _add_held(build, part, joint)
    _weigh(build, part, balanced=False)
    _add_geoms(build, part)


def _make(build: _Build, part: Rigid, name: str, place: Array, turn: Array) -> mujoco.MjsBody:
    """Add the body of a part at a position in the robot's frame, with the axes of `turn`."""
    origin, axes = build.frames[part.parent]
    body = build.made[part.parent].add_body(name=name, pos=axes.T @ (place - origin), quat=quaternion_of(axes.T @ turn))
    build.made[part.root], build.frames[part.root] = body, (place, turn)
    return body


def _add_held(build: _Build, part: Rigid, number: int) -> None:
    """Add a joint of the file that is held at its rest position."""
    model, address = build.original.model, build.original.model.jnt_dofadr[number]
    slide = int(model.jnt_type[number]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    unit = 1.0 if slide else 180.0 / math.pi
    name = build.name(model.joint(number).name or f"joint{number + 1}")
    least = MIN_ARMATURE_RATIO * mass_of(build.body, build.rest) * (1.0 if slide else build.body.radius**2)
    joint = build.made[part.root].add_joint(
        name=name,
        type=int(model.jnt_type[number]),
        pos=model.jnt_pos[number],
        axis=model.jnt_axis[number],
        ref=build.rest.rest[number] * unit,
        armature=max(float(model.dof_armature[address]), least),
    )
    joint.damping[0] = model.dof_damping[address]
    if model.jnt_limited[number]:
        joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_TRUE, model.jnt_range[number] * unit
    lock(build.spec, name, held=True)


def _add_knuckle(build: _Build, part: Rigid, joint: str, steering: Mapping[str, str]) -> None:
    """Add the knuckle of a steered wheel: a vertical hinge with its servo."""
    anchor, _ = build.rest.axis(build.original.model.joint(joint).id)
    name = f"{build.robot.name}/{steering[joint]}"
    body = _make(build, part, name, build.point(anchor), np.eye(3))
    _weigh(build, part, balanced=True)
    wheel = next(wheel for wheel in build.robot.drive.wheels if wheel.steer == steering[joint])
    mass = WHEEL_SHARE * mass_of(build.body, build.rest)
    add_kingpin(build.spec, body, name, inertia=mass * build.body.wheels[wheel.name].radius ** 2)
    _add_geoms(build, part)


def _add_wheels(build: _Build, part: Rigid, joint: str, wheels: list[Wheel]) -> None:
    """Add a wheel of the file; two if the wheels of an axle are one part, each with the geoms on its side."""
    sides: list[tuple[Wheel, str, float]] = []
    if len(wheels) > 1:
        sides = [(wheel, f"wheel_{wheel.name}", 1.0 if wheel.at[1] > 0 else -1.0) for wheel in wheels]
    elif build.body.wheels[wheels[0].name].joint == joint:
        sides = [(wheels[0], f"wheel_{wheels[0].name}", 0.0)]
    else:
        number = build.body.wheels[wheels[0].name].follow.index(joint) + 2
        sides = [(wheels[0], f"wheel_{wheels[0].name}-{number}", 0.0)]
    for wheel, name, side in sides:
        _add_wheel(build, part, joint, wheel, name=f"{build.robot.name}/{name}", side=side)


def _add_wheel(build: _Build, part: Rigid, joint: str, wheel: Wheel, *, name: str, side: float) -> None:
    own, load = build.body.wheels[wheel.name], mass_of(build.body, build.rest)
    share = 0.5 if side else 1.0
    mass = max(part.mass * build.heavier * share, MIN_MASS_RATIO * load)
    inertia = FREE_INERTIA if wheel.motor is None else wheel.motor.inertia
    sizes = WheelSpec(
        name=name,
        at=(0.0, 0.0),
        radius=own.radius,
        half_width=own.width / 2,
        mass=mass,
        gear=inertia * load * own.radius**2,
        sag=SAGS[wheel.load],
    )
    if wheel.rollers is not None:
        _add_roller_wheel(build, part, wheel, replace(sizes, at=wheel.at, mass=WHEEL_SHARE * load))
        return
    place = _middle(build, part, joint, side)
    if own.y is not None and not name.endswith(_FOLLOWERS):
        place[1] = own.y
    # It rolls on a circle that ends half-way into the contact.
    place[2] = own.radius - sizes.sag / 2
    body = _make(build, part, name, place, np.eye(3))
    around = 0.5 * mass * own.radius**2
    body.explicitinertial, body.mass = True, mass
    body.ipos, body.inertia = [0.0, 0.0, 0.0], [0.6 * around, around, 0.6 * around]
    add_tread(body, sizes)
    if not _add_geoms(build, part, side=side, touch=False):
        add_tyre(body, own.radius * 0.995, own.width / 2, hub=True)
    if wheel.motor is not None and not name.endswith(_FOLLOWERS):
        add_motor(build.spec, build.robot.drive, sizes, wheel.motor, load=load)
    elif wheel.motor is not None:
        _couple(build.spec, name, f"{build.robot.name}/wheel_{wheel.name}")


def _add_roller_wheel(build: _Build, part: Rigid, wheel: Wheel, sizes: WheelSpec) -> None:
    """Add a wheel with mjsim's rollers in place of one of the file, with its looks."""
    assert wheel.rollers is not None, "a wheel without rollers is a plain one"
    seen, _ = seen_and_touched(build.original.model, urdf=build.original.urdf)
    has_visual = any(bool(seen[number]) for number in build.rest.geoms(part))
    angle, count, heading = wheel.rollers.angle, wheel.rollers.count, wheel.heading
    body = add_roller_wheel(
        build.spec, build.made[0], sizes, heading=heading, angle=angle, count=count, seen=not has_visual
    )
    c, s = math.cos(wheel.heading), math.sin(wheel.heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    build.made[part.root], build.frames[part.root] = body, (np.array([*wheel.at, sizes.radius]), turn)
    build.rolling.add(part.root)
    _add_geoms(build, part, touch=False)
    assert wheel.motor is not None, "wheels with rollers are driven"
    add_motor(build.spec, build.robot.drive, sizes, wheel.motor, load=sizes.mass / WHEEL_SHARE)


def _keep_total_mass(build: _Build) -> None:
    """Reduce the mass of the chassis by the excess of mjsim's wheels with rollers over those of the file."""
    load, base, rolling = mass_of(build.body, build.rest), build.made[0], build.rolling
    wheels = [part for part in build.rest.parts if part.root in rolling]
    more = sum(WHEEL_SHARE * load * (part.parent not in rolling) - part.mass * build.heavier for part in wheels)
    left = max(1.0 - more / base.mass, MIN_MASS_RATIO)
    base.mass, base.inertia = base.mass * left, np.asarray(base.inertia) * left


def _add_roller_visual(build: _Build, part: Rigid) -> None:
    """Add the visual shape of a roller of the file to its wheel with mjsim's rollers."""
    build.made[part.root], build.frames[part.root] = build.made[part.parent], build.frames[part.parent]
    build.rolling.add(part.root)
    _add_geoms(build, part, touch=False)


_FOLLOWERS = tuple(f"-{number}" for number in range(2, 10))
"""Suffixes of the names of wheels driven by another one."""


def _middle(build: _Build, part: Rigid, joint: str, side: float) -> Array:
    """Return the center of a wheel, robot frame, shape (3,) [m]."""
    model = build.original.model
    anchor, _ = build.rest.axis(model.joint(joint).id)
    middle = build.point(anchor)
    points = [build.point(np.zeros(3))[:0]]
    for geom in build.rest.geoms(part):
        corners = build.rest.points(geom) @ build.robot_from_file[:, :3].T + build.robot_from_file[:, 3]
        if not side or (corners[:, 1].mean() - middle[1]) * side > 0:
            points.append(corners[:, 1])
    across = np.concatenate(points)
    if len(across):
        middle[1] = (across.min() + across.max()) / 2
    return middle


def _couple(spec: mujoco.MjSpec, follower: str, leader: str) -> None:
    """Couple the rotation of a wheel to that of another one, like a chain."""
    chain = spec.add_equality(name=follower, type=mujoco.mjtEq.mjEQ_JOINT, name1=follower, name2=leader)
    chain.objtype = mujoco.mjtObj.mjOBJ_JOINT
    chain.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]


def _weigh(build: _Build, part: Rigid, *, balanced: bool) -> None:
    """Set the mass of a part from the file, and a physically valid inertia."""
    load = mass_of(build.body, build.rest)
    body, (origin, axes) = build.made[part.root], build.frames[part.root]
    mass = part.mass * build.heavier
    turn = axes.T @ build.robot_from_file[:, :3]
    center = axes.T @ (build.point(part.center) - origin)
    inertia = turn @ part.inertia @ turn.T * build.heavier
    least = MIN_MASS_RATIO * load
    if mass < least:
        # Too light for stable contacts with objects as heavy as a robot.
        mass, inertia = least, np.eye(3) * least * (0.1 * build.body.radius) ** 2
    values, vectors = np.linalg.eigh(inertia + np.eye(3) * 1e-6 * mass * build.body.radius**2)
    if np.linalg.det(vectors) < 0:
        vectors[:, 0] *= -1
    values[2] = min(values[2], values[0] + values[1])
    body.explicitinertial, body.mass, body.inertia = True, mass, values
    body.ipos = [0.0, 0.0, center[2]] if balanced else center
    body.iquat = quaternion_of(vectors)


def _add_geoms(build: _Build, part: Rigid, *, side: float = 0.0, touch: bool = True) -> bool:
    """Add the geoms of a part to its body; return whether one of them is visible."""
    model = build.original.model
    seen, touched = seen_and_touched(model, urdf=build.original.urdf)
    lowest = MIN_CONTACT_HEIGHT * min(wheel.radius for wheel in build.body.wheels.values())
    any_seen = False
    for number in build.rest.geoms(part):
        corners = build.rest.points(number) @ build.robot_from_file[:, :3].T + build.robot_from_file[:, 3]
        if side and (corners[:, 1].mean() - build.frames[part.root][0][1]) * side < -1e-3:
            continue
        touches = touch and bool(touched[number]) and float(corners[:, 2].min()) > lowest
        housing = bool(seen[number]) and _houses_camera(build, number)
        for keys in _geom_roles(seen=bool(seen[number]), touches=touches, base=part.root == 0, housing=housing):
            _add_geom(build, part, number, keys)
        any_seen |= bool(seen[number])
    return any_seen


def _geom_roles(*, seen: bool, touches: bool, base: bool, housing: bool) -> list[dict[str, Any]]:
    """Return the roles of a geom of the file in the scene: visual, collision, or both."""
    solid = {"priority": 1, "friction": [BUMPER_FRICTION, 0.005, 0.0001], "solref": [0.01, 1.0]}
    decor = {"group": FITTINGS if housing else DECOR, "contype": 0, "conaffinity": 0}
    if base and touches and not housing:
        return [{**solid, "group": SEEN if seen else TOUCHED}]
    if base and touches:
        return [{**solid, "group": TOUCHED}, decor]
    # Rays do not hit moving parts on joints, as with wheels.
    return [*([{**solid, "group": RUNNING_GEAR}] if touches else []), *([decor] if seen else [])]


def _add_geom(build: _Build, part: Rigid, number: int, keys: Mapping[str, Any]) -> None:
    data = build.rest.data
    origin, axes = build.frames[part.root]
    turn = axes.T @ build.robot_from_file[:, :3] @ data.geom_xmat[number].reshape(3, 3)
    appearance = {} if keys["group"] in (TOUCHED, RUNNING_GEAR) else build.original.looks.of_geom(number, plain=None)
    place = {"pos": axes.T @ (build.point(data.geom_xpos[number]) - origin), "quat": quaternion_of(turn)}
    own = {**place, **keys, **(appearance or {"rgba": DARK})}
    copy_geom(build.spec, build.made[part.root], build.original, number, scale=1.0, **own)
