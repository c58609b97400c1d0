"""Beacon sensors: visible beacons, and errors of sightings."""

import math

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.compile import robot_from_sensor
from mjsim.geometry import Array, wrap_angle
from mjsim.interface import SensorInfo, Sighting
from mjsim.sim.rays import HIDDEN, Rays
from mjsim.sim.sensors.device import BeaconReading, Mounting
from mjsim.world import sensors

MAX_OCCLUDER_DEPTH = 0.005
"""Objects this close in front of a beacon do not occlude it: the wall or post that it is fixed to [m]."""
FINEST_RANGE, FINEST_BEARING = 1e-3, 1e-4
"""Minimum standard deviations in data sheets [m, rad]."""


class BeaconDevice:
    """A beacon sensor of a robot in a running simulation; each reading draws the same number of random values."""

    def __init__(self, sensor: sensors.BeaconSensor, mounting: Mounting) -> None:
        """Initialise.

        Args:
            sensor: Sensor of the world file.
            mounting: Its mounting; each option has its own random stream.
        """
        model, data, streams = mounting.model, mounting.data, mounting.streams
        robot, beacons = mounting.robot.name, mounting.beacons
        self._model, self._data, self._streams = model, data, streams
        self._names = [beacon.name for beacon in beacons]
        self._geoms = np.array([model.geom(f"beacon/{name}").id for name in self._names], dtype=int)
        self._all_round = np.array([beacon.reflects for beacon in beacons], dtype=bool)
        # A robot knows where its own beacon is; a bare anchor is invisible.
        self._seen = np.array(
            [beacon.on != robot and (beacon.has_face or beacon.reflects) for beacon in beacons], dtype=bool
        )
        self._robot_from_sensor = robot_from_sensor(sensor.at, yaw_deg=sensor.yaw_deg)
        self._place, self._axes = self._robot_from_sensor[:3, 3], self._robot_from_sensor[:3, :3]
        self._nearest, self._farthest = sensor.range
        self._half_fov = math.radians(sensor.fov_deg) / 2
        self._rays = Rays(model, data, robot, capacity=len(beacons))
        self._errors = streams("errors")
        self.retune(sensor)

    def retune(self, sensor: sensors.BeaconSensor) -> None:
        """Use the noise of this model from now on; random streams continue."""
        self._sensor, streams = sensor, self._streams
        self._sigma = np.array([sensor.noise.range, math.radians(sensor.noise.bearing_deg)])
        self._sheet = np.maximum(self._sigma, (FINEST_RANGE, FINEST_BEARING))
        self._missed = streams("missed") if sensor.missed else None
        self._outliers = streams("outliers") if sensor.outliers else None
        self._false = _FalseSightings(sensor, streams("false")) if sensor.false_rate else None

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        sensor = self._sensor
        return SensorInfo(
            kind="beacons",
            robot_from_sensor=self._robot_from_sensor,
            rate_hz=sensor.rate_hz,
            noise={"range": sensor.noise.range, "bearing_deg": sensor.noise.bearing_deg},
            latency=sensor.latency,
            range=(self._nearest, self._farthest),
            fov=2 * self._half_fov,
        )

    def take(self, stamp: float) -> BeaconReading:
        """Return a current reading; `stamp` is the simulated time [s]."""
        polar, in_sight = self._truth()
        errors, missed, astray, places = self._chances()
        measured = np.where(astray[:, None], places, polar + errors)
        found: list[tuple[Array, str | None, str | None]] = [
            (measured[index], self._names[index], self._names[index])
            for index in np.flatnonzero(in_sight & ~missed).tolist()
        ]
        if self._false is not None:
            found += [(place, self._name_at(chance), None) for place, chance in self._false.draw()]
        found.sort(key=lambda each: float(each[0][1]))
        return BeaconReading(
            sightings=tuple(self._sighting(place, name, stamp) for place, name, _ in found),
            identities=tuple(identity for _, _, identity in found),
        )

    def pass_over(self) -> None:
        """Draw the random numbers of a reading that was not requested."""
        self._chances()
        if self._false is not None:
            self._false.draw()

    def _truth(self) -> tuple[Array, NDArray[np.bool_]]:
        """Return range [m] and bearing [rad] of all beacons from the sensor, shape (n, 2), and which are visible."""
        place, axes = self._rays.pose()
        start = place + axes @ self._place
        offsets = self._data.geom_xpos[self._geoms] - start
        x, y, _ = (offsets @ (axes @ self._axes)).T
        polar = np.stack([np.hypot(x, y), np.arctan2(y, x)], axis=-1)
        normals = self._data.geom_xmat[self._geoms, 2::3]
        facing = self._all_round | (np.einsum("ij,ij->i", normals, offsets) < 0.0)
        inside = (polar[:, 0] >= self._nearest) & (polar[:, 0] <= self._farthest)
        # A removed beacon stays in place, but in an invisible group.
        visible = self._seen & (self._model.geom_group[self._geoms] != HIDDEN)
        in_sight = visible & facing & inside & (np.abs(polar[:, 1]) <= self._half_fov)
        candidates = np.flatnonzero(in_sight)
        if candidates.size:
            directions = offsets[candidates]
            lengths = np.sqrt(np.einsum("ij,ij->i", directions, directions))
            free = self._rays.cast(start, directions / lengths[:, None], limit=float(lengths.max()))
            in_sight[candidates] = free >= lengths - MAX_OCCLUDER_DEPTH
        return polar, in_sight

    def _chances(self) -> tuple[Array, NDArray[np.bool_], NDArray[np.bool_], Array]:
        """Return errors (n, 2), which are missed (n,), which are outliers (n,), and these (n, 2), visible or not."""
        count, sensor = len(self._names), self._sensor
        if sensor.heavy_tails is None:
            errors = self._errors.standard_normal((count, 2))
        else:
            # Student's t has variance f / (f - 2).
            f = sensor.heavy_tails
            errors = self._errors.standard_t(f, (count, 2)) * math.sqrt((f - 2.0) / f)
        never = np.zeros(count, dtype=bool)
        missed = self._missed.random(count) < sensor.missed if self._missed is not None else never
        if self._outliers is None:
            return errors * self._sigma, missed, never, np.zeros((count, 2))
        chance = self._outliers.random((count, 3))
        return errors * self._sigma, missed, chance[:, 0] < sensor.outliers, _anywhere(chance[:, 1:], sensor)

    def _name_at(self, chance: float) -> str | None:
        """Return the name of a false sighting."""
        return self._names[int(chance * len(self._names))] if self._names else None

    def _sighting(self, place: Array, name: str | None, stamp: float) -> Sighting:
        """Return the sighting from the robot's origin for range and bearing in the sensor's frame, shape (2,).

        References:
            Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 3.3: first-order propagation of covariance.
        """
        r, angle = max(float(place[0]), FINEST_RANGE), float(place[1]) + math.radians(self._sensor.yaw_deg)
        c, s = math.cos(angle), math.sin(angle)
        x, y = float(self._place[0]) + r * c, float(self._place[1]) + r * s
        squared = x * x + y * y
        distance = math.sqrt(squared)
        jacobian = np.array([[x / distance, y / distance], [-y / squared, x / squared]]) @ [[c, -r * s], [s, r * c]]
        return Sighting(
            stamp=stamp,
            name=None if self._sensor.anonymous else name,
            range=distance,
            bearing=wrap_angle(math.atan2(y, x)),
            covariance=(jacobian * self._sheet**2) @ jacobian.T,
        )


class _FalseSightings:
    """False sightings: a Poisson process, uniform in the field of view."""

    def __init__(self, sensor: sensors.BeaconSensor, stream: Generator) -> None:
        self._sensor, self._stream = sensor, stream
        mean = sensor.false_rate / sensor.rate_hz
        # More than this many occur once in 10^12 measurements; a bound keeps the number of draws constant.
        self._max_count = math.ceil(mean + 8.0 * math.sqrt(mean) + 8.0)
        terms = np.cumprod([math.exp(-mean), *(mean / k for k in range(1, self._max_count + 1))])
        self._chances = np.cumsum(terms)[:-1]

    def draw(self) -> list[tuple[Array, float]]:
        """Return range [m] and bearing [rad] of each, shape (2,), and a number in [0, 1) that selects its name."""
        count = int(np.searchsorted(self._chances, self._stream.random(), side="right"))
        chance = self._stream.random((self._max_count, 3))[:count]
        return list(zip(_anywhere(chance[:, :2], self._sensor), chance[:, 2].tolist(), strict=True))


def _anywhere(chance: Array, sensor: sensors.BeaconSensor) -> Array:
    """Return ranges [m] and bearings [rad] in a sensor's frame, uniform in both, from numbers in [0, 1), (n, 2)."""
    nearest, farthest = sensor.range
    fov = math.radians(sensor.fov_deg)
    return np.asarray(chance * (farthest - nearest, fov) + (nearest, -fov / 2))
