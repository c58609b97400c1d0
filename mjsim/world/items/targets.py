"""What people meet on things: seats, and targets for hands, feet and eyes."""

from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mjsim.world.ground import (
    JOINT_PATTERN,
    TARGET_PATTERN,
    Degrees,
    Distance,
    Length,
    Model,
    OneOf,
    Point3,
    fault,
    kind_of,
)

TargetName = Annotated[str, Field(pattern=JOINT_PATTERN, max_length=64)]
"""Letters, digits, `_` and `-`; a point separates it from the thing that it is on."""
TargetRef = Annotated[str, Field(pattern=TARGET_PATTERN, max_length=130)]
"""'THING.TARGET'."""


class Seat(Model):
    """A place to sit on a thing; whoever sits there faces along the thing's heading."""

    at: Point3
    """[x, y, z] of the hip point amid the travel, in the frame of the thing: its origin is the middle of the
    thing's underside, of a model the origin of its file; x lies along its heading [m]."""
    back_deg: Annotated[float, Field(ge=-10, le=60)] | None = None
    """How far the backrest leans back from upright; a stool has none."""
    travel: Annotated[tuple[Distance, ...], Field(strict=False, min_length=2, max_length=2)] = (0.0, 0.0)
    """How far the seat can be set, [along, up], from end to end [m]."""

    @model_validator(mode="after")
    def _within_reason(self) -> Self:
        if max(self.travel) > 1.0:
            raise fault(f"a travel is {max(self.travel):g} m; no seat is set by more than 1 m", "travel")
        return self


class _Target(Model):
    at: Point3
    """[x, y, z] in the frame of the thing, as that of a seat [m]."""

    @property
    def name(self) -> str:
        """What people's keys and pages call it, on its thing."""
        return str(getattr(self, kind_of(self, TARGET_KINDS) or ""))


class GripTarget(_Target):
    """Something to hold or to press."""

    grip: TargetName
    """Its name."""
    touch: Literal["fist", "thumb", "finger"] = "fist"
    """What meets it: the middle of the fist, the tip of the thumb, or that of the middle finger."""


class PedalTarget(_Target):
    """Something to step on, with the ball of a foot."""

    pedal: TargetName
    """Its name."""


class SightTarget(_Target):
    """A point to look at."""

    sight: TargetName
    """Its name."""


class DisplayTarget(_Target):
    """A flat display; it is seen from the front alone."""

    display: TargetName
    """Its name."""
    size: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[width, height] [m]."""
    yaw_deg: Degrees = 180.0
    """Where it faces, counter-clockwise from the thing's x: 180 looks back, at who sits behind it."""
    pitch_deg: Annotated[float, Field(ge=-90, le=90)] = 0.0
    """How far it looks up."""


TARGET_KINDS: dict[str, type[_Target]] = {
    "grip": GripTarget,
    "pedal": PedalTarget,
    "sight": SightTarget,
    "display": DisplayTarget,
}
"""Targets by the key that names their kind."""

Target = Annotated[
    GripTarget | PedalTarget | SightTarget | DisplayTarget,
    OneOf(TARGET_KINDS, f"a target needs its kind, which names it: {', '.join(TARGET_KINDS)}, such as grip: wheel"),
]
Targets = Annotated[tuple[Target, ...], Field(strict=False, max_length=200)]


def check_names(targets: Iterable[_Target]) -> None:
    """Refuse targets of one thing that share a name."""
    taken: set[str] = set()
    for number, target in enumerate(targets):
        if target.name in taken:
            key = kind_of(target, TARGET_KINDS) or ""
            message = f"name '{target.name}' is taken by another target of this thing; give each its own"
            raise fault(message, "targets", number, key)
        taken.add(target.name)


class Hands(Model):
    """What the hands hold, `THING.TARGET` each."""

    left: TargetRef | None = None
    """A grip."""
    right: TargetRef | None = None
    """A grip."""


class Feet(Model):
    """What the feet are on, `THING.TARGET` each."""

    left: TargetRef | None = None
    """A pedal."""
    right: TargetRef | None = None
    """A pedal."""
