"""Wheel encoders: the counters that odometry reads, as from a hardware driver."""

import numpy as np

from mjsim.interface import SensorInfo, WheelTicks
from mjsim.sim.sensors.device import Mounting
from mjsim.world import sensors


class EncoderDevice:
    """The encoders of a robot's driven wheels in a running simulation.

    They are also used by its odometry, which computes motion from differences of their readings.
    """

    def __init__(self, encoders: sensors.Encoders, mounting: Mounting) -> None:
        """Start at zero.

        Args:
            encoders: Encoders of the world file.
            mounting: Their mounting; the robot's odometry counts in steps.
        """
        ticks = mounting.robot.odometry.ticks
        assert ticks is not None, "the model of the robot has checked it"
        self._encoders, self._odometer, self._ticks = encoders, mounting.gear.odometer, ticks
        self._half = 1 << (encoders.bits - 1)

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        encoders = self._encoders
        return SensorInfo(
            kind="encoders", robot_from_sensor=np.eye(4), rate_hz=encoders.rate_hz, latency=encoders.latency
        )

    def retune(self, encoders: sensors.Encoders) -> None:
        """Do nothing: counters have no noise."""

    def take(self, stamp: float) -> WheelTicks:
        """Return the current counts; `stamp` is the simulated time [s]."""
        half = self._half
        counts = tuple((count + half) % (2 * half) - half for count in self._odometer.counts)
        return WheelTicks(stamp, counts, self._ticks, self._encoders.bits)

    def pass_over(self) -> None:
        """Do nothing: there are no random numbers."""
