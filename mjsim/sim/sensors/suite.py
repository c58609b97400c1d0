"""Timing of the sensors of one robot: each measures when due, and its reading arrives after its latency."""

from collections import deque
from collections.abc import Callable
from typing import Any

from mjsim.errors import UsageError
from mjsim.interface import SensorInfo
from mjsim.sim.sensors.device import Device, FastDevice, Makers, Mounting, Sensed, StepDevice
from mjsim.world import AnySensor, Robot, name_of


class Timed:
    """One sensor in time; to be asked, or passed over, once at each tick."""

    def __init__(self, device: Device, *, period: int = 1, latency: int = 0) -> None:
        """Initialise.

        Args:
            device: The sensor.
            period: Ticks between two readings.
            latency: Ticks from when a reading is taken to when it is told.
        """
        self.device = device
        self._period, self._latency = period, latency
        self._coming: deque[tuple[int, Any]] = deque()

    def at(self, tick: int, stamp: float, sensed: Sensed) -> None:
        """Look when due, and tell the reading whose time has come."""
        if tick % self._period == 0:
            self._coming.append((tick + self._latency, self.device.take(stamp)))
        if self._coming and self._coming[0][0] == tick:
            self.device.tell(self._coming.popleft()[1], sensed)

    def unasked(self, tick: int, stamp: float) -> None:
        """Let a tick pass at which nobody asks: only what will be told later is looked at."""
        if tick % self._period == 0:
            if self._latency:
                self._coming.append((tick + self._latency, self.device.take(stamp)))
            else:
                self.device.pass_over()
        if self._coming and self._coming[0][0] == tick:
            self._coming.popleft()


class Sensors:
    """All that a robot senses with besides its odometry, its bumper and its ring."""

    def __init__(
        self, robot: Robot, *, makers: Makers, mounting: Callable[[AnySensor], Mounting], rate_hz: float
    ) -> None:
        """Make the sensors.

        Args:
            robot: From the world file.
            makers: Model of a sensor -> what makes it.
            mounting: Gives what a sensor is made with.
            rate_hz: Of the loop.

        Raises:
            UsageError: A sensor's rate does not divide the loop's.
        """
        self._timed = {
            name_of(sensor): Timed(
                makers[type(sensor)](sensor, mounting(sensor)),
                period=1 if sensor.between_ticks else ticks_between(rate_hz, sensor.rate_hz),
                latency=sensor.latency,
            )
            for sensor in robot.sensors
        }
        devices = {name: timed.device for name, timed in self._timed.items()}
        self._own: Device | None = None
        if (own := robot.own_imu) is not None:
            self._own = devices[own.imu] = makers[type(own)](own, mounting(own))
        self.info: dict[str, SensorInfo] = {name: device.info() for name, device in devices.items()}
        """Data sheets by name."""
        self.after_step = [device.after_step for device in devices.values() if isinstance(device, StepDevice)]
        """What to call after each step of the physics."""
        self.imus = [device for device in devices.values() if isinstance(device, FastDevice)]
        """Inertial sensors, which controllers read between ticks."""

    def retune(self, robot: Robot) -> None:
        """Use this noise from now on; `robot` differs from what it was in noise alone."""
        for sensor in robot.sensors:
            self._timed[name_of(sensor)].device.retune(sensor)

    def at(self, tick: int, stamp: float) -> Sensed:
        """Look with what is due; return what is told at this tick."""
        sensed = Sensed()
        self._pass_over_own()
        for timed in self._timed.values():
            timed.at(tick, stamp, sensed)
        return sensed

    def unasked(self, tick: int, stamp: float) -> None:
        """Let a tick pass at which nobody asks."""
        self._pass_over_own()
        for timed in self._timed.values():
            timed.unasked(tick, stamp)

    def _pass_over_own(self) -> None:
        """Let go of what the sensor of the drive has read, which controllers have got and modules do not get."""
        if self._own is not None:
            self._own.pass_over()


def ticks_between(loop_hz: float, sensor_hz: float) -> int:
    """Return how many ticks lie between two readings.

    Raises:
        UsageError: The sensor's rate does not divide the loop's.
    """
    ticks = loop_hz / sensor_hz
    if abs(ticks - round(ticks)) > 1e-9 or ticks < 1.0 - 1e-9:
        nearest = loop_hz / max(1, round(ticks))
        raise UsageError(f"rate_hz is {sensor_hz:g}; it must divide the loop's {loop_hz:g}, the nearest is {nearest:g}")
    return round(ticks)
