"""Drives as a world file describes them: how a robot moves, and what its wheels tell of it."""

from typing import Annotated, Literal

from pydantic import Field

from mjsim.world.base import Deviation, Length, Model


class DriveNoise(Model):
    """White noise on the twist that is achieved; it acts also when the command is zero."""

    speed: Deviation = 0.0
    """[m/sqrt(s)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(s)]"""


class DifferentialDrive(Model):
    """Two driven wheels on one axle, and casters that slide."""

    type: Literal["differential"] = "differential"
    """Which kind of drive."""
    wheel_radius: Length = 0.0975
    """[m]"""
    track: Length = 0.33
    """Distance between the wheels [m]."""
    max_speed: Annotated[float, Field(gt=0, le=20)] = 0.7
    """[m/s]"""
    max_turn_deg: Annotated[float, Field(gt=0, le=3600)] = 100.0
    """[deg/s]"""
    max_acceleration: Annotated[float, Field(gt=0, le=100)] = 1.0
    """[m/s^2]"""
    max_turn_acceleration_deg: Annotated[float, Field(gt=0, le=36000)] = 300.0
    """[deg/s^2]"""
    noise: DriveNoise = DriveNoise()
    """How far the motion achieved differs from the one commanded."""


class OdometryNoise(Model):
    """Independent increments with variance distance^2 |d| and turn^2 |turn|."""

    distance: Deviation = 0.0
    """[m/sqrt(m)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(rad)]"""


class WheelOdometry(Model):
    """What the wheels tell of the motion. The constant errors are not told to the modules."""

    noise: OdometryNoise = OdometryNoise()
    """How far the motion told differs from the one driven."""
    scale: Annotated[float, Field(gt=0, le=10)] = 1.0
    """Distance told for one metre driven."""
    track_error: Annotated[float, Field(gt=-0.9, le=10)] = 0.0
    """Relative error of the track that turns are computed with."""
