"""Bumpers of robots, which hold contacts between ticks."""

from collections.abc import Sequence
from itertools import chain

import mujoco
import numpy as np

from mjsim.compile import RUNNING_GEAR
from mjsim.world import Robot, World, item_names

MIN_SUPPORT_COSINE = 0.5
"""A contact whose normal is steeper than this supports wheels and casters, and is not a bump: they climb steps of half
their radius."""
MAX_KNOWN = 1000
"""Number of sets of contacts that are known to touch no robot."""


class Bumper:
    """Detects contact between any part of a robot and anything except the floor, in every step of the physics."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, world: World) -> None:
        """Keep the state, read at each measurement, and find the geoms of the robot and the floor."""
        self._data = data
        self._base = model.body(f"{robot.name}/base").id
        # All touching parts of the base except casters, which have a group of their own.
        self._body = (model.geom_bodyid == self._base) & (model.geom_contype != 0) & (model.geom_group != RUNNING_GEAR)
        self._own = model.body_rootid[model.geom_bodyid] == self._base
        self._floor = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
        for name in item_names(world.floor.patches):
            self._floor[model.geom(f"floor/{name}").id] = True
        self._held: dict[tuple[int, int], list[float]] = {}

    def release(self) -> None:
        """Forget the contacts that are held."""
        self._held.clear()

    def hold(self) -> bool:
        """Hold the current contacts; return whether any part of the robot touches anything, be it what it rolls on."""
        pairs = self._data.contact.geom
        own = self._own[pairs]
        touched = (own[:, 0] != own[:, 1]) & ~self._floor[pairs].any(axis=1)
        if not touched.any():
            return False
        contact = self._data.contact
        # A wheel or a caster also rolls on objects; for the body every contact is a bump, whatever the angle.
        touched &= self._body[pairs].any(axis=1) | (np.abs(contact.frame[:, 2]) < MIN_SUPPORT_COSINE)
        offsets = contact.pos[touched] - self._data.xpos[self._base]
        x, y, _ = (offsets @ self._data.xmat[self._base].reshape(3, 3)).T
        found: dict[tuple[int, int], list[float]] = {}
        for (first, second), bearing in zip(pairs[touched].tolist(), np.arctan2(y, x).tolist(), strict=True):
            found.setdefault((first, second), []).append(bearing)
        self._held |= found
        return True

    def bearings(self) -> tuple[float, ...]:
        """Return the bearings of contacts since the last tick in the robot's frame, left positive, sorted [rad].

        Two parts that touched in several steps count once, with the last bearings.
        """
        self.hold()
        return tuple(sorted(chain.from_iterable(self._held.values())))


class Bumpers:
    """The bumpers of all robots of a simulation, which hold contacts from one tick to the next."""

    def __init__(self, data: mujoco.MjData, bumpers: Sequence[Bumper], *, steps: int) -> None:
        """Take the state, and the number of physics steps of a tick."""
        self._data, self._bumpers, self._steps, self._count = data, bumpers, steps, 0
        self._known = set[bytes]()

    def after_step(self) -> None:
        """Hold the contacts at the start of the step just taken; a tick's first step starts where they were read."""
        first, self._count = self._count == 0, (self._count + 1) % self._steps
        if first:
            for bumper in self._bumpers:
                bumper.release()
            return
        # Mostly wheels stand on the floor, as often before.
        if (pairs := self._data.contact.geom.tobytes()) in self._known:
            return
        if not any([bumper.hold() for bumper in self._bumpers]):
            if len(self._known) == MAX_KNOWN:
                self._known.clear()
            self._known.add(pairs)
