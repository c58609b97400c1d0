"""Mechanisms with prescribed motions, and all mechanisms of a world."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property, partial

import mujoco
import numpy as np

from mjsim.errors import PhysicsFault
from mjsim.geometry import Array
from mjsim.mechanics import JointMotion, SensorReadings, rates, residual, tracked
from mjsim.sim.control_loop import ControlActuation
from mjsim.sim.mechanisms.mechanism_control import MechanismControls
from mjsim.sim.mechanisms.mechanism_motion import MechanismAtWork
from mjsim.sim.mechanisms.mechanism_sensors import MechanismState
from mjsim.world import World

LED_MODES = ("inverse", "kinematics")
MISSED = 1e-6
"""Maximum error of prescribed loops [rad, m]."""


class LedMechanism(MechanismAtWork):
    """A mechanism in which motions prescribe each degree of freedom exactly, at every step.

    Forces do not move it; the forces that the motion requires are computed. Objects in contact with it feel its speed.
    """

    _power: tuple[float, float]
    """Time of the last tick, and the power of all motions then [s, W]."""
    _work: float
    """Work of the motions up to that time, by the trapezoidal rule over ticks [J]."""

    @property
    def moved(self) -> bool:
        """Whether something drives it: always true."""
        return True

    def act(self, step: int) -> None:
        """Set its pose at a step."""
        super().act(step)
        self._put(step)

    def settle(self, step: int) -> None:
        """Set its pose at the end of a tick, before the step of that number."""
        super().settle(step)
        self._put(step)

    def state(self, step: int) -> MechanismState:
        """Return its motion before the step of that number."""
        self._put(step)
        self._exact(step, self._data.qvel.copy())
        mujoco.mj_rnePostConstraint(self._model, self._scratch)
        now, time = self._motion_state(step, 0.0, 0.0), step * self._h
        power = float(now.efforts @ now.speeds) + sum(force * speed for force, speed in now.pulls.values())
        self._work += (power + self._power[1]) / 2.0 * (time - self._power[0])
        self._power = time, power
        return replace(now, work=self._work)

    def _go_to(self, step: int) -> None:
        """Do nothing: the forces of the physics do not drive it."""

    def _found_fault(self) -> str:
        """Return '': its motions determine its pose."""
        return ""

    def _lagging(self) -> Array:
        """Return zero forces: its speeds are current."""
        return np.zeros(len(self._places.dofs))

    def _begin(self) -> None:
        self._power, self._work = (0.0, 0.0), 0.0
        self._now = self._assembly.start.copy()
        self.act(0)

    def _put(self, step: int) -> None:
        """Solve for all values and speeds at a step, and write them."""
        linkage, rows = self._assembly.linkage, [*self._assembly.rows, *self._leading.locks.led(step)]
        slopes = [follower.slope(step * self._h)[0] for follower in self._followers]
        rates_of_rows = [np.zeros(self._held), np.array(slopes)]
        self._now = tracked(linkage, rows, self._now, columns=range(linkage.size))
        if np.abs(residual(linkage, rows, self._now)).max(initial=0.0) > MISSED and (line := self.locked(step)):
            raise PhysicsFault(f"physics failed at {step * self._h:.2f} s: {line}")
        speeds, _ = rates(linkage, rows, self._now, held={}, targets=np.concatenate(rates_of_rows))
        self._places.write(self._data, self._assembly, self._now, speeds)

    @cached_property
    def _held(self) -> int:
        """Return the number of constraint rows besides the motions."""
        return len(residual(self._assembly.linkage, self._assembly.rows, self._now))

    def _accelerations(self, step: int) -> dict[int, float]:
        return {each.equality: each.slope(step * self._h)[1] for each in self._followers}


class Mechanisms:
    """All mechanisms of a world during a run."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, world: World, *, seed: int) -> None:
        """Set them to their initial values.

        Args:
            model: The compiled world.
            data: Its state, at the start.
            world: The world.
            seed: Seed of the run.
        """
        self._all = [
            (LedMechanism if each.mode in LED_MODES else MechanismAtWork)(
                model, data, each, seed=seed, read=world.read_asset
            )
            for each in world.mechanisms
        ]
        self._controls: list[MechanismControls] | None = None
        self._make_control = partial(MechanismControls, model, data, world=world, seed=seed)
        self._per_tick = world.run.steps_per_tick
        self._now: tuple[int, dict[str, tuple[JointMotion, SensorReadings]]] = -1, {}

    def acting(self) -> list[MechanismAtWork]:
        """Return the mechanisms that something drives."""
        return [each for each in self._all if each.moved]

    def held(self) -> list[MechanismAtWork]:
        """Return the mechanisms that are currently moved only by a hand."""
        return [each for each in self._all if each.held and not each.moved]

    def controls(self) -> list[ControlActuation]:
        """Return all their controllers, created and started at the first call."""
        if self._controls is None:
            self._controls = [self._make_control(each.mechanism) for each in self._all]
        return [actuation for each in self._controls for actuation in each.actuations]

    def close(self) -> None:
        """Close controller modules with resources other than memory."""
        for each in self._controls or ():
            each.close()

    def settle(self, tick: int) -> None:
        """Set all mechanisms to their poses at a tick."""
        for each in self._all:
            each.settle(tick * self._per_tick)

    def lead(self, name: str, goals: Mapping[str, float | None], tick: int) -> None:
        """Move joints of a mechanism to values from a tick on [rad, m]; None returns or releases one."""
        self._named(name).lead(goals, tick * self._per_tick)

    def barred(self, name: str, goals: Mapping[str, float | None], tick: int) -> str:
        """Return why loops do not permit a `lead`, as text; '' if they do."""
        return self._named(name).barred(goals, tick * self._per_tick)

    def _named(self, name: str) -> MechanismAtWork:
        return next(each for each in self._all if each.mechanism.name == name)

    def failing(self, tick: int, *, known: bool) -> str:
        """Return why the physics fails at a tick, as text: motions that a loop does not permit, or a loop that opens.

        Args:
            tick: Number of the tick.
            known: Whether the failure is already known.
        """
        for each in self._all:
            if known or each.fault:
                line = each.locked(tick * self._per_tick) or each.fault
                if line:
                    return line
        return ""

    def motions(self, tick: int) -> dict[str, JointMotion]:
        """Return the motion of each mechanism's joints at a tick, by name."""
        return {name: motion for name, (motion, _) in self._at(tick).items()}

    def readings(self, tick: int) -> dict[str, SensorReadings]:
        """Return the readings of each mechanism's sensors at a tick, by name."""
        return {name: readings for name, (_, readings) in self._at(tick).items()}

    def _at(self, tick: int) -> dict[str, tuple[JointMotion, SensorReadings]]:
        """Return motions and readings at a tick, computed once."""
        if self._now[0] != tick:
            self._now = tick, {each.mechanism.name: each.motion(tick * self._per_tick) for each in self._all}
        return self._now[1]
