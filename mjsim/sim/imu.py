"""Inertial sensors: what the velocities of the physics tell a robot that feels them, and how far it errs."""

import numpy as np

from mjsim.compile.sensors import robot_from_sensor
from mjsim.geometry import Array
from mjsim.interface import ImuReading, SensorInfo
from mjsim.sim.streams import Streams
from mjsim.world import sensors as models
from mjsim.world.base import PHYSICS_STEP

ROW = 10
"""Numbers of one step: orientation as a quaternion (w, x, y, z), velocity in the world [m/s], turn of the base about
its own axes [rad/s]."""


class Imu:
    """An IMU of a robot in a running simulation.

    A reading is the mean over its period, as of a sensor that integrates inside: the turns of all readings add up to
    the change of orientation, the accelerations to that of the velocity, gravity apart. To that come an error that is
    constant in a run, one that wanders, and white noise; what is beyond the range reads as its end.

    References:
        Titterton, Weston, Strapdown Inertial Navigation Technology (2nd ed., 2004), chapters 4 and 11, for what is
        measured. IEEE Std 952, annex C, for the random walk of a bias.
    """

    def __init__(self, imu: models.Imu, streams: Streams, *, gravity: Array) -> None:
        """Get ready.

        Args:
            imu: As the world file has it.
            streams: Sources of chance of this sensor.
            gravity: World frame, shape (3,) [m/s^2].
        """
        self._gravity = gravity
        self._robot_from_sensor = robot_from_sensor(imu.at, yaw_deg=imu.yaw_deg, pitch_deg=imu.pitch_deg)
        self._steps = round(1.0 / (imu.rate_hz * PHYSICS_STEP))
        self._period = self._steps * PHYSICS_STEP
        self._limit = np.repeat([imu.range.acceleration, imu.range.turn], 3)
        self.retune(imu)
        self._white, self._wander = streams("white"), streams("walk")
        self._bias = np.repeat([imu.bias.acceleration, imu.bias.turn], 3) * streams("bias").standard_normal(6)
        self._felt = np.zeros((0, 6))

    def retune(self, imu: models.Imu) -> None:
        """Err as far as said from now on; the constant error and what has wandered stay."""
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

    def take(self, rows: Array, end: float) -> tuple[ImuReading, ...]:
        """Return the readings of some steps of the physics; what is left of them counts with the next.

        Args:
            rows: Before the first step and after each one, shape (steps + 1, ROW).
            end: Simulated time after the last step [s].
        """
        self._felt = np.concatenate([self._felt, self._feel(rows)])
        count = len(self._felt) // self._steps
        means = self._felt[: count * self._steps].reshape(count, self._steps, 6).mean(axis=1)
        self._felt = self._felt[count * self._steps :]
        # The error of a reading is that at its end; the walk is in units a root of a second.
        biases = self._bias + np.cumsum(
            self._walk * np.sqrt(self._period) * self._wander.standard_normal((count, 6)), axis=0
        )
        self._bias = biases[-1] if count else self._bias
        told = means + biases + self._noise * self._white.standard_normal((count, 6))
        told = np.clip(told, -self._limit, self._limit)
        last = end - len(self._felt) * PHYSICS_STEP
        stamps = [last - (count - 1 - number) * self._period for number in range(count)]
        name = self._imu.imu
        return tuple(ImuReading(stamp, row[:3], row[3:], name) for stamp, row in zip(stamps, told, strict=True))

    def _feel(self, rows: Array) -> Array:
        """Return mean specific force [m/s^2] and turn [rad/s] of each step in the sensor's frame, shape (steps, 6)."""
        world_from_base = _matrices(rows[:, :4])
        velocities, turns = rows[:, 4:7], rows[:, 7:]
        arm, base_from_sensor = self._robot_from_sensor[:3, 3], self._robot_from_sensor[:3, :3]
        there = velocities + np.einsum("nij,nj->ni", world_from_base, np.cross(turns, arm))
        forces = np.diff(there, axis=0) / PHYSICS_STEP - self._gravity
        # Halfway between two steps, to second order in the turn of a step.
        between = (world_from_base[:-1] + world_from_base[1:]) / 2
        felt = np.einsum("nji,nj->ni", between, forces)
        # The physics moves a step on with the velocity of its end.
        return np.concatenate([felt @ base_from_sensor, turns[1:] @ base_from_sensor], axis=1)


def _matrices(quaternions: Array) -> Array:
    """Return the rotation matrices of unit quaternions (w, x, y, z), shapes (n, 4) and (n, 3, 3)."""
    w, x, y, z = quaternions.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
