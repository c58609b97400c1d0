"""Wheel odometry and its errors."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Deviation, Model, Slider
from mjsim.world.items.drives.base import Slip


class OdometryNoise(Model):
    """Independent increments with variances distance^2 |d| and turn^2 |turn|."""

    distance: Deviation = 0.0
    """[m/sqrt(m)]"""
    turn: Deviation = 0.0
    """[rad/sqrt(rad)]"""


class WheelOdometry(Model):
    """Wheel odometry. Modules are not given its constant errors."""

    noise: OdometryNoise = OdometryNoise(distance=0.01, turn=0.02)
    """Random noise of odometry; default: that of a usual robot, which `mjsim check` and `mjsim run` report."""
    scale: Annotated[float, Field(gt=0, le=10), Slider(0.8, 1.2)] = 1.0
    """Measured distance per metre driven."""
    track_error: Annotated[float, Field(gt=-0.9, le=10), Slider(-0.2, 0.2)] = 0.0
    """Relative error of the track (or wheelbase of a tricycle) used to compute turns."""
    ticks: Annotated[int, Field(ge=4, le=10_000_000)] | None = None
    """Encoder counts per revolution of a wheel; default: no quantisation."""
    wheel_errors: Annotated[
        tuple[Annotated[float, Field(gt=-0.9, le=10)], ...], Field(strict=False, max_length=16)
    ] = ()
    """Relative error of the radius of each driven wheel used to compute distances; default: none."""
    slip: Annotated[float, Field(ge=0, le=10)] = 1.0
    """Factor on the slip in the covariance; 1 is typical for the kind of drive."""
    tyres: Slip | None = None
    """Slip in the covariance, by component; default: that of the kind of drive."""
