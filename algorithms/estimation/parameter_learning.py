"""Learns the inertial parameters of an arm's links from motor torques and the resulting motion."""

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import ArmInfo, JointState
from mjsim.mechanics import Arm

RELATIVE, PART = 0.2, 0.05
"""Prior standard deviation of a parameter: relative to its value, and to that of its link's mass at LEVER."""
LEVER = 0.3
"""Lever arm of parts of a link about its origin [m]."""
FORGETTING = 0.1
"""Rate at which the covariance returns to its initial value [1/s]."""
MODEL = 0.01
"""Standard deviation of the model error, relative to the maximum torque of each joint."""
CREEP = 0.02
"""Below about this speed, dry friction is unknown [rad/s, m/s]."""
POSTURES = 50
"""Number of postures used to find the maximum inertia and gravity torque of each joint."""
STEADY = 0.8
"""Largest gain of PD control, relative to the one at which it becomes unstable in one of these postures."""
MAX_REDUCTIONS = 200
"""Maximum number of reductions of gains."""


class ParameterLearner:
    """Parameters of the links and their covariance, by recursive least squares with exponential forgetting.

    The motion between two readings satisfies W a = y, with W the regressor and y the motor torques minus those of
    rotors and friction. Both go through one low-pass filter, so that the noise of measured rates does not bias a. The
    covariance P grows back to its initial value, never beyond: old motions are forgotten, and parameters that are not
    excited keep their values.

    References:
        Slotine and Li, Composite adaptive control of robot manipulators, Automatica 25(4), 1989; Salgado, Goodwin,
        Middleton, Modified least squares algorithm incorporating exponential resetting and forgetting, Int. J. of
        Control 47(2), 1988.
    """

    def __init__(self, arm: Arm, info: ArmInfo, *, lag: float, adaptation: float) -> None:
        """Start with the parameters of an arm.

        Args:
            arm: The assumed arm.
            info: Its limits.
            lag: Time constant of the filter [s].
            adaptation: Factor of the initial variances of the parameters.
        """
        self._arm, self._lag = arm, lag
        self.parameters = arm.parameters()
        """As in `Arm.parameters`, shape (10 n,)."""
        self._first = np.diag(adaptation * _variances(arm))
        self.covariance = self._first.copy()
        """P, shape (10 n, 10 n)."""
        self._armature, self._noise = arm.armature(), (MODEL * strength(arm, info)) ** 2
        still = np.full(arm.n, 1e-9)
        self._dry = 0.5 * (arm.friction(still) - arm.friction(-still))
        self._before: JointState | None = None
        self._seen = Filtered()

    def motion(self, state: JointState, dt: float) -> tuple[Array, Array, Array] | None:
        """Return positions, rates and accelerations that belong to the torques of a reading; None at the first one."""
        before, self._before = self._before, state
        if before is None:
            return None
        return before.positions, before.velocities, np.asarray((state.velocities - before.velocities) / dt)

    def learn(self, W: Array, qd: Array, qdd: Array, *, torques: Array, dt: float) -> None:
        """Update the parameters with a motion.

        Args:
            W: The regressor of the motion, shape (n, 10 n).
            qd: Rates of the joints, shape (n,).
            qdd: Their accelerations, shape (n,).
            torques: Torques of the motors at the joints, shape (n,).
            dt: Time since the last one [s].
        """
        y = torques - self._armature * qdd - self._arm.friction(qd)
        variances = self._noise + (self._dry * np.exp(-np.abs(qd) / CREEP)) ** 2
        W, y, variances = self._seen.add((W, y, variances), 1.0 - np.exp(-dt / self._lag))
        PWT = self.covariance @ W.T
        gain = np.linalg.solve(W @ PWT + np.diag(variances), PWT.T).T
        self.parameters = self.parameters + gain @ (y - W @ self.parameters)
        P = self.covariance - gain @ PWT.T
        P += FORGETTING * dt * (self._first - P)
        self.covariance = 0.5 * (P + P.T)

    def correct(self, change: Array) -> None:
        """Change the parameters by P times a vector, shape (10 n,)."""
        self.parameters = self.parameters + self.covariance @ change


class Filtered:
    """First-order low-pass filters of arrays: each is a weighted mean of all its inputs."""

    def __init__(self) -> None:
        """Start without inputs."""
        self._sums: tuple[Array, ...] = ()
        self._weight = 0.0

    def add(self, arrays: tuple[Array, ...], share: float) -> tuple[Array, ...]:
        """Add new arrays with a relative weight, and return the means."""
        sums = self._sums or tuple(np.zeros_like(array) for array in arrays)
        self._sums = tuple(total + share * (array - total) for total, array in zip(sums, arrays, strict=True))
        self._weight += share * (1.0 - self._weight)
        return tuple(total / self._weight for total in self._sums)


def _variances(arm: Arm) -> Array:
    """Return the initial variance of each parameter, shape (10 n,)."""
    lever = np.array([1.0, *[LEVER] * 3, *[LEVER**2] * 6])
    by_mass = (np.array([[link.mass] for link in arm.links]) * lever).reshape(-1)
    return np.asarray((RELATIVE * arm.parameters()) ** 2 + (PART * by_mass) ** 2)


def postures(info: ArmInfo) -> Array:
    """Return seeded values of the joints within their limits, shape (POSTURES, n)."""
    lower, upper = (np.clip(limits, -np.pi, np.pi) for limits in (info.lower, info.upper))
    return np.random.default_rng(0).uniform(lower, upper, (POSTURES, len(lower)))


def largest_inertia(arm: Arm, info: ArmInfo) -> Array:
    """Return the largest inertia that each joint feels, shape (n,) [kg m^2, kg]."""
    found: Array = np.diagonal(arm.inertia(postures(info)), axis1=-2, axis2=-1).max(axis=0)
    return found


def steady_inertia(arm: Arm, info: ArmInfo, phase: float) -> Array:
    """Return the inertia of each joint for which PD control is stable: the largest one where possible, shape (n,).

    With Kp = w^2 D, Kd = 2 w D and steps h, motions along an eigenvector of M^-1 D with the value k follow
    v' = v - h k (2 w v + w^2 x), x' = x + h v'. They are stable (Jury) if k (4 w h + (w h)^2) < 4.

    Args:
        arm: The arm.
        info: Limits of its joints.
        phase: w h.
    """
    bound = STEADY * 4.0 / (4.0 * phase + phase**2)
    inertia, all_masses = largest_inertia(arm, info), arm.inertia(postures(info))
    for _ in range(MAX_REDUCTIONS):
        root = np.sqrt(inertia)
        sizes, vectors = np.linalg.eigh(root[:, None] * np.linalg.inv(all_masses) * root)
        worst = int(np.argmax(sizes[:, -1]))
        if sizes[worst, -1] <= bound:
            break
        # Reduce the gains of the joints that take part in the fastest motion.
        inertia = inertia * (0.99 * bound / sizes[worst, -1]) ** (vectors[worst, :, -1] ** 2)
    return np.asarray(inertia)


def strength(arm: Arm, info: ArmInfo) -> Array:
    """Return the maximum torque of each motor, shape (n,) [N m, N]; without a limit, the torque that the arm needs."""
    held = np.abs(arm.gravload(postures(info))).max(axis=0)
    needed = 4.0 * held + 10.0 * largest_inertia(arm, info)
    return np.where(np.isfinite(info.max_torque), info.max_torque, needed)
