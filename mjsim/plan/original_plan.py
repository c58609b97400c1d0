"""A map or drawing in its original form, placed in the world that was made from it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A line of a drawing."""

    points: Array
    """Corners, world frame, shape (n, 2) [m]."""
    closed: bool = False
    """Whether its last corner is connected to the first."""
    path: int = 0
    """Number of the drawn shape; one shape may have several outlines."""
    dark: float | None = None
    """Darkness of its fill, 0 to 1; None if it is not filled."""


@dataclass(frozen=True, slots=True, eq=False)
class Original:
    """A map or a drawing, placed in the world."""

    name: str
    """Name of the file."""
    bounds: Array
    """Minimum and maximum of (x, y), shape (2, 2) [m]."""
    strokes: Sequence[Stroke] = ()
    """Lines of a drawing."""
    picture: NDArray[np.uint8] | None = None
    """Image of a map, RGB, shape (height, width, 3); the first row has the lowest y."""
    cell: float = 1.0
    """Side of a pixel of the image [m]."""
    world_from_picture: Pose = Pose(0.0, 0.0, 0.0)  # noqa: RUF009 - a frozen value
    """Pose of the image: outer corner of its first pixel, and direction of its rows [m, m, rad]."""
