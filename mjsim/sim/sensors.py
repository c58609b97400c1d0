"""The sensors of one robot in time: each looks when it is due, and tells when its latency is over."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

import mujoco
import numpy as np

from mjsim.interface import CameraFrame, ImuReading, Scan, SensorInfo, Sighting
from mjsim.sim.beacon_sensor import BeaconSensor, Look
from mjsim.sim.camera import OnboardCamera, ticks_between
from mjsim.sim.canvas import Canvas, Quality
from mjsim.sim.imu import ROW, Imu
from mjsim.sim.lidar import Lidar
from mjsim.sim.streams import kept, streams_of
from mjsim.world import sensors as models
from mjsim.world.robots import Robot
from mjsim.world.things import Beacon

R = TypeVar("R")


class Timed(Generic[R]):
    """One sensor in time; to be asked, or passed over, once at each tick."""

    def __init__(
        self, take: Callable[[float], R], pass_over: Callable[[], object], *, period: int = 1, latency: int = 0
    ) -> None:
        """Get ready.

        Args:
            take: Returns a reading of now, given its stamp [s].
            pass_over: Draws the chance of a reading that nobody asks for.
            period: Ticks between two readings.
            latency: Ticks from when a reading is taken to when it is told.
        """
        self._take, self._pass_over = take, pass_over
        self._period, self._latency = period, latency
        self._coming: deque[tuple[int, R]] = deque()

    def at(self, tick: int, stamp: float) -> R | None:
        """Look when due; return the reading that is told at this tick."""
        if tick % self._period == 0:
            self._coming.append((tick + self._latency, self._take(stamp)))
        return self._told(tick)

    def unasked(self, tick: int, stamp: float) -> None:
        """Let a tick pass at which nobody asks: only what will be told later is looked at."""
        if tick % self._period == 0:
            if self._latency:
                self._coming.append((tick + self._latency, self._take(stamp)))
            else:
                self._pass_over()
        self._told(tick)

    def _told(self, tick: int) -> R | None:
        return self._coming.popleft()[1] if self._coming and self._coming[0][0] == tick else None


@dataclass(frozen=True, slots=True, eq=False)
class Sensed:
    """What the sensors tell at one tick."""

    cameras: dict[str, CameraFrame]
    scans: dict[str, Scan]
    sightings: tuple[Sighting, ...]
    identities: tuple[str | None, ...]
    """Which beacon each sighting is of; never for modules."""
    imu: tuple[ImuReading, ...]


class Sensors:
    """All that a robot senses with besides its wheels, its bumper and its ring."""

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: Robot,
        *,
        beacons: Sequence[Beacon],
        rate_hz: float,
        seed: int,
        canvas: Callable[[Quality], Canvas],
    ) -> None:
        """Get ready to look.

        Args:
            model: The compiled world.
            data: Its state, which is read at each look.
            robot: As the world file has it.
            beacons: All of the world.
            rate_hz: Of the loop.
            seed: Of the run.
            canvas: Gives what cameras of a quality draw on.

        Raises:
            UsageError: A sensor's rate does not divide the loop's.
        """
        self.info: dict[str, SensorInfo] = {}
        """Data sheets by name."""
        self._cameras: dict[str, Timed[CameraFrame]] = {}
        self._scans: dict[str, Timed[Scan]] = {}
        self._looks: list[Timed[Look]] = []
        self._imus: list[Timed[tuple[ImuReading, ...]]] = []
        self._retune: dict[str, Callable[[Any], None]] = {}
        free = model.joint(f"{robot.name}/free")
        self._turned, self._moved = int(free.qposadr[0]) + 3, int(free.dofadr[0])
        self._data = data
        self._steps = [self._step()]
        self._felt = np.zeros((1, ROW))
        for sensor in robot.sensors:
            name = models.name_of(sensor)
            streams = kept(streams_of(seed, robot.name, name))
            if isinstance(sensor, models.Imu):
                imu = Imu(sensor, streams, gravity=model.opt.gravity.copy())
                self._imus.append(
                    Timed(partial(self._feel, imu), partial(self._feel, imu, 0.0), latency=sensor.latency)
                )
                self.info[name], self._retune[name] = imu.info(), imu.retune
                continue
            period = ticks_between(rate_hz, sensor.rate_hz)
            if isinstance(sensor, models.Camera):
                camera = OnboardCamera(model, robot, sensor, rate_hz=rate_hz, seed=seed, canvas=canvas(sensor.quality))
                take = partial(camera.frame, data)
                self._cameras[name] = Timed(take, camera.pass_over, period=period, latency=sensor.latency)
                self.info[name], self._retune[name] = camera.info(), camera.retune
            elif isinstance(sensor, models.Lidar):
                lidar = Lidar(model, data, robot.name, sensor, streams)
                self._scans[name] = Timed(lidar.take, lidar.pass_over, period=period, latency=sensor.latency)
                self.info[name], self._retune[name] = lidar.info(), lidar.retune
            else:
                ring = BeaconSensor(model, data, robot.name, sensor, beacons, streams)
                self._looks.append(Timed(ring.take, ring.pass_over, period=period, latency=sensor.latency))
                self.info[name], self._retune[name] = ring.info(), ring.retune

    def retune(self, robot: Robot) -> None:
        """Err as far as said from now on; `robot` differs from what it was in noise alone."""
        for sensor in robot.sensors:
            self._retune[models.name_of(sensor)](sensor)

    @property
    def feels(self) -> bool:
        """Whether each step of the physics is to be told to `feel_step`."""
        return bool(self._imus)

    def feel_step(self) -> None:
        """Note what inertial sensors feel, after a step of the physics."""
        self._steps.append(self._step())

    def at(self, tick: int, stamp: float) -> Sensed:
        """Look with what is due; return what is told at this tick."""
        self._end_tick()
        cameras = {name: camera.at(tick, stamp) for name, camera in self._cameras.items()}
        scans = {name: lidar.at(tick, stamp) for name, lidar in self._scans.items()}
        looks = [look for ring in self._looks if (look := ring.at(tick, stamp)) is not None]
        return Sensed(
            cameras={name: frame for name, frame in cameras.items() if frame is not None},
            scans={name: scan for name, scan in scans.items() if scan is not None},
            sightings=tuple(sighting for look in looks for sighting in look.sightings),
            identities=tuple(identity for look in looks for identity in look.identities),
            imu=tuple(reading for imu in self._imus for reading in imu.at(tick, stamp) or ()),
        )

    def unasked(self, tick: int, stamp: float) -> None:
        """Let a tick pass at which nobody asks."""
        self._end_tick()
        timed: list[Timed[Any]] = [*self._cameras.values(), *self._scans.values(), *self._looks, *self._imus]
        for sensor in timed:
            sensor.unasked(tick, stamp)

    def _end_tick(self) -> None:
        """Put aside what was felt since the last tick."""
        self._felt, self._steps = np.array(self._steps), self._steps[-1:]

    def _feel(self, imu: Imu, stamp: float) -> tuple[ImuReading, ...]:
        return imu.take(self._felt, stamp)

    def _step(self) -> list[float]:
        """Return orientation and velocities of now as an IMU takes them, ROW numbers."""
        quaternion = self._data.qpos[self._turned : self._turned + 4].tolist()
        return [*quaternion, *self._data.qvel[self._moved : self._moved + 6].tolist()]
