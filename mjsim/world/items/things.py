"""Objects in a room: obstacles of all kinds, and beacons."""

import math
from typing import TYPE_CHECKING, Annotated, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import (
    PLAIN_PATTERN,
    AssetPath,
    Color,
    Degrees,
    Distance,
    Length,
    Model,
    Name,
    OneOf,
    Point,
    fault,
)
from mjsim.world.items.markers import check_marker
from mjsim.world.items.model_files import FromFile
from mjsim.world.items.targets import Seat, Targets, check_names

if TYPE_CHECKING:  # Imported again where it is used, so that worlds that do not need it load faster.
    from mjsim.geometry import Array


class ScriptedPath(Model):
    """Scripted motion of an object; nothing can stop it."""

    points: Annotated[tuple[Point, ...], Field(strict=False, min_length=1, max_length=10_000)]
    """Waypoints of its centre after `at`, [x, y] each [m]."""
    speed: Annotated[float, Field(gt=0, le=10)] = 0.5
    """[m/s]"""
    closed: bool = False
    """Whether it continues from the last point to `at` and repeats; otherwise it returns the same way."""
    wait: Annotated[float, Field(ge=0, le=1e6)] = 0.0
    """Pause at each point [s]."""


Mass = Annotated[float, Field(ge=1e-3, le=1e5)]
"""Mass of a movable thing [kg]."""
MIN_SIZE = 1e-3
"""Minimum size of a movable object [m]: the physics cannot handle smaller ones."""


class _Obstacle(Model):
    at: Point
    """Centre, [x, y] [m]."""
    name: Name | None = None
    """Name in errors, events and plans."""
    heading_deg: Degrees = 0.0
    """Direction of its length, counter-clockwise from x."""
    elevation: Distance = 0.0
    """Height of its underside above the floor [m]."""
    color: Color = "#8a6f4d"
    """'#rrggbb'."""
    movable: bool = False
    """Whether a robot can push it."""
    mass: Mass = 5.0
    """Mass of a movable object [kg]."""
    friction: Annotated[float, Field(ge=0, le=10)] = 0.5
    """Coefficient of friction of a movable object on the floor."""
    path: ScriptedPath | None = None
    """Scripted motion; default: none."""
    seat: Seat | None = None
    """Seat for a person; default: none."""
    targets: Targets = ()
    """Targets for hands, feet and eyes of people."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""

    @property
    def origin_height(self) -> float:
        """Height of the origin of its frame above the floor [m]."""
        return self.elevation

    def world_from_thing(self) -> "Array":
        """Return its pose at the start: origin at the centre of the underside, x along its heading, shape (4, 4)."""
        from mjsim.mechanics import placed

        return placed((*self.at, self.origin_height), (0.0, 0.0, math.radians(self.heading_deg)))

    @model_validator(mode="after")
    def _own_names(self) -> Self:
        check_names(self.targets)
        return self

    @model_validator(mode="after")
    def _pushed_or_scripted(self) -> Self:
        if self.path is not None and self.movable:
            raise fault("an object with a path cannot be pushed; leave out 'movable' or 'path'", "movable")
        if not self.movable:
            for key in ("mass", "friction"):
                if key in self.model_fields_set and getattr(self, key) != type(self).model_fields[key].default:
                    raise fault(
                        Sentence("{key} applies only to movable objects; add 'movable: true' or leave it out", key), key
                    )
        return self

    @model_validator(mode="after")
    def _no_dust(self) -> Self:
        for kind in KINDS:
            sizes = getattr(self, kind, None) if self.movable else None
            for size in sizes if isinstance(sizes, tuple) else (sizes,):
                if isinstance(size, float) and size < MIN_SIZE:
                    raise fault(
                        Sentence(
                            "a size is {size:g} m; a movable object is at least {min_size:g} m large", size, MIN_SIZE
                        ),
                        kind,
                    )
        return self


class _Covered(_Obstacle):
    texture: AssetPath | None = None
    """A texture on all sides, multiplied by the colour unless that is the default."""
    tile: Length = 1.0
    """Size of one tile of the texture [m]."""


def _sizes(count: int) -> object:
    return Field(strict=False, min_length=count, max_length=count)


class BoxObstacle(_Covered):
    """A box."""

    box: Annotated[tuple[Length, ...], _sizes(3)]
    """Full size, [length, width, height] [m]."""


class CylinderObstacle(_Covered):
    """A vertical cylinder."""

    cylinder: Annotated[tuple[Length, ...], _sizes(2)]
    """[radius, height] [m]."""


class SphereObstacle(_Obstacle):
    """A sphere."""

    sphere: Length
    """Its radius [m]."""


class _Fixed(_Covered):
    @model_validator(mode="after")
    def _stands_still(self) -> Self:
        for key in ("movable", "path"):
            if getattr(self, key):
                raise fault(Sentence("ramps and steps cannot move; leave out '{key}'", key), key)
        return self


class RampObstacle(_Fixed):
    """A ramp that starts at the floor and rises along its heading."""

    ramp: Annotated[tuple[Length, ...], _sizes(3)]
    """[length, width, rise] [m]."""


class StepsObstacle(_Fixed):
    """Steps of equal height and depth that rise along their heading."""

    steps: Annotated[tuple[Length, ...], _sizes(3)]
    """Total [length, width, rise] of all steps [m]."""
    count: Annotated[int, Field(ge=1, le=1000)] = 3
    """Number of steps."""


class ModelObstacle(FromFile, _Obstacle):
    """An object from an MJCF, URDF, xacro or SDF file; its origin is at `at`, its lowest point at `elevation`."""

    # Other things have a default mass.
    mass: Mass | None = None  # type: ignore[assignment]
    """Mass of a movable object [kg]; default: that of the file."""

    @property
    def origin_height(self) -> float:
        """Height of the origin of its file above the floor [m]."""
        return self.elevation - self.shape.low * self.scale


KINDS: dict[str, type[_Obstacle]] = {
    "box": BoxObstacle,
    "cylinder": CylinderObstacle,
    "sphere": SphereObstacle,
    "ramp": RampObstacle,
    "steps": StepsObstacle,
    "model": ModelObstacle,
}
"""Obstacle models by the key of their shape."""


Obstacle = Annotated[
    BoxObstacle | CylinderObstacle | SphereObstacle | RampObstacle | StepsObstacle | ModelObstacle,
    OneOf(
        KINDS,
        "an obstacle needs its shape; write box: [length, width, height], cylinder: [radius, height], sphere: radius,"
        " ramp or steps: [length, width, rise], or model: FILE",
    ),
]


class Marker(Model):
    """A square fiducial marker: ArUco or AprilTag."""

    dictionary: Annotated[str, Field(pattern=PLAIN_PATTERN, max_length=40)] = "4x4_50"
    """Dictionary, named as in OpenCV: '4x4_50' to '7x7_1000', 'original', 'apriltag_16h5' to 'apriltag_36h11'."""
    id: Annotated[int, Field(ge=0, le=100_000)]
    """Number in the dictionary."""

    @model_validator(mode="after")
    def _has_shape(self) -> Self:
        wrong = check_marker(self.dictionary, self.id)
        if wrong is not None:
            raise fault(*wrong)
        return self


class Beacon(Model):
    """A thin plane with a picture or a marker, or a radio anchor; with none of these, a reflector."""

    name: Name
    """Name in sightings."""
    at: Point
    """Centre, [x, y] [m]; with `on`, in the frame of its carrier."""
    heading_deg: Degrees = 0.0
    """Direction that it faces."""
    tilt_deg: Annotated[float, Field(ge=-90, le=90)] = 0.0
    """Upward tilt from the horizontal."""
    image: AssetPath | None = None
    """The picture; its height follows from its aspect ratio."""
    marker: Marker | None = None
    """Marker in place of a picture."""
    width: Length = 0.6
    """Printed width [m]; for a marker, width of its black square."""
    center: Distance = 1.2
    """Height of its centre above the floor [m], or above the underside of its carrier."""
    on: Name | None = None
    """The obstacle or robot that carries it; default: fixed in the room."""

    anchor: bool = False
    """Whether it has a radio anchor; an anchor without a picture or marker is not a reflector."""
    group: Name | None = None
    """Group that the studio selects, moves and rotates together; no effect on runs."""

    @property
    def has_face(self) -> bool:
        """Whether it has a picture or a marker, visible from the front."""
        return self.image is not None or self.marker is not None

    @property
    def reflects(self) -> bool:
        """Whether beacon sensors see it from all sides."""
        return not self.has_face and not self.anchor

    @model_validator(mode="after")
    def _one_face(self) -> Self:
        if self.image is not None and self.marker is not None:
            raise fault("a beacon shows a picture or a marker; leave out 'image' or 'marker'", "marker")
        return self
