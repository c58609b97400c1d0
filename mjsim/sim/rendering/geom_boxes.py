"""Boxes around geoms, with sides along the axes of the world."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models import matrix_of

CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
"""Corners of a cube centred on the origin."""


class GeomBoxes:
    """Boxes of some geoms; those of static ones are computed once."""

    def __init__(self, model: mujoco.MjModel, geoms: NDArray[np.intp]) -> None:
        """Compute the boxes of the static geoms."""
        static = model.geom_bodyid[geoms] == 0
        self._rows = np.flatnonzero(~static)
        self._moving = geoms[self._rows]
        self.last = np.zeros((len(geoms), 3)), np.zeros((len(geoms), 3))
        """Minimum and maximum corners of the last update, world frame, shapes (n, 3) [m]."""
        for row in np.flatnonzero(static).tolist():
            self.last[0][row], self.last[1][row] = _box(model, int(geoms[row]))
        own = [_own_box(model, int(geom)) for geom in self._moving]
        self._middles, self._halves = np.array(own).reshape(-1, 2, 3).transpose(1, 0, 2)

    def update(self, data: mujoco.MjData) -> tuple[Array, Array]:
        """Return minimum and maximum corners in a state, world frame, shapes (n, 3) [m]."""
        low, high = self.last
        if len(self._moving):
            axes = data.geom_xmat[self._moving].reshape(-1, 3, 3)
            middles = data.geom_xpos[self._moving] + np.einsum("nij,nj->ni", axes, self._middles)
            halves = np.einsum("nij,nj->ni", np.abs(axes), self._halves)
            low[self._rows], high[self._rows] = middles - halves, middles + halves
        return low, high


def _own_box(model: mujoco.MjModel, geom: int) -> tuple[Array, Array]:
    """Return middle and half sides of a box around a geom, in its frame, shapes (3,) [m]."""
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE:
        # A plane without sizes is infinite; infinity times 0 would be NaN.
        sizes = np.where(model.geom_size[geom, :2] > 0.0, model.geom_size[geom, :2], ENDLESS)
        middle, half = np.zeros(3), np.append(sizes, 0.0)
    return middle, half


ENDLESS = 1e9
"""Half a side of an infinite plane [m]."""


def _box(model: mujoco.MjModel, geom: int) -> Array:
    """Return the corners of a box around a geom on the world's body, world frame, shape (2, 3) [m]."""
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        points = model.mesh_vert[first : first + model.mesh_vertnum[mesh]].astype(float)
    else:
        middle, half = _own_box(model, geom)
        points = middle + half * CORNERS
    if not np.isfinite(points).all():
        return np.array([[-ENDLESS] * 3, [ENDLESS] * 3])
    p_world = points @ matrix_of(model.geom_quat[geom]).T + model.geom_pos[geom]
    return np.stack([p_world.min(axis=0), p_world.max(axis=0)])
