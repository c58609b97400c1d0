"""Constraints of mechanisms between joints or bodies, in addition to joints."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Length, Metres, Model, OneOf, Point3, RollPitchYaw, fault
from mjsim.world.items.mechanisms.points import GROUND, Axis, End, Named, PartName


class _Constraint(Model):
    name: PartName | None = None
    """Name in errors."""

    def called(self, number: int) -> str:
        """Return its name, or a substitute made from its index among the constraints, from 0."""
        kind = next(key for key, model in CONSTRAINTS.items() if isinstance(self, model))
        return self.name or f"{kind if kind in ('parallel', 'curve') else 'constraint'}{number + 1}"


class GearConstraint(_Constraint):
    """Two rotations coupled by a gear, from their start values."""

    gear: Annotated[tuple[Named, ...], Field(strict=False, min_length=2, max_length=2)]
    """Two rotational joints, each as `JOINT` or `JOINT.VALUE`."""
    ratio: Annotated[float, Field(ge=-1e6, le=1e6)]
    """Revolutions of the first per revolution of the second; negative for opposite directions."""

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if self.ratio == 0.0:
            raise fault("ratio is 0, so that the first would not turn; use a weld", "ratio")
        return self


class ScrewConstraint(_Constraint):
    """A translation coupled with a rotation, from their start values."""

    screw: Annotated[tuple[Named, ...], Field(strict=False, min_length=2, max_length=2)]
    """A rotational and a translational joint."""
    pitch: Annotated[float, Field(ge=-100, le=100)]
    """Translation of the second per revolution of the first [m]."""


class DistanceConstraint(_Constraint):
    """Constant distance of two points: a massless rod with a ball joint at each end."""

    distance: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    length: Length | None = None
    """[m]; default: the initial distance."""


class SpringConstraint(_Constraint):
    """A massless spring and damper between two points."""

    spring: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    stiffness: Annotated[float, Field(ge=0, le=1e9)] = 0.0
    """[N/m]"""
    damping: Annotated[float, Field(ge=0, le=1e9)] = 0.0
    """[N s/m]"""
    rest: Annotated[float, Field(ge=0, le=10000)] | None = None
    """Rest length [m]; default: the initial distance."""

    @model_validator(mode="after")
    def _does_something(self) -> Self:
        if not self.stiffness and not self.damping:
            raise fault("this spring has neither stiffness nor damping; add one", "spring")
        return self


class ParallelConstraint(_Constraint):
    """An axis of two bodies remains parallel."""

    parallel: Annotated[tuple[PartName, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two bodies; one may be `ground`."""
    axis: Axis = (0.0, 0.0, 1.0)
    """Axis in the frames of both bodies."""


class CurveConstraint(_Constraint):
    """A point slides along a smooth curve of another body without friction."""

    name: PartName | None = None
    """Name of its value, the arc length of the point [m]; default: `curve1` and so on."""
    curve: End
    """The point."""
    on: PartName = GROUND
    """The body that carries the curve."""
    points: Annotated[tuple[Point3, ...], Field(strict=False, min_length=2, max_length=1000)] | None = None
    """Points of a cubic spline, frame of the body [m]; an open curve continues straight at its ends."""
    closed: bool = False
    """Whether the curve returns from the last of `points` to the first."""
    circle: Length | None = None
    """Radius of a circle about `at`, instead of points [m]."""
    ellipse: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)] | None = None
    """Semi-axes of an ellipse, along the projection of x into its plane and across, instead of points [m]."""
    axis: Axis | None = None
    """Normal of a circle or an ellipse; default: the axis of the mechanism's first joint."""
    at: Point3 = (0.0, 0.0, 0.0)
    """Origin of the curve, frame of the body [m]."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """Rotation of the curve relative to the body."""
    start: Metres | None = None
    """Initial arc length of the point; default: determined by the joints [m]."""
    near: Metres | None = None
    """Initial guess for the arc length, if there are several solutions; default: nearest to the point [m]."""
    speed: Metres | None = None
    """Initial speed along the curve [m/s]."""

    @model_validator(mode="after")
    def _is_one_curve(self) -> Self:
        given = [key for key in ("points", "circle", "ellipse") if getattr(self, key) is not None]
        if len(given) != 1:
            have = " and ".join(given) or "none"
            raise fault(Sentence("a curve is one of points, circle and ellipse; this one has {have}", have), "curve")
        if self.points is None and self.closed:
            raise fault("a circle or an ellipse is closed; leave out closed", "closed")
        if self.points is not None:
            self._check_points(self.points)
        return self

    def _check_points(self, points: tuple[tuple[float, ...], ...]) -> None:
        if self.axis is not None:
            raise fault("points say where the curve is; leave out axis", "axis")
        if self.closed and len(points) < 3:
            raise fault(Sentence("a closed curve has {count} points; give at least 3", len(points)), "points")
        pairs = list(zip(points, points[1:] + points[:1] * self.closed, strict=False))
        longest = max(math.dist(one, other) for one, other in pairs)
        for number, (one, other) in enumerate(pairs, start=1):
            if math.dist(one, other) <= 1e-6 * longest:
                place = number % len(points)
                raise fault("this point equals its neighbour; leave it out", "points", place)


CONSTRAINTS: dict[str, type[_Constraint]] = {
    "gear": GearConstraint,
    "screw": ScrewConstraint,
    "distance": DistanceConstraint,
    "parallel": ParallelConstraint,
    "spring": SpringConstraint,
    "curve": CurveConstraint,
}
"""Constraint models by their key."""

Constraint = Annotated[
    GearConstraint | ScrewConstraint | DistanceConstraint | ParallelConstraint | SpringConstraint | CurveConstraint,
    OneOf(
        CONSTRAINTS,
        Sentence("a constraint is one of {constraints}; such as gear: [JOINT, JOINT]", ", ".join(CONSTRAINTS)),
    ),
]
