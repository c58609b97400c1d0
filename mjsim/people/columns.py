"""Figures from above: the upright prisms that hold their segments."""

from collections.abc import Mapping, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.people.loft import Mesh

Column = tuple[Array, float, float]
"""Convex outline, counter-clockwise, shape (n, 2), and the heights of the lower and the upper face [m]."""


def columns(skins: Mapping[str, Sequence[Mesh]], poses: Mapping[str, Array]) -> dict[str, Column]:
    """Return upright prisms that hold the segments of a figure by their names, the lowest first.

    Args:
        skins: Surfaces of the segments, as `surfaces` returns them.
        poses: World from segment, as `Figure.poses` returns them.
    """
    from scipy.spatial import ConvexHull

    found: dict[str, Column] = {}
    for name, meshes in skins.items():
        pose = poses[name]
        points = np.concatenate([mesh.vertices for mesh in meshes]) @ pose[:3, :3].T + pose[:3, 3]
        outline = points[ConvexHull(points[:, :2]).vertices, :2]
        found[name] = outline, float(points[:, 2].min()), float(points[:, 2].max())
    return dict(sorted(found.items(), key=lambda item: item[1][2]))
