"""Rays from one point of a robot: distances to walls, objects and other robots."""

from dataclasses import dataclass
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

SOLID = np.array([1, 0, 0, 1, 0, 0], dtype=np.uint8)
"""Geom groups that rays hit: 0 and 3, so neither beacons nor running gears."""
COSINE_TOLERANCE = 1e-12
"""Tolerance of the cosine of half a rotation."""
HIDDEN = 5
"""Geom group of geoms excluded from one cast."""


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """First hits of rays, one row per ray."""

    distances: Array
    """Distances, +inf without a hit, shape (n,) [m]."""
    geoms: NDArray[np.int32]
    """Geoms hit, -1 for none, shape (n,)."""
    facing: Array
    """Cosine between ray and surface normal, shape (n,)."""
    unsure: NDArray[np.bool_]
    """Whether a round or polyhedral geom may be hit before, for MuJoCo to decide, shape (n,)."""

    @classmethod
    def nothing(cls, count: int, *, unsure: bool = False) -> Self:
        """Return hits of rays that hit nothing, or that are not yet cast."""
        free = np.full(count, np.inf), np.full(count, -1, dtype=np.int32), np.zeros(count)
        return cls(*free, unsure=np.full(count, unsure))

    def __getitem__(self, batch: slice) -> Self:
        """Return views of some rows."""
        return type(self)(self.distances[batch], self.geoms[batch], self.facing[batch], self.unsure[batch])

    def add(self, others: Self) -> None:
        """Merge hits of the same rays on other geoms, where these are nearer."""
        rows = np.flatnonzero(others.distances < self.distances)
        self.distances[rows], self.geoms[rows] = others.distances[rows], others.geoms[rows]
        self.facing[rows], self.unsure[rows] = others.facing[rows], others.unsure[rows]


class Fan:
    """Casts fans of rays, each from one point, with preallocated memory.

    `mj_multiRay` takes the bounding boxes of bodies as aligned with their frames, but they are aligned with principal
    axes. It therefore misses geoms of a body with rotated principal axes, such as a link of an arm or a robot with an
    asymmetric outline. In a model with such bodies rays are cast one by one.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, *, capacity: int, normals: bool = False) -> None:
        """Store the model and its state, which is read at each cast.

        Args:
            model: The compiled world.
            data: Its state.
            capacity: Largest number of rays.
            normals: Whether to compute surface normals.
        """
        self._model, self._data = model, data
        self.geoms = np.full(capacity, -1, dtype=np.int32)
        """Geoms hit by the last cast, -1 for none, shape (capacity,)."""
        self.distances = np.empty(capacity)
        """Distances of these hits, shape (capacity,) [m]."""
        self.normals = np.zeros((capacity, 3)) if normals else None
        """Surface normals of these hits, world frame, shape (capacity, 3)."""
        bodies = np.unique(model.geom_bodyid[SOLID[model.geom_group].astype(bool)])
        self._turned = bool((np.abs(model.body_iquat[bodies, 0]) < 1.0 - COSINE_TOLERANCE).any())

    def cast(self, start: Array, directions: Array, *, exclude: int, limit: float) -> None:
        """Cast the first rays of the fan, one for each direction.

        Args:
            start: World frame, shape (3,) [m].
            directions: Unit vectors, world frame, C-contiguous, shape (n, 3).
            exclude: Number of a body that rays ignore.
            limit: Distance beyond which hits may be omitted [m].
        """
        if self._turned:
            self._one_by_one(start, directions, exclude)
        else:
            self._at_once(start, directions, exclude, limit)

    def _at_once(self, start: Array, directions: Array, exclude: int, limit: float) -> None:
        n, rays = len(directions), directions.reshape(-1)
        geoms, distances = self.geoms[:n], self.distances[:n]
        normals = None if self.normals is None else self.normals[:n].reshape(-1)
        mujoco.mj_multiRay(
            self._model, self._data, start, rays, SOLID, True, exclude, geoms, distances, normals, n, limit
        )

    def _one_by_one(self, start: Array, directions: Array, exclude: int) -> None:
        for k, direction in enumerate(directions):
            normal = None if self.normals is None else self.normals[k]
            geom = self.geoms[k : k + 1]
            self.distances[k] = mujoco.mj_ray(
                self._model, self._data, start, direction, SOLID, True, exclude, geom, normal
            )


class Rays:
    """A fan of rays that ignore the robot that they come from, with preallocated memory."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, robot: str, *, capacity: int, carrier: str = "base"
    ) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            data: Its state, read at each measurement.
            robot: Name of the robot that the rays come from.
            capacity: Largest number of rays.
            carrier: The body whose frame `pose` returns, below the robot's name.
        """
        self._model, self._data = model, data
        self._base = base = model.body(f"{robot}/base").id
        self._carrier = model.body(f"{robot}/{carrier}").id
        bodies = model.geom_bodyid
        # MuJoCo can exclude one body; other parts of the robot that could be hit are hidden.
        own = (model.body_rootid[bodies] == base) & (bodies != base) & SOLID[model.geom_group].astype(bool)
        self._own: NDArray[np.int64] = np.flatnonzero(own)
        self._groups = model.geom_group[self._own].copy()
        self._fan = Fan(model, data, capacity=capacity, normals=True)

    def pose(self) -> tuple[Array, Array]:
        """Return world_from_carrier: the origin of the carrier, shape (3,) [m], and its axes, shape (3, 3)."""
        return self._data.xpos[self._carrier], self._data.xmat[self._carrier].reshape(3, 3)

    def cast(self, start: Array, directions: Array, *, limit: float) -> Array:
        """Return the distance of each ray, shape (n,) [m]; +inf without a hit. The next call overwrites the array.

        Args:
            start: World frame, shape (3,) [m].
            directions: Unit vectors, world frame, C-contiguous, shape (n, 3).
            limit: Largest distance of a hit [m].
        """
        own = self._own
        if own.size:
            self._model.geom_group[own] = HIDDEN
        try:
            self._fan.cast(start, directions, exclude=self._base, limit=limit)
        finally:
            if own.size:
                self._model.geom_group[own] = self._groups
        count = len(directions)
        geoms, distances = self._fan.geoms[:count], self._fan.distances[:count]
        distances[(geoms < 0) | (distances > limit)] = np.inf
        return distances

    def geoms_and_normals(self, count: int) -> tuple[NDArray[np.int32], Array]:
        """Return the hits of the last rays: geoms, shape (count,), -1 for none, and normals, shape (count, 3)."""
        assert self._fan.normals is not None
        return self._fan.geoms[:count], self._fan.normals[:count]
