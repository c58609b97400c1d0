"""The lamps of a room."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Color, Length, Model, Name, Point

Brightness = Annotated[float, Field(ge=0, le=10)]
"""As a multiple of what shows colours as they are written."""


class Lamp(Model):
    """A lamp that shines to all sides."""

    at: Point
    """[x, y] [m]."""
    name: Name | None = None
    """How events call it."""
    height: Length = 2.4
    """Above the floor [m]."""
    color: Color = "#fff4e0"
    """'#rrggbb'."""
    brightness: Brightness = 1.0
    """Right below it at 2 m, as a multiple of what shows colours as they are written; 0 is off."""
    range: Length = 10.0
    """How far it is of use [m]: a picture shows its light when what is nearer than this to it may be seen, and of
    many such lamps that of the nearest."""
    group: Name | None = None
    """Of the things that the studio selects, moves and turns as one; a run does not know it."""
