"""Mechanisms with prescribed motions, and all mechanisms of a world."""

from dataclasses import replace
from functools import cached_property, partial

import mujoco
import numpy as np

from mjsim.errors import PhysicsFault
from mjsim.geometry import Array
from mjsim.mechanics import JointMotion, SensorReadings, rates, residual, tracked
from mjsim.sim.control import ControlActuation
from mjsim.sim.mechanism_control import MechanismControls
from mjsim.sim.mechanism_sensors import MechanismState
from mjsim.sim.mechanisms import MechanismAtWork
from mjsim.world import World

LED_MODES = ("inverse", "kinematics")
MISSED = 1e-6
"""By which loops that are led exactly miss at most [rad, m]."""


class LedMechanism(MechanismAtWork):
    """A mechanism each freedom of which follows a motion: it is where that has it, at every step.

    Forces do not move it; those that the motion takes are worked out. What it touches feels its speed.
    """

    _power: tuple[float, float]
    """Time of the last tick, and the power of all motions then [s, W]."""
    _work: float
    """Of the motions up to then, by the trapezoidal rule over ticks [J]."""

    @property
    def moved(self) -> bool:
        """Whether something moves it: always."""
        return True

    def act(self, step: int) -> None:
        """Put it where it is at a step."""
        super().act(step)
        self._put(step)

    def settle(self, step: int) -> None:
        """Put it where it is at the end of a tick, before the step of that number."""
        super().settle(step)
        self._put(step)

    def state(self, step: int) -> MechanismState:
        """Return how it moves now, before the step of that number."""
        self._put(step)
        self._exact(step, self._data.qvel.copy())
        mujoco.mj_rnePostConstraint(self._model, self._scratch)
        now, time = self._told(step, 0.0, 0.0), step * self._h
        power = float(now.efforts @ now.speeds) + sum(force * speed for force, speed in now.pulls.values())
        self._work += (power + self._power[1]) / 2.0 * (time - self._power[0])
        self._power = time, power
        return replace(now, work=self._work)

    def _go_to(self, step: int) -> None:
        """Note nothing: the forces of the physics are not those that lead it."""

    def _found_fault(self) -> str:
        """Return nothing: it is where its motions have it."""
        return ""

    def _lagging(self) -> Array:
        """Return no forces: its speeds are those of now."""
        return np.zeros(len(self._places.dofs))

    def _begin(self) -> None:
        self._power, self._work = (0.0, 0.0), 0.0
        self._now = self._assembly.start.copy()
        self.act(0)

    def _put(self, step: int) -> None:
        """Solve for all values and speeds at a step, and write them."""
        linkage, rows = self._assembly.linkage, [*self._assembly.rows, *self._locks.led(step)]
        slopes = [follower.slope(step * self._h)[0] for follower in self._followers]
        wanted = [np.zeros(self._held), np.array(slopes)]
        self._now = tracked(linkage, rows, self._now, columns=range(linkage.size))
        if np.abs(residual(linkage, rows, self._now)).max(initial=0.0) > MISSED and (line := self.locked(step)):
            raise PhysicsFault(f"physics failed at {step * self._h:.2f} s: {line}")
        speeds, _ = rates(linkage, rows, self._now, held={}, wanted=np.concatenate(wanted))
        self._places.write(self._data, self._assembly, self._now, speeds)

    @cached_property
    def _held(self) -> int:
        """How many rows hold it beside the motions."""
        return len(residual(self._assembly.linkage, self._assembly.rows, self._now))

    def _accelerations(self, step: int) -> dict[int, float]:
        return {each.equality: each.slope(step * self._h)[1] for each in self._followers}


class Mechanisms:
    """All mechanisms of a world at work."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, world: World, *, seed: int) -> None:
        """Set them to their starts.

        Args:
            model: The compiled world.
            data: Its state, at the start.
            world: As it was written.
            seed: Of the run.
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
        """Return those that something moves."""
        return [each for each in self._all if each.moved]

    def held(self) -> list[MechanismAtWork]:
        """Return those that nothing but a hand moves now."""
        return [each for each in self._all if each.held and not each.moved]

    def controls(self) -> list[ControlActuation]:
        """Return the controllers of all, made and started with the first call."""
        if self._controls is None:
            self._controls = [self._make_control(each.mechanism) for each in self._all]
        return [actuation for each in self._controls for actuation in each.actuations]

    def close(self) -> None:
        """Close the modules of controllers that hold more than memory."""
        for each in self._controls or ():
            each.close()

    def settle(self, tick: int) -> None:
        """Bring all to where they are at a tick."""
        for each in self._all:
            each.settle(tick * self._per_tick)

    def lead(self, name: str, joint: str, goal: float | None, tick: int) -> None:
        """From a tick on bring a joint of a mechanism to a value [rad, m]; None: back, or let go."""
        self._named(name).lead(joint, goal, tick * self._per_tick)

    def barred(self, name: str, joint: str, goal: float | None, tick: int) -> str:
        """Return how loops do not allow what `lead` does, in words; '' where they do."""
        return self._named(name).barred(joint, goal, tick * self._per_tick)

    def _named(self, name: str) -> MechanismAtWork:
        return next(each for each in self._all if each.mechanism.name == name)

    def failing(self, tick: int, *, known: bool) -> str:
        """Return why physics fails at a tick, in words: motions that a loop does not allow, or a loop that gives way.

        Args:
            tick: Which.
            known: Whether it is known to fail.
        """
        for each in self._all:
            if known or each.fault:
                line = each.locked(tick * self._per_tick) or each.fault
                if line:
                    return line
        return ""

    def motions(self, tick: int) -> dict[str, JointMotion]:
        """Return how the joints of each mechanism move at a tick, by its name."""
        return {name: motion for name, (motion, _) in self._at(tick).items()}

    def readings(self, tick: int) -> dict[str, SensorReadings]:
        """Return what the sensors of each mechanism read at a tick, by its name."""
        return {name: readings for name, (_, readings) in self._at(tick).items()}

    def _at(self, tick: int) -> dict[str, tuple[JointMotion, SensorReadings]]:
        """Return all of a tick; worked out once."""
        if self._now[0] != tick:
            self._now = tick, {each.mechanism.name: each.motion(tick * self._per_tick) for each in self._all}
        return self._now[1]
