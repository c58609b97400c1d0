"""Actuators of mechanisms: prescribed motions of joints, and torques and forces."""

from typing import Annotated, Self

from pydantic import Field, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Model, OneOf, fault
from mjsim.world.items.mechanisms.points import Axis, End, Named
from mjsim.world.items.running import Control
from mjsim.world.items.timeline import Signal


class _Actuator(Model):
    signal: Signal | None = None
    """Value over time."""

    @property
    def target(self) -> str:
        """What it acts on, in the notation of sensors."""
        return str(getattr(self, actuator_kind(self)))


class _Named(_Actuator):
    name: Named | None = None
    """Name as an input in the control laboratory."""


class _Motion(_Actuator):
    @model_validator(mode="after")
    def _can_be_followed(self) -> Self:
        kind = actuator_kind(self)
        if self.signal is None:
            raise fault(Sentence("this {kind} has no signal; add signal: {{ramp: ...}} or another", kind))
        if self.signal.kind in ("step", "square", "pulse", "random") and kind != "velocity":
            raise fault(
                Sentence(
                    "a {kind} signal jumps, which no mass can follow; use a ramp, a sine or a table", self.signal.kind
                ),
                *("signal", self.signal.kind),
            )
        return self


class AngleActuator(_Named, _Motion):
    """Prescribes the angle of a joint over time, with whatever torque that requires."""

    angle: Named
    """A rotational joint, or `JOINT.VALUE`."""


class PositionActuator(_Named, _Motion):
    """Prescribes the position of a joint over time, with whatever force that requires."""

    position: Named
    """A translational joint, or `JOINT.VALUE`."""


class VelocityActuator(_Named, _Motion):
    """Prescribes the speed of a joint over time, with whatever torque or force that requires."""

    velocity: Named
    """A joint, or `JOINT.VALUE`."""


class DistanceActuator(_Motion):
    """Prescribes the distance of two points over time, with whatever force that requires."""

    distance: Annotated[tuple[End, ...], Field(strict=False, min_length=2, max_length=2)]
    """The two points."""
    name: Named = "distance"
    """Name in sensors."""

    @property
    def target(self) -> str:
        """Its name."""
        return self.name


class _Effort(_Named):
    axis: Axis | None = None
    """Direction of a positive value, frame of the mechanism; only for a body."""
    find: bool = False
    """Whether trimming determines its constant value; instead of a signal, on a joint."""
    controller: Control | None = None
    """A module that computes the value, instead of a signal, on a joint; it senses the joints of the mechanism."""
    goal: Signal | None = None
    """Goal of the controller, an angle or a length; default: the start of the joint."""

    @model_validator(mode="after")
    def _has_a_signal(self) -> Self:
        if self.find and self.signal is not None:
            raise fault("trimming finds its value; leave out signal, or find", "find")
        if self.controller is not None and (self.find or self.signal is not None):
            raise fault("a controller computes the value; leave out signal and find", "controller")
        if self.goal is not None and self.controller is None:
            raise fault("goal is for a controller; add controller: {use: ...}", "goal")
        if not self.find and self.signal is None and self.controller is None:
            kind = actuator_kind(self)
            raise fault(
                Sentence(
                    "this {kind} has no signal; add signal: {{constant: {{value: 1}}}}, or find: true in mode trim",
                    kind,
                )
            )
        return self


class TorqueActuator(_Effort):
    """A torque on a joint, or on a body about an axis [N m]."""

    torque: Named
    """A rotational joint, `JOINT.VALUE`, or a body."""


class ForceActuator(_Effort):
    """A force on a translational joint, or on a point of a body along an axis [N]."""

    force: Named
    """A translational joint, `JOINT.VALUE`, or a point of a body, `BODY.POINT`."""


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
"""Actuators that prescribe a motion, with whatever force it takes."""


def actuator_kind(actuator: _Actuator) -> str:
    """Return the key that names the kind of an actuator."""
    return next(kind for kind, model in ACTUATORS.items() if isinstance(actuator, model))


Actuator = Annotated[
    AngleActuator | PositionActuator | VelocityActuator | DistanceActuator | TorqueActuator | ForceActuator,
    OneOf(
        ACTUATORS,
        Sentence("an actuator needs a kind as a key: {actuators}, such as angle: JOINT", ", ".join(ACTUATORS)),
    ),
]
