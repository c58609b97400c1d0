"""Contacts of a robot, from MuJoCo's contact list."""

import mujoco
import numpy as np

from mjsim.compile import RUNNING_GEAR
from mjsim.world import Robot

MIN_SUPPORT_COSINE = 0.7
"""A contact whose normal is steeper than this supports wheels and casters, and is no bump."""


class Bumper:
    """Detects contact between any part of a robot and anything except the floor."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot) -> None:
        """Keep the state, read at each measurement, and find the geoms of the robot and the floor."""
        self._data = data
        self._base = model.body(f"{robot.name}/base").id
        # All touching parts of the base except casters, which have a group of their own.
        self._body = (model.geom_bodyid == self._base) & (model.geom_contype != 0) & (model.geom_group != RUNNING_GEAR)
        self._own = model.body_rootid[model.geom_bodyid] == self._base
        self._floor = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE

    def bearings(self) -> tuple[float, ...]:
        """Return the bearings of current contacts in the robot's frame, left positive, sorted [rad]."""
        contact = self._data.contact
        pairs = contact.geom
        own = self._own[pairs]
        touched = (own[:, 0] != own[:, 1]) & ~self._floor[pairs].any(axis=1)
        if not touched.any():
            return ()
        # A wheel or a caster also rolls on objects; for the body every contact is a bump, whatever the angle.
        touched &= self._body[pairs].any(axis=1) | (np.abs(contact.frame[:, 2]) < MIN_SUPPORT_COSINE)
        offsets = contact.pos[touched] - self._data.xpos[self._base]
        x, y, _ = (offsets @ self._data.xmat[self._base].reshape(3, 3)).T
        return tuple(np.sort(np.arctan2(y, x)).tolist())
