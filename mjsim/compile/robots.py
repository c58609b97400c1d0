"""Robots as MuJoCo bodies: a cylinder that bumps, two driven wheels, casters that slide, cameras.

The robot's frame has x ahead and y to the left, its origin on the floor midway between the wheels.
"""

import math

import mujoco

from mjsim.compile.parts import DARK, MATERIAL, PALE, RUNNING_GEAR, SEEN, make_decor
from mjsim.compile.pictures import color_of
from mjsim.compile.sensors import add_sensor
from mjsim.world.bodies import Body
from mjsim.world.drives import DifferentialDrive
from mjsim.world.robots import Robot

RESPONSE = 0.1
"""Time constant of the wheels' velocity servos with the robot's mass on them [s]."""
PUSH = 5.0
"""Largest push of both wheels together, per mass [m/s^2]: enough for steep ramps, and less than tyres hold; more for
robots that accelerate faster."""
RESERVE = 1.2
"""Push of the motors, as a multiple of what the largest acceleration needs."""
SAG = 3.47e-4
"""How deep MuJoCo's contacts let wheels into the floor at rest [m]; nearly the same for all masses and sizes."""
WHEEL_SHARE, GEAR_SHARE = 0.05, 0.02
"""Mass of one wheel, of the robot's; and inertia of its motor and gear, of the robot's mass at the wheel's rim."""
BUMPER_TRAVEL = 0.001
"""A bumper feels what is this near without being pressed yet, so that contact does not flicker [m]."""
BUMPER_FRICTION = 0.3
"""Of a plastic bumper on a wall."""


def add_robot(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Add a robot at its start; its parts are named `ROBOT/base`, `ROBOT/wheel_left`, `ROBOT/CAMERA` and so on."""
    heading = math.radians(robot.heading_deg)
    base = spec.worldbody.add_body(
        name=f"{robot.name}/base",
        pos=[*robot.at, 0.0],
        quat=[math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)],
    )
    base.add_freejoint(name=f"{robot.name}/free")
    _add_body(base, robot)
    _add_heading_mark(base, robot.body)
    _add_casters(base, robot)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        _add_wheel(spec, base, robot, side=side, y=sign * robot.drive.track / 2)
    for sensor in robot.sensors:
        add_sensor(base, robot, sensor)


def clearance(body: Body, drive: DifferentialDrive) -> float:
    """Return the height of the body's lower face above the floor [m]."""
    return min(0.03, 0.4 * drive.wheel_radius, 0.25 * body.height)


def _add_body(base: mujoco.MjsBody, robot: Robot) -> None:
    """Add the cylinder that bumps; its mass lies low, as batteries do."""
    body = robot.body
    low = clearance(body, robot.drive)
    half = (body.height - low) / 2
    mass = body.mass * (1.0 - 2.0 * WHEEL_SHARE)
    middle = min(low + half, max(low, body.radius / 2))
    across = mass * (body.radius**2 / 4 + min(half, middle) ** 2 / 3)
    base.explicitinertial = True
    base.mass, base.ipos = mass, [0.0, 0.0, middle]
    base.inertia = [across, across, mass * body.radius**2 / 2]
    base.add_geom(
        name=f"{robot.name}/body",
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        pos=[0.0, 0.0, low + half],
        size=[body.radius, half, 0.0],
        group=SEEN,
        priority=1,
        friction=[BUMPER_FRICTION, 0.005, 0.0001],
        # Twice as stiff as MuJoCo's default: at 2 m/s it gives way by a centimetre.
        solref=[0.01, 1.0],
        margin=BUMPER_TRAVEL,
        gap=BUMPER_TRAVEL,
        material=MATERIAL,
        rgba=color_of(body.color),
    )


def _add_heading_mark(base: mujoco.MjsBody, body: Body) -> None:
    """Add a bar on top from the middle to the rim, so that people see where the robot looks."""
    red, green, blue, _ = color_of(body.color)
    bright = 0.3 * red + 0.59 * green + 0.11 * blue > 0.6
    mark = base.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[body.radius / 2, 0.0, body.height],
        size=[body.radius * 0.46, body.radius * 0.11, 0.004],
    )
    make_decor(mark, DARK if bright else PALE)


def _add_casters(base: mujoco.MjsBody, robot: Robot) -> None:
    """Add a caster ahead and one behind; they slide, and are soft so that most weight stays on the wheels."""
    radius = clearance(robot.body, robot.drive)
    for x in (0.7 * robot.body.radius, -0.7 * robot.body.radius):
        base.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            pos=[x, 0.0, radius - SAG],
            size=[radius, 0.0, 0.0],
            group=RUNNING_GEAR,
            # Friction is the larger of the two surfaces' unless one has priority.
            priority=1,
            condim=1,
            friction=[0.0, 0.0, 0.0],
            # As on springs: at the foot of a ramp both casters bear the robot, and its wheels must not hang in the air.
            solref=[0.06, 1.0],
            solimp=[0.5, 0.5, 0.001, 0.5, 2.0],
            rgba=DARK,
        )


def _add_wheel(spec: mujoco.MjSpec, base: mujoco.MjsBody, robot: Robot, *, side: str, y: float) -> None:
    """Add a wheel with its hinge and its velocity servo."""
    name, radius, mass = f"{robot.name}/wheel_{side}", robot.drive.wheel_radius, robot.body.mass
    half_width = min(0.25 * radius, 0.2 * robot.drive.track)
    # It rolls on a circle that ends half-way into the contact.
    wheel = base.add_body(name=name, pos=[0.0, y, radius - SAG / 2])
    wheel.add_joint(
        name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0], armature=GEAR_SHARE * mass * radius**2
    )
    wheel.add_geom(
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        # An ellipsoid touches at one point right under the axle: it spins on the spot without scrubbing.
        size=[radius + SAG / 2, half_width, radius + SAG / 2],
        group=RUNNING_GEAR,
        mass=WHEEL_SHARE * mass,
        # Less than any floor, whose friction therefore counts.
        friction=[0.001, 0.0, 0.0],
        rgba=DARK,
    )
    disc = wheel.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[radius * 0.995, half_width, 0.0],
        quat=[math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0],
    )
    make_decor(disc, DARK)
    torque = max(PUSH, RESERVE * robot.drive.max_acceleration) * mass * radius / 2
    servo = spec.add_actuator(
        name=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=name,
        forcelimited=True,
        forcerange=[-torque, torque],
    )
    # Half of the robot, and the wheel's own rotation (2/5 m r^2 of an ellipsoid) with its motor's.
    inertia = (0.5 + 0.4 * WHEEL_SHARE + GEAR_SHARE) * mass * radius**2
    servo.set_to_velocity(kv=inertia / RESPONSE)
