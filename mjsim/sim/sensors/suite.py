"""Timing of the sensors of one robot: each measures when due, and its reading arrives after its latency."""

from collections import deque
from collections.abc import Callable
from typing import Any

from mjsim.errors import UsageError
from mjsim.interface import SensorInfo
from mjsim.sentences import Sentence
from mjsim.sim.sensors.device import Device, FastDevice, Makers, Mounting, Sensed, StepDevice
from mjsim.world import AnySensor, Robot, name_of


class Timed:
    """Timing of one sensor; `at` or `unasked` is called once per tick."""

    def __init__(self, sensor: AnySensor, device: Device, *, period: int = 1, latency: int = 0) -> None:
        """Initialise.

        Args:
            sensor: Sensor of the world file.
            device: The sensor in the simulation.
            period: Ticks between two readings.
            latency: Ticks from taking a reading to its delivery.
        """
        self._sensor, self.device = sensor, device
        self._period, self._latency = period, latency
        self._coming: deque[tuple[int, Any]] = deque()

    def at(self, tick: int, stamp: float, sensed: Sensed) -> None:
        """Take a reading if due, and deliver the one whose latency has passed."""
        if tick % self._period == 0:
            self._coming.append((tick + self._latency, self.device.take(stamp)))
        if self._coming and self._coming[0][0] == tick:
            sensed.add(self._sensor, self._coming.popleft()[1])

    def unasked(self, tick: int, stamp: float) -> None:
        """Skip a tick without a request: only readings that are delivered later are taken."""
        if tick % self._period == 0:
            if self._latency:
                self._coming.append((tick + self._latency, self.device.take(stamp)))
            else:
                self.device.pass_over()
        if self._coming and self._coming[0][0] == tick:
            self._coming.popleft()


class Sensors:
    """All sensors of a robot except odometry, bumper and ring."""

    def __init__(
        self, robot: Robot, *, makers: Makers, mounting: Callable[[AnySensor], Mounting], rate_hz: float
    ) -> None:
        """Create the sensors.

        Args:
            robot: Robot of the world file.
            makers: Model of a sensor -> factory.
            mounting: Gives the mounting of a sensor.
            rate_hz: Rate of the loop.

        Raises:
            UsageError: A sensor's rate does not divide the loop's.
        """
        self._timed = {
            name_of(sensor): Timed(
                sensor,
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
        """Functions to call after each step of the physics."""
        self.imus = [device for device in devices.values() if isinstance(device, FastDevice)]
        """Inertial sensors, which controllers read between ticks."""

    def retune(self, robot: Robot) -> None:
        """Use this noise from now on; `robot` must differ only in noise."""
        for sensor in robot.sensors:
            self._timed[name_of(sensor)].device.retune(sensor)

    def at(self, tick: int, stamp: float) -> Sensed:
        """Take readings that are due; return those delivered at this tick."""
        sensed = Sensed()
        self._pass_over_own()
        for timed in self._timed.values():
            timed.at(tick, stamp, sensed)
        return sensed

    def unasked(self, tick: int, stamp: float) -> None:
        """Skip a tick without a request."""
        self._pass_over_own()
        for timed in self._timed.values():
            timed.unasked(tick, stamp)

    def _pass_over_own(self) -> None:
        """Drop readings of the drive's own sensor, which only controllers get."""
        if self._own is not None:
            self._own.pass_over()


def ticks_between(loop_hz: float, sensor_hz: float) -> int:
    """Return the number of ticks between two readings.

    Raises:
        UsageError: The sensor's rate does not divide the loop's.
    """
    ticks = loop_hz / sensor_hz
    if abs(ticks - round(ticks)) > 1e-9 or ticks < 1.0 - 1e-9:
        nearest = loop_hz / max(1, round(ticks))
        raise UsageError(
            Sentence(
                "rate_hz is {sensor_hz:g}; it must divide the loop's {loop_hz:g}, the nearest is {nearest:g}",
                sensor_hz,
                loop_hz,
                nearest,
            )
        )
    return round(ticks)
