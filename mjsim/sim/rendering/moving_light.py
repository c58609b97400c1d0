"""Light on what moves: that of the probes where it is."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import MEAN_LIGHT
from mjsim.geometry import Array
from mjsim.light import GAMMA, BakedLight
from mjsim.sim.rendering.merged_geoms import moving_bodies

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
"""Corners of a cell of a grid."""


class MovingLight:
    """Colours that the surroundings give to geoms without a light map: one for all of a body, from all directions."""

    def __init__(self, model: mujoco.MjModel, baked: BakedLight) -> None:
        """Find the place of each body by its largest geom."""
        self._baked = baked
        self._last = np.array(baked.probes.light.shape[1:4]) - 1
        _, ny, nz = self._last + 1
        self._steps = np.array([ny * nz, nz, 1])
        bodies = moving_bodies(model)[model.geom_bodyid]
        bodies = np.where(bodies > 0, bodies, model.body_rootid[model.geom_bodyid])
        by_size = np.lexsort([-model.geom_rbound, bodies])
        found, first = np.unique(bodies[by_size], return_index=True)
        largest = by_size[first][np.searchsorted(found, bodies)]
        # What is part of the building has the light of its own place.
        self._points = np.where(bodies > 0, largest, np.arange(model.ngeom))
        self._light = np.zeros((0, 3))

    def set_weights(self, weights: Array) -> None:
        """Take new weights of the groups, shape (groups, 3)."""
        total = np.einsum("gxyzc,gc->xyzc", self._baked.probes.light.astype(float), weights)
        self._light = total.reshape(-1, 3) * self._baked.exposure

    def factors(self, data: mujoco.MjData, geoms: NDArray[np.intp]) -> Array:
        """Return what multiplies the colour that geoms have in full even light, shape (n, 3)."""
        probes = self._baked.probes
        where = np.clip((data.geom_xpos[self._points[geoms]] - probes.origin) / probes.spacing, 0.0, self._last)
        low = np.minimum(where.astype(np.intp), np.maximum(self._last - 1, 0))
        share = (where - low)[:, None]
        weights = np.where(CORNERS, share, 1.0 - share).prod(axis=2)
        places = np.minimum(low[:, None] + CORNERS, self._last) @ self._steps
        light = np.einsum("nk,nkc->nc", weights, self._light[places])
        return np.asarray(np.maximum(light, 0.0) ** (1.0 / GAMMA) / MEAN_LIGHT)
