"""Outlines of figures' segments from above and from other directions, and vertical prisms that contain them."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.people.loft import Mesh

Column = tuple[Array, float, float]
"""Convex outline, counter-clockwise, shape (n, 2), and the heights of the lower and the upper face [m]."""


def columns(skins: Mapping[str, Sequence[Mesh]], poses: Mapping[str, Array]) -> dict[str, Column]:
    """Return vertical prisms that contain the segments of a figure, by name, lowest first.

    Args:
        skins: Surfaces of the segments, as returned by `surfaces`.
        poses: world_from_segment, as returned by `Figure.poses`.
    """
    found: dict[str, Column] = {}
    for name, meshes in skins.items():
        points = np.concatenate([_moved(mesh, poses[name]) for mesh in meshes])
        found[name] = _hull(points), float(points[:, 2].min()), float(points[:, 2].max())
    return dict(sorted(found.items(), key=lambda item: item[1][2]))


def silhouettes(
    skins: Mapping[str, Sequence[Mesh]], poses: Mapping[str, Array], drawing_from_world: Array
) -> Iterator[tuple[str, Array]]:
    """Yield the outlines of a figure in a drawing, farthest first: the segment, and the hull of one of its surfaces.

    Args:
        skins: Surfaces of the segments, as returned by `surfaces`.
        poses: world_from_segment, as returned by `Figure.poses`.
        drawing_from_world: Axes right, up, towards the viewer, shape (3, 4) [m].

    Yields:
        Name, and a convex outline in the drawing, counter-clockwise, shape (n, 2) [m].
    """
    seen = []
    for name, meshes in skins.items():
        for mesh in meshes:
            points = _moved(mesh, poses[name]) @ drawing_from_world[:, :3].T + drawing_from_world[:, 3]
            seen.append((float(points[:, 2].mean()), name, _hull(points)))
    # At equal depths, such as of head and neck from the side, the order of the segments is kept.
    for _, name, outline in sorted(seen, key=lambda each: round(each[0], 2)):
        yield name, outline


def _moved(mesh: Mesh, pose: Array) -> Array:
    """Return the vertices of a surface in the world frame, shape (n, 3) [m]."""
    return np.asarray(mesh.vertices @ pose[:3, :3].T + pose[:3, 3])


def _hull(points: Array) -> Array:
    """Return the convex outline of points, shape (n, 2 or 3), by their first two coordinates, counter-clockwise."""
    from scipy.spatial import ConvexHull

    return np.asarray(points[ConvexHull(points[:, :2]).vertices, :2])
