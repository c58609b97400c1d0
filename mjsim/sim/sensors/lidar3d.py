"""3-D lidars: a stack of beams that turns, or a rosette, measured while the robot drives."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import PointCloud, SensorInfo
from mjsim.sim.rays import BatchRays
from mjsim.sim.sensors.device import Mounting
from mjsim.sim.sensors.lidar import BRIGHT
from mjsim.world import sensors


class Lidar3dDevice:
    """A 3-D lidar of a robot in a running simulation.

    It fires between ticks: the beams of a revolution are distributed over the steps of the physics, and those of one
    step start at the pose of the sensor after it. Rays are only cast on request. Each revolution draws the same number
    of random values, one per beam.

    References:
        Brazeal, Wilkinson, Hochmair, A Rigorous Observation Model for the Risley Prism-Based Livox Mid-40 Lidar
        Sensor, Sensors 21(14), 2021, for the rosette: each prism bends the beam by half the cone's half angle.
    """

    def __init__(self, lidar: sensors.Lidar3d, mounting: Mounting) -> None:
        """Initialise.

        Args:
            lidar: Lidar of the world file.
            mounting: Its mounting; each option has its own random stream.
        """
        model = mounting.model
        self._data, self._streams = mounting.data, mounting.streams
        step = model.opt.timestep
        self._steps = round(1.0 / (lidar.rate_hz * step))
        self._beams, columns, self._rings = _pattern(lidar)
        turn = np.arange(len(self._rings)) // columns
        slots = turn * self._steps // (turn[-1] + 1)
        self._times = ((slots + 1 - self._steps) * step).astype(np.float32)
        mount = mounting.mount(lidar)
        self._robot_from_sensor = mount.robot_from_sensor
        edges = np.searchsorted(slots, np.arange(self._steps + 1))
        self._rays = BatchRays(
            model, mounting.robot.name, carrier=mount.carrier, mount=mount.carrier_from_sensor, edges=edges
        )
        self._brightness = np.append(model.geom_rgba[:, :3] @ BRIGHT, 0.0)
        self._states = np.empty((self._steps, model.nq))
        self._count = 0
        self.retune(lidar)

    def retune(self, lidar: sensors.Lidar3d) -> None:
        """Use the noise of this model from now on; random streams continue."""
        self._lidar = lidar
        self._noise = self._streams("range") if lidar.noise.range else None
        self._missed = self._streams("missed") if lidar.missed else None

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        lidar = self._lidar
        return SensorInfo(
            kind="lidar3d",
            robot_from_sensor=self._robot_from_sensor,
            rate_hz=lidar.rate_hz,
            noise={"range": lidar.noise.range},
            latency=lidar.latency,
            range=(lidar.range[0], lidar.range[1]),
            fov=math.radians(lidar.fov_deg if lidar.rosette is None else lidar.rosette.fov_deg),
        )

    def after_step(self) -> None:
        """Store the state after a step of the physics."""
        self._states[self._count % self._steps] = self._data.qpos
        self._count += 1

    def take(self, stamp: float) -> PointCloud:
        """Return the revolution that is now complete; before the first one, everything is assumed to be at rest.

        Args:
            stamp: The simulated time [s].
        """
        if self._count < self._steps:
            self._states[:] = self._data.qpos
        beams = self._beams(round(stamp * self._lidar.rate_hz))
        hits = self._rays.cast(beams, self._states, limit=self._lidar.range[1])
        ranges = hits.distances
        if self._noise is not None:
            ranges += self._lidar.noise.range * self._noise.standard_normal(len(ranges))
        nearest, farthest = self._lidar.range
        back = (ranges >= nearest) & (ranges <= farthest)
        if self._missed is not None:
            back &= self._missed.random(len(ranges)) >= self._lidar.missed
        hit = np.flatnonzero(back)
        return PointCloud(
            stamp=stamp,
            points=(ranges[hit, None] * beams[hit]).astype(np.float32),
            times=self._times[hit],
            intensities=(self._brightness[hits.geoms[hit]] * hits.facing[hit]).astype(np.float32),
            rings=self._rings[hit],
        )

    def pass_over(self) -> None:
        """Draw the random numbers of a revolution that was not requested."""
        if self._noise is not None:
            self._noise.standard_normal(len(self._rings))
        if self._missed is not None:
            self._missed.random(len(self._rings))


Pattern = tuple[Callable[[int], Array], int, NDArray[np.uint16]]
"""Number of a revolution -> its beams, unit vectors in the sensor's frame, shape (n, 3); how many are fired at once;
ring of each, shape (n,)."""


def _pattern(lidar: sensors.Lidar3d) -> Pattern:
    if lidar.rosette is not None:
        rosette = lidar.rosette
        return (lambda turn: _petals(rosette, turn, lidar.rate_hz)), 1, np.zeros(rosette.points, dtype=np.uint16)
    up = np.radians(lidar.elevations_deg)
    beams = _stack(lidar, up)
    rings = np.tile(np.arange(len(up), dtype=np.uint16), lidar.columns)
    return (lambda turn: beams), len(up), rings


def _stack(lidar: sensors.Lidar3d, up: Array) -> Array:
    """Return the beams of a stack at these elevations [rad], column after column, shape (columns * rings, 3)."""
    fov, columns = math.radians(lidar.fov_deg), lidar.columns
    # Over a full circle, the last column does not coincide with the first.
    step = fov / (columns if lidar.fov_deg == 360.0 else columns - 1)
    left = (-fov / 2 + step * np.arange(columns))[:, None]
    level = np.cos(up) * np.ones_like(left)
    rows = [level * np.cos(left), level * np.sin(left), np.sin(up) * np.ones_like(left)]
    return np.stack(rows, axis=-1).reshape(-1, 3)


def _petals(rosette: sensors.Rosette, turn: int, rate_hz: float) -> Array:
    """Return the beams of one reading of a rosette, shape (points, 3)."""
    times = (turn + np.arange(rosette.points) / rosette.points) / rate_hz
    angles = np.outer([rpm * 2.0 * math.pi / 60.0 for rpm in rosette.rpm], times)
    bend = math.radians(rosette.fov_deg) / 4
    left, up = bend * np.cos(angles).sum(axis=0), bend * np.sin(angles).sum(axis=0)
    angle = np.hypot(left, up)
    side = np.sinc(angle / math.pi)
    return np.stack([np.cos(angle), side * left, side * up], axis=-1)
