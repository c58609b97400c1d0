"""Worlds in from what people have, and out to what others read.

In: maps of ROS map_server and Nav2, drawings in SVG and DXF, mazes, cluttered rooms, templates. Out: maps, SDF, plans
in SVG.
"""

from collections.abc import Sequence
from pathlib import Path

from mjsim.exchange.clutter import clutter_world
from mjsim.exchange.drawing import world_from_drawing
from mjsim.exchange.maps import explained, name_of, world_from_map
from mjsim.exchange.maze import maze_world
from mjsim.exchange.place import with_robot
from mjsim.exchange.raster import write_map
from mjsim.exchange.sdf import write_sdf
from mjsim.exchange.svg_out import write_svg
from mjsim.exchange.template import template_text
from mjsim.world.model import World

__all__ = [
    "clutter_world",
    "explained",
    "maze_world",
    "template_text",
    "with_robot",
    "world_from_dxf",
    "world_from_map",
    "world_from_svg",
    "write_map",
    "write_sdf",
    "write_svg",
]


def world_from_svg(
    path: str | Path, *, scale: float | None = None, thickness: float | None = None, layers: Sequence[str] = ()
) -> World:
    """Return the world of the walls that an SVG file shows as lines; its lower left corner becomes [0, 0].

    Args:
        path: The file.
        scale: Metres to one user unit; must be given unless mjsim wrote the file.
        thickness: Of the walls [m]; as wide as the lines are drawn unless given, 0.1 when these are hair lines.
        layers: Ids or Inkscape labels of the groups that hold walls; the group `walls` unless given, or all.

    Raises:
        UsageError: It cannot be read, or does not show the walls of a building.
    """
    from mjsim.exchange.svg_in import read_svg

    return world_from_drawing(read_svg(path, layers=layers), name=name_of(path), scale=scale, thickness=thickness)


def world_from_dxf(
    path: str | Path, *, scale: float | None = None, thickness: float | None = None, layers: Sequence[str] = ()
) -> World:
    """Return the world of the walls that a DXF file shows as lines; its lower left corner becomes [0, 0].

    Args:
        path: The file.
        scale: Metres to one unit of the drawing; must be given unless the file says it.
        thickness: Of the walls [m]; as wide as the lines are drawn unless given, 0.1 when these are hair lines.
        layers: That hold walls; a layer called walls or a-wall unless given, or all that are switched on.

    Raises:
        UsageError: It cannot be read, or does not show the walls of a building.
    """
    from mjsim.exchange.dxf_in import read_dxf

    return world_from_drawing(read_dxf(path, layers=layers), name=name_of(path), scale=scale, thickness=thickness)
