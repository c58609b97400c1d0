"""Motions that joints follow: what an equality constraint must aim at so that the joint is where its signal is.

A constraint of MuJoCo pulls like a spring with a damper, k (y - q) - b q', and so lags behind what moves. It is led by
what that lag would be: it aims at y + (b y' + y'') / k. The derivatives are those of the steps of the physics, which
are exact for them: the speed of step n is (y[n] - y[n-1]) / h.
"""

import mujoco

from mjsim.world import Motion


class Course:
    """One motion, at every step of the physics."""

    def __init__(self, drive: Motion, *, step: float, start: float) -> None:
        """Begin at the start.

        Args:
            drive: What is followed.
            step: Period of the physics [s].
            start: Value of the joint or distance at the start [rad, m].
        """
        self.drive, self._h = drive, step
        speed, change = self.slope(0.0)
        before = start - self._h * (speed - self._h / 2.0 * change)
        self._n, self._window = 0, [before, start, start]
        self._window[2] = self._after(0)

    def slope(self, time: float) -> tuple[float, float]:
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

    @property
    def last(self) -> float:
        """Where the joint was a step ago [rad, m]."""
        return self._window[0]

    def speed(self, n: int) -> float:
        """Return how fast the physics has it move at step n: half a step earlier than its goal [1/s]."""
        self._go_to(n)
        return (self._window[1] - self._window[0]) / self._h

    def acceleration(self, n: int) -> float:
        """Return its acceleration at step n [1/s^2]."""
        self._go_to(n)
        before, here, after = self._window
        return (after - 2.0 * here + before) / self._h**2


class Follower(Course):
    """A motion that an equality constraint makes a joint follow."""

    def __init__(self, model: mujoco.MjModel, equality: int, drive: Motion, *, start: float) -> None:
        """Get ready.

        Args:
            model: The compiled world.
            equality: Number of the constraint.
            drive: What is followed.
            start: Value of the joint or distance at the start [rad, m], from which the constraint counts.
        """
        super().__init__(drive, step=float(model.opt.timestep), start=start)
        self._model, self.equality, self._rest = model, equality, start
        time_constant, impedance = float(model.eq_solref[equality, 0]), float(model.eq_solimp[equality, 1])
        self._damping = 2.0 / (impedance * time_constant)
        self._stiffness = 1.0 / (impedance * time_constant**2)

    def aim(self, n: int, data: mujoco.MjData) -> None:
        """Set what the constraint aims at in step n; the state still has the forces of the step before."""
        lead = (self._damping * self.speed(n) + self.acceleration(n)) / self._stiffness
        self._model.eq_data[self.equality, 0] = (
            self.goal(n) + lead + yielded(self._model, data, self.equality) - self._rest
        )


def yielded(model: mujoco.MjModel, data: mujoco.MjData, equality: int) -> float:
    """Return by how much a constraint of one row gave way to its force in the last step [rad, m].

    It is softened by R, so that its acceleration falls short by R f; what it aims at can make up for that.
    """
    count = int(data.ne)
    own = (data.efc_id[:count] == equality) & (data.efc_type[:count] == mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    time_constant, impedance = float(model.eq_solref[equality, 0]), float(model.eq_solimp[equality, 1])
    return float(data.efc_R[:count][own] @ data.efc_force[:count][own]) * impedance * time_constant**2
