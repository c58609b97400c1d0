"""Distance of robots from everything that they could touch, to skip contact checks for some ticks."""

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

MAX_ACCELERATION = 100.0
"""Upper bound of the acceleration of a robot that touches only the floor, ten times that due to friction and gravity
[m/s^2]."""
PAUSE = 25
"""Ticks between two measurements of the distance, which cost more than they save near obstacles."""


class ContactBound:
    """Bounds when robots can touch anything except the floor.

    Each moving body is replaced by the sphere about its root that contains it in every state of its joints, static ones
    by the boxes of their geoms. In a world with slides there is no bound.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, robots: list[int], floor: NDArray[np.bool_], *, dt: float
    ) -> None:
        """Find the moving and the static geoms.

        Args:
            model: The world.
            data: Its state.
            robots: Bodies that are roots of robots.
            floor: Which geoms are the floor.
            dt: Period of a tick [s].
        """
        self._data, self._qpos, self._qvel, self._dt = data, data.qpos, data.qvel, dt
        solid = ((model.geom_contype != 0) | (model.geom_conaffinity != 0)) & ~floor
        trees = model.body_rootid[model.jnt_bodyid]
        moving = np.unique(trees)
        self._is_bounded = not (model.nmocap or model.npair or (model.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE).any())
        self._boxes = np.flatnonzero(solid & ~np.isin(model.body_rootid[model.geom_bodyid], moving))
        self._middles, halves = np.split(model.geom_aabb[self._boxes], 2, axis=1)
        self._halves = halves + model.geom_margin[self._boxes, None]
        roots = np.array(sorted({*moving.tolist(), *robots}), dtype=int)
        self._radii = _radii(model, solid)[roots]
        self._robots = np.flatnonzero(np.isin(roots, robots))
        self._places: Array = model.body_pos[roots].copy()
        free = model.jnt_type == mujoco.mjtJoint.mjJNT_FREE
        self._free = np.searchsorted(roots, trees[free])
        self._in_qpos = (model.jnt_qposadr[free][:, None] + np.arange(3)).ravel()
        self._in_qvel = (model.jnt_dofadr[free][:, None] + np.arange(3)).ravel()
        self._from: Array = np.zeros(len(self._in_qpos))
        self._room, self._age = -math.inf, PAUSE

    def are_clear(self) -> bool:
        """Return whether no robot can touch anything except the floor before the next tick."""
        self._age += 1
        if not self._reaches():
            return True
        if self._age < PAUSE or not self._is_bounded:
            return False
        self._measure()
        return not self._reaches()

    def _reaches(self) -> bool:
        """Return whether motion since the last measurement may have used up the clearance in this tick."""
        moved, speed = self._qpos[self._in_qpos] - self._from, self._qvel[self._in_qvel]
        # NaN counts as near.
        return not math.sqrt(moved.dot(moved)) + math.sqrt(speed.dot(speed)) * self._dt < self._room

    def _measure(self) -> None:
        """Measure the clearance."""
        data, self._age = self._data, 0
        self._from = data.qpos[self._in_qpos]
        self._places[self._free] = self._from.reshape(-1, 3)
        own = self._places[self._robots]
        turned = data.geom_xmat[self._boxes].reshape(-1, 3, 3)
        offset = np.einsum("rki,kij->rkj", own[:, None] - data.geom_xpos[self._boxes], turned)
        beyond = np.maximum(np.abs(offset - self._middles) - self._halves, 0.0)
        boxes = np.sqrt((beyond**2).sum(axis=-1)) - self._radii[self._robots, None]
        spheres = np.sqrt(((own[:, None] - self._places) ** 2).sum(axis=-1)) - self._radii
        spheres -= self._radii[self._robots, None]
        spheres[np.arange(len(own)), self._robots] = math.inf
        clearance = min(float(boxes.min(initial=math.inf)), float(spheres.min(initial=math.inf)))
        # Two bodies approach each other by at most sqrt(2) times the norm of all motion.
        self._room = clearance / math.sqrt(2.0) - MAX_ACCELERATION * self._dt**2


def _radii(model: mujoco.MjModel, solid: NDArray[np.bool_]) -> Array:
    """Return for each root the radius about its position that contains the solid geoms of its tree [m]."""
    reach, radii = np.zeros(model.nbody), np.zeros(model.nbody)
    turns = model.jnt_type != mujoco.mjtJoint.mjJNT_FREE
    # A joint rotates the origin of its body about its anchor.
    np.maximum.at(reach, model.jnt_bodyid[turns], 2.0 * np.linalg.norm(model.jnt_pos[turns], axis=1))
    for body in range(1, model.nbody):
        if model.body_rootid[body] != body:
            reach[body] += reach[model.body_parentid[body]] + np.linalg.norm(model.body_pos[body])
    out = np.linalg.norm(model.geom_pos, axis=1) + model.geom_rbound + model.geom_margin
    bodies = model.geom_bodyid[solid]
    np.maximum.at(radii, model.body_rootid[bodies], reach[bodies] + out[solid])
    return radii
