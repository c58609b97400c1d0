"""Bodies of mechanisms in MuJoCo: masses, visual and collision shapes, and sizes."""

import math

import mujoco
import numpy as np

from mjsim.compile.geom_groups import MATERIAL, SEEN
from mjsim.compile.textures import color_of
from mjsim.geometry import Array
from mjsim.mechanics import Solid, is_valid, nearest_valid
from mjsim.models import pose_keys
from mjsim.world import MechanismBody

THICKNESS_RATIO = 0.3
"""Thickness of a body other than a rod, relative to its smallest half size, so that joints do not hide it."""


def lowest(body: MechanismBody, world_from_shape: Array) -> float:
    """Return the height of the lowest point of a body [m]."""
    rotation, height = world_from_shape[:3, :3], float(world_from_shape[2, 3])
    down = -rotation[2]
    match body:
        case _ if hasattr(body, "rod"):
            length, radius = body.rod
            return height - radius + min(0.0, float(rotation[2, 0]) * length)
        case _ if hasattr(body, "box"):
            return height - float(np.abs(down) @ (np.array(body.box) / 2.0))
        case _ if hasattr(body, "model"):
            return height + float((np.array(body.spans()[0]) @ rotation[2]).min())
        case _ if hasattr(body, "cylinder"):
            radius, tall = body.cylinder
            return height - radius * math.hypot(down[0], down[1]) - abs(float(down[2])) * tall / 2.0
        case _:
            return height - float(getattr(body, "sphere", 0.0))


def thickness(body: MechanismBody) -> float:
    """Return the radius of a rod; for other bodies a part of the smallest half size [m]."""
    match body:
        case _ if hasattr(body, "rod"):
            return float(body.rod[1])
        case _ if hasattr(body, "box"):
            return THICKNESS_RATIO * float(min(body.box)) / 2.0
        case _ if hasattr(body, "model"):
            return THICKNESS_RATIO * float(np.ptp(body.spans()[0], axis=0).min()) / 2.0
        case _ if hasattr(body, "cylinder"):
            return THICKNESS_RATIO * float(min(body.cylinder[0], body.cylinder[1] / 2.0))
        case _:
            return THICKNESS_RATIO * float(getattr(body, "sphere", 0.1))


def set_mass(body: mujoco.MjsBody, solid: Solid) -> None:
    """Set mass and inertia of a body to the nearest valid ones in MuJoCo."""
    given = solid if is_valid(solid) else nearest_valid(solid)
    xx, yy, zz, xy, yz, xz = given.inertia
    body.explicitinertial = True
    body.mass, body.ipos = given.mass, given.center
    body.fullinertia = [xx, yy, zz, xy, xz, yz]


def add_shape(body: mujoco.MjsBody, item: MechanismBody, name: str) -> None:
    """Add the visual and collision shapes of a body."""
    frame = item.frame()
    common = {
        "name": name,
        "group": SEEN,
        "material": MATERIAL,
        "rgba": color_of(item.color),
        "mass": 0.0,
        "friction": [item.friction, 0.005, 0.0001],
    }
    match item:
        case _ if hasattr(item, "rod"):
            ends = [frame[:3, 3], frame[:3, :3] @ (item.rod[0], 0.0, 0.0) + frame[:3, 3]]
            size = [item.rod[1], 0.0, 0.0]
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=np.concatenate(ends), size=size, **common)
        case _ if hasattr(item, "box"):
            size = [value / 2 for value in item.box]
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, **pose_keys(frame), **common)
        case _ if hasattr(item, "cylinder"):
            size = [item.cylinder[0], item.cylinder[1] / 2, 0.0]
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, **pose_keys(frame), **common)
        case _:
            size = [getattr(item, "sphere", 0.0), 0.0, 0.0]
            body.add_geom(type=mujoco.mjtGeom.mjGEOM_SPHERE, size=size, **pose_keys(frame), **common)
