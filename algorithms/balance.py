"""A linear quadratic regulator for a two-wheeled balancing base, designed from the robot's data sheet."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from scipy.linalg import expm, solve_discrete_are

from mjsim import BalancingInfo, Command, FastReading, ImuReading, Observation, RobotInfo

GRAVITY = 9.81
"""[m/s^2]"""
FALLEN = math.radians(50.0)
"""Beyond this pitch the robot cannot recover; the motors stop [rad]."""
MAX_LAG, MAX_TURN_LAG = 0.6, 1.0
"""Lag of the base behind its set-point beyond which the set-point waits [m], [rad]."""
CORRECTION = 0.3
"""Bandwidth at which the accelerometer corrects the gyroscope's pitch [rad/s]."""


class Lqr:
    """Balances a base and follows forward and turn commands with state feedback.

    The state is the distance travelled by the axle, the pitch of the body, and their rates; in addition the heading and
    its rate. The feedback minimises the integral of x' Q x + R u^2 of the linear model, sampled at the rate of the
    controller. The pitch is the integrated gyroscope rate, slowly corrected by the direction of gravity; distance and
    heading come from the wheel encoders, which count relative to the body.

    References:
        Grasser, D'Arrigo, Colombi, Rufer, JOE: A Mobile, Inverted Pendulum, IEEE Transactions on Industrial Electronics
        49(1), 2002, for the plant and the decoupled control of pitch and turn. Pathak, Franch, Agrawal, Velocity and
        Position Control of a Wheeled Inverted Pendulum by Partial Feedback Linearization, IEEE Transactions on
        Robotics 21(3), 2005, for its dynamics. Mahony, Hamel, Pflimlin, Nonlinear Complementary Filters on the Special
        Orthogonal Group, IEEE Transactions on Automatic Control 53(5), 2008, for the pitch and the gyroscope's bias.
    """

    def __init__(
        self,
        weights: Sequence[float] = (20.0, 20.0, 5.0, 2.0),
        effort: float = 0.2,
        turn_weights: Sequence[float] = (20.0, 2.0),
    ) -> None:
        """Set the weights of the quadratic cost.

        Args:
            weights: Weights of squared errors of the distance [m], the pitch [rad], and their rates.
            effort: Weight of the squared torque of both motors together [N m].
            turn_weights: Weights of squared errors of the heading [rad] and its rate.
        """
        if len(weights) != 4 or len(turn_weights) != 2:
            raise ValueError("weights needs four numbers, turn_weights two")
        self._Q, self._R = np.diag(np.asarray(weights, dtype=float)), np.array([[float(effort)]])
        self._Q_turn = np.diag(np.asarray(turn_weights, dtype=float))
        self.feedback: tuple[float, ...] = ()
        """Torque of both motors together for an error of the distance, the pitch, and their rates; set by the
        design."""

    def start(self, robot: RobotInfo, part: str, rng: Generator) -> None:
        """Store the data sheet; the feedback is designed at the first call, which gives the rate."""
        if robot.balancing is None:
            raise ValueError(f"robot '{robot.name}' does not balance; this controller is for balancing bases")
        self._robot, self._masses = robot, robot.balancing
        self._lean = Lean(robot)
        self.feedback = ()
        self._turn_feedback = 0.0, 0.0
        self._target_distance, self._heading, self._begun = 0.0, 0.0, False
        self._max_torque = robot.balancing.max_torque

    def torques(self, sensed: FastReading, wanted: Command) -> Sequence[float]:
        """Return the torques of the left and the right motor [N m]."""
        if not self.feedback:
            self._design(sensed.dt)
        left, right = sensed.wheels.positions.tolist()
        left_rate, right_rate = sensed.wheels.velocities.tolist()
        radius, track = self._robot.wheel_radius, self._robot.track
        spin = radius * (left_rate + right_rate) / 2
        for reading in sensed.imu:
            self._lean.add(reading, spin)
        pitch, rate = self._lean.pitch, self._lean.rate
        distance, speed = radius * ((left + right) / 2 + pitch), spin + radius * rate
        heading, turn = radius * (right - left) / track, radius * (right_rate - left_rate) / track
        if not self._begun or abs(pitch) > FALLEN:
            self._target_distance, self._heading, self._begun = distance, heading, self._lean.known
        if abs(pitch) > FALLEN or not self._lean.known:
            return 0.0, 0.0
        k = self.feedback
        push = -(
            k[0] * (distance - self._target_distance) + k[1] * pitch + k[2] * (speed - wanted.forward) + k[3] * rate
        )
        g = self._turn_feedback
        twist = -(g[0] * (heading - self._heading) + g[1] * (turn - wanted.turn))
        self._target_distance = _clamped(self._target_distance + wanted.forward * sensed.dt, distance, MAX_LAG)
        self._heading = _clamped(self._heading + wanted.turn * sensed.dt, heading, MAX_TURN_LAG)
        return self._shared(push, twist)

    def _shared(self, push: float, twist: float) -> tuple[float, float]:
        """Return the torques of left and right; balancing has priority over turning."""
        push = _clamped(push, 0.0, 2.0 * self._max_torque)
        twist = _clamped(twist, 0.0, 2.0 * self._max_torque - abs(push))
        return (push - twist) / 2, (push + twist) / 2

    def design(self, masses: BalancingInfo, *, wheel_radius: float, dt: float) -> tuple[float, ...]:
        """Return the feedback of distance, pitch, and their rates for a period of the controller [s]."""
        A, B = plant(masses, wheel_radius=wheel_radius)
        return tuple(regulator(A, B, self._Q, self._R, dt=dt))

    def _design(self, dt: float) -> None:
        """Design both feedbacks for a period [s]."""
        radius, track = self._robot.wheel_radius, self._robot.track
        self.feedback = self.design(self._masses, wheel_radius=radius, dt=dt)
        A, B = turning_plant(self._masses, wheel_radius=radius, track=track)
        on_spot, faster = regulator(A, B, self._Q_turn, self._R, dt=dt)
        self._turn_feedback = on_spot, faster


class Lean:
    """The pitch of a body from its inertial sensor: integrated gyroscope rate, slowly corrected by the accelerometer.

    The accelerometer measures f = a - g. For a sensor at height h above the axle, with acceleration a of the axle, the
    component along the body's x axis is a cos(pitch) + h pitch'' - g sin(pitch). The error e of the pitch corrects it
    with
    2 w e, and the gyroscope's bias with w^2 e, for both poles at w.
    """

    def __init__(self, robot: RobotInfo) -> None:
        """Find the sensor; the pitch is unknown."""
        self._name, sensor = next((n, s) for n, s in robot.sensors.items() if s.kind == "imu")
        self._axes = sensor.robot_from_sensor[:3, :3]
        self._height = float(sensor.robot_from_sensor[2, 3]) - robot.wheel_radius
        self._radius = robot.wheel_radius
        self.pitch, self.rate, self.known = 0.0, 0.0, False
        self._bias = 0.0
        self._before: tuple[float, float, float] | None = None

    def begin(self, since: float) -> None:
        """Assume that the robot was upright at a time [s]."""
        self._before, self.known = (since, 0.0, 0.0), True

    def add(self, reading: ImuReading, spin: float) -> None:
        """Process a reading; those of other sensors are ignored.

        Args:
            reading: Reading of an inertial sensor.
            spin: Mean speed of the wheels relative to the body, times their radius [m/s].
        """
        if reading.name != self._name:
            return
        force, turn = self._axes @ reading.acceleration, self._axes @ reading.turn
        if self.known:
            self._take(reading.stamp, float(turn[1]), float(force[0]), spin)
        else:
            self.pitch, self.known = math.atan2(-float(force[0]), float(force[2])), True
            self.rate, self._before = float(turn[1]), (reading.stamp, spin, float(turn[1]))

    def about(self, reading: ImuReading) -> float:
        """Return the turn rate about the axle in a reading [rad/s]."""
        return float((self._axes @ reading.turn)[1])

    def _take(self, stamp: float, turn: float, force: float, spin: float) -> None:
        """Process one reading: the turn rate about y [rad/s] and the specific force along x [m/s^2]."""
        assert self._before is not None
        then, spun, turned = self._before
        dt, self._before = stamp - then, (stamp, spin, turn)
        gained = (spin - spun + self._radius * (turn - turned)) / dt
        sine = (gained * math.cos(self.pitch) + self._height * (turn - turned) / dt - force) / GRAVITY
        error = math.asin(_clamped(sine, 0.0, 1.0)) - self.pitch
        self.rate = turn - self._bias
        self.pitch += dt * (self.rate + 2.0 * CORRECTION * error)
        self._bias -= dt * CORRECTION**2 * error


class TickLean:
    """The pitch of a body at each tick, for modules whose camera is on it; 0 without an inertial sensor.

    The robot is assumed to be upright at the first tick; the accelerometer corrects this within seconds.
    """

    def __init__(self, robot: RobotInfo) -> None:
        """Find the inertial sensor of a balancing robot."""
        has_imu = robot.balancing is not None and any(sensor.kind == "imu" for sensor in robot.sensors.values())
        self._lean = Lean(robot) if has_imu else None
        self._radius, self._speed = robot.wheel_radius, 0.0

    def update(self, seen: Observation) -> float:
        """Return the pitch after a tick [rad], assuming constant acceleration of the axle."""
        if self._lean is None:
            return 0.0
        before, self._speed = self._speed, seen.odometry.forward / seen.dt
        if not self._lean.known:
            self._lean.begin(seen.time)
        for number, reading in enumerate(seen.imu, start=1):
            speed = before + (self._speed - before) * number / len(seen.imu)
            self._lean.add(reading, speed - self._radius * self._lean.about(reading))
        return self._lean.pitch


def plant(masses: BalancingInfo, *, wheel_radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the linear model of a balancing base about the upright position: x' = A x + B u.

    Args:
        masses: Masses of the robot.
        wheel_radius: [m]

    Returns:
        A: Shape (4, 4), of the state: distance of the axle [m], pitch [rad], and their rates.
        B: Shape (4, 1), of the torque of both motors together [N m].

    References:
        Pathak, Franch, Agrawal (2005), equation 10, linearised about the upright position; the motors act between body
        and wheels.
    """
    r, m, h = wheel_radius, masses.body_mass, masses.center
    whole = m + 2.0 * masses.wheel_mass + 2.0 * masses.wheel_inertia / r**2
    M = np.array([[whole, m * h], [m * h, masses.pitch_inertia + m * h**2]])
    A, B = np.zeros((4, 4)), np.zeros((4, 1))
    A[:2, 2:] = np.eye(2)
    A[2:, 1] = np.linalg.solve(M, [0.0, m * GRAVITY * h])
    B[2:, 0] = np.linalg.solve(M, [1.0 / r, -1.0])
    return A, B


def turning_plant(masses: BalancingInfo, *, wheel_radius: float, track: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the linear model of its turn: state heading [rad] and rate, input the right torque less the left [N m]."""
    rolling = masses.wheel_mass + masses.wheel_inertia / wheel_radius**2
    inertia = masses.yaw_inertia + 2.0 * (masses.wheel_across + rolling * (track / 2) ** 2)
    return np.array([[0.0, 1.0], [0.0, 0.0]]), np.array([[0.0], [track / (2.0 * wheel_radius) / inertia]])


def regulator(A: np.ndarray, B: np.ndarray, Q: np.ndarray, R: np.ndarray, *, dt: float) -> list[float]:
    """Return the feedback K of u = -K x that minimises the sum of x' Q x + u' R u, held between samples.

    Args:
        A: Matrix of the continuous model, shape (n, n).
        B: Shape (n, 1).
        Q: Weights of the state, shape (n, n).
        R: Weight of the input, shape (1, 1).
        dt: Period of the samples [s].

    References:
        Franklin, Powell, Workman, Digital Control of Dynamic Systems (3rd ed., 1998), sections 4.3 and 9.3.
    """
    n = len(A)
    both = expm(np.block([[A, B], [np.zeros((1, n + 1))]]) * dt)
    Ad, Bd = both[:n, :n], both[:n, n:]
    P = solve_discrete_are(Ad, Bd, Q, R)
    K: list[float] = np.linalg.solve(R + Bd.T @ P @ Bd, Bd.T @ P @ Ad)[0].tolist()
    return K


def _clamped(value: float, middle: float, reach: float) -> float:
    """Return a value limited to a distance from a centre."""
    return min(max(value, middle - reach), middle + reach)
