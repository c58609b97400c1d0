"""All mechanisms of a world during a run; worlds without mechanisms do not load their code."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import mujoco

from mjsim.mechanics import JointMotion, SensorReadings
from mjsim.world import World

if TYPE_CHECKING:
    from mjsim.sim.control_loop import ControlActuation
    from mjsim.sim.mechanisms.mechanism_control import MechanismControls
    from mjsim.sim.mechanisms.mechanism_motion import MechanismAtWork


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
        self._model, self._data, self._world, self._seed = model, data, world, seed
        self._all = self._at_work() if world.mechanisms else []
        self._controls: list[MechanismControls] | None = None
        self._per_tick = world.run.steps_per_tick
        self._now: tuple[int, dict[str, tuple[JointMotion, SensorReadings]]] = -1, {}

    def acting(self) -> "list[MechanismAtWork]":
        """Return the mechanisms that something drives."""
        return [each for each in self._all if each.moved]

    def held(self) -> "list[MechanismAtWork]":
        """Return the mechanisms that are currently moved only by a hand."""
        return [each for each in self._all if each.held and not each.moved]

    def controls(self) -> "list[ControlActuation]":
        """Return all their controllers, created and started at the first call."""
        if self._controls is None:
            self._controls = self._made_controls() if self._all else []
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

    def _named(self, name: str) -> "MechanismAtWork":
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

    def _at_work(self) -> "list[MechanismAtWork]":
        from mjsim.sim.mechanisms.prescribed import mechanism_at_work

        return [
            mechanism_at_work(self._model, self._data, each, seed=self._seed, read=self._world.read_asset)
            for each in self._world.mechanisms
        ]

    def _made_controls(self) -> "list[MechanismControls]":
        from mjsim.sim.mechanisms.mechanism_control import MechanismControls

        return [
            MechanismControls(self._model, self._data, each.mechanism, world=self._world, seed=self._seed)
            for each in self._all
        ]
