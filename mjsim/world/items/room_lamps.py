"""The lamps of a room."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Color, Length, Model, Name, Point

Brightness = Annotated[float, Field(ge=0, le=10)]
"""Brightness relative to that which shows colours as written."""


class Lamp(Model):
    """A lamp: a point that shines in all directions; in baked light a level square of 0.2 m that shines downwards."""

    at: Point
    """[x, y] [m]."""
    name: Name | None = None
    """Name in events."""
    height: Length = 2.4
    """Height above the floor [m]."""
    color: Color = "#fff4e0"
    """'#rrggbb'."""
    brightness: Brightness = 1.0
    """Brightness 2 m below it, relative to that which shows colours as written; 0 is off."""
    range: Length = 10.0
    """Range [m]: a picture shows its light if surfaces within this range may be visible, and of many such lamps only
    the nearest."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""
