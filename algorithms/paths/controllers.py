"""Path and set-point control: PID, feedback linearisation, LQR."""

import math

import numpy as np
from scipy.linalg import solve_discrete_are

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import Command


class Pid:
    """Proportional, integral and derivative action on one error, with limits.

    The derivative is low-pass filtered (first order), since that of the raw error would be mostly noise.
    Back-calculation prevents windup of the integral while the output is at its limit.

    References:
        Astrom, Murray, Feedback Systems (2008), section 10.4: setpoint, anti-windup by back-calculation, and the
        filtered derivative; section 10.5: the discrete form.
    """

    def __init__(
        self, kp: float, ki: float = 0.0, kd: float = 0.0, *, limit: float = math.inf, filter_time: float = 0.0
    ) -> None:
        """Set the gains.

        Args:
            kp: Output per unit of error.
            ki: Output per unit of error and second.
            kd: Output per unit of error per second.
            limit: Largest size of the output.
            filter_time: Time constant of the derivative's low pass [s].
        """
        self.kp, self.ki, self.kd, self.limit, self.filter_time = kp, ki, kd, limit, filter_time
        self._integral = self._derivative = 0.0
        self._last: float | None = None

    def reset(self) -> None:
        """Reset the state."""
        self._integral = self._derivative = 0.0
        self._last = None

    def __call__(self, error: float, dt: float) -> float:
        """Return the output for an error `dt` [s] after the last one."""
        change = 0.0 if self._last is None else (error - self._last) / dt
        self._last = error
        self._derivative += dt / (self.filter_time + dt) * (change - self._derivative)
        unlimited = self.kp * error + self._integral + self.kd * self._derivative
        output = min(max(unlimited, -self.limit), self.limit)
        # Back-calculation with the tracking time kp / ki: the integral is reduced by the saturated part.
        self._integral += self.ki * dt * error
        if self.kp:
            self._integral += min(1.0, self.ki * dt / self.kp) * (output - unlimited)
        return output


def feedback_linearisation(pose: Pose, velocity: Array, *, ahead: float) -> Command:
    """Return the twist that gives a point ahead of the robot a desired velocity.

    A unicycle cannot move sideways, but a point ahead of its axle can: forward speed and turn rate give it any
    velocity.

    Args:
        pose: Pose of the robot.
        velocity: Wanted velocity of the point, world frame, shape (2,) [m/s].
        ahead: How far the point lies ahead of the robot's origin [m], above 0.

    References:
        Siciliano, Sciavicco, Villani, Oriolo, Robotics: Modelling, Planning and Control (2009), section 11.6.1:
        input/output linearisation.
    """
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    x, y = np.asarray(velocity, dtype=float).tolist()
    return Command(forward=c * x + s * y, turn=(c * y - s * x) / ahead)


def lqr_gains(speed: float, dt: float, *, lateral: float = 4.0, heading: float = 1.0, effort: float = 1.0) -> Array:
    """Return the LQR gains for following a straight path at a constant speed.

    The error (e, psi) is the distance to the left of the path [m] and the heading left of its direction [rad]; over
    one period e grows by speed dt psi, and psi by dt times the turn rate beyond that of the path.

    Args:
        speed: [m/s], above 0.
        dt: Period of control [s].
        lateral: Weight of e^2.
        heading: Weight of psi^2.
        effort: Weight of the square of the turn rate.

    Returns:
        K, shape (2,): turn = -K @ (e, psi) [1/(m s), 1/s].

    References:
        Anderson, Moore, Optimal Control: Linear Quadratic Methods (1990), section 2.4, the discrete regulator.
    """
    A = np.array([[1.0, speed * dt], [0.0, 1.0]])
    B = np.array([[0.5 * speed * dt**2], [dt]])
    P = solve_discrete_are(A, B, np.diag([lateral, heading]), np.array([[effort]]))
    return np.asarray(np.linalg.solve(B.T @ P @ B + effort, B.T @ P @ A)[0], dtype=float)


def path_errors(pose: Pose, point: Array, direction: float) -> Array:
    """Return the lateral and the heading error of a pose, left positive, shape (2,) [m, rad].

    Args:
        pose: Pose of the robot.
        point: The nearest point of the path, shape (2,) [m].
        direction: Direction of the path there [rad].
    """
    x, y = pose.x - float(point[0]), pose.y - float(point[1])
    return np.array([y * math.cos(direction) - x * math.sin(direction), wrap_angle(pose.heading - direction)])
