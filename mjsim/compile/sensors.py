"""Onboard sensors as MuJoCo has them: cameras, with the housings and masts that carry them."""

import math

import mujoco
import numpy as np

from mjsim.compile.parts import DARK, FITTINGS, make_decor
from mjsim.geometry import Array
from mjsim.world.robots import Camera, Robot

HOUSING = (0.03, 0.02, 0.02)
"""Half of the length, width and height of what is seen of a camera [m]."""


def add_camera(base: mujoco.MjsBody, robot: Robot, camera: Camera) -> None:
    """Add a camera, with a small dark housing behind its lens, on a mast when it is above the body."""
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
