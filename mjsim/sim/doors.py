"""Doors at work: a motor swings a leaf to where an event wants it, gently, and a lock holds it there."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import mujoco

from mjsim.compile.doors import PUSH, inertia
from mjsim.world.doors import Leaf

SPEED = math.radians(60.0)
"""At which a motor swings a leaf [rad/s]."""
LEAD = math.radians(10.0)
"""How far the motor's aim may go ahead of a leaf that something holds up [rad]."""
STIFFNESS = 6.0
"""Natural frequency with which the leaf follows the aim, critically damped [rad/s]."""
NEAR, SLOW = math.radians(0.1), math.radians(0.1)
"""A leaf has come to its goal when it is this near [rad] and this slow [rad/s]."""


@dataclass(slots=True)
class _Swing:
    """A leaf on its way."""

    goal: float
    """[rad]"""
    aim: float
    """Where the motor wants it now [rad]."""


class _Hinge:
    """What of the compiled world belongs to one leaf."""

    def __init__(self, model: mujoco.MjModel, leaf: Leaf) -> None:
        joint = model.joint(f"door/{leaf.name}")
        self.leaf = leaf
        self.place, self.speed = int(joint.qposadr[0]), int(joint.dofadr[0])
        self.motor, self.lock = model.actuator(f"door/{leaf.name}").id, model.equality(f"door/{leaf.name}").id
        self.rest = float(model.qpos0[self.place])
        self.inertia = inertia(leaf)


class Doors:
    """The doors of a simulation: each turns freely or is locked, unless it is on its way to where it shall be."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, leaves: Iterable[Leaf]) -> None:
        """Find the leaves in the compiled world."""
        self._model, self._data = model, data
        self._hinges = {leaf.name: _Hinge(model, leaf) for leaf in leaves}
        self._swings: dict[str, _Swing] = {}

    def __contains__(self, name: object) -> bool:
        """Say whether there is a door of that name."""
        return name in self._hinges

    def names(self) -> list[str]:
        """Return the names of all doors."""
        return list(self._hinges)

    def limit(self, name: str) -> float:
        """Return how far a door swings to either side [rad]."""
        return math.radians(self._hinges[name].leaf.door.limit_deg)

    def angle(self, name: str) -> float:
        """Return how far a door stands open, positive to the left side of its wall [rad]."""
        return float(self._data.qpos[self._hinges[name].place])

    def leaf(self, name: str) -> Leaf:
        """Return where a door hangs."""
        return self._hinges[name].leaf

    def swing(self, name: str, goal: float) -> None:
        """Begin to swing a door to an angle [rad]."""
        self._data.eq_active[self._hinges[name].lock] = 0
        self._swings[name] = _Swing(goal, self.angle(name))

    @property
    def moving(self) -> bool:
        """Whether a door is on its way."""
        return bool(self._swings)

    def drive(self) -> None:
        """Set the motors for the next physics step."""
        for name, swing in list(self._swings.items()):
            hinge, angle = self._hinges[name], self.angle(name)
            speed = float(self._data.qvel[hinge.speed])
            if abs(angle - swing.goal) < NEAR and abs(speed) < SLOW:
                self._arrive(name, swing)
                continue
            dt, before = self._model.opt.timestep, swing.aim
            aim = before + min(max(swing.goal - before, -SPEED * dt), SPEED * dt)
            swing.aim = min(max(aim, angle - LEAD), angle + LEAD)
            pull = STIFFNESS**2 * (swing.aim - angle) + 2.0 * STIFFNESS * ((swing.aim - before) / dt - speed)
            limit = PUSH * hinge.leaf.width
            torque = hinge.inertia * pull + hinge.leaf.door.spring * angle
            self._data.ctrl[hinge.motor] = min(max(torque, -limit), limit)

    def _arrive(self, name: str, swing: _Swing) -> None:
        hinge = self._hinges[name]
        del self._swings[name]
        self._data.ctrl[hinge.motor] = 0.0
        if hinge.leaf.door.locked:
            self._model.eq_data[hinge.lock, 0] = swing.goal - hinge.rest
            self._data.eq_active[hinge.lock] = 1
