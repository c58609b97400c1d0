"""Simulated arms: goals, encoder readings and true motion."""

from collections.abc import Sequence
from dataclasses import fields

import mujoco
import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import ArmInfo, Command, JointGoal, JointState
from mjsim.mechanics import JointMotion
from mjsim.sentences import Sentence
from mjsim.sim.fast_senses import JointEncoders
from mjsim.world import Robot, RobotArm

HAND_SPEED = 1.0
"""Speed of joints moved by events, unless their limits are lower [rad/s, m/s]."""
TIME_ROUNDING = 1e-9
"""Rounding error of a time within a tick [s]."""


class ArmAtWork:
    """One arm of a robot: converts goals to set-points for its controller."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, item: RobotArm, *, tick: float
    ) -> None:
        """Initialise, holding the initial posture.

        Args:
            model: The compiled world.
            data: Its state.
            robot: Robot with the arm.
            item: Item of the world file.
            tick: Period of the loop [s].
        """
        self._model, self._data, self._tick, self.name = model, data, tick, item.name
        self._names = tuple(f"joint{number}" for number in range(1, item.arm.n + 1))
        self.motors = tuple(f"{item.name}/{name}" for name in self._names)
        """Names without the robot's."""
        self._joints = [f"{robot.name}/{motor}" for motor in self.motors]
        self._places = np.array([model.joint(name).qposadr[0] for name in self._joints], dtype=int)
        self._dofs = np.array([model.joint(name).dofadr[0] for name in self._joints], dtype=int)
        self._tool = model.site(f"{robot.name}/{item.name}/tool").id
        self._encoders = self.encoders()
        self._goal, self._since = JointGoal(positions=item.start()), 0.0
        self._led: Array | None = None
        self._rates = np.minimum([link.max_velocity for link in item.arm.links], HAND_SPEED)
        # Dry friction that depends on direction is represented by its mean, in the scene, and a constant torque.
        data.qfrc_applied[self._dofs] = [-abs(link.gear) * sum(link.coulomb) / 2.0 for link in item.arm.links]
        self.info = _info(item, self._names)

    def encoders(self) -> JointEncoders:
        """Return new encoders of its joints, for one reader."""
        return JointEncoders(self._model, self._data, self._joints)

    def read(self, stamp: float) -> JointState:
        """Return the encoder readings for modules at a tick [s]."""
        return self._encoders.read(stamp)

    def command(self, goal: JointGoal) -> None:
        """Take a goal; it is extrapolated with its velocities and accelerations for one tick, then held.

        Raises:
            UsageError: It does not match the arm, or is not finite.
        """
        for part in fields(goal):
            values = getattr(goal, part.name)
            if values is not None and (len(values) != len(self._names) or not np.isfinite(values).all()):
                raise UsageError(
                    Sentence(
                        "the goal of arm '{name}' has {other_name} {tuple}; give {count} finite numbers, one for "
                        "each joint",
                        self.name,
                        part.name,
                        tuple(values),
                        len(self._names),
                    )
                )
        if self._led is None:
            self._goal, self._since = goal, 0.0

    def lead(self, values: Array | None) -> None:
        """Move the joints to values within their limits [rad, m] in place of goals; None returns to goals."""
        self._led = values

    def goal(self) -> Array:
        """Return the current set-points of the joints, shape (n,) [rad, m]."""
        return np.array(self._goal.after(min(self._since, self._tick)).positions)

    def before_step(self) -> None:
        """Set the goal of the next tick, if an event moves the joints."""
        if self._led is not None:
            now = self.goal()
            rates = np.clip((self._led - now) / self._tick, -self._rates, self._rates)
            self._goal = JointGoal(positions=tuple(now.tolist()), velocities=tuple(rates.tolist()))
            self._since = 0.0

    def wanted(self, seconds: float) -> Command:
        """Return the set-points for the next period [s], and advance by it."""
        if self._since > self._tick - TIME_ROUNDING:
            self._goal, self._since = JointGoal(positions=self._goal.after(self._tick).positions), 0.0
        goal = self._goal.after(self._since)
        self._since += seconds
        return Command(joints={self.name: goal})

    def motion(self) -> JointMotion:
        """Return the motion of its joints, and the pose of its tool."""
        data, pose = self._data, np.eye(4)
        pose[:3, :3], pose[:3, 3] = data.site_xmat[self._tool].reshape(3, 3), data.site_xpos[self._tool]
        return JointMotion(
            names=self._names,
            positions=data.qpos[self._places],
            velocities=data.qvel[self._dofs],
            accelerations=data.qacc[self._dofs],
            torques=data.qfrc_actuator[self._dofs],
            goal=self.goal(),
            tool=pose,
        )


def _info(item: RobotArm, names: Sequence[str]) -> ArmInfo:
    lower, upper = item.arm.limits
    return ArmInfo(
        joints=tuple(names),
        lower=lower,
        upper=upper,
        max_velocity=np.array([link.max_velocity for link in item.arm.links]),
        max_torque=np.array([link.max_torque for link in item.arm.links]),
        model=item.arm,
    )
