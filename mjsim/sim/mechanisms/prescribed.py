"""Mechanisms with prescribed motions."""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property

import mujoco
import numpy as np

from mjsim.errors import PhysicsFault
from mjsim.geometry import Array
from mjsim.mechanics import rates, residual, tracked
from mjsim.sentences import Sentence
from mjsim.sim.mechanisms.mechanism_motion import MechanismAtWork
from mjsim.sim.mechanisms.mechanism_sensors import MechanismState
from mjsim.world import Mechanism

LED_MODES = ("inverse", "kinematics")
MAX_LOOP_ERROR = 1e-6
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
        """Whether it is driven: always true."""
        return True

    def act(self, step: int) -> None:
        """Set its pose at a step."""
        super().act(step)
        self._put(step)

    def settle(self, step: int) -> None:
        """Set its pose at the end of a tick, before a given step."""
        super().settle(step)
        self._put(step)

    def state(self, step: int) -> MechanismState:
        """Return its motion before a given step."""
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
        if np.abs(residual(linkage, rows, self._now)).max(initial=0.0) > MAX_LOOP_ERROR and (line := self.locked(step)):
            raise PhysicsFault(Sentence("physics failed at {step:.2f} s: {line}", step * self._h, line))
        speeds, _ = rates(linkage, rows, self._now, held={}, targets=np.concatenate(rates_of_rows))
        self._places.write(self._data, self._assembly, self._now, speeds)

    @cached_property
    def _held(self) -> int:
        """Return the number of constraint rows besides the motions."""
        return len(residual(self._assembly.linkage, self._assembly.rows, self._now))

    def _accelerations(self, step: int) -> dict[int, float]:
        return {each.equality: each.slope(step * self._h)[1] for each in self._followers}


def mechanism_at_work(
    model: mujoco.MjModel, data: mujoco.MjData, mechanism: Mechanism, *, seed: int, read: Callable[[str], bytes]
) -> MechanismAtWork:
    """Return a running mechanism of the kind that its mode needs; see `MechanismAtWork`."""
    kind = LedMechanism if mechanism.mode in LED_MODES else MechanismAtWork
    return kind(model, data, mechanism, seed=seed, read=read)
