"""Simulated joints: a motor moves a joint smoothly to its goal, and a lock holds it there."""

from collections.abc import Iterable
from dataclasses import dataclass

import mujoco

from mjsim.world import MotorJoint

STIFFNESS = 6.0
"""Natural frequency with which a joint follows its set-point, critically damped [rad/s]."""


@dataclass(slots=True)
class _Motion:
    """A moving joint."""

    goal: float
    set_point: float
    """Current set-point of the motor."""


class _Placed:
    """Elements of the compiled world that belong to one joint."""

    def __init__(self, model: mujoco.MjModel, joint: MotorJoint) -> None:
        found = model.joint(joint.name)
        self.joint = joint
        self.position, self.velocity = int(found.qposadr[0]), int(found.dofadr[0])
        self.motor, self.lock = model.actuator(joint.name).id, model.equality(joint.name).id
        self.rest = float(model.qpos0[self.position])


class Joints:
    """The joints of mechanisms: each moves freely or is locked, unless its motor moves it."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, joints: Iterable[MotorJoint]) -> None:
        """Find the joints in the compiled world."""
        self._model, self._data = model, data
        self._placed = {joint.name: _Placed(model, joint) for joint in joints}
        self._motions: dict[str, _Motion] = {}

    def value(self, name: str) -> float:
        """Return the value of a joint [rad, m]."""
        return float(self._data.qpos[self._placed[name].position])

    def move(self, name: str, goal: float) -> None:
        """Begin to move a joint to a value within its limits [rad, m]."""
        self._data.eq_active[self._placed[name].lock] = 0
        self._motions[name] = _Motion(goal, self.value(name))

    @property
    def moving(self) -> bool:
        """Whether a joint is moving."""
        return bool(self._motions)

    def drive(self) -> None:
        """Set the motors for the next physics step."""
        for name, motion in list(self._motions.items()):
            placed, value = self._placed[name], self.value(name)
            joint, speed = placed.joint, float(self._data.qvel[placed.velocity])
            if abs(value - motion.goal) < joint.tolerance and abs(speed) < joint.tolerance:
                self._arrive(name, motion)
                continue
            dt, before = self._model.opt.timestep, motion.set_point
            set_point = before + min(max(motion.goal - before, -joint.speed * dt), joint.speed * dt)
            motion.set_point = min(max(set_point, value - joint.lead), value + joint.lead)
            pull = STIFFNESS**2 * (motion.set_point - value)
            pull += 2.0 * STIFFNESS * ((motion.set_point - before) / dt - speed)
            effort = joint.inertia * pull + joint.stiffness * value
            self._data.ctrl[placed.motor] = min(max(effort, -joint.effort), joint.effort)

    def _arrive(self, name: str, motion: _Motion) -> None:
        placed = self._placed[name]
        del self._motions[name]
        self._data.ctrl[placed.motor] = 0.0
        if placed.joint.locked:
            self._model.eq_data[placed.lock, 0] = motion.goal - placed.rest
            self._data.eq_active[placed.lock] = 1
