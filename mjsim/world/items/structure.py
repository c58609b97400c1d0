"""The structure of a room: walls with openings and doors, the floor and the ceiling."""

import math
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from mjsim.geometry import Array, Pose
from mjsim.sentences import Sentence
from mjsim.world.ground import AssetPath, Color, Degrees, Distance, Length, Model, Name, Point, fault


class Door(Model):
    """A hinged leaf that closes a doorway."""

    hinge: Literal["left", "right"] = "left"
    """End of the opening with the hinge; left is where the opening begins."""
    angle_deg: Annotated[float, Field(ge=-170, le=170)] = 0.0
    """Initial angle; positive opens to the left side of the wall, 0 is closed."""
    limit_deg: Annotated[float, Field(gt=0, le=170)] = 110.0
    """Maximum angle to either side."""
    locked: bool = False
    """Whether only events can move it; otherwise a robot can push it open."""
    spring: Annotated[float, Field(ge=0, le=1e3)] = 0.0
    """Stiffness of a door closer [N m/rad]; 0 for none."""
    mass: Annotated[float, Field(gt=0, le=1000)] = 20.0
    """[kg]"""
    color: Color = "#9c7a52"
    """'#rrggbb'."""

    @model_validator(mode="after")
    def _within_its_limit(self) -> Self:
        if abs(self.angle_deg) > self.limit_deg:
            raise fault(
                Sentence(
                    "angle_deg is {angle_deg:g}; this door swings to {limit_deg:g} at most",
                    self.angle_deg,
                    self.limit_deg,
                ),
                "angle_deg",
            )
        return self


class Opening(Model):
    """A doorway or a window in one segment of a wall."""

    segment: Annotated[int, Field(ge=0)] = 0
    """Index of the wall segment, starting at 0."""
    at: Distance
    """Start of the opening, measured from the first corner of its segment [m]."""
    width: Length
    """[m]"""
    sill: Distance = 0.0
    """Height of its lower edge [m]; 0 for a door."""
    head: Length = 2.1
    """Height of its upper edge [m]."""
    name: Name | None = None
    """Name in events and plans."""
    door: Door | None = None
    """A door in the opening; default: none."""

    @model_validator(mode="after")
    def _head_above_sill(self) -> Self:
        if self.head <= self.sill:
            raise fault(
                Sentence("head is {head} m; it must be above the sill at {sill} m", self.head, self.sill), "head"
            )
        return self


class Wall(Model):
    """Straight walls joined at their corners; an end within 2 cm of another wall is joined to it."""

    points: Annotated[tuple[Point, ...], Field(strict=False, min_length=2)]
    """Corners of the centreline, [x, y] each [m]."""
    name: Name | None = None
    """Name in errors and plans."""
    closed: bool = False
    """Whether a segment connects the last corner to the first."""
    height: Length = 2.5
    """[m]"""
    thickness: Length = 0.1
    """[m]"""
    color: Color = "#e8e4da"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A texture, multiplied by the colour unless that is the default."""
    tile: Length = 1.0
    """Size of one tile of the texture [m]."""
    openings: Annotated[tuple[Opening, ...], Field(strict=False)] = ()
    """Doorways and windows."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""

    @model_validator(mode="after")
    def _corners_differ(self) -> Self:
        for index, (first, second) in enumerate(self.segments()):
            if first == second:
                corner = (index + 1) % len(self.points)
                raise fault(
                    Sentence(
                        "points[{index}] and points[{corner}] are both [{x:g}, {y:g}]; make them differ",
                        *(index, corner, first[0], first[1]),
                    ),
                    "points",
                )
        for index, opening in enumerate(self.openings):
            if opening.segment >= len(self.segments()):
                message = Sentence(
                    "segment is {segment}; this wall has segments 0 to {last}",
                    opening.segment,
                    len(self.segments()) - 1,
                )
                raise fault(message, "openings", index, "segment")
        return self

    def segments(self) -> list[tuple[Point, Point]]:
        """Return both ends of each segment, the closing segment last."""
        ends = self.points[1:] + (self.points[:1] if self.closed else ())
        return list(zip(self.points, ends, strict=False))


class FloorPatch(Model):
    """A flat patch of floor with its own properties: a carpet, a wet area, a steel plate."""

    at: Point
    """Centre, [x, y] [m]."""
    size: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[length, width] [m]."""
    name: Name | None = None
    """Name in errors and plans."""
    heading_deg: Degrees = 0.0
    """Direction of its length, counter-clockwise from x."""
    friction: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Coefficient of friction of a rubber tyre on it."""
    color: Color = "#7d8a96"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A texture, multiplied by the colour unless that is the default."""
    tile: Length = 1.0
    """Size of one tile of the texture, the first at the left end of its rear edge [m]."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""

    def outline(self) -> Array:
        """Return its corners, world frame, counter-clockwise, shape (4, 2) [m]."""
        corners = np.array(self.size) / 2 * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
        return Pose(self.at[0], self.at[1], math.radians(self.heading_deg)).transform(corners)


class Floor(Model):
    """The level floor."""

    texture: AssetPath | None = None
    """A texture, multiplied by the colour unless that is the default."""
    tile: Length = 2.0
    """Size of one tile of the texture; tiles begin at the world's origin [m]."""
    color: Color = "#b8aa94"
    """'#rrggbb'."""
    friction: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Coefficient of friction of a rubber tyre on it."""
    patches: Annotated[tuple[FloorPatch, ...], Field(strict=False)] = ()
    """Patches with other friction; later ones cover earlier ones."""


class Ceiling(Model):
    """A level ceiling above all walls, seen from below."""

    height: Length | None = None
    """Height above the floor [m]; default: that of the highest wall."""
    color: Color = "#f4f2ec"
    """'#rrggbb'."""
    texture: AssetPath | None = None
    """A texture, multiplied by the colour unless that is the default."""
    tile: Length = 1.2
    """Size of one tile of the texture [m]."""
