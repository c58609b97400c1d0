"""Bodies as a world file describes them: the shapes that bump, and how they look."""

from typing import Annotated, Any, Self

import numpy as np
from pydantic import Discriminator, Field, PrivateAttr, Tag, ValidationInfo, model_validator

from mjsim.geometry import Array
from mjsim.world.base import Color, Degrees, Length, Metres, Model, ModelPath, Point, Point3, fault
from mjsim.world.source import BUILT, Source, read_asset

CIRCLE_SIDES = 32
"""Of the outline of a cylinder."""
Mass = Annotated[float, Field(gt=0, le=10000)]
"""[kg]"""


class Part(Model):
    """A box, a cylinder or a ball that is seen and does nothing else; it makes a robot look like what it is."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)] | None = None
    """[length, width, height] [m]."""
    cylinder: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)] | None = None
    """[radius, height] [m], upright unless turned."""
    sphere: Length | None = None
    """Its radius [m]."""
    at: Point3 = (0.0, 0.0, 0.0)
    """[x, y, z] of its middle in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """To the left."""
    pitch_deg: Degrees = 0.0
    """Up, of its own x axis."""
    roll_deg: Degrees = 0.0
    """About its own x axis; 90 lays a cylinder across."""
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
    """What all bodies have."""

    mass: Mass = 9.0
    """Of the whole robot [kg]."""
    color: Color = "#c8202a"
    """'#rrggbb'."""
    look: Annotated[tuple[Part, ...], Field(strict=False, max_length=200)] = ()
    """Parts that are seen in place of the plain shape, which bumps as before."""


class CylinderBody(_Body):
    """The shape that bumps: an upright cylinder around the robot's origin."""

    radius: Length = 0.22
    """[m]"""
    height: Length = 0.25
    """[m]"""

    def outline(self) -> Array:
        """Return the shape from above, robot frame, counter-clockwise, shape (n, 2) [m]."""
        angles = np.arange(CIRCLE_SIDES) * (2 * np.pi / CIRCLE_SIDES)
        return self.radius * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


class BoxBody(_Body):
    """The shape that bumps: an upright box."""

    box: Annotated[tuple[Length, ...], Field(strict=False, min_length=3, max_length=3)]
    """[length, width, height] [m]; the height is that of its top above the floor."""
    at: Point = (0.0, 0.0)
    """[x, y] of its middle in the robot's frame [m]."""

    @property
    def height(self) -> float:
        """Of its top above the floor [m]."""
        return self.box[2]

    @property
    def radius(self) -> float:
        """Of the circle around the body, about the robot's origin [m]."""
        return float(np.hypot(*self.outline().T).max())

    def outline(self) -> Array:
        """Return the shape from above, robot frame, counter-clockwise, shape (4, 2) [m]."""
        half = np.array(self.box[:2]) / 2
        return np.asarray(self.at + half * [[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)

    @model_validator(mode="after")
    def _around_the_origin(self) -> Self:
        _check_origin(self, "at")
        return self


class PolygonBody(_Body):
    """The shape that bumps: an upright prism on any polygon without crossings."""

    polygon: Annotated[
        tuple[Annotated[tuple[Metres, ...], Field(strict=False, min_length=2, max_length=2)], ...],
        Field(strict=False, min_length=3, max_length=64),
    ]
    """Corners [x, y] each, in the robot's frame [m]."""
    height: Length = 0.25
    """[m]"""

    @property
    def radius(self) -> float:
        """Of the circle around the body, about the robot's origin [m]."""
        return float(np.hypot(*self.outline().T).max())

    def outline(self) -> Array:
        """Return the shape from above, robot frame, counter-clockwise, shape (n, 2) [m]."""
        corners = np.array(self.polygon, dtype=float)
        return corners if _area(corners) > 0 else corners[::-1]

    @model_validator(mode="after")
    def _simple(self) -> Self:
        from shapely import Polygon

        if not Polygon(self.polygon).is_valid or abs(_area(np.array(self.polygon))) < 1e-6:
            raise fault("the polygon's sides cross, or it has no area; give its corners in turn", "polygon")
        _check_origin(self, "polygon")
        return self


class ModelBody(_Body):
    """A robot from a file of MJCF: its body `base`, with the wheels of a drive of the user's own.

    Each wheel is a hinge with a velocity servo of the same name. The file has shapes of MuJoCo's own, no meshes, and
    its masses count.
    """

    model: ModelPath
    """The file; the origin of `base` is on the floor, and its geoms are what bumps."""
    radius: Length = 0.3
    """Of the circle around the robot [m]."""
    height: Length = 0.3
    """[m]"""
    _source: Source = PrivateAttr(default=BUILT)

    def outline(self) -> Array:
        """Return the circle around the robot, robot frame, counter-clockwise, shape (n, 2) [m]."""
        return CylinderBody(radius=self.radius).outline()

    def text(self) -> str:
        """Return what the file holds."""
        return read_asset(self.model, self._source).decode("utf-8", errors="replace")

    @model_validator(mode="after")
    def _keep_source(self, info: ValidationInfo) -> Self:
        source = (info.context or {}).get("source")
        if isinstance(source, Source):
            self._source = source
        return self


def _area(corners: Array) -> float:
    """Return the area inside corners, negative when they go clockwise [m^2]."""
    x, y = corners.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def _check_origin(body: "BoxBody | PolygonBody", key: str) -> None:
    from shapely import Point as Spot
    from shapely import Polygon

    if not Polygon(body.outline()).covers(Spot(0.0, 0.0)):
        raise fault("the robot's origin [0, 0] is outside the body; let the body lie around it", key)


SHAPES: dict[str, tuple[str, ...]] = {
    "box": ("box", "at"),
    "polygon": ("polygon", "height"),
    "model": ("model", "radius", "height"),
    "cylinder": ("radius", "height"),
}
"""Keys that belong to a shape."""


def shape_of(keys: Any) -> str:
    """Return which shape the keys of a body describe."""
    return next((shape for shape in ("box", "polygon", "model") if shape in keys), "cylinder")


def rims(body: "Body", bearings: Array) -> Array:
    """Return how far the outermost rim of a body is from its origin along bearings [rad], same shape [m]."""
    if isinstance(body, CylinderBody | ModelBody):
        return np.full(np.shape(bearings), body.radius)
    start = body.outline()
    edge = np.roll(start, -1, axis=0) - start
    ahead = np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)[..., None, :]
    # start + s edge = t ahead, solved by cross products; an edge along the ray ends at corners that others have too.
    across = ahead[..., 0] * edge[:, 1] - ahead[..., 1] * edge[:, 0]
    safe = np.where(across == 0.0, np.inf, across)
    t = (start[:, 0] * edge[:, 1] - start[:, 1] * edge[:, 0]) / safe
    s = (start[:, 0] * ahead[..., 1] - start[:, 1] * ahead[..., 0]) / safe
    met = (across != 0.0) & (s >= -1e-9) & (s <= 1 + 1e-9) & (t >= 0.0)
    return np.asarray(np.where(met, t, 0.0).max(axis=-1), dtype=float)


def _kind_of_body(item: Any) -> str | None:
    if isinstance(item, dict):
        return f"<{shape_of(item)}>"
    kinds = {BoxBody: "<box>", PolygonBody: "<polygon>", ModelBody: "<model>", CylinderBody: "<cylinder>"}
    return next((tag for kind, tag in kinds.items() if isinstance(item, kind)), None)


Body = Annotated[
    Annotated[CylinderBody, Tag("<cylinder>")]
    | Annotated[BoxBody, Tag("<box>")]
    | Annotated[PolygonBody, Tag("<polygon>")]
    | Annotated[ModelBody, Tag("<model>")],
    Discriminator(
        _kind_of_body,
        custom_error_type="kind",
        custom_error_message="a body has a shape: radius and height, box: [length, width, height],"
        " polygon: [[x, y], ...] with height, or model: FILE",
    ),
]
