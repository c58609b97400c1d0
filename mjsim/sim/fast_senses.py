"""Inputs of controllers between ticks: encoders of wheels and joints, and inertial sensors."""

import math
from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import FastReading, ImuReading, JointState
from mjsim.sim.sensors import FastDevice


class JointEncoders:
    """The encoders of some hinges or slides of a robot, each with a motor of the same name."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[str], *, step: float | None = None
    ) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            data: Its state, read at each measurement.
            joints: Names of hinges or slides.
            step: Resolution of the encoders [rad]; by default exact.
        """
        self._data, self._step = data, step
        self._places = np.array([model.joint(name).qposadr[0] for name in joints], dtype=int)
        self._dofs = np.array([model.joint(name).dofadr[0] for name in joints], dtype=int)
        self._before: tuple[float, Array] | None = None

    def read(self, stamp: float) -> JointState:
        """Return the current readings; `stamp` is the simulated time [s]."""
        data = self._data
        positions, velocities = data.qpos[self._places], data.qvel[self._dofs]
        if self._step is not None:
            positions = np.floor(positions / self._step) * self._step
            velocities = self._change(stamp, positions)
        return JointState(stamp, positions, velocities, data.qfrc_actuator[self._dofs])

    def _change(self, stamp: float, positions: Array) -> Array:
        """Return the speeds from encoder steps since the last reading, shape (joints,)."""
        before, self._before = self._before, (stamp, positions)
        if before is None or stamp <= before[0]:
            return np.zeros(len(positions))
        return np.asarray((positions - before[1]) / (stamp - before[0]), dtype=float)


class ImuFeed:
    """Distributes the readings of a robot's inertial sensors to several controllers, each at its own rate."""

    def __init__(self, devices: Sequence[FastDevice]) -> None:
        """Store the sensors."""
        self._devices, self._until = devices, -math.inf
        self._takers: list[list[ImuReading]] = []

    def join(self) -> list[ImuReading]:
        """Return a list to which the readings of the next calls of `pull` are added."""
        self._takers.append([])
        return self._takers[-1]

    def pull(self, stamp: float) -> None:
        """Extend all lists to a time [s]; the first readings are of the robot held at rest."""
        if stamp <= self._until:
            return
        began, self._until = stamp == 0.0, stamp
        for device in self._devices:
            readings = (device.at_rest(stamp),) if began else device.pull(stamp)
            for taker in self._takers:
                taker += readings


class FastSenses:
    """Inputs of one controller: the readings since its own last call."""

    def __init__(self, *, wheels: JointEncoders, arms: Mapping[str, JointEncoders], imu: ImuFeed) -> None:
        """Store the sensors."""
        self._wheels, self._arms, self._feed = wheels, arms, imu
        self._readings = imu.join()

    def read(self, stamp: float, dt: float) -> FastReading:
        """Return the current inputs.

        Args:
            stamp: The simulated time [s].
            dt: Period of the controller [s].
        """
        self._feed.pull(stamp)
        readings = tuple(self._readings)
        self._readings.clear()
        return FastReading(
            time=stamp,
            dt=dt,
            joints={name: encoders.read(stamp) for name, encoders in self._arms.items()},
            wheels=self._wheels.read(stamp),
            imu=readings,
        )
