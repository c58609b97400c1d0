"""What a mechanism consists of."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Model
from mjsim.world.items.mechanisms.actuators import Actuator
from mjsim.world.items.mechanisms.bodies import MechanismBody
from mjsim.world.items.mechanisms.joints import Jointed
from mjsim.world.items.mechanisms.sensors import MechanismSensor


class MechanismParts(Model):
    """Bodies, joints, actuators and sensors, before they are put together."""

    bodies: Annotated[tuple[MechanismBody, ...], Field(strict=False, min_length=1, max_length=200)]
    """What it consists of."""
    joints: Annotated[tuple[Jointed, ...], Field(strict=False, min_length=1, max_length=300)]
    """What holds its bodies; a joint between bodies that others hold already closes a loop."""
    actuators: Annotated[tuple[Actuator, ...], Field(strict=False, max_length=200)] = ()
    """What moves it."""
    sensors: Annotated[tuple[MechanismSensor, ...], Field(strict=False, max_length=200)] = ()
    """What is recorded beside its joints."""
