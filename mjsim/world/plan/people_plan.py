"""People from above and from the side."""

from collections.abc import Iterator, Mapping

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import Person


def person_outlines(
    person: Person, poses: Mapping[str, Array], drawing_from_world: Array
) -> Iterator[tuple[Array, str]]:
    """Yield outlines of a person in a posture, seen from a direction, farthest first, each with its colour.

    Args:
        person: The person.
        poses: world_from_segment by the segment's name, shape (4, 4) each [m]: `Person.poses()`, or for a seated person
            `mjsim.posture.poses_of`.
        drawing_from_world: Axes right, up, towards the viewer, shape (3, 4) [m]; see `look_beside`.

    Yields:
        Convex outline in the drawing, counter-clockwise, shape (n, 2) [m], and a colour, '#rrggbb'.
    """
    from mjsim.people import silhouettes

    for segment, outline in silhouettes(person.skins, poses, drawing_from_world):
        yield outline, person.color_of(segment)


def look_beside(poses: Mapping[str, Array]) -> Array:
    """Return the view of a person from the right, shape (3, 4) [m]: x is forward from the hips, y is up from the floor.

    Args:
        poses: world_from_segment, shape (4, 4) each [m].
    """
    ahead, left, at = _around(poses)
    return drawing_from_world(np.array([ahead, (0.0, 0.0, 1.0), -left]), at)


def look_over(poses: Mapping[str, Array]) -> Array:
    """Return the view of a person from above, shape (3, 4) [m]: x is forward from the hips, y is left.

    Args:
        poses: world_from_segment, shape (4, 4) each [m].
    """
    ahead, left, at = _around(poses)
    return drawing_from_world(np.array([ahead, left, (0.0, 0.0, 1.0)]), at)


def _around(poses: Mapping[str, Array]) -> tuple[Array, Array, Array]:
    """Return forward and left of the hips, horizontal unit vectors, and the hips' position on the floor [m]."""
    pelvis = poses["pelvis"]
    left = np.array([pelvis[0, 1], pelvis[1, 1], 0.0])
    left /= np.linalg.norm(left)
    return np.array([left[1], -left[0], 0.0]), left, np.array([pelvis[0, 3], pelvis[1, 3], 0.0])


def drawing_from_world(axes: Array, at: Array) -> Array:
    """Return the transform from world to drawing, shape (3, 4) [m].

    Args:
        axes: Axes of the drawing in the world frame, as rows: right, up, towards the viewer; shape (3, 3).
        at: Origin of the drawing, world frame, shape (3,) [m].
    """
    return np.column_stack([axes, -axes @ at])
