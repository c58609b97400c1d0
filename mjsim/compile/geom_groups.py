"""Shared by all parts of a robot: geom groups, colours, and purely visual geoms.

Geom groups: 0 is visible to cameras and rays (the body), 1 is purely visual, 2 is visible in views from outside only
(housings and masts of cameras, which would block the other cameras of the robot), 4 touches the floor and is invisible
to cameras and rays (wheels and casters), so that no sensor of a robot detects its own running gear.
"""

from collections.abc import Sequence

import mujoco

SEEN, DECOR, FITTINGS, RUNNING_GEAR = 0, 1, 2, 4
"""Geom groups."""
MATERIAL = "matte"
"""Material of everything on a robot; part of the scene."""
DARK, PALE = (0.13, 0.13, 0.14, 1.0), (0.97, 0.97, 0.94, 1.0)


def make_decor(geom: mujoco.MjsGeom, rgba: Sequence[float], *, group: int = DECOR) -> None:
    """Make a geom purely visual, without collisions and mass."""
    geom.group, geom.contype, geom.conaffinity, geom.mass = group, 0, 0, 0.0
    geom.material, geom.rgba = MATERIAL, rgba
