"""Bumpers of robots, which store contacts between ticks."""

from collections.abc import Callable, Sequence
from itertools import chain
from typing import NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import RUNNING_GEAR
from mjsim.geometry import Array
from mjsim.sim.contact_bound import ContactBound
from mjsim.world import Robot, World, item_names

MIN_SUPPORT_COSINE = 0.5
"""A contact whose normal is steeper than this supports wheels and casters and is not a bump: they climb steps of half
their radius."""
MAX_KNOWN = 1000
"""Number of sets of contacts that are known to touch no robot."""


class _Contacts(NamedTuple):
    """Contacts after a step of the physics, world frame."""

    pairs: NDArray[np.int32]
    """Geoms, shape (n, 2)."""
    places: Array
    """Shape (n, 3) [m]."""
    steep: NDArray[np.bool_]
    """Whether they are too steep to roll on, shape (n,)."""
    place: Array
    """Of the robot, shape (3,) [m]."""
    turned: Array
    """Rotation of the robot, shape (9,)."""


class Bumper:
    """Detects contact between any part of a robot and anything except the floor, in every step of the physics."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, world: World) -> None:
        """Store the state, read at each measurement, and find the geoms of the robot and the floor."""
        self._data = data
        self._base = model.body(f"{robot.name}/base").id
        # All colliding parts of the base except casters, which have a group of their own.
        self._body = (model.geom_bodyid == self._base) & (model.geom_contype != 0) & (model.geom_group != RUNNING_GEAR)
        self._own = model.body_rootid[model.geom_bodyid] == self._base
        self._floor = _floor(model, world)
        self._held: dict[bytes, _Contacts] = {}
        self._touches: dict[bytes, bool] = {}

    def release(self) -> None:
        """Forget the stored contacts."""
        self._held.clear()

    def hold(self, key: bytes) -> bool:
        """Store the current contacts; return whether any part of the robot touches anything, including the ground.

        Args:
            key: Bytes of the pairs of geoms in contact; for the same pairs, the last contacts are held.
        """
        if key not in self._touches:
            pairs = self._data.contact.geom
            own = self._own[pairs]
            if len(self._touches) == MAX_KNOWN:
                self._touches.clear()
            self._touches[key] = bool(((own[:, 0] != own[:, 1]) & ~self._floor[pairs].any(axis=1)).any())
        if not self._touches[key]:
            return False
        contact, place, turned = self._data.contact, self._data.xpos[self._base], self._data.xmat[self._base]
        steep = np.abs(contact.frame[:, 2]) < MIN_SUPPORT_COSINE
        key += steep.tobytes()
        self._held.pop(key, None)  # Keep the order of the last contacts.
        self._held[key] = _Contacts(contact.geom.copy(), contact.pos.copy(), steep, place.copy(), turned.copy())
        return True

    def bearings(self) -> tuple[float, ...]:
        """Return the bearings of contacts since the last tick in the robot's frame, left positive, sorted [rad].

        Two parts that touched in several steps count once, with the last bearings.
        """
        if self._data.ncon:
            self.hold(self._data.contact.geom.tobytes())
        found: dict[tuple[int, int], list[float]] = {}
        for contacts in self._held.values():
            found |= self._bearings(contacts)
        return tuple(sorted(chain.from_iterable(found.values())))

    def _bearings(self, contacts: _Contacts) -> dict[tuple[int, int], list[float]]:
        """Return the bearings of contacts by pairs of geoms [rad]."""
        pairs = contacts.pairs
        own = self._own[pairs]
        touched = (own[:, 0] != own[:, 1]) & ~self._floor[pairs].any(axis=1)
        # A wheel or a caster also rolls on objects; for the body every contact is a bump, whatever the angle.
        touched &= self._body[pairs].any(axis=1) | contacts.steep
        x, y, _ = ((contacts.places[touched] - contacts.place) @ contacts.turned.reshape(3, 3)).T
        found: dict[tuple[int, int], list[float]] = {}
        for (first, second), bearing in zip(pairs[touched].tolist(), np.arctan2(y, x).tolist(), strict=True):
            found.setdefault((first, second), []).append(bearing)
        return found


class Bumpers:
    """The bumpers of all robots of a simulation, which store contacts from one tick to the next."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, bumpers: Sequence[Bumper], world: World) -> None:
        """Store the state and the bumpers."""
        self._data, self._bumpers, self._steps, self._count = data, bumpers, world.run.steps_per_tick, 0
        self._known = set[bytes]()
        roots = [model.body(f"{robot.name}/base").id for robot in world.robots]
        dt = self._steps * model.opt.timestep
        self._bound = ContactBound(model, data, roots, _floor(model, world), dt=dt)

    def before_tick(self, *, forced: bool) -> list[Callable[[], None]]:
        """Return the functions to call after each step of the coming tick: none if no robot can touch anything.

        Args:
            forced: Whether forces or motions from outside act in this tick.
        """
        if forced or not self._bound.are_clear():
            return [self.after_step]
        for bumper in self._bumpers:
            bumper.release()
        return []

    def after_step(self) -> None:
        """Store the contacts at the start of the step just taken; those at the start of a tick were read before."""
        first, self._count = self._count == 0, (self._count + 1) % self._steps
        if first:
            for bumper in self._bumpers:
                bumper.release()
            return
        # Usually only wheels touch the floor: a known set of contacts.
        if (pairs := self._data.contact.geom.tobytes()) in self._known:
            return
        if not any([bumper.hold(pairs) for bumper in self._bumpers]):
            if len(self._known) == MAX_KNOWN:
                self._known.clear()
            self._known.add(pairs)


def _floor(model: mujoco.MjModel, world: World) -> NDArray[np.bool_]:
    """Return which geoms are the floor."""
    floor = model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE
    for name in item_names(world.floor.patches):
        floor[model.geom(f"floor/{name}").id] = True
    return np.asarray(floor)
