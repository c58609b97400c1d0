"""Actuators of mechanisms: motions that joints follow, and torques and forces that act on them."""

import math
from typing import Annotated, Self

from pydantic import Field, model_validator

from mjsim.world.ground import Model, OneOf, Point3, fault
from mjsim.world.items.mechanisms.points import End, Named
from mjsim.world.items.signals import Signal


class _Actuator(Model):
    signal: Signal
    """Its value over time."""

    @property
    def target(self) -> str:
        """What it acts on, as sensors name it."""
        return str(getattr(self, actuator_kind(self)))


class _Motion(_Actuator):
    @model_validator(mode="after")
    def _can_be_followed(self) -> Self:
        kind = actuator_kind(self)
        if self.signal.kind in ("step", "square", "pulse", "random") and kind != "velocity":
            raise fault(
                f"a {self.signal.kind} jumps, and nothing with a mass can follow; give a ramp, a sine or a table",
                *("signal", self.signal.kind),
            )
        return self


class AngleActuator(_Motion):
    """Turns a joint to angles over time, with whatever torque that needs."""

    angle: Named
    """A joint that turns, or `JOINT.VALUE`."""


class PositionActuator(_Motion):
    """Slides a joint to positions over time, with whatever force that needs."""

    position: Named
    """A joint that slides, or `JOINT.VALUE`."""


class VelocityActuator(_Motion):
    """Moves a joint at speeds over time, with whatever torque or force that needs."""

    velocity: Named
    """A joint, or `JOINT.VALUE`."""


class DistanceActuator(_Motion):
    """Keeps two points as far apart as its signal says, with whatever force that needs."""

    distance: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    name: Named = "distance"
    """What sensors call it."""

    @property
    def target(self) -> str:
        """Its name."""
        return self.name


class _Effort(_Actuator):
    axis: Point3 | None = None
    """Direction of a positive value, frame of the mechanism; for a body only."""

    @model_validator(mode="after")
    def _has_a_direction(self) -> Self:
        if self.axis is not None and math.hypot(*self.axis) < 1e-9:
            raise fault("axis is [0, 0, 0], which has no direction", "axis")
        return self


class TorqueActuator(_Effort):
    """A torque on a joint, or on a body about an axis [N m]."""

    torque: Named
    """A joint that turns, `JOINT.VALUE`, or a body."""


class ForceActuator(_Effort):
    """A force on a joint that slides, or on a point of a body along an axis [N]."""

    force: Named
    """A joint that slides, `JOINT.VALUE`, or a point of a body, `BODY.POINT`."""


ACTUATORS: dict[str, type[_Actuator]] = {
    "angle": AngleActuator,
    "position": PositionActuator,
    "velocity": VelocityActuator,
    "distance": DistanceActuator,
    "torque": TorqueActuator,
    "force": ForceActuator,
}
"""Actuators by the key that names what they act on."""
MOTIONS = ("angle", "position", "velocity", "distance")
"""Those that a joint follows, whatever it takes."""


def actuator_kind(actuator: _Actuator) -> str:
    """Return the key of an actuator's kind."""
    return next(kind for kind, model in ACTUATORS.items() if isinstance(actuator, model))


Actuator = Annotated[
    AngleActuator | PositionActuator | VelocityActuator | DistanceActuator | TorqueActuator | ForceActuator,
    OneOf(ACTUATORS, f"an actuator needs its kind, which names a joint: {', '.join(ACTUATORS)}, such as angle: JOINT"),
]
