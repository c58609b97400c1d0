"""What a room is made of: walls with openings, obstacles, beacons and the floor."""

from typing import Annotated, Self

from pydantic import Discriminator, Field, Tag, model_validator

from mjsim.world.base import AssetPath, Color, Degrees, Distance, Length, Model, Name, Point, fault


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

    @model_validator(mode="after")
    def _head_above_sill(self) -> Self:
        if self.head <= self.sill:
            raise fault(f"head is {self.head} m; it must be above the sill at {self.sill} m", "head")
        return self


class Wall(Model):
    """A run of straight walls through its corners; consecutive corners are joined."""

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


class _Obstacle(Model):
    at: Point
    """Its middle, [x, y] [m]."""
    name: Name | None = None
    """How errors and plans call it."""
    heading_deg: Degrees = 0.0
    """Where its length points, counter-clockwise from x."""
    color: Color = "#8a6f4d"
    """'#rrggbb'."""


class BoxObstacle(_Obstacle):
    """A box on the floor."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)]
    """Full sizes, [length, width, height] [m]."""


class CylinderObstacle(_Obstacle):
    """An upright cylinder on the floor."""

    cylinder: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[radius, height] [m]."""


def _kind_of_obstacle(item: object) -> str | None:
    if isinstance(item, dict):
        return next((f"<{kind}>" for kind in ("box", "cylinder") if kind in item), None)
    return "<box>" if isinstance(item, BoxObstacle) else "<cylinder>" if isinstance(item, CylinderObstacle) else None


Obstacle = Annotated[
    Annotated[BoxObstacle, Tag("<box>")] | Annotated[CylinderObstacle, Tag("<cylinder>")],
    Discriminator(
        _kind_of_obstacle,
        custom_error_type="kind",
        custom_error_message="an obstacle needs its shape; write box: [length, width, height]"
        " or cylinder: [radius, height]",
    ),
]


class Beacon(Model):
    """A thin plane with a picture on it; without a picture, a reflector."""

    name: Name
    """What sightings call it."""
    at: Point
    """Its middle, [x, y] [m]."""
    heading_deg: Degrees = 0.0
    """Where its picture faces."""
    image: AssetPath | None = None
    """The picture; its height follows from its shape."""
    width: Length = 0.6
    """Printed width [m]."""
    center: Distance = 1.2
    """Height of its middle above the floor [m]."""


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
