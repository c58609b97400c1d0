"""Visibility: geoms outside the view of a camera, or behind walls, are not rendered."""

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import rgba_of
from mjsim.geometry import Array
from mjsim.sim.rendering.hiding import Hiding


@dataclass(frozen=True, slots=True, eq=False)
class Frustum:
    """Where a camera is and how far it sees to all sides; world frame."""

    eye: Array
    """Shape (3,) [m]."""
    ahead: Array
    """Along the optical axis, shape (3,)."""
    up: Array
    """Shape (3,)."""
    right: Array
    """Shape (3,)."""
    half_width: float
    """Tangent of half the horizontal field of view."""
    half_height: float
    """Tangent of half the vertical field of view."""
    columns: int
    """Of the picture [px]."""

    def beside(self, offsets: Array, radii: Array) -> NDArray[np.bool_]:
        """Say of balls whether they lie wholly beside or behind the view; their middles from the eye, shape (n, 3)."""
        right, up, ahead = offsets @ self.right, offsets @ self.up, offsets @ self.ahead
        wide, high = self.half_width, self.half_height
        beside = np.abs(right) - wide * ahead > radii * np.hypot(1.0, wide)
        beside |= np.abs(up) - high * ahead > radii * np.hypot(1.0, high)
        beside |= ahead < -radii
        return np.asarray(beside)


def frustum_of(scene: mujoco.MjvScene, *, width: int, height: int) -> Frustum:
    """Return the view of a scene whose camera is up to date, for pictures of a size [px]."""
    first, second = scene.camera[0], scene.camera[1]
    ahead, up = np.array(first.forward, dtype=float), np.array(first.up, dtype=float)
    half_height = float(first.frustum_top / first.frustum_near)
    return Frustum(
        eye=(np.asarray(first.pos, dtype=float) + second.pos) / 2,
        ahead=ahead,
        up=up,
        right=np.array(
            [
                ahead[1] * up[2] - ahead[2] * up[1],
                ahead[2] * up[0] - ahead[0] * up[2],
                ahead[0] * up[1] - ahead[1] * up[0],
            ]
        ),
        half_width=half_height * width / height,
        half_height=half_height,
        columns=width,
    )


class InView:
    """Tells which geoms a camera may see; what does not change is made once."""

    def __init__(self, model: mujoco.MjModel, drawn: NDArray[np.intp]) -> None:
        """Initialise.

        Args:
            model: The compiled world.
            drawn: Geoms that are drawn at all.
        """
        self._drawn = drawn
        self.clear = np.array([geom for geom in drawn.tolist() if rgba_of(model, geom)[3] < 1.0], dtype=np.intp)
        """Those that are transparent."""
        self._planes = np.asarray(model.geom_type[drawn] == mujoco.mjtGeom.mjGEOM_PLANE)
        sizes = model.geom_size[drawn]
        # Of a sphere around each [m]; a plane without sizes has no end.
        flat = np.where(sizes[:, :2].min(axis=1, initial=np.inf) > 0.0, np.hypot(sizes[:, 0], sizes[:, 1]), np.inf)
        self._radii = np.where(self._planes, flat, model.geom_rbound[drawn])
        self._hiding = Hiding(model, drawn)

    def unseen(self, data: mujoco.MjData, view: Frustum) -> NDArray[np.intp]:
        """Return the drawn geoms that lie wholly beside or behind the view or behind walls, or show a bare back."""
        offsets = data.geom_xpos[self._drawn] - view.eye
        normals = data.geom_xmat[self._drawn, 2::3]
        unseen = self._planes & (np.einsum("ij,ij->i", offsets, normals) > 0.0)
        unseen |= view.beside(offsets, self._radii)
        self._hiding.add_to(unseen, view.eye, view.ahead, view.right, view.half_width, view.columns)
        return np.asarray(self._drawn[unseen])
