"""Rays of a sensor that turns while it and everything else moves: each batch of them has a state of its own."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Self

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.sim.rays import SOLID, Rays
from mjsim.sim.standing import Standing, has_embree, is_clear

TINY = 1e-12
"""A ray along a face has at least this share across it."""


@dataclass(frozen=True, slots=True, eq=False)
class RayHits:
    """What rays meet first, one row a ray."""

    distances: Array
    """+inf where nothing is met, shape (n,) [m]."""
    geoms: NDArray[np.int32]
    """-1 for none, shape (n,)."""
    facing: Array
    """Cosine between ray and surface normal, shape (n,)."""
    unsure: NDArray[np.bool_]
    """Whether something round, or with more corners than a box, may be met before; MuJoCo knows, shape (n,)."""

    def __getitem__(self, batch: slice) -> Self:
        """Return views of some rows."""
        return type(self)(self.distances[batch], self.geoms[batch], self.facing[batch], self.unsure[batch])


class BatchRays:
    """Casts all rays of a turn: Embree at what stands still, MuJoCo where the shape is neither flat nor a box.

    Without Embree (`pip install 'mjsim[embree]'`) MuJoCo casts all.
    """

    def __init__(
        self, model: mujoco.MjModel, robot: str, *, carrier: str, mount: Array, edges: NDArray[np.intp]
    ) -> None:
        """Get ready.

        Args:
            model: The compiled world.
            robot: Name of the robot that carries the sensor, which its rays do not meet.
            carrier: The body that carries it, below the robot's name.
            mount: carrier_from_sensor, shape (4, 4) [m].
            edges: Where each batch begins among the rays of a turn, and their count at the end, shape (batches + 1,).
        """
        self._model, self._data = model, mujoco.MjData(model)
        self._batches = [slice(first, last) for first, last in pairwise(edges.tolist())]
        self._rays = Rays(model, self._data, robot, most=int(np.diff(edges).max()), carrier=carrier)
        self._place, self._turned = mount[:3, 3], mount[:3, :3]
        self._starts, self._directions = np.empty((edges[-1], 3)), np.empty((edges[-1], 3))
        self._own: NDArray[np.bool_] = model.body_rootid[model.geom_bodyid] == model.body(f"{robot}/base").id
        moves = (model.body_weldid[model.geom_bodyid] != 0) & ~self._own & ~is_clear(model)
        self._movers: NDArray[np.int64] = np.flatnonzero(moves)
        self._groups: NDArray[np.int32] | None = None
        self._has_embree = has_embree()

    def cast(self, beams: Array, states: Array, *, limit: float) -> RayHits:
        """Return what the rays of a turn meet.

        Args:
            beams: Unit vectors in the sensor's frame, shape (n, 3).
            states: MuJoCo's positions at each batch, shape (batches, nq).
            limit: What is farther is not met [m].
        """
        for batch, state in zip(self._batches, states, strict=True):
            self._aim(batch, beams, state)
        hits = self._at_standing(limit)
        for batch, state in zip(self._batches, states, strict=True):
            if batch.start < batch.stop:
                self._at_others(batch, state, hits[batch], limit)
        return hits

    def _bring_up(self, state: Array) -> None:
        self._data.qpos[:] = state
        mujoco.mj_kinematics(self._model, self._data)

    def _aim(self, batch: slice, beams: Array, state: Array) -> None:
        """Note where the rays of a batch start and point."""
        self._bring_up(state)
        place, axes = self._rays.pose()
        self._starts[batch] = place + axes @ self._place
        np.matmul(beams[batch], (axes @ self._turned).T, out=self._directions[batch])

    def _at_standing(self, limit: float) -> RayHits:
        """Return what rays meet of what stands still."""
        count = len(self._starts)
        if not self._has_embree:
            nothing = np.full(count, np.inf), np.full(count, -1, dtype=np.int32), np.zeros(count)
            return RayHits(*nothing, unsure=np.ones(count, dtype=bool))
        standing = self._standing()
        distances, met = standing.cast(self._starts, self._directions)
        normals = np.append(standing.normals, np.zeros((1, 3)), axis=0)[met]
        distances[distances > limit] = np.inf
        return RayHits(
            distances,
            geoms=np.append(standing.geom_of, np.int32(-1))[met],
            facing=np.abs(np.einsum("ij,ij->i", normals, self._directions)),
            unsure=np.append(standing.is_round, False)[met],
        )

    def _at_others(self, batch: slice, state: Array, hits: RayHits, limit: float) -> None:
        """Put in what the rays of a batch meet of what moves, and what MuJoCo alone can tell."""
        self._bring_up(state)
        directions = self._directions[batch]
        if self._has_embree:
            for mover in self._near(self._starts[batch.start], directions, limit).tolist():
                self._at_mover(mover, self._starts[batch.start], directions, hits)
        rows = np.flatnonzero(hits.unsure)
        if rows.size:
            asked = directions[rows]
            hits.distances[rows] = self._rays.cast(self._starts[batch.start], asked, limit=limit)
            hits.geoms[rows], normals = self._rays.met(len(rows))
            hits.facing[rows] = np.abs(np.einsum("ij,ij->i", normals, asked))

    def _near(self, start: Array, directions: Array, limit: float) -> NDArray[np.int64]:
        """Return the geoms that move and whose bounding sphere lies in reach of the cone around these rays."""
        model, movers = self._model, self._movers
        to, radii = self._data.geom_xpos[movers] - start, model.geom_rbound[movers]
        away = np.maximum(np.linalg.norm(to, axis=1), TINY)
        axis = directions.sum(axis=0)
        axis /= max(float(np.linalg.norm(axis)), TINY)
        widest = np.arccos(np.clip((directions @ axis).min(), -1.0, 1.0))
        off = np.arccos(np.clip(to @ axis / away, -1.0, 1.0)) - np.arcsin(np.clip(radii / away, 0.0, 1.0))
        solid = SOLID[model.geom_group[movers]].astype(bool)
        near: NDArray[np.int64] = movers[solid & (away - radii < limit) & ((off <= widest) | (away <= radii))]
        return near

    def _at_mover(self, mover: int, start: Array, directions: Array, hits: RayHits) -> None:
        """Put in what rays meet of a box that moves; note who may meet a mover that is none."""
        model, axes = self._model, self._data.geom_xmat[mover].reshape(3, 3)
        to = self._data.geom_xpos[mover] - start
        ahead, radius = directions @ to, model.geom_rbound[mover]
        rows = np.flatnonzero((ahead > -radius) & (to @ to - ahead**2 <= radius**2) & (ahead - radius < hits.distances))
        if not rows.size:
            return
        center, half = model.geom_aabb[mover, :3], model.geom_aabb[mover, 3:]
        local = directions[rows] @ axes
        distances, facing = box_met(-to @ axes - center, local, half)
        nearer = distances < hits.distances[rows]
        rows = rows[nearer]
        if model.geom_type[mover] != mujoco.mjtGeom.mjGEOM_BOX:
            hits.unsure[rows] = True
            return
        hits.distances[rows], hits.geoms[rows], hits.facing[rows] = distances[nearer], mover, facing[nearer]

    def _standing(self) -> Standing:
        """Return what stands still, collected again after something was taken away."""
        if self._groups is None or not np.array_equal(self._groups, self._model.geom_group):
            self._groups = self._model.geom_group.copy()
            self._found = Standing(self._model, self._data, without=self._own)
        return self._found


def box_met(start: Array, directions: Array, half: Array) -> tuple[Array, Array]:
    """Return how far rays from outside go to a box about the origin, and the cosine at which they meet it.

    Args:
        start: Shape (3,) [m].
        directions: Unit vectors, shape (n, 3).
        half: Half sizes, shape (3,) [m].

    Returns:
        Distances, +inf for rays that pass, 0 from inside, and cosines, shape (n,) each.

    References:
        Kay and Kajiya, Ray Tracing Complex Scenes, SIGGRAPH 1986: a box is three slabs.
    """
    slopes = np.where(np.abs(directions) < TINY, TINY, directions)
    ends = np.stack([(-half - start) / slopes, (half - start) / slopes])
    enters, leaves = ends.min(axis=0), ends.max(axis=0).min(axis=1)
    side = enters.argmax(axis=1)[:, None]
    first = np.maximum(np.take_along_axis(enters, side, axis=1)[:, 0], 0.0)
    return np.where(first <= leaves, first, np.inf), np.abs(np.take_along_axis(directions, side, axis=1)[:, 0])
