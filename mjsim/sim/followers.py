"""Motions that joints follow: what an equality constraint must aim at so that the joint is where its signal is.

A constraint of MuJoCo pulls like a spring with a damper, k (y - q) - b q', and so lags behind what moves. It is led by
what that lag would be: it aims at y + (b y' + y'') / k. The derivatives are those of the steps of the physics, which
are exact for them: the speed of step n is (y[n] - y[n-1]) / h.
"""

import mujoco

from mjsim.world import Motion


class Follower:
    """One motion, at every step of the physics."""

    def __init__(self, model: mujoco.MjModel, equality: int, drive: Motion, *, start: float) -> None:
        """Get ready.

        Args:
            model: The compiled world.
            equality: Number of the constraint.
            drive: What is followed.
            start: Value of the joint or distance at the start [rad, m].
        """
        self._model, self.equality, self.drive = model, equality, drive
        self._h = float(model.opt.timestep)
        time_constant, impedance = float(model.eq_solref[equality, 0]), float(model.eq_solimp[equality, 1])
        self._damping = 2.0 / (impedance * time_constant)
        self._stiffness = 1.0 / (impedance * time_constant**2)
        self._rest = float(start)
        """Where the constraint counts from."""
        speed, change = self._slope(0.0)
        before = start - self._h * (speed - self._h / 2.0 * change)
        self._n, self._window = 0, [before, start, start]
        self._window[2] = self._after(0)

    def _slope(self, time: float) -> tuple[float, float]:
        """Return speed and acceleration of the motion at a time [s]."""
        signal = self.drive.signal
        if self.drive.kind == "velocity":
            return float(signal.value(time)), float(signal.rate(time))
        return float(signal.rate(time)), float(signal.second(time))

    def _after(self, n: int) -> float:
        """Return the value one step after the window's middle, which is at step n."""
        if self.drive.kind != "velocity":
            return float(self.drive.signal.value((n + 1) * self._h))
        here, there = (float(self.drive.signal.value((n + k) * self._h)) for k in (0, 1))
        return self._window[1] + self._h * (here + there) / 2.0

    def _go_to(self, n: int) -> None:
        while self._n < n:
            self._n += 1
            self._window = [*self._window[1:], 0.0]
            self._window[2] = self._after(self._n)

    def goal(self, n: int) -> float:
        """Return where the joint shall be at step n [rad, m]."""
        self._go_to(n)
        return self._window[1]

    def speed(self, n: int) -> float:
        """Return how fast the physics has it move at step n: half a step earlier than its goal [1/s]."""
        self._go_to(n)
        return (self._window[1] - self._window[0]) / self._h

    def acceleration(self, n: int) -> float:
        """Return its acceleration at step n [1/s^2]."""
        self._go_to(n)
        before, here, after = self._window
        return (after - 2.0 * here + before) / self._h**2

    def aim(self, n: int) -> None:
        """Set what the constraint aims at in step n."""
        lead = (self._damping * self.speed(n) + self.acceleration(n)) / self._stiffness
        self._model.eq_data[self.equality, 0] = self.goal(n) + lead - self._rest
