"""Joints of mechanisms; each is a chain of translations and rotations between two bodies."""

import math
from abc import abstractmethod
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import BeforeValidator, Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Metres, Model, RollPitchYaw, fault
from mjsim.world.items.mechanisms.points import Axis, End, PartName

if TYPE_CHECKING:  # Imported where it is used: worlds without mechanisms load faster.
    from mjsim.mechanics import Primitive

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, int | float) and not isinstance(value, bool) else value


ONE_OR_MORE = BeforeValidator(_listed, json_schema_input_type=float | list[float])
Angle = Annotated[float, Field(ge=-36000, le=36000)]
Figure = Annotated[float, Field(ge=0, le=1e9)]
Angles = Annotated[tuple[Angle, ...], ONE_OR_MORE, Field(strict=False, min_length=1, max_length=6)]
Lengths = Annotated[tuple[Metres, ...], ONE_OR_MORE, Field(strict=False, min_length=1, max_length=6)]
Figures = Annotated[tuple[Figure, ...], ONE_OR_MORE, Field(strict=False, min_length=1, max_length=6)]
Pair = Annotated[tuple[Metres, ...], Field(strict=False, min_length=2, max_length=2)]
AnglePair = Annotated[tuple[Angle, ...], Field(strict=False, min_length=2, max_length=2)]


class MechanismJoint(Model):
    """Base class of all joints; a number stands for a list of one.

    Lists have one number per slide, or per rotation (`_deg`); a ball has three rotations. `stiffness`, `damping` and
    `friction` have one number for all, or one per slide and then per rotation.
    """

    of: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """Two points that coincide: one on the first (carrying) body, one on the second."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """Rotation of the second body relative to the first at joint value 0."""
    start: Lengths | None = None
    """Initial values of translations [m]; default: determined by loops, else 0."""
    start_deg: Angles | None = None
    """Initial values of rotations; default: determined by loops, else 0."""
    near: Lengths | None = None
    """Initial guess for translations determined by loops [m]."""
    near_deg: Angles | None = None
    """Initial guess for rotations determined by loops."""
    speed: Lengths | None = None
    """Initial speeds of translations [m/s]."""
    speed_deg: Angles | None = None
    """Initial speeds of rotations [deg/s]."""
    range: Pair | None = None
    """Limits [lower, upper] of translations [m]."""
    range_deg: AnglePair | None = None
    """Limits [lower, upper] of rotations."""
    stiffness: Figures | None = None
    """Spring stiffness [N/m, N m/rad]."""
    rest: Lengths | None = None
    """Rest positions of springs of translations [m]; default: 0."""
    rest_deg: Angles | None = None
    """Rest angles of springs of rotations; default: 0."""
    damping: Figures | None = None
    """Viscous damping [N s/m, N m s/rad]."""
    friction: Figures | None = None
    """Dry friction, equal at rest and in motion [N, N m]."""

    @property
    def kind(self) -> str:
        """The key that names its kind: `revolute` and so on."""
        return next(key for key, field in type(self).model_fields.items() if field.annotation is str)

    @property
    def name(self) -> str:
        """Its name; `MECHANISM/JOINT` in the scene."""
        return str(getattr(self, self.kind))

    @abstractmethod
    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return its elementary motions in order, from the first body to the second.

        Args:
            axis: Its default axis, in the frame of the first body.
        """

    @model_validator(mode="after")
    def _lists_fit(self) -> Self:
        slides, turns = self._counts()
        for key, value in self._lists():
            expected = turns if key.endswith("_deg") else slides
            if not expected:
                other = key.removesuffix("_deg") if key.endswith("_deg") else f"{key}_deg"
                moves = "turns" if slides else "slides"
                raise fault(
                    Sentence("{key} is for a joint that {moves}; give {other}", key, moves, other)
                    if slides + turns
                    else Sentence("a weld does not move; leave out {key}", key),
                    key,
                )
            if key not in ("range", "range_deg") and len(value) != expected:
                raise fault(
                    Sentence("{key} has {count} numbers; this joint needs {expected}", key, len(value), expected), key
                )
        for key in ("stiffness", "damping", "friction"):
            value = getattr(self, key)
            if value is not None and not slides + turns:
                raise fault(Sentence("a weld does not move; leave out {key}", key), key)
            if value is not None and len(value) not in (1, slides + turns):
                raise fault(
                    Sentence("{key} has {count} numbers; give 1 or {expected}", key, len(value), slides + turns), key
                )
        for key in ("range", "range_deg"):
            pair = getattr(self, key)
            if pair is not None and pair[0] >= pair[1]:
                raise fault(
                    Sentence("{key} is [{low:g}, {high:g}]; the first must be below the second", key, pair[0], pair[1]),
                    key,
                )
        return self

    def _lists(self) -> Iterator[tuple[str, tuple[float, ...]]]:
        for key in ("start", "near", "speed", "range", "rest"):
            for name in (key, f"{key}_deg"):
                value = getattr(self, name)
                if value is not None:
                    yield name, value

    def _counts(self) -> tuple[int, int]:
        """Return the numbers of slides and of rotations."""
        parts = self.primitives(Z)
        slides = sum(part.kind == "slide" for part in parts)
        return slides, sum(part.width for part in parts) - slides

    def spread(self, key: str) -> list[float | None]:
        """Return the numbers of `key` and `key_deg` for each value [m, rad], None if not given, in order."""
        slides, turns = iter(getattr(self, key) or ()), iter(getattr(self, f"{key}_deg") or ())
        found: list[float | None] = []
        for part in self.primitives(Z):
            if part.kind == "slide":
                found.append(next(slides, None))
            else:
                angles = (next(turns, None) for _ in range(part.width))
                found += [None if angle is None else math.radians(angle) for angle in angles]
        return found

    def figures(self, key: str) -> list[float]:
        """Return stiffness, damping or friction of each value, in order; 0 by default."""
        parts = self.primitives(Z)
        width = sum(part.width for part in parts)
        given = getattr(self, key) or (0.0,)
        if len(given) == 1:
            return [given[0]] * width
        slides = sum(part.kind == "slide" for part in parts)
        of_slides, of_turns = iter(given[:slides]), iter(given[slides:])
        return [next(of_slides if part.kind == "slide" else of_turns) for part in parts for _ in range(part.width)]


class OneAxis(MechanismJoint):
    """A joint along one axis."""

    axis: Axis | None = None
    """Axis in the frame of the first body; default: that of the mechanism's first joint."""

    def direction(self, axis: tuple[float, ...]) -> tuple[float, float, float]:
        """Return its axis as a unit vector; the default axis unless it has its own."""
        return unit(axis if self.axis is None else self.axis)


class WeldJoint(MechanismJoint):
    """A rigid connection."""

    weld: PartName
    """Its name."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return none."""
        return ()


class RevoluteJoint(OneAxis):
    """A hinge."""

    revolute: PartName
    """Its name."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return the rotation."""
        return chain(("turn", self.direction(axis), ""))


class PrismaticJoint(OneAxis):
    """A sliding joint."""

    prismatic: PartName
    """Its name."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return the slide."""
        return chain(("slide", self.direction(axis), ""))


class CylindricalJoint(OneAxis):
    """A translation along an axis and a rotation about it."""

    cylindrical: PartName
    """Its name; its values are `NAME.slide` and `NAME.turn`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return slide and rotation."""
        along = self.direction(axis)
        return chain(("slide", along, "slide"), ("turn", along, "turn"))


class PlanarJoint(OneAxis):
    """Two translations in a plane and a rotation about its normal `axis`."""

    planar: PartName
    """Its name; its values are `NAME.x`, `NAME.y` and `NAME.turn`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return both slides and the rotation."""
        normal = self.direction(axis)
        first, second = across(normal)
        return chain(("slide", first, "x"), ("slide", second, "y"), ("turn", normal, "turn"))


class InPlaneJoint(OneAxis):
    """Two translations in a plane with normal `axis`."""

    in_plane: PartName
    """Its name; its values are `NAME.x` and `NAME.y`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return both slides."""
        first, second = across(self.direction(axis))
        return chain(("slide", first, "x"), ("slide", second, "y"))


class SphericalJoint(MechanismJoint):
    """A ball joint; its values are the components of a rotation vector."""

    spherical: PartName
    """Its name; its values are `NAME.rx`, `NAME.ry` and `NAME.rz`."""

    def primitives(self, axis: tuple[float, ...]) -> "tuple[Primitive, ...]":
        """Return the ball."""
        return chain(("ball", Z, ""))


def chain(*parts: tuple[Any, tuple[float, float, float], str]) -> "tuple[Primitive, ...]":
    """Return primitives of kinds, axes and suffixes."""
    from mjsim.mechanics import Primitive

    return tuple(Primitive(kind=kind, axis=axis, suffix=suffix) for kind, axis, suffix in parts)


def unit(vector: tuple[float, ...]) -> tuple[float, float, float]:
    """Return a vector of length 1 in the same direction."""
    length = math.hypot(*vector)
    x, y, z = (part / length for part in vector)
    return (x, y, z)


def across(normal: tuple[float, float, float]) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return two axes in the plane of a normal, right-handed with it: x is kept if the normal is z."""
    start = X if abs(normal[0]) < 0.9 else Y
    along = sum(a * b for a, b in zip(start, normal, strict=True))
    first = unit(tuple(a - along * b for a, b in zip(start, normal, strict=True)))
    nx, ny, nz = normal
    fx, fy, fz = first
    return first, (ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx)
