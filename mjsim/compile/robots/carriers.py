"""Carriers of sensors: the body of the robot, or a link or the tool of an arm."""

import numpy as np

from mjsim.geometry import Array
from mjsim.world import Robot, Sensor


def carrier_of(robot: Robot, sensor: Sensor) -> tuple[str, Array]:
    """Return the body that carries a sensor, below the robot's name, and the frame of the sensor's pose on it.

    The frame is body_from_frame, shape (4, 4) [m].
    """
    on = getattr(sensor, "on", None)
    if on is None:
        return "base", np.eye(4)
    name, _, part = on.partition("/")
    arm = next(item.arm for item in robot.arms if item.name == name)
    return (f"{name}/link{arm.carrier + 1}", arm.flange @ arm.tool) if part == "tool" else (on, np.eye(4))


def robot_from_carrier(robot: Robot, sensor: Sensor) -> Array:
    """Return the frame of a sensor's pose at the start, shape (4, 4) [m]."""
    on = getattr(sensor, "on", None)
    if on is None:
        return np.eye(4)
    name, _, part = on.partition("/")
    item = next(item for item in robot.arms if item.name == name)
    posture = item.arm.posture(item.start())
    return np.array(posture.tool if part == "tool" else posture.links[int(part.removeprefix("link")) - 1])
