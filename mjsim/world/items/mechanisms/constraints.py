"""Constraints of mechanisms: what must hold between joints or bodies beside the joints themselves."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from mjsim.world.ground import Length, Metres, Model, OneOf, Point3, RollPitchYaw, fault
from mjsim.world.items.mechanisms.points import GROUND, Axis, End, Named, PartName


class _Constraint(Model):
    name: PartName | None = None
    """How errors call it."""

    def called(self, number: int) -> str:
        """Return its name, or what stands for one where it is of that number among the constraints, from 0."""
        kind = next(key for key, model in CONSTRAINTS.items() if isinstance(self, model))
        return self.name or f"{kind if kind in ('parallel', 'curve') else 'constraint'}{number + 1}"


class GearConstraint(_Constraint):
    """Two joints turn together, from where they start."""

    gear: Annotated[tuple[Named, ...], Field(strict=False, min_length=2, max_length=2)]
    """Two joints that turn, or `JOINT.VALUE` each."""
    ratio: Annotated[float, Field(ge=-1e6, le=1e6)]
    """Turns of the first for one of the second; negative for wheels that turn opposite ways."""

    @model_validator(mode="after")
    def _turns(self) -> Self:
        if self.ratio == 0.0:
            raise fault("ratio is 0, so that the first would not turn; use a weld", "ratio")
        return self


class ScrewConstraint(_Constraint):
    """A joint slides as another turns, from where they start."""

    screw: Annotated[tuple[Named, ...], Field(strict=False, min_length=2, max_length=2)]
    """A joint that turns and one that slides."""
    pitch: Annotated[float, Field(ge=-100, le=100)]
    """How far the second slides in one turn of the first [m]."""


class DistanceConstraint(_Constraint):
    """Two points stay as far apart as they are: a rod without mass, with a ball at each end."""

    distance: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    length: Length | None = None
    """[m]; as at the start unless given."""


class SpringConstraint(_Constraint):
    """A spring with a damper between two points, without mass."""

    spring: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    stiffness: Annotated[float, Field(ge=0, le=1e9)] = 0.0
    """[N/m]"""
    damping: Annotated[float, Field(ge=0, le=1e9)] = 0.0
    """[N s/m]"""
    rest: Annotated[float, Field(ge=0, le=10000)] | None = None
    """How far apart it pulls and pushes them to [m]; as at the start unless given."""

    @model_validator(mode="after")
    def _does_something(self) -> Self:
        if not self.stiffness and not self.damping:
            raise fault("this spring has neither stiffness nor damping; add one", "spring")
        return self


class ParallelConstraint(_Constraint):
    """An axis of two bodies stays parallel."""

    parallel: Annotated[tuple[PartName, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two bodies; one may be `ground`."""
    axis: Axis = (0.0, 0.0, 1.0)
    """In the frames of both."""


class CurveConstraint(_Constraint):
    """A point slides along a smooth curve of another body without friction, and never leaves it."""

    name: PartName | None = None
    """Of its value, how far along the curve the point is [m]; `curve1` and so on unless given."""
    curve: End
    """The point."""
    on: PartName = GROUND
    """The body that carries the curve."""
    points: Annotated[tuple[Point3, ...], Field(strict=False, min_length=2, max_length=1000)] | None = None
    """Which a smooth curve passes, a cubic spline, frame of the body [m]; an open one goes on straight at its ends."""
    closed: bool = False
    """Whether the curve comes back from the last of `points` to the first."""
    circle: Length | None = None
    """Radius of a circle about `at`, in place of points [m]."""
    ellipse: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)] | None = None
    """Half of its sizes along x, or what of x lies in its plane, and across that, in place of points [m]."""
    axis: Axis | None = None
    """Normal of a circle or an ellipse; the axis of the mechanism's first joint unless given."""
    at: Point3 = (0.0, 0.0, 0.0)
    """Where the curve has its origin, frame of the body [m]."""
    rpy_deg: RollPitchYaw = (0.0, 0.0, 0.0)
    """How the curve is turned against the body."""
    start: Metres | None = None
    """How far along the curve the point is at the start; what follows from the joints unless given [m]."""
    near: Metres | None = None
    """Near which length it starts, where several fit; the nearest to the point unless given [m]."""
    speed: Metres | None = None
    """Its speed along the curve at the start [m/s]."""

    @model_validator(mode="after")
    def _is_one_curve(self) -> Self:
        given = [key for key in ("points", "circle", "ellipse") if getattr(self, key) is not None]
        if len(given) != 1:
            have = " and ".join(given) or "none"
            raise fault(f"a curve is one of points, circle and ellipse; this one has {have}", "curve")
        if self.points is None and self.closed:
            raise fault("a circle or an ellipse is closed; leave out closed", "closed")
        if self.points is not None:
            self._check_points(self.points)
        return self

    def _check_points(self, points: tuple[tuple[float, ...], ...]) -> None:
        if self.axis is not None:
            raise fault("points say where the curve is; leave out axis", "axis")
        if self.closed and len(points) < 3:
            raise fault(f"a closed curve has {len(points)} points; give 3 at least", "points")
        pairs = list(zip(points, points[1:] + points[:1] * self.closed, strict=False))
        longest = max(math.dist(one, other) for one, other in pairs)
        for number, (one, other) in enumerate(pairs, start=1):
            if math.dist(one, other) <= 1e-6 * longest:
                place = number % len(points)
                raise fault("this point is that of its neighbour; leave it out", "points", place)


CONSTRAINTS: dict[str, type[_Constraint]] = {
    "gear": GearConstraint,
    "screw": ScrewConstraint,
    "distance": DistanceConstraint,
    "parallel": ParallelConstraint,
    "spring": SpringConstraint,
    "curve": CurveConstraint,
}
"""Constraints by the key that names what they are between."""

Constraint = Annotated[
    GearConstraint | ScrewConstraint | DistanceConstraint | ParallelConstraint | SpringConstraint | CurveConstraint,
    OneOf(CONSTRAINTS, f"a constraint is one of {', '.join(CONSTRAINTS)}; such as gear: [JOINT, JOINT]"),
]
