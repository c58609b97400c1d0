"""Light on what moves: that of the probes where it is."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import MEAN_LIGHT
from mjsim.geometry import Array
from mjsim.light import GAMMA, BakedLight
from mjsim.sim.merged_geoms import moving_bodies

CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
"""Corners of a cell of a grid."""


class MovingLight:
    """Colours that the surroundings give to geoms without a light map: one for all of a body, from all directions."""

    def __init__(self, model: mujoco.MjModel, baked: BakedLight, geoms: NDArray[np.intp]) -> None:
        """Group the geoms.

        Args:
            model: The compiled world.
            baked: Its light.
            geoms: Geoms without a light map.
        """
        self._baked = baked
        self._last = np.array(baked.probes.cubes.shape[1:4]) - 1
        bodies = moving_bodies(model)[model.geom_bodyid[geoms]]
        # What stands has light of its own place, geom by geom.
        keys = np.where(bodies > 0, -bodies, geoms)
        self._of_geom = np.unique(keys, return_inverse=True)[1].reshape(-1)
        largest = np.lexsort([-model.geom_rbound[geoms], keys])
        _, first = np.unique(keys[largest], return_index=True)
        self._points = geoms[largest[first]]
        self._light = np.zeros(0)

    def set_weights(self, weights: Array) -> None:
        """Take new weights of the groups, shape (groups, 3)."""
        cubes = self._baked.probes.cubes
        mean = np.zeros((*cubes.shape[1:4], 3))
        for cube, weight in zip(cubes, weights, strict=True):
            mean += cube.mean(axis=3, dtype=np.float64) * weight
        self._light = mean.reshape(-1, 3) * self._baked.exposure

    def factors(self, data: mujoco.MjData) -> Array:
        """Return what multiplies the colour of each geom where full even light falls, shape (n, 3)."""
        probes = self._baked.probes
        where = np.clip((data.geom_xpos[self._points] - probes.origin) / probes.spacing, 0.0, self._last)
        low = np.minimum(where.astype(np.intp), np.maximum(self._last - 1, 0))
        share = (where - low)[:, None]
        weights = np.where(CORNERS, share, 1.0 - share).prod(axis=2)
        _, ny, nz = self._last + 1
        places = np.minimum(low[:, None] + CORNERS, self._last) @ np.array([ny * nz, nz, 1])
        light = np.einsum("nk,nkc->nc", weights, self._light[places])
        return np.asarray(np.maximum(light, 0.0) ** (1.0 / GAMMA) / MEAN_LIGHT)[self._of_geom]
