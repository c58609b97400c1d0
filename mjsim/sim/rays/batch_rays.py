"""Rays of a rotating sensor in a moving world: each batch of rays has its own state of the simulation."""

from itertools import pairwise

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.sim.rays.embree import Standing, has_embree, is_clear
from mjsim.sim.rays.ray_fan import SOLID, RayHits, Rays

MIN_COMPONENT = 1e-12
"""Minimum component of a ray perpendicular to a face that it runs along."""


class BatchRays:
    """Casts all rays of a turn: Embree for static geoms, MuJoCo for shapes that are neither flat nor boxes.

    Movable geoms that did not move during a turn form a second scene, rebuilt after any of them has moved.

    Where Embree cannot be used, MuJoCo casts all rays.
    """

    def __init__(
        self, model: mujoco.MjModel, robot: str, *, carrier: str, mount: Array, edges: NDArray[np.intp]
    ) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            robot: Name of the robot that carries the sensor; rays ignore it.
            carrier: The body that carries the sensor, below the robot's name.
            mount: carrier_from_sensor, shape (4, 4) [m].
            edges: First ray of each batch, and the number of rays of a turn at the end, shape (batches + 1,).
        """
        self._model, self._data = model, mujoco.MjData(model)
        self._batches = [slice(first, last) for first, last in pairwise(edges.tolist())]
        self._rays = Rays(model, self._data, robot, capacity=int(np.diff(edges).max()), carrier=carrier)
        self._place, self._turned = mount[:3, 3], mount[:3, :3]
        self._starts, self._directions = np.empty((edges[-1], 3)), np.empty((edges[-1], 3))
        own = model.body_rootid[model.geom_bodyid] == model.body(f"{robot}/base").id
        moves = model.body_weldid[model.geom_bodyid] != 0
        self._fixed: NDArray[np.int64] = np.flatnonzero(~moves & ~own & ~is_clear(model))
        self._movers: NDArray[np.int64] = np.flatnonzero(moves & ~own & ~is_clear(model))
        # Static bodies attached to others: segments of people, and little else.
        self._turning = np.flatnonzero((model.body_weldid == 0) & (model.body_parentid != 0))
        count = len(self._batches), len(self._movers)
        self._places, self._axes = np.empty((*count, 3)), np.empty((*count, 9))
        self._eyes, self._ahead = np.empty((count[0], 3)), np.empty((count[0], 3))
        self._beams: Array | None = None
        self._known: dict[str, tuple[bytes, Standing]] = {}
        self._has_embree = has_embree()

    def cast(self, beams: Array, states: Array, *, limit: float) -> RayHits:
        """Return the hits of the rays of a turn.

        Args:
            beams: Unit vectors in the sensor's frame, shape (n, 3).
            states: MuJoCo's positions at each batch, shape (batches, nq).
            limit: Largest distance of a hit [m].
        """
        for number, state in enumerate(states):
            self._aim(number, beams, state)
        return self._hits(states, limit)

    def cast_between(self, beams: Array, states: Array, shares: Array, *, limit: float) -> RayHits:
        """Return the hits of the rays of a turn; the sensor moves evenly from state to state.

        Args:
            beams: Unit vectors in the sensor's frame, shape (n, 3).
            states: MuJoCo's positions before the first batch and at the end of each, shape (batches + 1, nq).
            shares: When each ray is cast, from 0 at the beginning of its batch to 1 at its end, shape (n,).
            limit: Largest distance of a hit [m].
        """
        eye, turned = self._view(states[0])
        for number, batch in enumerate(self._batches):
            left = 1.0 - shares[batch, None]
            now, turned_now = self._aim(number, beams, states[number + 1])
            self._starts[batch] -= left * (now - eye)
            directions = self._directions[batch] - left * (beams[batch] @ (turned_now - turned).T)
            self._directions[batch] = directions / np.linalg.norm(directions, axis=1, keepdims=True)
            self._eyes[number] = 0.5 * (eye + now)
            eye, turned = now, turned_now
        return self._hits(states[1:], limit)

    def _hits(self, states: Array, limit: float) -> RayHits:
        """Return the hits of the rays as they were aimed."""
        movers: list[list[int]] = [[]] * len(states)
        if not self._has_embree:
            hits = RayHits.nothing(len(self._starts), unsure=True)
        else:
            solid = SOLID[self._model.geom_group].astype(bool)
            resting = solid[self._movers] & self._stay()
            hits = self._standing("fixed", self._fixed[solid[self._fixed]], self._held(), limit)
            if resting.any():
                poses = self._places[0, resting].tobytes() + self._axes[0, resting].tobytes()
                hits.add(self._standing("resting", self._movers[resting], poses, limit))
            movers = self._movers_in_reach(np.flatnonzero(solid[self._movers] & ~resting), limit)
        for number, batch in enumerate(self._batches):
            for mover in movers[number]:
                self._at_mover(number, mover, hits[batch])
            self._at_round(number, states[number], hits[batch], limit)
        return hits

    def _held(self) -> bytes:
        """Return the orientations of static geoms that events can change: the arms of people."""
        return bytes(self._model.body_quat[self._turning].tobytes())

    def _bring_up(self, state: Array) -> None:
        self._data.qpos[:] = state
        mujoco.mj_kinematics(self._model, self._data)

    def _view(self, state: Array) -> tuple[Array, Array]:
        """Return the position of the sensor in a state, shape (3,) [m], and its axes, shape (3, 3)."""
        self._bring_up(state)
        place, axes = self._rays.pose()
        return place + axes @ self._place, axes @ self._turned

    def _aim(self, number: int, beams: Array, state: Array) -> tuple[Array, Array]:
        """Store the rays of a batch and the poses of movable geoms at its time; return the pose of the sensor."""
        if beams is not self._beams:
            self._beams, self._cones = beams, [_cone(beams[batch]) for batch in self._batches]
        eye, turned = self._view(state)
        batch = self._batches[number]
        self._starts[batch] = self._eyes[number] = eye
        np.matmul(beams[batch], turned.T, out=self._directions[batch])
        self._ahead[number] = turned @ self._cones[number][0]
        self._places[number] = self._data.geom_xpos[self._movers]
        self._axes[number] = self._data.geom_xmat[self._movers]
        return eye, turned

    def _stay(self) -> NDArray[np.bool_]:
        """Return which movers keep exactly the same pose for the entire turn, with the sensor outside of them."""
        same = (self._places == self._places[0]).all(axis=(0, 2)) & (self._axes == self._axes[0]).all(axis=(0, 2))
        away = np.linalg.norm(self._places - self._eyes[:, None], axis=2).min(axis=0)
        stay: NDArray[np.bool_] = same & (away > self._model.geom_rbound[self._movers])
        return stay

    def _standing(self, name: str, geoms: NDArray[np.int64], poses: bytes, limit: float) -> RayHits:
        """Return the hits of rays on geoms at rest; the scene is rebuilt when the set or the poses of these change."""
        key = geoms.tobytes() + poses
        if name not in self._known or self._known[name][0] != key:
            self._known[name] = key, Standing(self._model, self._data, geoms)
        return self._known[name][1].cast(self._starts, self._directions, limit=limit)

    def _at_round(self, number: int, state: Array, hits: RayHits, limit: float) -> None:
        """Add the hits of the rays of a batch on shapes that only MuJoCo can intersect."""
        rows = np.flatnonzero(hits.unsure)
        if rows.size:
            self._bring_up(state)
            directions = self._directions[self._batches[number]][rows]
            hits.distances[rows] = self._rays.cast(self._eyes[number], directions, limit=limit)
            hits.geoms[rows], normals = self._rays.geoms_and_normals(len(rows))
            hits.facing[rows] = np.abs(np.einsum("ij,ij->i", normals, directions))

    def _movers_in_reach(self, moving: NDArray[np.intp], limit: float) -> list[list[int]]:
        """Return for each batch the movers whose bounding sphere intersects the cone around its rays."""
        to, radii = self._places[:, moving] - self._eyes[:, None], self._model.geom_rbound[self._movers[moving]]
        away = np.maximum(np.linalg.norm(to, axis=2), MIN_COMPONENT)
        angles = np.arccos(np.clip(np.einsum("bmi,bi->bm", to, self._ahead) / away, -1.0, 1.0))
        gap = angles - np.arcsin(np.clip(radii / away, 0.0, 1.0))
        widest = np.array([widest for _, widest in self._cones])[:, None]
        in_reach = (away - radii < limit) & ((gap <= widest) | (away <= radii))
        return [moving[row].tolist() for row in in_reach]

    def _at_mover(self, number: int, mover: int, hits: RayHits) -> None:
        """Add the hits of rays on a moving box; note the batches that may hit a mover of another shape."""
        model, geom, axes = self._model, self._movers[mover], self._axes[number, mover].reshape(3, 3)
        to, directions = self._places[number, mover] - self._eyes[number], self._directions[self._batches[number]]
        ahead, radius = directions @ to, model.geom_rbound[geom]
        rows = np.flatnonzero((ahead > -radius) & (to @ to - ahead**2 <= radius**2) & (ahead - radius < hits.distances))
        if not rows.size:
            return
        center, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        local = directions[rows] @ axes
        distances, facing = box_hits(-to @ axes - center, local, half)
        nearer = distances < hits.distances[rows]
        rows = rows[nearer]
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_BOX:
            hits.unsure[rows] = True
            return
        hits.distances[rows], hits.geoms[rows], hits.facing[rows] = distances[nearer], geom, facing[nearer]


def _cone(beams: Array) -> tuple[Array, float]:
    """Return the axis of a cone around beams, shape (3,), and its half angle [rad]; -inf for no beams."""
    axis = beams.sum(axis=0)
    axis /= max(float(np.linalg.norm(axis)), MIN_COMPONENT)
    return axis, float(np.arccos(np.clip((beams @ axis).min(), -1.0, 1.0))) if len(beams) else -np.inf


def box_hits(start: Array, directions: Array, half: Array) -> tuple[Array, Array]:
    """Return the distances of rays from outside to a box about the origin, and the cosines of incidence.

    Args:
        start: Shape (3,) [m].
        directions: Unit vectors, shape (n, 3).
        half: Half sizes, shape (3,) [m].

    Returns:
        Distances, +inf for rays that miss, 0 from inside, and cosines, shape (n,) each.

    References:
        Kay and Kajiya, Ray Tracing Complex Scenes, SIGGRAPH 1986: a box is three slabs.
    """
    slopes = np.where(np.abs(directions) < MIN_COMPONENT, MIN_COMPONENT, directions)
    ends = np.stack([(-half - start) / slopes, (half - start) / slopes])
    enters, leaves = ends.min(axis=0), ends.max(axis=0).min(axis=1)
    side = enters.argmax(axis=1)[:, None]
    first = np.maximum(np.take_along_axis(enters, side, axis=1)[:, 0], 0.0)
    return np.where(first <= leaves, first, np.inf), np.abs(np.take_along_axis(directions, side, axis=1)[:, 0])
