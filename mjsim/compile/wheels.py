"""Wheels of all kinds: plain ones with one contact point, wheels with rollers, casters, and their motors."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.compile.parts import DARK, RUNNING_GEAR, make_decor

RESPONSE = 0.1
"""Time constant of the wheels' velocity servos with the robot's mass on them, of a differential drive [s]."""
LAG = 0.05
"""Time constant with which the servos of all other drives follow what they are told, whatever the load [s]."""
LONGEST_STEP = 0.004
"""Of the physics that a world may ask for [s]; what is as stiff as can be is so for all steps alike."""
STIFFNESS = 0.5
"""Fraction of a free wheel's missing speed that those servos give it in the longest step; well below 2, where Euler's
steps explode."""
STEERING_RATE = 40.0
"""Natural frequency of a steering servo [rad/s]."""
SAG = 3.47e-4
"""How deep MuJoCo's contacts let a pair of wheels into the floor at rest [m]; nearly the same for all masses and
sizes."""
SAGS = {"full": SAG, "shared": 2.15e-4, "heavy": 3.8e-4, "light": 5.15e-4}
"""That of wheels by what they bear, see `mjsim.world.drives.Wheel.load` [m]."""
WHEEL_SHARE = 0.05
"""Mass of one wheel, of the robot's."""
FREE_INERTIA = 0.1 * 0.02
"""Inertia that stands for bearings and so on of a wheel without a motor, of the robot's mass at the wheel's rim."""
ROLLER_SHARE, ROLLER_INERTIA = 0.25, 0.03
"""Radius of a roller at its middle, of the wheel's over the rollers; and its inertia, of the robot's mass at its rim.
MuJoCo's contacts are as soft as what touches is light; rollers that are heavy would jerk the robot when they touch."""
SPRUNG = ([0.06, 1.0], [0.5, 0.5, 0.001, 0.5, 2.0])
"""MuJoCo's `solref` and `solimp` of a caster that gives way as on springs."""
STEADY = ([0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0])
"""Those of a caster that bears a fraction of the robot; MuJoCo's own."""
HUB, HUB_COLOR = 0.55, (0.42, 0.43, 0.45, 1.0)
"""Radius of what is seen of a rim, of the wheel's."""
ACROSS = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)
"""Turns what stands upright about z so that it lies along y."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelSpec:
    """Description of a wheel."""

    name: str
    """Of its body, its hinge and its servo: `ROBOT/wheel_left`."""
    at: tuple[float, float]
    """Of its middle, in the frame of what carries it [m]."""
    radius: float
    """[m]"""
    half_width: float
    """[m]"""
    mass: float
    """[kg]"""
    gear: float
    """Inertia of its motor and gear about the axle [kg m^2]."""
    sag: float = SAG
    """How deep it is let into the floor [m]."""
    solid: bool = False
    """Whether it is a solid cylinder; else an ellipsoid."""


def add_plain_wheel(
    carrier: mujoco.MjsBody, wheel: WheelSpec, *, lift: float = 0.0, hub: bool = True
) -> mujoco.MjsBody:
    """Add a wheel with its hinge.

    Args:
        carrier: The robot's base, or what steers.
        wheel: Its sizes.
        lift: Of the carrier's origin above the floor [m].
        hub: Whether its rim is seen.
    """
    # It rolls on a circle that ends half-way into the contact.
    body = carrier.add_body(name=wheel.name, pos=[*wheel.at, wheel.radius - wheel.sag / 2 - lift])
    add_tread(body, wheel)
    add_tyre(body, wheel.radius * 0.995, wheel.half_width, hub=hub)
    return body


def add_tread(body: mujoco.MjsBody, wheel: WheelSpec) -> None:
    """Add the hinge of a wheel, and what of it touches the floor."""
    body.add_joint(name=wheel.name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=wheel.gear)
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        # An ellipsoid touches at one point right under the axle: it spins on the spot without scrubbing.
        size=[wheel.radius + wheel.sag / 2, wheel.half_width, wheel.radius + wheel.sag / 2],
        group=RUNNING_GEAR,
        mass=wheel.mass,
        # Less than any floor, whose friction therefore counts.
        friction=[0.001, 0.0, 0.0],
        rgba=DARK,
    )
    if wheel.solid:
        across = wheel.mass * (wheel.radius**2 / 4 + wheel.half_width**2 / 3)
        _weigh(body, wheel.mass, [across, wheel.mass * wheel.radius**2 / 2, across])


def add_tyre(body: mujoco.MjsBody, radius: float, half_width: float, *, hub: bool) -> None:
    """Add what is seen of a wheel."""
    tyre = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[radius, half_width, 0.0], quat=ACROSS)
    make_decor(tyre, DARK)
    if not hub:
        return
    rim = body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=[HUB * radius, half_width * 1.02, 0.0], quat=ACROSS)
    make_decor(rim, HUB_COLOR)
    for angle in (0.0, math.pi / 2):  # so that one sees it turn
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
    """Add a wheel whose rim is rollers that turn freely, and return its body.

    A roller is an ellipsoid of radius r and half length L, whose middle is R - r from the axle. With the wheel turned
    by t, the roller's axis dips by n = sin(angle) sin(t) and its lowest point is (R - r) cos(t) + sqrt(r^2 + (L^2 -
    r^2) n^2) below the axle. That is R to third order in t when L^2 = r^2 + r (R - r) / sin(angle)^2: it runs round.

    Args:
        spec: For what must not touch: the rollers and their own robot.
        base: What carries it.
        wheel: Its sizes; the mass is that of all of it.
        heading: Direction in which the wheel rolls, robot frame [rad].
        angle: From the wheel's axle to the axis of the lowest roller, about the vertical, left positive [rad].
        count: Of rollers.
        seen: Whether it is drawn.
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
            look = [small * 0.98, small * 0.98, 0.62 * length]
            make_decor(roller.add_geom(type=mujoco.mjtGeom.mjGEOM_ELLIPSOID, size=look), HUB_COLOR)
        mass = 0.3 * wheel.mass / count
        _weigh(roller, mass, [mass * small**2 / 2] * 3)
        spec.add_exclude(bodyname1=base.name, bodyname2=name)
    return body


def _add_roller(
    wheel: mujoco.MjsBody, name: str, *, place: float, angle: float, inertia: float, sizes: tuple[float, float, float]
) -> mujoco.MjsBody:
    """Add a roller to a wheel.

    Args:
        wheel: What carries it.
        name: Of its body and its hinge.
        place: Where on the rim, from the lowest point [rad].
        angle: From the wheel's axle to its axis when it is lowest [rad].
        inertia: About its axis [kg m^2].
        sizes: Distance of its middle from the axle, radius and half length [m].
    """
    distance, radius, length = sizes
    # Of the lowest roller: the axle is y, the axis lies level at the roller's angle from it.
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
        # It touches what is touched by all; two rollers of one wheel overlap and must not push each other.
        contype=0,
        conaffinity=1,
        friction=[0.001, 0.0, 0.0],
        # As stiff as can be, whatever the floor: they do not sag.
        solmix=1e6,
        solref=[2.0 * LONGEST_STEP, 1.0],
        solimp=[0.99, 0.99, 0.001, 0.5, 2.0],
        rgba=DARK,
    )
    return roller


def add_caster(base: mujoco.MjsBody, *, x: float, radius: float) -> None:
    """Add a caster that slides, and is soft so that most weight stays on the wheels."""
    # As on springs: at the foot of a ramp both casters bear the robot, and its wheels must not hang in the air.
    _add_sliding_ball(base, at=(x, 0.0, radius - SAG), radius=radius, contact=SPRUNG)


def add_steady_caster(base: mujoco.MjsBody, *, x: float, y: float, radius: float) -> None:
    """Add a caster that slides and bears what the mass of the robot puts on it; the wheels are let into the floor."""
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
        spec: Of the scene.
        name: Of the hinge or slide, and of the motor.
        torque: Largest, either way, on the side of the joint [N m], or [N].
        gear: Turns of the motor for one of the joint; what it is told is the torque before the gear.
    """
    motor = _actuator(spec, name, torque=None)
    motor.gear[0] = gear
    motor.ctrllimited, motor.ctrlrange = True, [-torque / gear, torque / gear]


def add_soft_servo(spec: mujoco.MjSpec, name: str, *, inertia: float, torque: float | None) -> None:
    """Add the velocity servo of a differential drive's wheel, which follows with a lag that the load gives it."""
    _actuator(spec, name, torque).set_to_velocity(kv=inertia / RESPONSE)


def add_servo(spec: mujoco.MjSpec, wheel: WheelSpec, *, torque: float | None) -> None:
    """Add a velocity servo that follows with the same lag whatever the load, as far as its torque goes [N m]."""
    servo = _actuator(spec, wheel.name, torque)
    servo.set_to_velocity(kv=STIFFNESS * wheel.gear / LONGEST_STEP)
    _follow(servo, LAG)


def add_steering(base: mujoco.MjsBody, spec: mujoco.MjSpec, name: str, wheel: WheelSpec) -> mujoco.MjsBody:
    """Add what steers a wheel, right above it: a hinge with a position servo; return what carries the wheel."""
    knuckle = base.add_body(name=name, pos=[*wheel.at, 2 * wheel.radius])
    _weigh(knuckle, 0.1 * wheel.mass, [0.1 * wheel.mass * wheel.radius**2] * 3)
    add_kingpin(spec, knuckle, name, inertia=wheel.mass * wheel.radius**2)
    return knuckle


def add_kingpin(spec: mujoco.MjSpec, knuckle: mujoco.MjsBody, name: str, *, inertia: float) -> None:
    """Add the hinge that steers, with its position servo, made for an inertia [kg m^2]."""
    knuckle.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 0.0, 1.0], armature=inertia)
    servo = _actuator(spec, name, torque=None)
    whole = 1.5 * inertia
    servo.set_to_position(kp=whole * STEERING_RATE**2, kv=2 * whole * STEERING_RATE)
    _follow(servo, LAG)


def _weigh(body: mujoco.MjsBody, mass: float, inertia: Sequence[float]) -> None:
    """Give a body a mass [kg] in its origin and an inertia about its axes [kg m^2]."""
    body.explicitinertial, body.mass, body.inertia = True, mass, inertia
    body.ipos = [0.0, 0.0, 0.0]  # else it is where the body is in its carrier


def _actuator(spec: mujoco.MjSpec, name: str, torque: float | None) -> mujoco.MjsActuator:
    servo = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    if torque is not None:
        servo.forcelimited, servo.forcerange = True, [-torque, torque]
    return servo


def _follow(servo: mujoco.MjsActuator, lag: float) -> None:
    """Let a servo follow what it is told with a time constant [s]."""
    servo.dyntype = mujoco.mjtDyn.mjDYN_FILTEREXACT
    servo.dynprm[0] = lag
