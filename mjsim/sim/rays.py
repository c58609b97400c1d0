"""Rays from one point of a robot: how far it is to walls, things and other robots."""

from functools import partial
from typing import Protocol

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

SOLID = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
"""Geom groups that rays hit: 0 and 3, so neither beacons nor anybody's running gear."""
STRAIGHT = 1e-12
"""The cosine of half a turn may be off by this."""
HIDDEN = 5
"""Geom group of what is left out for the time of one look."""


class Fan(Protocol):
    """Casts a fan of rays from one point: first geoms, -1 for none, their distances, and the normals there."""

    def __call__(
        self,
        start: Array,
        directions: Array,
        *,
        exclude: int,
        geoms: NDArray[np.int32],
        distances: Array,
        normals: Array | None,
        limit: float,
    ) -> None:
        """Write what rays meet into the arrays.

        Args:
            start: World frame, shape (3,) [m].
            directions: Unit vectors, world frame, C-contiguous, shape (n, 3).
            exclude: Number of the body that is not met.
            geoms: Shape (n,).
            distances: Shape (n,) [m].
            normals: Shape (3 n,); None where nobody asks.
            limit: What is farther may be left out [m].
        """


def fan_of(model: mujoco.MjModel, data: mujoco.MjData) -> Fan:
    """Return what casts fans of rays in a model: all at once where MuJoCo finds everything so, else one by one.

    `mj_multiRay` looks for bodies in boxes along their frames, but the boxes lie along principal axes: it passes some
    of what hangs on a body whose principal axes are turned, such as a link of an arm or a robot of an odd outline.
    """
    bodies = np.unique(model.geom_bodyid[SOLID[model.geom_group].astype(bool)])
    turned = bool((np.abs(model.body_iquat[bodies, 0]) < 1.0 - STRAIGHT).any())
    return partial(_one_by_one if turned else _at_once, model, data)


def _at_once(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    start: Array,
    directions: Array,
    *,
    exclude: int,
    geoms: NDArray[np.int32],
    distances: Array,
    normals: Array | None,
    limit: float,
) -> None:
    rays, count = directions.reshape(-1), len(directions)
    mujoco.mj_multiRay(model, data, start, rays, SOLID, True, exclude, geoms, distances, normals, count, limit)


def _one_by_one(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    start: Array,
    directions: Array,
    *,
    exclude: int,
    geoms: NDArray[np.int32],
    distances: Array,
    normals: Array | None,
    limit: float,
) -> None:
    for number, direction in enumerate(directions):
        normal = None if normals is None else normals[3 * number : 3 * number + 3]
        met = geoms[number : number + 1]
        distances[number] = mujoco.mj_ray(model, data, start, direction, SOLID, True, exclude, met, normal)


class Rays:
    """A fan of rays that never meet the robot that they come from; its memory is made once."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, robot: str, *, most: int, carrier: str = "base"
    ) -> None:
        """Get ready.

        Args:
            model: The compiled world.
            data: Its state, which is read at each look.
            robot: Name of the robot that the rays come from.
            most: How many rays there are at most.
            carrier: The body in whose frame `pose` is, below the robot's name.
        """
        self._model, self._data = model, data
        self._base = base = model.body(f"{robot}/base").id
        self._carrier = model.body(f"{robot}/{carrier}").id
        bodies = model.geom_bodyid
        # MuJoCo leaves out one body by itself; whatever else of the robot could be hit is hidden.
        own = (model.body_rootid[bodies] == base) & (bodies != base) & SOLID[model.geom_group].astype(bool)
        self._own: NDArray[np.int64] = np.flatnonzero(own)
        self._groups = model.geom_group[self._own].copy()
        self._geoms = np.empty(most, dtype=np.int32)
        self._distances = np.empty(most)
        self._normals = np.zeros(3 * most)
        self._fan = fan_of(model, data)

    def pose(self) -> tuple[Array, Array]:
        """Return world_from_carrier: where the origin of the carrier is, shape (3,) [m], and its axes, shape (3, 3)."""
        return self._data.xpos[self._carrier], self._data.xmat[self._carrier].reshape(3, 3)

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
            normals = self._normals[: 3 * count]
            self._fan(
                start, directions, exclude=self._base, geoms=geoms, distances=distances, normals=normals, limit=limit
            )
        finally:
            if own.size:
                self._model.geom_group[own] = self._groups
        distances[(geoms < 0) | (distances > limit)] = np.inf
        return distances

    def met(self, count: int) -> tuple[NDArray[np.int32], Array]:
        """Return what the last rays met: geoms, shape (count,), -1 for none, and their normals, shape (count, 3)."""
        return self._geoms[:count], self._normals[: 3 * count].reshape(count, 3)
