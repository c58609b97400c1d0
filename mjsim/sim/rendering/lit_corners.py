"""Baked light as colours of corners, for files whose viewers do not support light maps."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import PICTURES, Triangles, divided
from mjsim.geometry import Array
from mjsim.light import GAMMA, BakedLight, LitSurface

MAX_EDGE = 0.4
"""Longest edge of a triangle with light at its corners [m]."""
TURN_DISTANCE = 0.2
"""Distance that counts as much as a surface turned by a right angle [m]."""


class LitCorners:
    """The light on static surfaces, looked up by position and normal: also on the parts of merged furniture."""

    def __init__(self, baked: BakedLight, weights: Array) -> None:
        """Sample the light at the corners of small triangles.

        Args:
            baked: Light of a world.
            weights: Weight of each group of lights, shape (groups, 3).
        """
        from scipy.spatial import cKDTree

        image = np.ascontiguousarray(np.clip(baked.total(weights), 0.0, 1.0) ** (1.0 / GAMMA), dtype=np.float32)
        samples = [_samples(surface, image) for surface in baked.surfaces]
        self._tree = cKDTree(np.concatenate([places for places, _ in samples]))
        self._values = np.concatenate([values for _, values in samples])

    def lit(self, shape: Triangles) -> tuple[Triangles, Array]:
        """Return a surface with smaller triangles, and the light on its corners as values of pictures, shape (n, 3).

        Args:
            shape: Shape in the world frame.
        """
        columns, corners = divided(
            np.hstack([shape.points, shape.normals, shape.places]), shape.corners.astype(np.int32), MAX_EDGE
        )
        points, normals = columns[:, :3], columns[:, 3:6]
        _, nearest = self._tree.query(_places(points, normals))
        small = Triangles(points, normals, columns[:, 6:], corners.astype(np.uint32))
        return small, self._values[nearest]


def shown_color(model: mujoco.MjModel, geom: int, color: Array) -> Array:
    """Return the colour of a geom whose light is known, RGBA, without the colour of its picture."""
    material = int(model.geom_matid[geom])
    is_picture = material >= 0 and model.mat(material).name.startswith(PICTURES)
    return np.array([1.0, 1.0, 1.0, color[3]]) if is_picture else color


def _samples(surface: LitSurface, image: NDArray[np.float32]) -> tuple[Array, Array]:
    """Return places and light of a surface, shapes (n, 6) and (n, 3)."""
    from scipy.ndimage import map_coordinates

    columns, _ = divided(np.hstack([surface.points, surface.normals, surface.lightcoords]), surface.triangles, MAX_EDGE)
    height, width = image.shape[:2]
    at = (columns[:, :5:-1] * [height, width] - 0.5).T
    light = np.stack([map_coordinates(image[:, :, k], at, order=1, mode="nearest") for k in range(3)], axis=1)
    return _places(columns[:, :3], columns[:, 3:6]), np.asarray(light, dtype=float)


def _places(points: Array, normals: Array) -> Array:
    return np.hstack([points, TURN_DISTANCE / np.sqrt(2.0) * normals])
