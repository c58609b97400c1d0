"""Seats on objects, and targets for hands, feet and eyes of people."""

from collections.abc import Iterable
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import (
    JOINT_PATTERN,
    TARGET_PATTERN,
    Degrees,
    Distance,
    Legible,
    Length,
    Model,
    OneOf,
    Point3,
    TakenNames,
    fault,
    kind_of,
)

TargetName = Annotated[str, Field(pattern=JOINT_PATTERN, max_length=64), Legible]
"""Letters, digits, `_` and `-`; a dot separates it from the name of its object."""
TargetRef = Annotated[str, Field(pattern=TARGET_PATTERN, max_length=130), Legible]
"""'THING.TARGET'."""


class Seat(Model):
    """A seat on an object; the person faces along the object's heading."""

    at: Point3
    """[x, y, z] of the hip point at the middle of the travel, in the frame of the object: the origin is the centre of
    its underside (for a model, the origin of its file), x points along its heading [m]."""
    back_deg: Annotated[float, Field(ge=-10, le=60)] | None = None
    """Backward tilt of the backrest from the vertical; default: no backrest."""
    travel: Annotated[tuple[Distance, ...], Field(strict=False, min_length=2, max_length=2)] = (0.0, 0.0)
    """Adjustment range of the seat, [along, up], from end to end [m]."""

    @model_validator(mode="after")
    def _within_reason(self) -> Self:
        if max(self.travel) > 1.0:
            raise fault(
                Sentence("a travel is {travel:g} m; the travel of a seat is at most 1 m", max(self.travel)), "travel"
            )
        return self


class _Target(Model):
    at: Point3
    """Position [x, y, z] in the frame of the object, as for a seat [m]."""

    @property
    def name(self) -> str:
        """Name of the target on its object."""
        return str(getattr(self, kind_of(self, TARGET_KINDS) or ""))


class GripTarget(_Target):
    """A target for a hand."""

    grip: TargetName
    """Its name."""
    touch: Literal["fist", "thumb", "finger"] = "fist"
    """Contact point of the hand: centre of the fist, tip of the thumb, or tip of the middle finger."""


class PedalTarget(_Target):
    """A target for the ball of a foot."""

    pedal: TargetName
    """Its name."""


class SightTarget(_Target):
    """A point to look at."""

    sight: TargetName
    """Its name."""


class DisplayTarget(_Target):
    """A flat display, visible only from the front."""

    display: TargetName
    """Its name."""
    size: Annotated[tuple[Length, ...], Field(strict=False, min_length=2, max_length=2)]
    """[width, height] [m]."""
    yaw_deg: Degrees = 180.0
    """Direction it faces, counter-clockwise from the object's x; 180 faces a person behind it."""
    pitch_deg: Annotated[float, Field(ge=-90, le=90)] = 0.0
    """Upward tilt."""


TARGET_KINDS: dict[str, type[_Target]] = {
    "grip": GripTarget,
    "pedal": PedalTarget,
    "sight": SightTarget,
    "display": DisplayTarget,
}
"""Target models by the key of their kind."""

Target = Annotated[
    GripTarget | PedalTarget | SightTarget | DisplayTarget,
    OneOf(
        TARGET_KINDS,
        Sentence("a target needs a kind as a key: {target_kinds}, such as grip: wheel", ", ".join(TARGET_KINDS)),
    ),
]
Targets = Annotated[tuple[Target, ...], Field(strict=False, max_length=200)]


def check_names(targets: Iterable[_Target]) -> None:
    """Refuse targets of one object with the same name."""
    taken = TakenNames()
    for number, target in enumerate(targets):
        if message := taken.fault(target.name, "another target of this thing"):
            raise fault(message, "targets", number, kind_of(target, TARGET_KINDS) or "")


class Hands(Model):
    """Targets of the hands, each as `OBJECT.TARGET`."""

    left: TargetRef | None = None
    """A grip."""
    right: TargetRef | None = None
    """A grip."""


class Feet(Model):
    """Targets of the feet, each as `OBJECT.TARGET`."""

    left: TargetRef | None = None
    """A pedal."""
    right: TargetRef | None = None
    """A pedal."""
