"""2-D lidars: one fan of rays per scan, and errors of readings."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Scan, SensorInfo
from mjsim.sim.rays import Rays
from mjsim.sim.sensors.device import CarriedSensor, Mounting
from mjsim.world import sensors

MAX_RANGE_RATIO = 0.1
"""Both sides of a spot are on one surface if their ranges differ by less than this ratio to the nearer one; a wall hit
at a grazing angle is not an edge."""
BRIGHT = np.array([0.2126, 0.7152, 0.0722])
"""Weights of red, green and blue in brightness (ITU-R BT.709)."""


class LidarDevice:
    """A lidar of a robot in a running simulation.

    References:
        ROS REP 117 for missing and too near returns. Ye and Borenstein, Characterization of a 2-D Laser Scanner for
        Mobile Robot Obstacle Negotiation, ICRA 2002, for mixed pixels: a spot on an edge gives a range between both
        surfaces. Lambert's law for the strength of a return.
    """

    def __init__(self, lidar: sensors.Lidar, mounting: Mounting) -> None:
        """Initialise.

        Args:
            lidar: Lidar of the world file.
            mounting: Its mounting; each option has its own random stream.
        """
        self._mounting = mounting
        self._increment: float | None = None
        self._brightness = mounting.model.geom_rgba[:, :3] @ BRIGHT
        self.retune(lidar)

    def retune(self, lidar: sensors.Lidar) -> None:
        """Use the noise of this model from now on; random streams continue."""
        self._lidar, streams = lidar, self._mounting.streams
        self._nearest, self._farthest = lidar.range
        self._first, self._step = beam_angles(lidar)
        angles = self._first + self._step * np.arange(lidar.beams)
        half_spot = math.radians(lidar.spot_deg) / 2
        offsets = (0.0, -half_spot, half_spot) if lidar.mixed_pixels else (0.0,)
        fan = np.concatenate([angles + offset for offset in offsets])
        mount = self._mounting.mount(lidar)
        self._robot_from_sensor = mount.robot_from_sensor
        self._aim(np.stack([np.cos(fan), np.sin(fan), np.zeros(len(fan))], axis=-1), mount)
        self._noise = streams("range") if lidar.noise.range else None
        self._missed = streams("missed") if lidar.missed else None
        self._mixed = streams("mixed") if lidar.mixed_pixels else None

    def _aim(self, fan: Array, mount: CarriedSensor) -> None:
        """Prepare rays in these directions, unit vectors in the sensor's frame, shape (n, 3)."""
        mounting = self._mounting
        self._place = mount.carrier_from_sensor[:3, 3]
        self._beams = fan @ mount.carrier_from_sensor[:3, :3].T
        self._directions = np.empty_like(self._beams)
        self._rays = Rays(mounting.model, mounting.data, mounting.robot.name, capacity=len(fan), carrier=mount.carrier)

    def info(self) -> SensorInfo:
        """Return its data sheet."""
        lidar = self._lidar
        return SensorInfo(
            kind="lidar",
            robot_from_sensor=self._robot_from_sensor,
            rate_hz=lidar.rate_hz,
            noise={"range": lidar.noise.range},
            latency=lidar.latency,
            range=(self._nearest, self._farthest),
            fov=math.radians(lidar.fov_deg),
        )

    def take(self, stamp: float) -> Scan:
        """Return a current scan; `stamp` is the simulated time [s]."""
        count = self._lidar.beams
        distances, strength = self._cast(count)
        ranges = distances[:count].copy()
        if self._mixed is not None:
            _mix(
                ranges,
                distances[count : 2 * count],
                distances[2 * count :],
                self._mixed.random((2, count)),
                self._lidar,
            )
        if self._noise is not None:
            ranges += self._lidar.noise.range * self._noise.standard_normal(count)
        ranges[ranges > self._farthest] = np.inf
        ranges[ranges < self._nearest] = -np.inf
        if self._missed is not None:
            ranges[self._missed.random(count) < self._lidar.missed] = np.inf
        if strength is not None:
            strength[~np.isfinite(ranges)] = 0.0
        return Scan(
            stamp=stamp,
            ranges=ranges,
            angle_min=self._first,
            angle_increment=self._step,
            range_min=self._nearest,
            range_max=self._farthest,
            intensities=strength,
            time_increment=self._increment,
        )

    def pass_over(self) -> None:
        """Draw the random numbers of a scan that was not requested."""
        count = self._lidar.beams
        if self._mixed is not None:
            self._mixed.random((2, count))
        if self._noise is not None:
            self._noise.standard_normal(count)
        if self._missed is not None:
            self._missed.random(count)

    def _cast(self, count: int) -> tuple[Array, Array | None]:
        """Return the distance of each ray of the fan [m], and the strength of the return of each beam if measured.

        The strength is brightness times the cosine of the angle of incidence, shape (count,).
        """
        place, axes = self._rays.pose()
        np.matmul(self._beams, axes.T, out=self._directions)
        distances = self._rays.cast(place + axes @ self._place, self._directions, limit=self._farthest)
        if not self._lidar.intensity:
            return distances, None
        geoms, normals = self._rays.geoms_and_normals(count)
        facing = np.abs(np.einsum("ij,ij->i", normals, self._directions[:count]))
        return distances, np.where(geoms >= 0, self._brightness[geoms] * facing, 0.0)


def beam_angles(lidar: sensors.Lidar) -> tuple[float, float]:
    """Return the angle of the first beam and the step to the next, left positive [rad]."""
    fov = math.radians(lidar.fov_deg)
    # Over a full circle, the last beam does not coincide with the first.
    step = fov / (lidar.beams if lidar.fov_deg == 360.0 else lidar.beams - 1)
    return -fov / 2, step


def _mix(ranges: Array, right: Array, left: Array, chance: Array, lidar: sensors.Lidar) -> None:
    """Move readings whose spot is on an edge to random ranges between both surfaces.

    Args:
        ranges: Ranges of the centres of the spots, changed in place, shape (n,) [m].
        right: Ranges of their right edges, shape (n,) [m].
        left: Ranges of their left edges, shape (n,) [m].
        chance: Two uniform random numbers per beam, shape (2, n).
        lidar: Gives the probability.
    """
    nearer, farther = np.minimum(right, left), np.maximum(right, left)
    on_edge = np.isfinite(farther) & (farther > (1.0 + MAX_RANGE_RATIO) * nearer) & (chance[0] < lidar.mixed_pixels)
    nearer, farther = nearer[on_edge], farther[on_edge]
    ranges[on_edge] = nearer + chance[1, on_edge] * (farther - nearer)
