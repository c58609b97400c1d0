"""Bodies as a world file describes them: the shapes that bump."""

from typing import Annotated

from pydantic import Field

from mjsim.world.base import Color, Length, Model


class Body(Model):
    """The shape that bumps: an upright cylinder around the robot's origin."""

    radius: Length = 0.22
    """[m]"""
    height: Length = 0.25
    """[m]"""
    mass: Annotated[float, Field(gt=0, le=10000)] = 9.0
    """[kg]"""
    color: Color = "#c8202a"
    """'#rrggbb'."""
