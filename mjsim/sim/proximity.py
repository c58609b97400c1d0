"""The ring of proximity rays around a robot."""

import mujoco
import numpy as np

from mjsim.geometry import Array
from mjsim.sim.rays import Fan
from mjsim.world import PROXIMITY_HEIGHT, Robot, rims

RAYS = 16


class ProximityRing:
    """Sixteen level rays from the rim of a robot, first ahead, then counter-clockwise."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: Robot) -> None:
        """Keep the model and its state, which is read at each look, and where the rays of the robot begin."""
        self._data, self._fan = data, Fan(model, data, most=RAYS)
        self._base = model.body(f"{robot.name}/base").id
        angles = np.asarray(np.arange(RAYS) * (2.0 * np.pi / RAYS), dtype=float)
        self._rims, self._reach = rims(robot.body, angles), robot.proximity_range
        self._rays = np.stack([np.cos(angles), np.sin(angles), np.zeros(RAYS)], axis=-1)
        self._farthest = float(np.max(self._rims)) + self._reach
        self._start = np.array([0.0, 0.0, PROXIMITY_HEIGHT * robot.body.height])
        self._directions = np.empty((RAYS, 3))

    def ranges(self) -> Array:
        """Return the free distance from the rim along each ray, shape (16,) [m]; +inf beyond its reach.

        What touches the robot is at 0.
        """
        world_from_base = self._data.xmat[self._base].reshape(3, 3)
        np.matmul(self._rays, world_from_base.T, out=self._directions)
        # From the middle, leaving out the base: a ray that began at the rim would begin inside what is touched.
        start = self._data.xpos[self._base] + world_from_base @ self._start
        self._fan.cast(start, self._directions, exclude=self._base, limit=self._farthest)
        distances = self._fan.distances
        hit = (self._fan.geoms >= 0) & (distances <= self._rims + self._reach)
        return np.where(hit, np.maximum(distances - self._rims, 0.0), np.inf)
