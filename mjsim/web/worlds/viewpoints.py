"""Views of mechanisms and people on the page: from above as on the plan, from their right, from the front."""

import math
from typing import Literal

import numpy as np

from mjsim.geometry import Array
from mjsim.world import drawing_from_world

Look = Literal["above", "side", "front"]
KeyChange = tuple[tuple[str | int, ...], float | list[float]]
"""A key of a mechanism or a person by its relative path, and its new value [m, deg]."""
ABOVE = np.eye(4)[:3]


def look_at(look: Look, at: tuple[float, float], heading: float) -> Array:
    """Return drawing_from_world: right, up, towards the viewer, shape (3, 4) [m].

    Args:
        look: View from above in the world frame, or upright with the origin of the drawing on the floor below the item.
        at: Position of the item, world frame [m].
        heading: Direction that it faces, counter-clockwise from x [rad]: to the right in the side view, towards the
            viewer in the front view.
    """
    if look == "above":
        return ABOVE
    c, s = math.cos(heading), math.sin(heading)
    ahead, left, up = (c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)
    turned = np.array([ahead, up, (s, -c, 0.0)] if look == "side" else [left, up, ahead])
    return drawing_from_world(turned, np.array([*at, 0.0]))
