"""Bodies as described in a world file: collision shapes and appearance."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, Field, PrivateAttr, ValidationInfo, model_validator

from mjsim.errors import did_you_mean
from mjsim.geometry import Array
from mjsim.sentences import Sentence
from mjsim.world.files import BUILT, Source, read_asset
from mjsim.world.ground import Color, Degrees, Length, Metres, Model, ModelPath, OneOf, Point, Point3, fault, kind_of
from mjsim.world.items.model_files import shape_in

if TYPE_CHECKING:  # Imported again where it is used, so that worlds that do not need it load faster.
    from mjsim.models import ModelFiles, ModelShape

CIRCLE_SIDES = 32
"""Number of corners of a cylinder's outline."""
Mass = Annotated[float, Field(gt=0, le=10000)]
"""[kg]"""
JointName = Annotated[str, Field(min_length=1, max_length=200)]
"""Name of a joint in a file."""
Caster = Annotated[tuple[Metres, ...], Field(strict=False, min_length=3, max_length=3)]
"""[x, y, radius] [m]."""


class Part(Model):
    """A box, a cylinder or a sphere, only for appearance."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)] | None = None
    """[length, width, height] [m]."""
    cylinder: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)] | None = None
    """[radius, height] [m], vertical unless rotated."""
    sphere: Length | None = None
    """Its radius [m]."""
    at: Point3 = (0.0, 0.0, 0.0)
    """Centre [x, y, z] in the robot frame [m]."""
    yaw_deg: Degrees = 0.0
    """Yaw to the left."""
    pitch_deg: Degrees = 0.0
    """Pitch of its own x axis, positive up."""
    roll_deg: Degrees = 0.0
    """Roll about its own x axis; with 90 a cylinder lies across."""
    color: Color = "#3a3c40"
    """'#rrggbb'."""

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        if sum(shape is not None for shape in (self.box, self.cylinder, self.sphere)) != 1:
            raise fault(
                "a part has one shape; write box: [length, width, height], cylinder: [radius, height] or sphere"
            )
        return self


class _Body(Model):
    """Base class of bodies."""

    mass: Mass = 9.0
    """Mass of the whole robot [kg]."""
    color: Color = "#c8202a"
    """'#rrggbb'."""
    look: Annotated[tuple[Part, ...], Field(strict=False, max_length=200)] = ()
    """Visible parts instead of the collision shape, which does not change."""


class CylinderBody(_Body):
    """Collision shape: a vertical cylinder around the robot's origin."""

    radius: Length = 0.22
    """[m]"""
    height: Length = 0.25
    """[m]"""

    def outline(self) -> Array:
        """Return the outline seen from above, robot frame, counter-clockwise, shape (n, 2) [m]."""
        angles = np.arange(CIRCLE_SIDES) * (2 * np.pi / CIRCLE_SIDES)
        return self.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


class BoxBody(_Body):
    """Collision shape: an upright box."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)]
    """[length, width, height] [m]; the height is that of the top above the floor."""
    at: Point = (0.0, 0.0)
    """Centre [x, y] in the robot frame [m]."""
    center: Annotated[float, Field(gt=0, le=10)] | None = None
    """Only for a balancing base, whose `box` and `mass` are then those of the body without the wheels: height of the
    centre above the axle [m]."""
    _axle: float = PrivateAttr(default=0.0)
    _wheels: tuple[float, float] = PrivateAttr(default=(0.0, 0.0))

    @property
    def middle(self) -> float | None:
        """Height of its centre above the floor [m]; None for the usual ground clearance."""
        return None if self.center is None else self._axle + self.center

    @property
    def height(self) -> float:
        """Height of its top above the floor [m]."""
        return self.box[2] if self.middle is None else self.middle + self.box[2] / 2

    def stand_on(self, axle: float, wheels: tuple[float, float]) -> None:
        """Set the wheels that carry it, for a balancing base.

        Args:
            axle: Height of the axle above the floor, from which `center` is measured [m].
            wheels: Their extent forwards and to the side [m]; they are part of the outline.
        """
        self._axle, self._wheels = axle, wheels

    @property
    def radius(self) -> float:
        """Radius of the circumscribed circle about the robot's origin [m]."""
        return float(np.hypot(*self.outline().T).max())

    def outline(self) -> Array:
        """Return the outline seen from above, robot frame, counter-clockwise, shape (4, 2) [m]."""
        half = np.maximum(np.array(self.box[:2]) / 2, self._wheels)
        return np.asarray(self.at + half * [[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)

    @model_validator(mode="after")
    def _around_the_origin(self) -> Self:
        _check_origin(self, "at")
        if self.center is not None and self.at != (0.0, 0.0):
            raise fault("a balancing body is centred above the axle; leave out 'at'", "at")
        return self


class PolygonBody(_Body):
    """Collision shape: an upright prism on any simple polygon."""

    polygon: Annotated[
        tuple[Annotated[tuple[Metres, ...], Field(strict=False, min_length=2, max_length=2)], ...],
        Field(strict=False, min_length=3, max_length=64),
    ]
    """Corners, [x, y] each, in the robot frame [m]."""
    height: Length = 0.25
    """[m]"""

    @property
    def radius(self) -> float:
        """Radius of the circumscribed circle about the robot's origin [m]."""
        return float(np.hypot(*self.outline().T).max())

    def outline(self) -> Array:
        """Return the outline seen from above, robot frame, counter-clockwise, shape (n, 2) [m]."""
        corners = np.array(self.polygon, dtype=float)
        return corners if _area(corners) > 0 else corners[::-1]

    @model_validator(mode="after")
    def _simple(self) -> Self:
        from shapely import Polygon

        if not Polygon(self.polygon).is_valid or abs(_area(np.array(self.polygon))) < 1e-6:
            raise fault("the polygon's sides cross, or it has no area; give its corners in order", "polygon")
        _check_origin(self, "polygon")
        return self


class ModelWheel(Model):
    """A wheel of a robot that is read from a file."""

    joint: JointName
    """The hinge in the file; two wheels on one axle share it."""
    y: Metres | None = None
    """y of its centre, robot frame [m]; default: that of its shapes."""
    radius: Length
    """Rolling radius [m]."""
    width: Length
    """[m]"""
    follow: Annotated[tuple[JointName, ...], Field(strict=False, max_length=8)] = ()
    """Hinges of wheels coupled to it by a chain or belt."""


class ModelBody(_Body):
    """A robot from an MJCF or URDF file, with the joints of its wheels; written by `mjsim new --robot-from`.

    With a user-defined drive, it is the body `base` of an MJCF file, and each wheel is a hinge with a velocity servo of
    the same name.
    """

    model: ModelPath
    """The file; files that it names must be beside it or below the world file."""
    radius: Length = 0.3
    """Radius of the circle around the robot [m]."""
    height: Length = 0.3
    """[m]"""
    # Other bodies have a default mass.
    mass: Mass | None = None  # type: ignore[assignment]
    """Mass of the whole robot [kg]; default: that of the file."""
    origin: Point3 = (0.0, 0.0, 0.0)
    """Origin of the robot frame, on the floor, in the frame of the file [m]; not for user-defined drives."""
    forward_deg: Degrees = 0.0
    """Forward direction in the frame of the file, counter-clockwise from x."""
    wheels: Annotated[Mapping[str, ModelWheel], Field(strict=False, max_length=8)] = {}
    """Wheels by their names in the drive: left and right, or front_left, front_right, and so on."""
    steering: Annotated[Mapping[str, JointName], Field(strict=False, max_length=4)] = {}
    """Steering hinges by their names in the drive."""
    casters: Annotated[tuple[Caster, ...], Field(strict=False, max_length=16)] = ()
    """Casters that slide on the floor, [x, y, radius], robot frame [m]."""
    _source: Source = PrivateAttr(default=BUILT)

    @property
    def ready(self) -> bool:
        """Whether it names the joints of its wheels; otherwise the user's drive knows them."""
        return bool(self.wheels)

    def outline(self) -> Array:
        """Return the circle around the robot, robot frame, counter-clockwise, shape (n, 2) [m]."""
        return CylinderBody(radius=self.radius).outline()

    @cached_property
    def shape(self) -> "ModelShape":
        """Content of the file, in its own frame; ValueError if it cannot be read."""
        from mjsim.models import read_model

        return read_model(self.model, self._read)

    @cached_property
    def files(self) -> "ModelFiles":
        """All parts of the file; ValueError if it cannot be read."""
        from mjsim.models import ROBOT, gather_model

        return self.shape.files if self.ready else gather_model(self.model, self._read, sections=ROBOT)

    def _read(self, path: str) -> bytes:
        return read_asset(path, self._source)

    @model_validator(mode="after")
    def _can_be_read(self, info: ValidationInfo) -> Self:
        context = info.context or {}
        source = context.get("source")
        if isinstance(source, Source):
            self._source = source
            if self.ready:
                vars(self)["shape"] = shape_in(context, self.model, self._read)
                self._check_joints()
        return self

    def _check_joints(self) -> None:
        """Refuse joints that are not in the file."""
        for path, joint in self._joints():
            if joint not in self.shape.hinges:
                raise fault(
                    Sentence(
                        "no hinge '{joint}' in '{model}'{meant}",
                        *(joint, self.model, did_you_mean(joint, self.shape.hinges)),
                    ),
                    *path,
                )

    def _joints(self) -> Iterator[tuple[tuple[str | int, ...], str]]:
        """Yield each joint that the keys name, with its path."""
        for name, wheel in self.wheels.items():
            yield ("wheels", name, "joint"), wheel.joint
            yield from ((("wheels", name, "follow", number), other) for number, other in enumerate(wheel.follow))
        yield from ((("steering", name), joint) for name, joint in self.steering.items())


class NoBody(_Body):
    """No body, the default of a fixed base: nothing collides with it."""

    shape: Literal["none"]
    """Kind of body; may be omitted."""

    @property
    def radius(self) -> float:
        """Radius of its symbol in plans [m]."""
        return 0.05

    @property
    def height(self) -> float:
        """Height of its symbol in plans [m]."""
        return 0.05

    def outline(self) -> Array:
        """Return a small circle, robot frame, counter-clockwise, shape (n, 2) [m]."""
        return CylinderBody(radius=self.radius).outline()


def _area(corners: Array) -> float:
    """Return the signed area of a polygon, negative if its corners run clockwise [m^2]."""
    x, y = corners.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def _check_origin(body: "BoxBody | PolygonBody", key: str) -> None:
    from shapely import Point as Spot
    from shapely import Polygon

    if not Polygon(body.outline()).covers(Spot(0.0, 0.0)):
        raise fault("the robot's origin [0, 0] is outside the body; let the body lie around it", key)


SHAPES: dict[str, tuple[str, ...]] = {
    "box": ("box", "at", "center"),
    "polygon": ("polygon", "height"),
    "model": ("model", "radius", "height", "origin", "forward_deg", "wheels", "steering", "casters"),
    "cylinder": ("radius", "height"),
}
"""Keys that belong to a shape."""


def shape_of(keys: Any) -> str:
    """Return the kind of shape that the keys of a body describe."""
    return next((shape for shape in ("box", "polygon", "model") if shape in keys), "cylinder")


PROXIMITY_HEIGHT = 0.6
"""Height of the ring of proximity rays, as a fraction of the body's height."""


def rims(body: "Body", bearings: Array) -> Array:
    """Return the distance from the origin to the outermost rim along bearings [rad], same shape [m]."""
    if isinstance(body, CylinderBody | ModelBody | NoBody):
        return np.full(np.shape(bearings), body.radius)
    start = body.outline()
    edge = np.roll(start, -1, axis=0) - start
    ahead = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[..., None, :]
    # start + s edge = t ahead, solved by cross products; a ray along an edge meets the corner, which adjacent edges
    # share.
    across = ahead[..., 0] * edge[:, 1] - ahead[..., 1] * edge[:, 0]
    safe = np.where(across == 0.0, np.inf, across)
    t = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / safe
    s = (start[:, 0] * ahead[..., 1] - start[:, 1] * ahead[..., 0]) / safe
    hit = (across != 0.0) & (s >= -1e-9) & (s <= 1 + 1e-9) & (t >= 0.0)
    return np.asarray(np.where(hit, t, 0.0).max(axis=-1), dtype=float)


BODY_KINDS: Mapping[str, type[_Body]] = {
    "cylinder": CylinderBody,
    "box": BoxBody,
    "polygon": PolygonBody,
    "model": ModelBody,
    "none": NoBody,
}
"""Bodies by the key of their shape; a cylinder has no such key."""


def _kind_of_body(item: Any, kinds: Mapping[str, type[BaseModel]]) -> str | None:
    if isinstance(item, dict):
        return "none" if "shape" in item else shape_of(item)
    return kind_of(item, kinds)


Body = Annotated[
    CylinderBody | BoxBody | PolygonBody | ModelBody | NoBody,
    OneOf(
        BODY_KINDS,
        "a body has a shape: radius and height, box: [length, width, height], polygon: [[x, y], ...] with height, or"
        " model: FILE",
        _kind_of_body,
    ),
]
