"""What the wheels tell of the motion, and how far they err."""

from typing import Annotated

from pydantic import Field

from mjsim.world.ground import Deviation, Model, Slider
from mjsim.world.items.drives.base import Slip


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
    scale: Annotated[float, Field(gt=0, le=10), Slider(0.8, 1.2)] = 1.0
    """Distance told for one metre driven."""
    track_error: Annotated[float, Field(gt=-0.9, le=10), Slider(-0.2, 0.2)] = 0.0
    """Relative error of the track, or of the wheelbase of a tricycle, that turns are computed with."""
    ticks: Annotated[int, Field(ge=4, le=10_000_000)] | None = None
    """Steps that an encoder counts in one turn of its wheel; as fine as can be unless given."""
    wheel_errors: Annotated[
        tuple[Annotated[float, Field(gt=-0.9, le=10)], ...], Field(strict=False, max_length=16)
    ] = ()
    """Relative error of the radius of each driven wheel that ways are computed with; none unless given."""
    slip: Annotated[float, Field(ge=0, le=10)] = 1.0
    """How much its covariance allows for tyres that slip, as a multiple of what is usual for the kind of drive."""
    tyres: Slip | None = None
    """What its covariance allows for tyres that slip, part by part; that of the kind of drive unless given."""
