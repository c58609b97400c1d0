"""Onboard sensors in MuJoCo: cameras, and housings and masts of all sensors."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DARK, FITTINGS, make_decor
from mjsim.compile.robots.carriers import carrier_of
from mjsim.geometry import Array
from mjsim.models import quaternion_of
from mjsim.world import Camera, Robot, Sensor, aimed

HOUSING = (0.03, 0.02, 0.02)
"""Half length, width and height of the housing of a camera [m]."""


PUCK = (0.035, 0.02)
"""Radius and half height of the housing of a sensor that looks all around [m]."""


Boxes = Sequence[tuple[Array, Array]]
"""Lowest and highest corners, robot frame, shape (3,) each [m]."""
HOUSING_MARGIN = 0.02
"""A visual geom this near to a sensor counts as the sensor [m]."""


def add_sensor(base: mujoco.MjsBody, robot: Robot, sensor: Sensor, boxes: Boxes = ()) -> None:
    """Add a sensor: a camera with its housing, or the dark housing of another.

    Args:
        base: Body that carries it.
        robot: Robot of the world file.
        sensor: One of its sensors.
        boxes: Boxes of the robot's small visual geoms; a sensor inside one of these has a visual shape already.
    """
    name, frame = carrier_of(robot, sensor)
    below = () if name == "base" else base.find_all(mujoco.mjtObj.mjOBJ_BODY)
    carrier = next((body for body in below if body.name == f"{robot.name}/{name}"), base)
    place = np.array(sensor.at if isinstance(sensor, Camera) else sensor.housing or (np.inf,) * 3)
    dressed = name == "base" and any(
        (low - HOUSING_MARGIN < place).all() and (place < high + HOUSING_MARGIN).all() for low, high in boxes
    )
    if isinstance(sensor, Camera):
        _add_camera(carrier, robot, sensor, frame=frame, dressed=dressed)
    elif sensor.housing is not None and not dressed:
        turned = quaternion_of(frame[:3, :3])
        middle = frame[:3, :3] @ sensor.housing + frame[:3, 3]
        puck = carrier.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, pos=middle, quat=turned, size=[*PUCK, 0.0])
        make_decor(puck, DARK, group=FITTINGS)
        if name == "base":
            _add_mast(base, robot, np.array(sensor.housing))


def _add_camera(carrier: mujoco.MjsBody, robot: Robot, camera: Camera, *, frame: Array, dressed: bool) -> None:
    """Add a camera, with a small dark housing behind its lens unless it has a visual shape already."""
    axes = frame[:3, :3] @ robot_from_view(camera)
    place = frame[:3, :3] @ camera.at + frame[:3, 3]
    orientation = [*axes[:, 0], *axes[:, 1]]
    carrier.add_camera(
        name=f"{robot.name}/{camera.camera}",
        pos=place,
        xyaxes=orientation,
        fovy=vertical_fov_deg(camera),
        resolution=[camera.width, camera.height],
    )
    if dressed:
        return
    middle = place + HOUSING[0] * axes[:, 2]
    housing = carrier.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, pos=middle, xyaxes=orientation, size=HOUSING[::-1])
    make_decor(housing, DARK, group=FITTINGS)
    if camera.on is None:
        _add_mast(carrier, robot, middle)


def _add_mast(base: mujoco.MjsBody, robot: Robot, middle: Array) -> None:
    """Add the mast of a housing that is above the body."""
    if middle[2] > robot.body.height + HOUSING[2]:
        foot = middle[:2] * min(1.0, 0.9 * robot.body.radius / max(math.hypot(middle[0], middle[1]), 1e-9))
        mast = base.add_geom(
            type=mujoco.mjtGeom.mjGEOM_CYLINDER, fromto=[*foot, robot.body.height, *middle], size=[0.008, 0.0, 0.0]
        )
        make_decor(mast, DARK, group=FITTINGS)


def robot_from_view(camera: Camera) -> Array:
    """Return the axes of a camera in MuJoCo's convention, right, up and back, as columns, shape (3, 3)."""
    yaw, pitch = math.radians(camera.yaw_deg), math.radians(camera.pitch_deg)
    cy, sy, cp, sp = math.cos(yaw), math.sin(yaw), math.cos(pitch), math.sin(pitch)
    return np.array([[sy, -sp * cy, -cp * cy], [-cy, -sp * sy, -cp * sy], [0.0, cp, -sp]])


def vertical_fov_deg(camera: Camera) -> float:
    """Return the vertical field of view for square pixels [deg]."""
    half = math.tan(math.radians(camera.fov_deg) / 2) * camera.height / camera.width
    return math.degrees(2 * math.atan(half))


def robot_from_sensor(at: Sequence[float], *, yaw_deg: float, pitch_deg: float = 0.0) -> Array:
    """Return the pose of a sensor whose frame has x ahead, y to the left and z up, shape (4, 4) [m]."""
    return aimed(at, yaw=math.radians(yaw_deg), pitch=math.radians(pitch_deg))
