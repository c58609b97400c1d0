"""Motions that joints follow: the target of an equality constraint that keeps the joint on its signal.

A constraint of MuJoCo acts like a spring with a damper, k (y - q) - b q', and so lags behind a moving target. The lag
is compensated: the target is y + (b y' + y'') / k, with b = 1 / h and k = 1 / h^2 as in `mjsim.compile`. The
derivatives are those of the steps of the physics, which are exact for them: the speed of step n is (y[n] - y[n-1]) / h.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.world import Motion

MAX_JOINT_SPEED = 1.0
"""Largest speed of a joint on its way to a goal, unless it is faster already [rad/s, m/s]."""
MIN_DURATION = 0.4
"""Minimum duration of a motion to a goal [s]."""
STRETCHES = tuple(1.1**k for k in range(20))
"""Factors on the duration from rest that are tried if a joint moves away from its goal."""
SPEED_TOLERANCE = 1.0 + 1e-6
"""Tolerance factor of speeds against rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Blend:
    """A motion to rest at another value: a polynomial of degree 5 with continuous acceleration."""

    begin: float
    """[s]"""
    seconds: float
    """Its duration [s]."""
    factors: Array
    """Coefficients of the powers 0 to 5 of the time relative to the duration, shape (6,)."""

    @classmethod
    def to(cls, goal: float, *, begin: float, value: float, speed: float, change: float, far: float = 0.0) -> "Blend":
        """Return the motion to a goal from a value with a speed and an acceleration, at a time [s].

        `far` is the change of another value that it moves, which has the same largest speed [rad, m].
        """
        # The maximum speed of such a motion from rest is 15/8 of its mean.
        seconds = max(MIN_DURATION, 15.0 / 8.0 * max(abs(goal - value), far) / MAX_JOINT_SPEED)
        # A motion that reverses first has a longer path than one from rest.
        stretches = STRETCHES if speed * (goal - value) < 0.0 else STRETCHES[:1]
        blends = [
            cls._within(seconds * stretch, goal, begin=begin, value=value, speed=speed, change=change)
            for stretch in stretches
        ]
        limit = SPEED_TOLERANCE * max(MAX_JOINT_SPEED, abs(speed))
        # If it accelerates at first, no duration may satisfy the limit.
        return next((each for each in blends if each.fastest() <= limit), min(blends, key=cls.fastest))

    @classmethod
    def _within(
        cls, seconds: float, goal: float, *, begin: float, value: float, speed: float, change: float
    ) -> "Blend":
        """Return the motion of a given duration [s]."""
        first = np.array([value, speed * seconds, change * seconds**2 / 2.0])
        rest = np.array([goal - first.sum(), -first[1] - 2.0 * first[2], -2.0 * first[2]])
        last = np.linalg.solve(np.array([[1.0, 1.0, 1.0], [3.0, 4.0, 5.0], [6.0, 12.0, 20.0]]), rest)
        return cls(begin, seconds, np.concatenate([first, last]))

    def fastest(self) -> float:
        """Return the greatest speed of the motion [rad/s, m/s]."""
        speeds = np.polynomial.Polynomial(self.factors).deriv(1)(np.linspace(0.0, 1.0, 101)) / self.seconds
        return float(np.abs(speeds).max())

    def at(self, time: float) -> tuple[float, float, float]:
        """Return value, speed and acceleration at a time not before its start [s]."""
        share = min((time - self.begin) / self.seconds, 1.0)
        polynomial = np.polynomial.Polynomial(self.factors)
        if share == 1.0:
            return float(self.factors.sum()), 0.0, 0.0
        speed, change = polynomial.deriv(1)(share) / self.seconds, polynomial.deriv(2)(share) / self.seconds**2
        return float(polynomial(share)), float(speed), float(change)


class Course:
    """One motion, at every step of the physics."""

    def __init__(self, drive: Motion, *, step: float, start: float) -> None:
        """Start with the signal.

        Args:
            drive: Motion to follow.
            step: Period of the physics [s].
            start: Value of the joint or distance at the start [rad, m].
        """
        self.drive, self._h = drive, step
        self._blend: Blend | None = None
        """Motion to a goal; None when it follows its signal."""
        self._offset: Blend | None = None
        """Remaining offset while it returns to its signal; of the speed if the signal is a speed."""
        speed, change = self.slope(0.0)
        before = start - self._h * (speed - self._h / 2.0 * change)
        self._n, self._window = 0, [before, start, start]
        self._window[2] = self._after(0)

    def slope(self, time: float) -> tuple[float, float]:
        """Return speed and acceleration of the motion at a time [s]."""
        if self._blend is not None:
            return self._blend.at(time)[1:]
        value, speed, change = self._sampled(time)
        return (value, speed) if self.drive.kind == "velocity" else (speed, change)

    def _sampled(self, time: float) -> tuple[float, float, float]:
        """Return the signal at a time [s], plus the remaining offset, and both derivatives."""
        signal = self.drive.signal
        signal_values = float(signal.value(time)), float(signal.rate(time)), float(signal.second(time))
        if self._offset is None:
            return signal_values
        value, speed, change = (one + other for one, other in zip(signal_values, self._offset.at(time), strict=True))
        return value, speed, change

    def _after(self, n: int) -> float:
        """Return the value one step after the window's middle, which is at step n."""
        if self._blend is not None:
            return self._blend.at((n + 1) * self._h)[0]
        if self.drive.kind != "velocity":
            return self._sampled((n + 1) * self._h)[0]
        current, following = (self._sampled((n + k) * self._h)[0] for k in (0, 1))
        return self._window[1] + self._h * (current + following) / 2.0

    def _go_to(self, n: int) -> None:
        while self._n < n:
            self._n += 1
            self._window = [*self._window[1:], 0.0]
            self._window[2] = self._after(self._n)

    def goal(self, n: int) -> float:
        """Return the desired value of the joint at step n [rad, m]."""
        self._go_to(n)
        return self._window[1]

    def lead(self, goal: float, n: int, *, far: float = 0.0) -> None:
        """Move to a value from step n on and stay there, regardless of the signal [rad, m]; `far` as for `Blend.to`."""
        self._go_to(n)
        speed, change = self.slope(n * self._h)
        self._offset = None
        self._blend = Blend.to(goal, begin=n * self._h, value=self._window[1], speed=speed, change=change, far=far)
        self._window[2] = self._after(n)

    def release(self, n: int, *, whole: float) -> None:
        """Follow the signal again from step n on: a joint moved to a goal returns to it; others are unchanged.

        Args:
            n: Number of the step.
            whole: Period whose multiples may remain as a difference: 2 pi for a joint without limits, or 0.
        """
        self._go_to(n)
        if self._blend is not None:
            self._offset, self._blend = self._return_blend(n, whole), None
            self._window[2] = self._after(n)

    def end(self, n: int, *, whole: float) -> float | None:
        """Return the value at which `release` reaches the signal again [rad, m]; None if the signal is a speed."""
        self._go_to(n)
        if self._blend is None or self.drive.kind == "velocity":
            return None
        blend = self._return_blend(n, whole)
        return float(self.drive.signal.value(blend.begin + blend.seconds)) + blend.at(blend.begin + blend.seconds)[0]

    def _return_blend(self, n: int, whole: float) -> Blend:
        """Return the decay of the difference from the signal, or from its speed, from step n on."""
        time, signal = n * self._h, self.drive.signal
        speed, change = self.slope(time)
        if self.drive.kind == "velocity":
            value, slope = float(signal.value(time)), float(signal.rate(time))
            return Blend.to(0.0, begin=time, value=speed - value, speed=change - slope, change=0.0)
        offset = self._window[1] - float(signal.value(time))
        whole_turns = whole * round(offset / whole) if whole else 0.0
        speed, change = speed - float(signal.rate(time)), change - float(signal.second(time))
        return Blend.to(whole_turns, begin=time, value=offset, speed=speed, change=change)

    def speed(self, n: int) -> float:
        """Return its speed in the physics at step n: half a step earlier than its goal [1/s]."""
        self._go_to(n)
        return (self._window[1] - self._window[0]) / self._h

    def middle_speed(self, n: int) -> float:
        """Return its speed at the goal of step n [1/s]."""
        return self.speed(n) + self._h / 2.0 * self.acceleration(n)

    def acceleration(self, n: int) -> float:
        """Return its acceleration at step n [1/s^2]."""
        self._go_to(n)
        before, current, after = self._window
        return (after - 2.0 * current + before) / self._h**2


class Follower(Course):
    """A motion that an equality constraint makes a joint follow."""

    def __init__(self, model: mujoco.MjModel, equality: int, drive: Motion, *, start: float) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            equality: Number of the constraint.
            drive: Motion to follow.
            start: Value of the joint or distance at the start [rad, m], the reference of the constraint.
        """
        super().__init__(drive, step=float(model.opt.timestep), start=start)
        self._model, self.equality, self._rest = model, equality, start

    def aim(self, n: int, *, gave: float) -> None:
        """Set the target of the constraint in step n, given its yield in the step before [rad, m]."""
        # The joint must be this much farther after the step.
        lead = self._h * self.speed(n) + self._h**2 * self.acceleration(n)
        self._model.eq_data[self.equality, 0] = self.goal(n) + lead + gave - self._rest


def yields(model: mujoco.MjModel, data: mujoco.MjData) -> Array:
    """Return the yield of constraints to their forces in the last step, by number, shape (neq,) [rad, m].

    Each is softened by R, so that its acceleration is too small by R f; its target can compensate for that. For a
    constraint with several rows only the last one is returned.
    """
    count, found = int(data.ne), np.zeros(model.neq)
    found[data.efc_id[:count]] = data.efc_R[:count] * data.efc_force[:count] * model.opt.timestep**2
    return found
