"""Rays from one point of a robot: how far it is to walls, things and other robots."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

SOLID = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
"""Geom groups that rays hit: 0 and 3, so neither beacons nor anybody's running gear."""
HIDDEN = 5
"""Geom group of what is left out for the time of one look."""


class Rays:
    """A fan of rays that never meet the robot that they come from; its memory is made once."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, robot: str, *, most: int) -> None:
        """Get ready.

        Args:
            model: The compiled world.
            data: Its state, which is read at each look.
            robot: Name of the robot that the rays come from.
            most: How many rays there are at most.
        """
        self._model, self._data = model, data
        self._base = base = model.body(f"{robot}/base").id
        bodies = model.geom_bodyid
        # MuJoCo leaves out one body by itself; whatever else of the robot could be hit is hidden.
        own = (model.body_rootid[bodies] == base) & (bodies != base) & SOLID[model.geom_group].astype(bool)
        self._own: NDArray[np.int64] = np.flatnonzero(own)
        self._groups = model.geom_group[self._own].copy()
        self._geoms = np.empty(most, dtype=np.int32)
        self._distances = np.empty(most)
        self._normals = np.zeros(3 * most)

    def pose(self) -> tuple[Array, Array]:
        """Return world_from_robot: where the robot's origin is, shape (3,) [m], and its axes, shape (3, 3)."""
        return self._data.xpos[self._base], self._data.xmat[self._base].reshape(3, 3)

    def cast(self, start: Array, directions: Array, *, limit: float) -> Array:
        """Return how far each ray goes, shape (n,) [m]; +inf where it meets nothing. The next call writes over it.

        Args:
            start: World frame, shape (3,) [m].
            directions: Unit vectors, world frame, C-contiguous, shape (n, 3).
            limit: What is farther is not met [m].
        """
        count = len(directions)
        geoms, distances = self._geoms[:count], self._distances[:count]
        own = self._own
        if own.size:
            self._model.geom_group[own] = HIDDEN
        try:
            mujoco.mj_multiRay(
                self._model,
                self._data,
                start,
                directions.reshape(-1),
                SOLID,
                True,
                self._base,
                geoms,
                distances,
                self._normals[: 3 * count],
                count,
                limit,
            )
        finally:
            if own.size:
                self._model.geom_group[own] = self._groups
        distances[(geoms < 0) | (distances > limit)] = np.inf
        return distances

    def met(self, count: int) -> tuple[NDArray[np.int32], Array]:
        """Return what the last rays met: geoms, shape (count,), -1 for none, and their normals, shape (count, 3)."""
        return self._geoms[:count], self._normals[: 3 * count].reshape(count, 3)
