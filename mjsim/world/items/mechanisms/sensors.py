"""Sensors of mechanisms: what reports and recordings tell of joints, bodies, reactions and actuators."""

from typing import Annotated

from mjsim.world.ground import Model, OneOf
from mjsim.world.items.mechanisms.points import End, Named, PartName


class JointSensor(Model):
    """Position, speed, acceleration and torque of a joint."""

    joint: Named
    """Its name."""


class ReactionSensor(Model):
    """Force and torque that the first body of a joint exerts on the second, at the joint, frame of the mechanism."""

    reaction: PartName
    """Name of the joint."""


class ActuatorSensor(Model):
    """Torque or force of an actuator, and its power."""

    actuator: Named
    """What it acts on."""


class BodySensor(Model):
    """Position, velocity and acceleration of a point, and how its body turns, frame of the mechanism."""

    body: End
    """`BODY`, `BODY.POINT` or {BODY: [x, y, z]}."""
    name: Named | None = None
    """With which the names of its numbers begin; what stands at `body` unless given."""

    @property
    def called(self) -> str:
        """With what the names of its numbers begin."""
        if self.name is not None:
            return self.name
        return self.body if isinstance(self.body, str) else next(iter(self.body))


SENSORS: dict[str, type[Model]] = {
    "joint": JointSensor,
    "reaction": ReactionSensor,
    "actuator": ActuatorSensor,
    "body": BodySensor,
}
"""Sensors by the key that names what they are on."""

MechanismSensor = Annotated[
    JointSensor | ReactionSensor | ActuatorSensor | BodySensor,
    OneOf(SENSORS, f"a sensor of a mechanism is one of {', '.join(SENSORS)}, such as joint: NAME"),
]
