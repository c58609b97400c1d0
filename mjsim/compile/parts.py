"""Shared by all parts of a robot: geom groups, colours, and purely visual geoms.

Geom groups: 0 is what cameras see and rays hit (the body), 1 is for the eye alone, 2 is for views from outside alone
(housings and masts of cameras, which would stand before the other cameras of the robot), 4 touches the floor and is
neither seen nor hit by rays (wheels and casters), so that no sensor of a robot meets its own running gear.
"""

from collections.abc import Sequence

import mujoco

SEEN, DECOR, FITTINGS, RUNNING_GEAR = 0, 1, 2, 4
"""Geom groups."""
MATERIAL = "matte"
"""Of everything on a robot; the scene brings it."""
DARK, PALE = (0.13, 0.13, 0.14, 1.0), (0.97, 0.97, 0.94, 1.0)


def make_decor(geom: mujoco.MjsGeom, rgba: Sequence[float], *, group: int = DECOR) -> None:
    """Make a geom purely visual, without collisions and mass."""
    geom.group, geom.contype, geom.conaffinity, geom.mass = group, 0, 0, 0.0
    geom.material, geom.rgba = MATERIAL, rgba
