"""Onboard sensors as MuJoCo has them: cameras, and the housings and masts that carry any of them."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.compile.parts import DARK, FITTINGS, make_decor
from mjsim.geometry import Array
from mjsim.world.robots import Robot
from mjsim.world.sensors import BeaconSensor, Camera, Lidar, Sensor

HOUSING = (0.03, 0.02, 0.02)
"""Half of the length, width and height of what is seen of a camera [m]."""


PUCK = (0.035, 0.02)
"""Radius, and half of the height, of what is seen of a sensor that looks around [m]."""


def add_sensor(base: mujoco.MjsBody, robot: Robot, sensor: Sensor) -> None:
    """Add what is there of a sensor: for a camera the camera itself; for all that look out a dark housing."""
    if isinstance(sensor, Camera):
        _add_camera(base, robot, sensor)
    elif isinstance(sensor, Lidar | BeaconSensor):
        puck = base.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, pos=sensor.at, size=[*PUCK, 0.0])
        make_decor(puck, DARK, group=FITTINGS)
        _add_mast(base, robot, np.array(sensor.at))


def _add_camera(base: mujoco.MjsBody, robot: Robot, camera: Camera) -> None:
    """Add a camera, with a small dark housing behind its lens."""
    axes = robot_from_view(camera)
    orientation = [*axes[:, 0], *axes[:, 1]]
    base.add_camera(
        name=f"{robot.name}/{camera.camera}",
        pos=camera.at,
        xyaxes=orientation,
        fovy=vertical_fov_deg(camera),
        resolution=[camera.width, camera.height],
    )
    middle = np.array(camera.at) + HOUSING[0] * axes[:, 2]
    housing = base.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=middle, xyaxes=orientation, size=HOUSING[::-1])
    make_decor(housing, DARK, group=FITTINGS)
    _add_mast(base, robot, middle)


def _add_mast(base: mujoco.MjsBody, robot: Robot, middle: Array) -> None:
    """Add the mast of a housing that is above the body."""
    if middle[2] > robot.body.height + HOUSING[2]:
        foot = middle[:2] * min(1.0, 0.9 * robot.body.radius / max(math.hypot(middle[0], middle[1]), 1e-9))
        mast = base.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER, fromto=[*foot, robot.body.height, *middle], size=[0.008, 0.0, 0.0]
        )
        make_decor(mast, DARK, group=FITTINGS)


def robot_from_view(camera: Camera) -> Array:
    """Return the axes of a camera as MuJoCo has them, to the right, up and back, as columns, shape (3, 3)."""
    yaw, pitch = math.radians(camera.yaw_deg), math.radians(camera.pitch_deg)
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([[sy, -sp * cy, -cp * cy], [-cy, -sp * sy, -cp * sy], [0.0, cp, -sp]])


def vertical_fov_deg(camera: Camera) -> float:
    """Return the vertical field of view, pixels being square [deg]."""
    half = math.tan(math.radians(camera.fov_deg) / 2) * camera.height / camera.width
    return math.degrees(2 * math.atan(half))


def robot_from_sensor(at: Sequence[float], *, yaw_deg: float, pitch_deg: float = 0.0) -> Array:
    """Return the pose of a sensor whose frame has x ahead, y to the left and z up, shape (4, 4) [m]."""
    yaw, pitch = math.radians(yaw_deg), math.radians(pitch_deg)
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    transform = np.eye(4)
    transform[:3, :3] = [[cy * cp, -sy, -cy * sp], [sy * cp, cy, -sy * sp], [sp, 0.0, cp]]
    transform[:3, 3] = at
    return transform
