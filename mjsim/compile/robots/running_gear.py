"""The running gear of a base: wheels of the drive, casters, motors and steering.

Parts are named `ROBOT/wheel_left`, `ROBOT/wheel_front_left`, `ROBOT/steer_front_left` and so on; servos have the names
of the joints that they turn.
"""

import math
from dataclasses import replace

import mujoco
import numpy as np

from mjsim.compile.robots.wheels import (
    FREE_INERTIA,
    SAGS,
    WHEEL_SHARE,
    WheelSpec,
    add_caster,
    add_plain_wheel,
    add_roller_wheel,
    add_servo,
    add_soft_servo,
    add_steering,
    add_torque_motor,
)
from mjsim.world import AnyDrive, Body, BoxBody, Motor, Robot, TorqueMotor, Wheel, rims

MAX_TRACTION = 5.0
"""Largest traction of all wheels together, per mass [m/s^2]: enough for steep ramps, and below the grip of the tyres;
more for robots that accelerate faster."""
TRACTION_RESERVE = 1.2
"""Traction of the motors, as a multiple of that for the largest acceleration."""
CASTER_POSITION = 0.7
"""Distance of casters ahead and behind, relative to the body's reach."""
MAX_CLEARANCE = 0.03
"""Largest ground clearance of a body [m]."""


def add_running_gear(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot) -> None:
    """Add casters, wheels, steering and motors."""
    if robot.drive.on_casters:
        ahead, behind = rims(robot.body, np.array([0.0, math.pi])).tolist()
        for x in (CASTER_POSITION * ahead, -CASTER_POSITION * behind):
            add_caster(base, x=x, radius=clearance(robot.body, robot.drive))
    for wheel in robot.drive.wheels:
        _add_wheel(spec, base, robot, wheel)


def clearance(body: Body, drive: AnyDrive) -> float:
    """Return the height of the body's lower face above the floor [m]."""
    if isinstance(body, BoxBody) and body.middle is not None:
        return body.middle - body.box[2] / 2
    return min(MAX_CLEARANCE, 0.4 * drive.driven_radius, 0.25 * body.height)


def _add_wheel(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, wheel: Wheel) -> None:
    sizes = _sizes(robot, wheel)
    if wheel.rollers is not None:
        rollers = wheel.rollers
        add_roller_wheel(spec, base, sizes, heading=wheel.heading, angle=rollers.angle, count=rollers.count)
    elif wheel.steer is not None:
        knuckle = add_steering(base, spec, f"{robot.name}/{wheel.steer}", sizes)
        add_plain_wheel(knuckle, replace(sizes, at=(0.0, 0.0)), lift=2 * wheel.radius, hub=wheel.spokes)
        spec.add_exclude(bodyname1=f"{robot.name}/base", bodyname2=sizes.name)
    else:
        add_plain_wheel(base, sizes, hub=wheel.spokes)
    if wheel.motor is not None:
        assert robot.body.mass is not None
        add_motor(spec, robot.drive, sizes, wheel.motor, load=robot.body.mass)


def _sizes(robot: Robot, wheel: Wheel) -> WheelSpec:
    """Return the sizes and masses of a wheel."""
    assert robot.body.mass is not None
    inertia = FREE_INERTIA if wheel.motor is None else wheel.motor.inertia
    return WheelSpec(
        name=f"{robot.name}/wheel_{wheel.name}",
        at=wheel.at,
        radius=wheel.radius,
        half_width=wheel.half_width,
        mass=WHEEL_SHARE * robot.body.mass if wheel.mass is None else wheel.mass,
        solid=wheel.mass is not None,
        gear=inertia * robot.body.mass * wheel.radius**2,
        sag=SAGS[wheel.load],
    )


def add_motor(
    spec: mujoco.MjSpec, drive: AnyDrive, wheel: WheelSpec, motor: Motor | TorqueMotor, *, load: float
) -> None:
    """Add the motor of a wheel of a robot of a given mass [kg]: a servo, or a torque motor for a controller."""
    if isinstance(motor, TorqueMotor):
        add_torque_motor(spec, wheel.name, torque=motor.torque)
        return
    torque = None
    if motor.share is not None:
        torque = max(MAX_TRACTION, TRACTION_RESERVE * drive.max_acceleration) * load * wheel.radius * motor.share
    if motor.follows_load:
        assert motor.share is not None, "a motor that moves a load has a share of it"
        # Its share of the mass of the robot, and the wheel's own rotation (2/5 m r^2 of an ellipsoid) with its motor's.
        inertia = (motor.share + 0.4 * wheel.mass / load + motor.inertia) * load * wheel.radius**2
        add_soft_servo(spec, wheel.name, inertia=inertia, torque=torque)
    else:
        add_servo(spec, wheel, torque=torque)
