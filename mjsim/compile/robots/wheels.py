"""Wheels of all kinds: plain ones with one contact point, wheels with rollers, casters, and their motors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, RUNNING_GEAR, make_decor

RESPONSE = 0.1
"""Time constant of the wheels' velocity servos of a differential drive, with the load of the robot's mass [s]."""
LAG = 0.05
"""Time constant of the servos of all other drives, at any load [s]."""
MAX_STEP = 0.004
"""Longest period of the physics in a world file [s]; the stiffest servos are chosen for it and are the same at all
periods."""
STIFFNESS = 0.5
"""Proportion of a free wheel's speed error that those servos correct in the longest step; well below 2, where Euler's
method becomes unstable."""
STEERING_RATE = 40.0
"""Natural frequency of a steering servo [rad/s]."""
WHEEL_PENETRATION = 3.47e-4
"""Penetration of a pair of wheels into the floor at rest in MuJoCo's contacts [m]; nearly the same for all masses and
sizes."""
SAGS = {"full": WHEEL_PENETRATION, "shared": 2.15e-4, "heavy": 3.8e-4, "light": 5.15e-4}
"""Penetration depth of wheels under their load; see `mjsim.world.drives.Wheel.load` [m]."""
WHEEL_SHARE = 0.05
"""Mass of one wheel, relative to the robot's."""
KNUCKLE_SHARE = 0.1
"""Mass of the knuckle of a steered wheel, relative to the wheel's."""
FREE_INERTIA = 0.1 * 0.02
"""Armature of a wheel without a motor, for bearings and the like, relative to the robot's mass at the wheel's rim."""
ROLLER_SHARE, ROLLER_INERTIA = 0.25, 0.03
"""Radius of a roller at its middle, relative to the wheel's over the rollers; and its inertia, relative to the robot's
mass at its rim. MuJoCo's contacts are softer for lighter bodies; heavy rollers would jerk the robot at contact."""
SPRUNG = ([0.06, 1.0], [0.5, 0.5, 0.001, 0.5, 2.0])
"""MuJoCo's `solref` and `solimp` of a caster as soft as on springs."""
STEADY = ([0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0])
"""Those of a caster that carries part of the robot's weight; MuJoCo's own."""
HUB, HUB_COLOR = 0.55, (0.42, 0.43, 0.45, 1.0)
"""Radius of the visual shape of a rim, relative to the wheel's."""
ACROSS = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Rotation of an axis from z to y."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSpec:
    """Description of a wheel."""

    name: str
    """Name of its body, its hinge and its servo: `ROBOT/wheel_left`."""
    at: tuple[float, float]
    """Position of its center in the frame of its carrier [m]."""
    radius: float
    """[m]"""
    half_width: float
    """[m]"""
    mass: float
    """[kg]"""
    gear: float
    """Inertia of its motor and gear about the axle [kg m^2]."""
    sag: float = WHEEL_PENETRATION
    """Penetration into the floor [m]."""
    solid: bool = False
    """Whether it is a solid cylinder; else an ellipsoid."""


def add_plain_wheel(
    carrier: mujoco.MjsBody, wheel: WheelSpec, *, lift: float = 0.0, hub: bool = True
) -> mujoco.MjsBody:
    """Add a wheel with its hinge.

    Args:
        carrier: The robot's base, or the knuckle that steers.
        wheel: Its sizes.
        lift: Height of the carrier's origin above the floor [m].
        hub: Whether its rim is visible.
    """
    # It rolls on a circle that ends half-way into the contact.
    body = carrier.add_body(name=wheel.name, pos=[*wheel.at, wheel.radius - wheel.sag / 2 - lift])
    add_tread(body, wheel)
    add_tyre(body, wheel.radius * 0.995, wheel.half_width, hub=hub)
    return body


def add_tread(body: mujoco.MjsBody, wheel: WheelSpec) -> None:
    """Add the hinge of a wheel, and its collision shape."""
    body.add_joint(name=wheel.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=wheel.gear)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        # An ellipsoid touches at one point directly below the axle: it spins on the spot without scrubbing.
        size=[wheel.radius + wheel.sag / 2, wheel.half_width, wheel.radius + wheel.sag / 2],
        group=RUNNING_GEAR,
        mass=wheel.mass,
        # Less than any floor, so that the floor's friction counts.
        friction=[0.001, 0.0, 0.0],
        rgba=DARK,
    )
    if wheel.solid:
        across = wheel.mass * (wheel.radius**2 / 4 + wheel.half_width**2 / 3)
        _weigh(body, wheel.mass, [across, wheel.mass * wheel.radius**2 / 2, across])


def add_tyre(body: mujoco.MjsBody, radius: float, half_width: float, *, hub: bool) -> None:
    """Add the visual shape of a wheel."""
    tyre = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, half_width, 0.0], quat=ACROSS)
    make_decor(tyre, DARK)
    if not hub:
        return
    rim = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[HUB * radius, half_width * 1.02, 0.0], quat=ACROSS)
    make_decor(rim, HUB_COLOR)
    for angle in (0.0, math.pi / 2):  # so that its rotation is visible
        spoke = body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[HUB * radius, half_width * 1.03, 0.07 * radius],
            quat=[math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0],
        )
        make_decor(spoke, DARK)


def add_roller_wheel(
    spec: mujoco.MjSpec,
    base: mujoco.MjsBody,
    wheel: WheelSpec,
    *,
    heading: float,
    angle: float,
    count: int,
    seen: bool = True,
) -> mujoco.MjsBody:
    """Add a wheel with freely turning rollers along its rim, and return its body.

    A roller is an ellipsoid of radius r and half length L, whose center is R - r from the axle. With the wheel rotated
    by t, the roller's axis dips by n = sin(angle) sin(t), and its lowest point is (R - r) cos(t) + sqrt(r^2 + (L^2 -
    r^2) n^2) below the axle. That is R to third order in t if L^2 = r^2 + r (R - r) / sin(angle)^2: the wheel runs
    true.

    Args:
        spec: The scene, for excluding collisions of the rollers with their own robot.
        base: Body that carries it.
        wheel: Its sizes; the mass includes the rollers.
        heading: Direction in which the wheel rolls, robot frame [rad].
        angle: Angle from the wheel's axle to the axis of the lowest roller, about the vertical, left positive [rad].
        count: Number of rollers.
        seen: Whether it is visible.
    """
    big, small = wheel.radius, ROLLER_SHARE * wheel.radius
    body = base.add_body(
        name=wheel.name,
        pos=[*wheel.at, big],
        quat=[math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)],
    )
    body.add_joint(name=wheel.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=wheel.gear)
    core = 0.7 * wheel.mass
    _weigh(body, core, [core * big**2 / 4, core * big**2 / 2, core * big**2 / 4])
    if seen:
        add_tyre(body, big - 1.6 * small, wheel.half_width, hub=True)
    length = math.sqrt(small**2 + small * (big - small) / math.sin(angle) ** 2)
    for number in range(count):
        name = f"{wheel.name}/roller{number + 1}"
        place, sizes = number * 2 * math.pi / count, (big - small, small, length)
        # The wheel's mass is a known fraction of the robot's.
        inertia = ROLLER_INERTIA * wheel.mass / WHEEL_SHARE * small**2
        roller = _add_roller(body, name, place=place, angle=angle, inertia=inertia, sizes=sizes)
        if seen:
            visual = [small * 0.98, small * 0.98, 0.62 * length]
            make_decor(roller.add_geom(type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=visual), HUB_COLOR)
        mass = 0.3 * wheel.mass / count
        _weigh(roller, mass, [mass * small**2 / 2] * 3)
        spec.add_exclude(bodyname1=base.name, bodyname2=name)
    return body


def _add_roller(
    wheel: mujoco.MjsBody, name: str, *, place: float, angle: float, inertia: float, sizes: tuple[float, float, float]
) -> mujoco.MjsBody:
    """Add a roller to a wheel.

    Args:
        wheel: Body of the wheel.
        name: Name of its body and its hinge.
        place: Position on the rim, from the lowest point [rad].
        angle: Angle from the wheel's axle to its axis at the lowest point [rad].
        inertia: Inertia about its axis [kg m^2].
        sizes: Distance of its center from the axle, radius and half length [m].
    """
    distance, radius, length = sizes
    # For the lowest roller: the axle is y, its axis is horizontal at the roller's angle from the axle.
    axis, down = np.array([-math.sin(angle), math.cos(angle), 0.0]), np.array([0.0, 0.0, -1.0])
    c, s = math.cos(place), math.sin(place)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    roller = wheel.add_body(name=name, pos=turn @ down * distance)
    rotation = np.zeros(4)
    mujoco.mju_quatZ2Vec(rotation, turn @ axis)
    roller.quat = rotation
    roller.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=[0.0, 0.0, 1.0],
        armature=inertia,
    )
    roller.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        size=[radius, radius, length],
        group=RUNNING_GEAR,
        # It collides with everything that others do; two rollers of one wheel overlap and must not push each other.
        contype=0,
        conaffinity=1,
        friction=[0.001, 0.0, 0.0],
        # As stiff as possible on any floor: they do not sag.
        solmix=1e6,
        solref=[2.0 * MAX_STEP, 1.0],
        solimp=[0.99, 0.99, 0.001, 0.5, 2.0],
        rgba=DARK,
    )
    return roller


def add_caster(base: mujoco.MjsBody, *, x: float, radius: float) -> None:
    """Add a sliding caster, soft so that most weight stays on the wheels."""
    # As on springs: at the foot of a ramp both casters carry the robot, and its wheels must not lose contact.
    _add_sliding_ball(base, at=(x, 0.0, radius - WHEEL_PENETRATION), radius=radius, contact=SPRUNG)


def add_steady_caster(base: mujoco.MjsBody, *, x: float, y: float, radius: float) -> None:
    """Add a sliding caster that carries its part of the robot's weight.

    The wheels are placed into the floor by their sag, the caster is not.
    """
    _add_sliding_ball(base, at=(x, y, radius), radius=radius, contact=STEADY)


def _add_sliding_ball(
    base: mujoco.MjsBody,
    *,
    at: tuple[float, float, float],
    radius: float,
    contact: tuple[list[float], list[float]],
) -> None:
    solref, solimp = contact
    base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        pos=at,
        size=[radius, 0.0, 0.0],
        group=RUNNING_GEAR,
        # Friction is the larger of the two surfaces' unless one has priority.
        priority=1,
        condim=1,
        friction=[0.0, 0.0, 0.0],
        solref=solref,
        solimp=solimp,
        rgba=DARK,
    )


def add_torque_motor(spec: mujoco.MjSpec, name: str, *, torque: float, gear: float = 1.0) -> None:
    """Add a torque motor.

    Args:
        spec: The scene.
        name: Name of the hinge or slide, and of the motor.
        torque: Largest torque in either direction at the joint [N m], or force [N].
        gear: Gear ratio, turns of the motor per turn of the joint; the command is the torque before the gear.
    """
    motor = _actuator(spec, name, torque=None)
    motor.gear[0] = gear
    motor.ctrllimited, motor.ctrlrange = True, [-torque / gear, torque / gear]


def add_soft_servo(spec: mujoco.MjSpec, name: str, *, inertia: float, torque: float | None) -> None:
    """Add the velocity servo of a differential drive's wheel, whose lag depends on the load."""
    _actuator(spec, name, torque).set_to_velocity(kv=inertia / RESPONSE)


def add_servo(spec: mujoco.MjSpec, wheel: WheelSpec, *, torque: float | None) -> None:
    """Add a velocity servo with a lag independent of the load, within its torque [N m]."""
    servo = _actuator(spec, wheel.name, torque)
    servo.set_to_velocity(kv=STIFFNESS * wheel.gear / MAX_STEP)
    _follow(servo, LAG)


def add_steering(base: mujoco.MjsBody, spec: mujoco.MjSpec, name: str, wheel: WheelSpec) -> mujoco.MjsBody:
    """Add a steering hinge with a position servo right above a wheel; return the body that carries the wheel."""
    knuckle = base.add_body(name=name, pos=[*wheel.at, 2 * wheel.radius])
    mass = KNUCKLE_SHARE * wheel.mass
    _weigh(knuckle, mass, [mass * wheel.radius**2] * 3)
    add_kingpin(spec, knuckle, name, inertia=wheel.mass * wheel.radius**2)
    return knuckle


def add_kingpin(spec: mujoco.MjSpec, knuckle: mujoco.MjsBody, name: str, *, inertia: float) -> None:
    """Add the hinge that steers, with its position servo tuned for an inertia [kg m^2]."""
    knuckle.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0], armature=inertia)
    servo = _actuator(spec, name, torque=None)
    whole = 1.5 * inertia
    servo.set_to_position(kp=whole * STEERING_RATE**2, kv=2 * whole * STEERING_RATE)
    _follow(servo, LAG)


def _weigh(body: mujoco.MjsBody, mass: float, inertia: Sequence[float]) -> None:
    """Set the mass of a body [kg], at its origin, and its inertia about its axes [kg m^2]."""
    body.explicitinertial, body.mass, body.inertia = True, mass, inertia
    body.ipos = [0.0, 0.0, 0.0]  # otherwise it is the position of the body in its carrier


def _actuator(spec: mujoco.MjSpec, name: str, torque: float | None) -> mujoco.MjsActuator:
    servo = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    if torque is not None:
        servo.forcelimited, servo.forcerange = True, [-torque, torque]
    return servo


def _follow(servo: mujoco.MjsActuator, lag: float) -> None:
    """Make a servo follow its command with a time constant [s]."""
    servo.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
    servo.dynprm[0] = lag
