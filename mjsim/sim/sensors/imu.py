"""Inertial sensors: readings from velocities of the physics, and their errors."""

import math
from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import ImuReading, SensorInfo
from mjsim.sim.sensors.device import Mounting
from mjsim.world import sensors

STATE_LENGTH = 10
"""Length of the state of the carrier (the base, or a link of an arm) at one step: orientation as a quaternion (w, x, y,
z), velocity in the world frame [m/s], angular velocity in its own frame [rad/s]."""


class ImuDevice:
    """An IMU of a robot in a running simulation.

    A reading is the mean over its period, as for a sensor that integrates internally: the turns of all readings sum to
    the change of orientation, the accelerations (without gravity) to the change of velocity. Errors are a constant bias
    per run, a random walk, and white noise; readings are clipped to the range.

    References:
        Titterton, Weston, Strapdown Inertial Navigation Technology (2nd ed., 2004), chapters 4 and 11, for what is
        measured. IEEE Std 952, annex C, for the random walk of a bias.
    """

    def __init__(self, imu: sensors.Imu, mounting: Mounting) -> None:
        """Start at rest.

        Args:
            imu: Inertial sensor of the world file.
            mounting: Its mounting.
        """
        model, streams = mounting.model, mounting.streams
        self._gravity, self._step = model.opt.gravity.copy(), model.opt.timestep
        mount = mounting.mount(imu)
        name = f"{mounting.robot.name}/{mount.carrier}"
        self._row = _of_base(mounting) if imu.on is None else _of_link(mounting, name)
        self._rows = [self._row()]
        self._robot_from_sensor, self._carrier_from_sensor = mount.robot_from_sensor, mount.carrier_from_sensor
        self._arm = self._carrier_from_sensor[:3, 3].tolist()
        self._gravity_list = self._gravity.tolist()
        self._twice_sensor = np.kron(np.eye(2), self._carrier_from_sensor[:3, :3])
        self._steps = round(1.0 / (imu.rate_hz * self._step))
        self._period = self._steps * self._step
        self._limit = np.repeat([imu.range.acceleration, imu.range.turn], 3)
        self.retune(imu)
        self._white, self._wander = streams("white"), streams("walk")
        self._bias = np.repeat([imu.bias.acceleration, imu.bias.turn], 3) * streams("bias").standard_normal(6)
        self._felt = np.zeros((0, 6))
        self._rest = streams("rest")
        self._pending: list[ImuReading] = []

    def retune(self, imu: sensors.Imu) -> None:
        """Use the noise of this model from now on; bias and random walk are kept."""
        self._imu = imu
        self._noise, self._walk = (np.repeat([each.acceleration, each.turn], 3) for each in (imu.noise, imu.walk))

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        imu = self._imu
        parts = {"": imu.noise, "_bias": imu.bias, "_walk": imu.walk}
        noise = {f"{key}{part}": getattr(each, key) for part, each in parts.items() for key in ("acceleration", "turn")}
        return SensorInfo(
            kind="imu",
            robot_from_sensor=self._robot_from_sensor,
            rate_hz=imu.rate_hz,
            noise=noise,
            latency=imu.latency,
        )

    def after_step(self) -> None:
        """Store the state after a step of the physics."""
        self._rows.append(self._row())

    def take(self, stamp: float) -> tuple[ImuReading, ...]:
        """Return the readings since the last call, including those returned by `pull`.

        Args:
            stamp: The simulated time [s].
        """
        readings, self._pending = (*self._pending, *self._read(stamp)), []
        return readings

    def pull(self, stamp: float) -> tuple[ImuReading, ...]:
        """Return the readings since the last call, between ticks; `take` returns them again at the next tick."""
        if len(self._rows) == 1:
            return ()
        alone = len(self._rows) == 2 and self._steps == 1 and not len(self._felt)
        readings = (self._read_one(stamp),) if alone else self._read(stamp)
        self._pending += readings
        return readings

    def _read_one(self, stamp: float) -> ImuReading:
        """Return the reading of one step: like `_read`, in plain numbers, which is faster for so few."""
        felt = self._feel_step(*self._rows)
        del self._rows[0]
        self._bias = self._bias + self._walk * math.sqrt(self._period) * self._wander.standard_normal(6)
        measured = felt @ self._twice_sensor + self._bias + self._noise * self._white.standard_normal(6)
        if (np.abs(measured) > self._limit).any():
            measured = np.clip(measured, -self._limit, self._limit)
        return ImuReading(stamp, measured[:3], measured[3:], self._imu.imu)

    def _feel_step(self, before: Sequence[float], after: Sequence[float]) -> Array:
        """Return mean specific force [m/s^2] and turn [rad/s] of one step in the frame of the base, shape (6,)."""
        R, moved = self._placed(before)
        Q, moves = self._placed(after)
        forces = [(new - old) / self._step - g for new, old, g in zip(moves, moved, self._gravity_list, strict=True)]
        fx, fy, fz = (0.5 * force for force in forces)
        felt = [(R[k] + Q[k]) * fx + (R[k + 3] + Q[k + 3]) * fy + (R[k + 6] + Q[k + 6]) * fz for k in range(3)]
        return np.array([*felt, *after[7:]])

    def _placed(self, row: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return the orientation as a matrix, row by row, and the velocity of the sensor in the world [m/s]."""
        R = _matrix(row[0], row[1], row[2], row[3])
        (x, y, z), (p, q, r) = self._arm, row[7:]
        u, v, w = q * z - r * y, r * x - p * z, p * y - q * x
        speeds = (row[4 + k] + R[3 * k] * u + R[3 * k + 1] * v + R[3 * k + 2] * w for k in range(3))
        return R, tuple(speeds)

    def at_rest(self, stamp: float) -> ImuReading:
        """Return the reading of a robot held at rest in its current pose."""
        world_from_base = _matrices(np.array([self._row()[:4]]))[0]
        force = -self._gravity @ world_from_base @ self._carrier_from_sensor[:3, :3]
        felt = np.concatenate([force, np.zeros(3)])
        measured = felt + self._bias + self._noise * self._rest.standard_normal(6)
        measured = np.clip(measured, -self._limit, self._limit)
        return ImuReading(stamp, measured[:3], measured[3:], self._imu.imu)

    def _read(self, stamp: float) -> tuple[ImuReading, ...]:
        """Return the readings since the last call; steps of an incomplete reading count for the next."""
        rows, self._rows = np.array(self._rows), self._rows[-1:]
        self._felt = np.concatenate([self._felt, self._feel(rows)])
        count = len(self._felt) // self._steps
        means = self._felt[: count * self._steps].reshape(count, self._steps, 6).mean(axis=1)
        self._felt = self._felt[count * self._steps :]
        # The error of a reading is that at its end; the walk is in units per square root of a second.
        biases = self._bias + np.cumsum(
            self._walk * np.sqrt(self._period) * self._wander.standard_normal((count, 6)), axis=0
        )
        self._bias = biases[-1] if count else self._bias
        measured = means + biases + self._noise * self._white.standard_normal((count, 6))
        measured = np.clip(measured, -self._limit, self._limit)
        last = stamp - len(self._felt) * self._step
        stamps = [last - (count - 1 - number) * self._period for number in range(count)]
        name = self._imu.imu
        return tuple(ImuReading(stamp, row[:3], row[3:], name) for stamp, row in zip(stamps, measured, strict=True))

    def pass_over(self) -> None:
        """Draw the random numbers of readings that were not requested, and continue the random walk."""
        self.take(0.0)

    def _feel(self, rows: Array) -> Array:
        """Return mean specific force [m/s^2] and turn [rad/s] of each step in the sensor's frame, shape (steps, 6).

        Args:
            rows: Values before the first step and after each one, shape (steps + 1, STATE_LENGTH).
        """
        world_from_base = _matrices(rows[:, :4])
        velocities, turns = rows[:, 4:7], rows[:, 7:]
        arm, base_from_sensor = self._carrier_from_sensor[:3, 3], self._carrier_from_sensor[:3, :3]
        velocities_at_sensor = velocities + np.einsum("nij,nj->ni", world_from_base, np.cross(turns, arm))
        forces = np.diff(velocities_at_sensor, axis=0) / self._step - self._gravity
        # Halfway between two steps, to second order in the rotation per step.
        between = (world_from_base[:-1] + world_from_base[1:]) / 2
        felt = np.einsum("nji,nj->ni", between, forces)
        # The physics advances a step with the velocity at its end.
        return np.concatenate([felt @ base_from_sensor, turns[1:] @ base_from_sensor], axis=1)


def _of_base(mounting: Mounting) -> Callable[[], list[float]]:
    """Return a function that gives the state of a robot's base, STATE_LENGTH numbers."""
    free, data = mounting.model.joint(f"{mounting.robot.name}/free"), mounting.data
    turned, moved = int(free.qposadr[0]) + 3, int(free.dofadr[0])
    return lambda: [*data.qpos[turned : turned + 4].tolist(), *data.qvel[moved : moved + 6].tolist()]


def _of_link(mounting: Mounting, name: str) -> Callable[[], list[float]]:
    """Return a function that gives the state of a body, STATE_LENGTH numbers."""
    model, data, number = mounting.model, mounting.data, mounting.model.body(name).id
    velocity = np.zeros(6)

    def row() -> list[float]:
        # After a step, body poses are still those before it.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, number, velocity, 0)
        turn = data.xmat[number].reshape(3, 3).T @ velocity[:3]
        return [*data.xquat[number].tolist(), *velocity[3:].tolist(), *turn.tolist()]

    return row


def _matrix(w: float, x: float, y: float, z: float) -> tuple[float, ...]:
    """Return the rotation matrix of a unit quaternion, row by row, 9 numbers."""
    return (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )


def _matrices(quaternions: Array) -> Array:
    """Return the rotation matrices of unit quaternions (w, x, y, z), shapes (n, 4) and (n, 3, 3)."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
