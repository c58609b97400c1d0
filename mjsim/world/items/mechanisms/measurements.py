"""Sensors of mechanisms: measurements of joints, bodies, reactions and actuators for reports and recordings."""

from typing import Annotated

from mjsim.sentences import Sentence
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
    """The joint, body or point it acts on."""


class BodySensor(Model):
    """Position, velocity and acceleration of a point, and rotation of its body, frame of the mechanism."""

    body: End
    """`BODY`, `BODY.POINT` or {BODY: [x, y, z]}."""
    name: Named | None = None
    """Prefix of the names of its values; default: `body`."""

    @property
    def called(self) -> str:
        """Prefix of the names of its numbers."""
        if self.name is not None:
            return self.name
        return self.body if isinstance(self.body, str) else next(iter(self.body))


SENSORS: dict[str, type[Model]] = {
    "joint": JointSensor,
    "reaction": ReactionSensor,
    "actuator": ActuatorSensor,
    "body": BodySensor,
}
"""Sensor models by their key."""

MechanismSensor = Annotated[
    JointSensor | ReactionSensor | ActuatorSensor | BodySensor,
    OneOf(SENSORS, Sentence("a sensor of a mechanism is one of {sensors}, such as joint: NAME", ", ".join(SENSORS))),
]
