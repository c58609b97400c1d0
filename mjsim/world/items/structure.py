"""What a room is made of: walls with openings and doors, the floor and the ceiling."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from mjsim.geometry import Array, Pose
from mjsim.world.ground import AssetPath, Color, Degrees, Distance, Length, Model, Name, Point, fault


class Door(Model):
    """A leaf that swings on a hinge and closes a doorway."""

    hinge: Literal["left", "right"] = "left"
    """Which end of the opening it hangs from, for one who looks along the wall's left side: left is where it begins."""
    angle_deg: Annotated[float, Field(ge=-170, le=170)] = 0.0
    """How far it stands open at the start; positive swings to the left side of the wall, 0 is closed."""
    limit_deg: Annotated[float, Field(gt=0, le=170)] = 110.0
    """How far it swings to either side."""
    locked: bool = False
    """Whether it stays where events put it, whoever pushes; else a robot can push it open."""
    spring: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Stiffness of a closer that swings it shut [N m/rad]; 0 for none."""
    mass: Annotated[float, Field(gt=0, le=1000)] = 20.0
    """[kg]"""
    color: Color = "#9c7a52"
    """'#rrggbb'."""

    @model_validator(mode="after")
    def _within_its_limit(self) -> Self:
        if abs(self.angle_deg) > self.limit_deg:
            raise fault(f"angle_deg is {self.angle_deg:g}; this door swings to {self.limit_deg:g} at most", "angle_deg")
        return self


class Opening(Model):
    """A doorway or a window in one segment of a wall."""

    segment: Annotated[int, Field(ge=0)] = 0
    """Which segment of the wall, counted from 0."""
    at: Distance
    """Where it begins, from the first corner of its segment [m]."""
    width: Length
    """[m]"""
    sill: Distance = 0.0
    """Height of its lower edge [m]; 0 for a door."""
    head: Length = 2.1
    """Height of its upper edge [m]."""
    name: Name | None = None
    """How events and plans call it."""
    door: Door | None = None
    """A leaf that swings in it; open unless there is one."""

    @model_validator(mode="after")
    def _head_above_sill(self) -> Self:
        if self.head <= self.sill:
            raise fault(f"head is {self.head} m; it must be above the sill at {self.sill} m", "head")
        return self


class Wall(Model):
    """A run of straight walls through its corners, joined there; an end within 2 cm of another wall is joined to it."""

    points: Annotated[tuple[Point, ...], Field(strict=False, min_length=2)]
    """Corners of the centreline, [x, y] each [m]."""
    name: Name | None = None
    """How errors and plans call it."""
    closed: bool = False
    """Whether a last segment joins the last corner to the first."""
    height: Length = 2.5
    """[m]"""
    thickness: Length = 0.1
    """[m]"""
    color: Color = "#e8e4da"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A picture that covers the wall instead of the colour."""
    tile: Length = 1.0
    """Size of one tile of the texture [m]."""
    openings: Annotated[tuple[Opening, ...], Field(strict=False)] = ()
    """Doorways and windows."""
    group: Name | None = None
    """Of the things that the studio selects, moves and turns as one; a run does not know it."""

    @model_validator(mode="after")
    def _corners_differ(self) -> Self:
        for index, (first, second) in enumerate(self.segments()):
            if first == second:
                corner = (index + 1) % len(self.points)
                raise fault(
                    f"points[{index}] and points[{corner}] are both [{first[0]:g}, {first[1]:g}]; make them differ",
                    "points",
                )
        for index, opening in enumerate(self.openings):
            if opening.segment >= len(self.segments()):
                message = f"segment is {opening.segment}; this wall has segments 0 to {len(self.segments()) - 1}"
                raise fault(message, "openings", index, "segment")
        return self

    def segments(self) -> list[tuple[Point, Point]]:
        """Return both ends of each segment; the closing one is the last."""
        ends = self.points[1:] + (self.points[:1] if self.closed else ())
        return list(zip(self.points, ends, strict=False))


class FloorPatch(Model):
    """A flat piece of another floor: a carpet, a wet place, a steel plate."""

    at: Point
    """Its middle, [x, y] [m]."""
    size: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[length, width] [m]."""
    name: Name | None = None
    """How errors and plans call it."""
    heading_deg: Degrees = 0.0
    """Where its length points, counter-clockwise from x."""
    friction: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Coefficient of friction of a rubber tyre on it."""
    color: Color = "#7d8a96"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A picture that covers it instead of the colour."""
    tile: Length = 1.0
    """Size of one tile of the texture [m]."""
    group: Name | None = None
    """Of the things that the studio selects, moves and turns as one; a run does not know it."""

    def outline(self) -> Array:
        """Return its corners, world frame, counter-clockwise, shape (4, 2) [m]."""
        corners = np.array(self.size) / 2 * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        return Pose(self.at[0], self.at[1], math.radians(self.heading_deg)).transform(corners)


class Floor(Model):
    """The level floor under everything."""

    texture: AssetPath | None = None
    """A picture that covers the floor instead of the colour."""
    tile: Length = 2.0
    """Size of one tile of the texture [m]."""
    color: Color = "#b8aa94"
    """'#rrggbb'."""
    friction: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Coefficient of friction of a rubber tyre on it."""
    patches: Annotated[tuple[FloorPatch, ...], Field(strict=False)] = ()
    """Carpets, puddles and plates with other friction; a later one lies on those before."""


class Ceiling(Model):
    """A level ceiling over all walls, seen from below."""

    height: Length | None = None
    """Above the floor [m]; that of the highest wall unless given."""
    color: Color = "#f4f2ec"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A picture that covers it instead of the colour."""
    tile: Length = 1.2
    """Size of one tile of the texture [m]."""
