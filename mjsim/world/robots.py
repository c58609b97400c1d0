"""Robots as a world file describes them: body, drive, odometry and sensors."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from mjsim.world.base import Degrees, Length, Model, Name, Point, Point3, Rate, fault
from mjsim.world.bodies import Body
from mjsim.world.drives import DifferentialDrive, WheelOdometry
from mjsim.world.presets import over_preset


class Camera(Model):
    """A camera on the robot; it looks along the robot's x axis unless yaw and pitch say otherwise."""

    camera: Name
    """Its name."""
    at: Point3 = (0.0, 0.0, 0.3)
    """[x, y, z] in the robot's frame [m]."""
    yaw_deg: Degrees = 0.0
    """To the left."""
    pitch_deg: Annotated[float, Field(ge=-89, le=89)] = 0.0
    """Up."""
    width: Annotated[int, Field(ge=16, le=4096)] = 640
    """[px]"""
    height: Annotated[int, Field(ge=16, le=4096)] = 480
    """[px]"""
    fov_deg: Annotated[float, Field(ge=5, le=150)] = 60.0
    """Horizontal field of view."""
    rate_hz: Rate = 12.5
    """Pictures a second; it divides the rate of the tick."""
    quality: Literal["normal", "high"] = "normal"
    """High adds shadows, reflections and multisampling."""
    noise: Annotated[float, Field(ge=0, le=100)] = 0.0
    """Standard deviation of each pixel's value, of 255."""


Sensor = Camera


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
    drive: DifferentialDrive = DifferentialDrive()
    """How it moves."""
    body: Body = Body()
    """The shape that bumps."""
    odometry: WheelOdometry = WheelOdometry()
    """What the wheels tell."""
    sensors: Annotated[tuple[Sensor, ...], Field(strict=False)] = ()
    """What else it senses with."""
    proximity_range: Length = 2.0
    """How far the ring of 16 proximity rays sees [m]."""

    @model_validator(mode="before")
    @classmethod
    def _over_preset(cls, keys: Any) -> Any:
        if isinstance(keys, dict) and isinstance(keys.get("preset"), str):
            try:
                return over_preset(keys["preset"], keys)
            except ValueError as error:
                raise fault(str(error), "preset") from None
        return keys
