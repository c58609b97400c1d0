"""Robots as a world file describes them: body, drive, odometry and sensors."""

from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from mjsim.world.base import Degrees, Length, Model, Name, Point, fault
from mjsim.world.bodies import Body, CylinderBody, ModelBody
from mjsim.world.drives import DifferentialDrive, Drive, UserDrive, WheelOdometry
from mjsim.world.presets import over_preset
from mjsim.world.sensors import Sensor


class Robot(Model):
    """A wheeled robot."""

    name: Name
    """How drivers, recordings and plans call it."""
    at: Point
    """Where it starts, [x, y] [m]."""
    heading_deg: Degrees = 0.0
    """Where it looks at the start, counter-clockwise from x."""
    preset: Name | None = None
    """A robot of `assets/robots`; keys beside this one override it."""
    drive: Drive = DifferentialDrive()
    """How it moves."""
    body: Body = CylinderBody()
    """The shape that bumps."""
    odometry: WheelOdometry = WheelOdometry()
    """What the wheels tell."""
    sensors: Annotated[tuple[Sensor, ...], Field(strict=False)] = ()
    """What else it senses with."""
    proximity_range: Length = 2.0
    """How far the ring of 16 proximity rays sees [m]."""

    @model_validator(mode="after")
    def _own_drive_on_own_body(self) -> Self:
        if isinstance(self.drive, UserDrive) != isinstance(self.body, ModelBody):
            raise fault("a drive of your own goes with a body of your own; give both drive: {use} and body: {model}")
        return self

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            try:
                return over_preset(keys["preset"], keys)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return keys
