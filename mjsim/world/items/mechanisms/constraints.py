"""Constraints of mechanisms: what must hold between joints or bodies beside the joints themselves."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from mjsim.world.ground import Length, Model, OneOf, fault
from mjsim.world.items.mechanisms.points import Axis, End, Named, PartName


class _Constraint(Model):
    name: PartName | None = None
    """How errors call it."""


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


class ParallelConstraint(_Constraint):
    """An axis of two bodies stays parallel."""

    parallel: Annotated[tuple[PartName, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two bodies; one may be `ground`."""
    axis: Axis = (0.0, 0.0, 1.0)
    """In the frames of both."""


class CurveConstraint(_Constraint):
    """A point stays on a curve of a body."""

    curve: End
    """The point."""

    @model_validator(mode="after")
    def _is_refused(self) -> Self:
        raise fault(
            "a point on a curve is not simulated; use a prismatic joint for a straight guide, a revolute one on a rod"
            " for an arc, or a motion with signal: {table: {points: ...}} for a cam",
            "curve",
        )


CONSTRAINTS: dict[str, type[_Constraint]] = {
    "gear": GearConstraint,
    "screw": ScrewConstraint,
    "distance": DistanceConstraint,
    "parallel": ParallelConstraint,
    "curve": CurveConstraint,
}
"""Constraints by the key that names what they are between."""

Constraint = Annotated[
    GearConstraint | ScrewConstraint | DistanceConstraint | ParallelConstraint | CurveConstraint,
    OneOf(CONSTRAINTS, f"a constraint is one of {', '.join(CONSTRAINTS)}; such as gear: [JOINT, JOINT]"),
]
