"""Robots as MuJoCo bodies: a shape that bumps, wheels and what turns them, sensors.

The robot's frame has x ahead and y to the left, its origin on the floor where its drive turns about.
"""

import math

import mujoco
import numpy as np

from mjsim.compile.bodies import add_body
from mjsim.compile.running_gear import add_running_gear, clearance, wheel_count
from mjsim.compile.sensors import add_sensor
from mjsim.compile.user_robots import add_user_robot
from mjsim.compile.wheels import WHEEL_SHARE
from mjsim.world.bodies import ModelBody
from mjsim.world.drives import DifferentialDrive
from mjsim.world.robots import Robot


def add_robot(spec: mujoco.MjSpec, robot: Robot) -> None:
    """Add a robot at its start; its parts are named `ROBOT/base`, `ROBOT/wheel_left`, `ROBOT/CAMERA` and so on."""
    heading = math.radians(robot.heading_deg)
    if isinstance(robot.body, ModelBody):
        quaternion = np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)])
        base = add_user_robot(spec, robot.body, name=robot.name, at=robot.at, quaternion=quaternion)
    else:
        base = _add_own(spec, robot, heading)
    for sensor in robot.sensors:
        add_sensor(base, robot, sensor)


def _add_own(spec: mujoco.MjSpec, robot: Robot, heading: float) -> mujoco.MjsBody:
    """Add the body and the running gear of a robot of one of our kinds; return its base."""
    assert not isinstance(robot.body, ModelBody)
    base = spec.worldbody.add_body(
        name=f"{robot.name}/base",
        pos=[*robot.at, 0.0],
        quat=[math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)],
    )
    base.add_freejoint(name=f"{robot.name}/free")
    low = clearance(robot.body, robot.drive)
    mass = robot.body.mass * (1.0 - wheel_count(robot.drive) * WHEEL_SHARE)
    balanced = isinstance(robot.drive, DifferentialDrive)
    add_body(spec, base, robot.body, name=f"{robot.name}/body", low=low, mass=mass, balanced=balanced)
    add_running_gear(spec, base, robot)
    return base
