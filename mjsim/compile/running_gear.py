"""The running gear of each drive: where its wheels are, what they weigh, and what turns them.

Parts are named `ROBOT/wheel_left`, `ROBOT/wheel_front_left`, `ROBOT/steer_front_left` and so on; the servos have the
names of what they turn. Commands and rotations of wheels come in the order in which the wheels are added here.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from mjsim.compile.wheels import (
    DRIVE_SAG,
    GEAR_SHARE,
    GEARED_SHARE,
    SAG,
    SHARED_SAG,
    STRONG_SHARE,
    WHEEL_SHARE,
    WheelSpec,
    add_caster,
    add_plain_wheel,
    add_roller_wheel,
    add_servo,
    add_soft_servo,
    add_steering,
)
from mjsim.world import drives
from mjsim.world.bodies import Body, rims
from mjsim.world.robots import Robot

PUSH = 5.0
"""Largest push of all wheels together, per mass [m/s^2]: enough for steep ramps, and less than tyres hold; more for
robots that accelerate faster."""
RESERVE = 1.2
"""Push of the motors, as a multiple of what the largest acceleration needs."""
SIDES = (("left", 1.0), ("right", -1.0))
CORNERS = tuple((f"{end}_{side}", x, y) for end, x in (("front", 1.0), ("rear", -1.0)) for side, y in SIDES)
OMNI3_BEARINGS = {"front_left": math.pi / 3, "rear": math.pi, "front_right": -math.pi / 3}
"""Where the wheels stand on their circle, from ahead, left positive [rad]."""
MOST_CLEARANCE = 0.03
"""Of a body above the floor [m]."""


def add_running_gear(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot) -> None:
    """Add wheels, what steers them, casters and servos."""
    adders: Mapping[type, Callable[..., None]] = {
        drives.DifferentialDrive: _add_differential,
        drives.SkidSteerDrive: _add_skid_steer,
        drives.AckermannDrive: _add_ackermann,
        drives.TricycleDrive: _add_tricycle,
        drives.Omni3Drive: _add_omni3,
        drives.MecanumDrive: _add_mecanum,
    }
    adders[type(robot.drive)](spec, base, robot, robot.drive)


def wheel_count(drive: drives.Drive) -> int:
    """Return how many wheels carry a robot, casters left out."""
    counts = {drives.DifferentialDrive: 2, drives.TricycleDrive: 3, drives.Omni3Drive: 3}
    return counts.get(type(drive), 4)


def clearance(body: Body, drive: Any) -> float:
    """Return the height of the body's lower face above the floor [m]."""
    return min(MOST_CLEARANCE, 0.4 * float(drive.wheel_radius), 0.25 * body.height)


def _wheel(
    robot: Robot, name: str, at: tuple[float, float], *, radius: float, gear: float = 0.1 * GEAR_SHARE, sag: float = SAG
) -> WheelSpec:
    """Return a wheel of a robot; gear is the inertia of its motor, of the robot's mass at the rim."""
    drive: Any = robot.drive
    width = getattr(drive, "wheel_width", None)
    track = getattr(drive, "track", math.inf)
    return WheelSpec(
        name=f"{robot.name}/wheel_{name}",
        at=at,
        radius=radius,
        half_width=width / 2 if width is not None else min(0.25 * radius, 0.2 * track),
        mass=WHEEL_SHARE * robot.body.mass,
        gear=gear * robot.body.mass * radius**2,
        sag=sag,
    )


def _torque(robot: Robot, *, radius: float, share: float) -> float:
    """Return the largest torque of a wheel that moves a share of the robot [N m]."""
    return max(PUSH, RESERVE * robot.drive.max_acceleration) * robot.body.mass * radius * share


def _add_differential(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.DifferentialDrive) -> None:
    """Two driven wheels, a caster ahead and one behind."""
    ahead, behind = rims(robot.body, np.array([0.0, math.pi])).tolist()
    for x in (0.7 * ahead, -0.7 * behind):
        add_caster(base, x=x, radius=clearance(robot.body, drive))
    radius = drive.wheel_radius
    for side, sign in SIDES:
        wheel = _wheel(robot, side, (0.0, sign * drive.track / 2), radius=radius, gear=GEAR_SHARE)
        add_plain_wheel(base, wheel, hub=False)
        # Half of the robot, and the wheel's own rotation (2/5 m r^2 of an ellipsoid) with its motor's.
        inertia = (0.5 + 0.4 * WHEEL_SHARE + GEAR_SHARE) * robot.body.mass * radius**2
        add_soft_servo(spec, wheel.name, inertia=inertia, torque=_torque(robot, radius=radius, share=0.5))


def _add_skid_steer(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.SkidSteerDrive) -> None:
    """Four driven wheels that do not steer."""
    for name, x, y in CORNERS:
        at = x * drive.wheelbase / 2, y * drive.track / 2
        wheel = _wheel(robot, name, at, radius=drive.wheel_radius, gear=STRONG_SHARE)
        add_plain_wheel(base, wheel)
        # No load slows these down: the tyres give way first.
        add_servo(spec, wheel, torque=None)


def _add_ackermann(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.AckermannDrive) -> None:
    """Two driven wheels under the origin, two steered ones ahead."""
    for side, y in SIDES:
        at = 0.0, y * drive.track / 2
        wheel = _wheel(robot, f"rear_{side}", at, radius=drive.wheel_radius, gear=GEARED_SHARE, sag=SHARED_SAG)
        add_plain_wheel(base, wheel)
        add_servo(spec, wheel, torque=_torque(robot, radius=drive.wheel_radius, share=0.5))
    for side, y in SIDES:
        at = drive.wheelbase, y * drive.track / 2
        wheel = _wheel(robot, f"front_{side}", at, radius=drive.wheel_radius, sag=SHARED_SAG)
        _add_steered(spec, base, robot, wheel, f"{robot.name}/steer_front_{side}")


def _add_tricycle(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.TricycleDrive) -> None:
    """Two wheels on the fixed axle under the origin, and one that is driven and steered."""
    load_radius = drive.load_wheel_radius or drive.wheel_radius
    for side, y in SIDES:
        add_plain_wheel(base, _wheel(robot, side, (0.0, y * drive.track / 2), radius=load_radius, sag=SHARED_SAG))
    x = drive.wheelbase if drive.driven == "front" else -drive.wheelbase
    wheel = _wheel(robot, "drive", (x, 0.0), radius=drive.wheel_radius, gear=GEARED_SHARE, sag=DRIVE_SAG)
    _add_steered(spec, base, robot, wheel, f"{robot.name}/steer")
    add_servo(spec, wheel, torque=_torque(robot, radius=drive.wheel_radius, share=1.0))


def _add_steered(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, wheel: WheelSpec, name: str) -> None:
    knuckle = add_steering(base, spec, name, wheel)
    add_plain_wheel(knuckle, replace(wheel, at=(0.0, 0.0)), lift=2 * wheel.radius)
    spec.add_exclude(bodyname1=f"{robot.name}/base", bodyname2=wheel.name)


def _add_omni3(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.Omni3Drive) -> None:
    """Three wheels on a circle, which roll along it, with rollers across."""
    for name, bearing in OMNI3_BEARINGS.items():
        at = drive.wheel_circle * math.cos(bearing), drive.wheel_circle * math.sin(bearing)
        wheel = _wheel(robot, name, at, radius=drive.wheel_radius, gear=GEARED_SHARE)
        add_roller_wheel(spec, base, wheel, heading=bearing + math.pi / 2, angle=math.pi / 2, count=drive.rollers)
        add_servo(spec, wheel, torque=_torque(robot, radius=drive.wheel_radius, share=0.5))


def _add_mecanum(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, drive: drives.MecanumDrive) -> None:
    """Four wheels with rollers at 45 degrees; those on the floor lie across the lines to the robot's middle."""
    for name, x, y in CORNERS:
        at = x * drive.wheelbase / 2, y * drive.track / 2
        wheel = _wheel(robot, name, at, radius=drive.wheel_radius, gear=GEARED_SHARE)
        add_roller_wheel(spec, base, wheel, heading=0.0, angle=x * y * math.pi / 4, count=drive.rollers)
        add_servo(spec, wheel, torque=_torque(robot, radius=drive.wheel_radius, share=0.5))
