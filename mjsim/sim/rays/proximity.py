"""The ring of proximity sensors around a robot: horizontal rays, and cones for people."""

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.rays.ray_fan import Fan
from mjsim.world import PROXIMITY_HEIGHT, Robot, rims

RAYS = 16
RAYS_PER_SENSOR = 6
"""Number of rays per sensor of the ring, for cones: 3.75 degrees apart."""
CONE_RAYS = 4
"""Number of rays to each side within the cone of a sensor: 30 degrees, as for ultrasonic sensors."""
MIN_RAY_HEIGHT, MAX_RAY_SPACING = 0.015, 0.15
"""Rows of these rays: height of the lowest, which hits toes, and maximum distance between rows [m]."""


class ProximityRing:
    """Sixteen proximity sensors around a robot, counter-clockwise from the front: level rays and cones."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, *, sought: Sequence[int] = ()) -> None:
        """Store the model and its state, read at each measurement, and where the rays of the robot begin.

        Args:
            model: The compiled world.
            data: Its state.
            robot: Robot with the ring.
            sought: Geoms detected anywhere in the cone of a sensor; all others are only detected by the rays.
        """
        self._data, self._fan = data, Fan(model, data, capacity=RAYS)
        self._base = model.body(f"{robot.name}/base").id
        angles = np.asarray(np.arange(RAYS) * (2.0 * np.pi / RAYS), dtype=float)
        self._rims, self._reach = rims(robot.body, angles), robot.proximity_range
        self._rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(RAYS)], axis=-1)
        self._farthest = float(np.max(self._rims)) + self._reach
        self._start = np.array([0.0, 0.0, PROXIMITY_HEIGHT * robot.body.height])
        self._directions = np.empty((RAYS, 3))
        self._cones = Cones(model, data, robot, sought) if len(sought) else None

    def ranges(self) -> Array:
        """Return the free distance from the rim along each ray, shape (16,) [m]; +inf beyond its range.

        It is 0 in contact. Sought geoms are detected if any part of them is in the cone of a sensor.
        """
        world_from_base = self._data.xmat[self._base].reshape(3, 3)
        np.matmul(self._rays, world_from_base.T, out=self._directions)
        # From the centre, excluding the base: a ray that started at the rim would start inside a touched object.
        start = self._data.xpos[self._base] + world_from_base @ self._start
        self._fan.cast(start, self._directions, exclude=self._base, limit=self._farthest)
        distances = self._fan.distances
        hit = (self._fan.geoms >= 0) & (distances <= self._rims + self._reach)
        found = np.where(hit, np.maximum(distances - self._rims, 0.0), np.inf)
        return found if self._cones is None else np.minimum(found, self._cones.ranges())


class Cones:
    """Detections of a ring in cones: objects between two rays, such as legs, or below all rays, such as feet.

    Each sensor detects chosen geoms in a cone, in rows from the floor to the height of the robot, like the thermal
    sensors of robots that work among people.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot, sought: Sequence[int]) -> None:
        """Store the model and its state, read at each measurement.

        Args:
            model: The compiled world.
            data: Its state.
            robot: Robot with the ring.
            sought: Geoms to detect.
        """
        self._data, self._base = data, model.body(f"{robot.name}/base").id
        count = RAYS_PER_SENSOR * RAYS
        angles = np.asarray(np.arange(count) * (2.0 * np.pi / count), dtype=float)
        self._rims, self._reach = rims(robot.body, angles), robot.proximity_range
        self._rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)], axis=-1)
        self._farthest = float(np.max(self._rims)) + self._reach
        top = max(robot.body.height, MIN_RAY_HEIGHT)
        self._heights = np.linspace(MIN_RAY_HEIGHT, top, 1 + math.ceil((top - MIN_RAY_HEIGHT) / MAX_RAY_SPACING))
        self._cones = (RAYS_PER_SENSOR * np.arange(RAYS)[:, None] + np.arange(-CONE_RAYS, CONE_RAYS + 1)) % count
        self._is_sought = np.zeros(model.ngeom, dtype=bool)
        self._is_sought[sought] = True
        self._parts = np.flatnonzero(self._is_sought)
        self._sizes = model.geom_rbound[self._parts]
        self._fan = Fan(model, data, capacity=count)

    def ranges(self) -> Array:
        """Return the minimum distance from the rim to sought geoms in each cone, shape (16,) [m]; or +inf."""
        place, axes = self._data.xpos[self._base], self._data.xmat[self._base].reshape(3, 3)
        away = np.hypot(*(self._data.geom_xpos[self._parts, :2] - place[:2]).T) - self._sizes
        if away.min() > self._farthest:
            return np.full(RAYS, np.inf)
        directions = np.ascontiguousarray(self._rays @ axes.T)
        rows = [self._row(place + height * axes[:, 2], directions) for height in self._heights]
        return np.asarray(np.min(rows, axis=0))

    def _row(self, start: Array, directions: Array) -> Array:
        """Return `ranges` for the rays from one point on the robot's axis.

        Args:
            start: World frame, shape (3,) [m].
            directions: Unit vectors, world frame, shape (96, 3).
        """
        self._fan.cast(start, directions, exclude=self._base, limit=self._farthest)
        geoms, distances = self._fan.geoms, self._fan.distances
        hit = (geoms >= 0) & self._is_sought[geoms] & (distances <= self._rims + self._reach)
        free = np.where(hit, np.maximum(distances - self._rims, 0.0), np.inf)
        return np.asarray(free[self._cones].min(axis=1))
