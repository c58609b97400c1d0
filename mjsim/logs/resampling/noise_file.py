"""The file of noise and bias written by `mjsim calibrate -o`, and the correction of imported logs with it.

    noise: {distance: 0.05, turn: 0.1, range: 0.03, bearing_deg: 1.5}
    bias: {scale: 1.08, turn_deg: 0.2, delay: 0.16, range: 0.09, bearing_deg: -0.2}

All keys are optional: missing noise is the default of the log's format, and a missing bias is not corrected.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import Field

from mjsim.geometry import Array
from mjsim.interface import Odometry, Sighting
from mjsim.world import Model, read_described

MIN_RANGE = 1e-3
"""Minimum range of a sighting after subtraction of the bias [m]."""

Deviation = Annotated[float, Field(ge=0, le=10)]


class MeasuredNoise(Model):
    """Standard deviations; missing ones are the defaults of the log's format."""

    distance: Deviation | None = None
    """Noise of the distance by odometry [m/sqrt(m)]."""
    turn: Deviation | None = None
    """Noise of the turn by odometry [rad/sqrt(rad)]."""
    veer: Deviation | None = None
    """Noise of the heading by odometry, over distance [rad/sqrt(m)]."""
    range: Annotated[float, Field(gt=0, le=100)] | None = None
    """Noise of a sighting [m]."""
    bearing_deg: Annotated[float, Field(gt=0, le=180)] | None = None
    """Noise of a sighting."""

    def motion(self) -> dict[str, float]:
        """Return the measured noise of odometry, by the fields of `MotionNoise`."""
        values = {"distance": self.distance, "turn": self.turn, "veer": self.veer}
        return {key: value for key, value in values.items() if value is not None}

    def bearing(self) -> float | None:
        """Return the standard deviation of a sighting's bearing [rad]."""
        return None if self.bearing_deg is None else math.radians(self.bearing_deg)


class Bias(Model):
    """Systematic errors of a robot's readings, to be subtracted from them."""

    scale: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """Distance by odometry divided by the true distance."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Bias of the turn rate of odometry while the robot moves, left positive [deg/s]."""
    delay: Annotated[float, Field(ge=-5, le=5)] = 0.0
    """Delay of the robot's motion relative to odometry [s]."""
    range: Annotated[float, Field(ge=-100, le=100)] = 0.0
    """Measured minus true [m]."""
    bearing_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    """Measured minus true, left positive."""

    def corrected_motion(self, step: Odometry, seconds: float) -> Odometry:
        """Return a step of some duration [s] without the errors of odometry; a standing robot does not turn."""
        if not (step.forward or step.left or step.turn):
            return step
        turn = step.turn - math.radians(self.turn_deg) * seconds
        return replace(step, forward=step.forward / self.scale, left=step.left / self.scale, turn=turn)

    def corrected_times(self, rows: Array) -> Array:
        """Return odometry whose rows (n, k) begin with their times [s], shifted by the delay."""
        return rows + np.array([self.delay] + [0.0] * (rows.shape[1] - 1)) if self.delay else rows

    def corrected_sighting(self, seen: Sighting) -> Sighting:
        """Return a sighting without the errors of range and bearing."""
        away, bearing = max(seen.range - self.range, MIN_RANGE), seen.bearing - math.radians(self.bearing_deg)
        return replace(seen, range=away, bearing=math.remainder(bearing, 2.0 * math.pi))


UNBIASED = Bias()


class MeasuredErrors(Model):
    """The results of `mjsim calibrate` for a log."""

    noise: MeasuredNoise = MeasuredNoise()
    bias: Bias = UNBIASED


def read_noise(path: str | Path) -> MeasuredErrors:
    """Read noise and bias from a file written by `mjsim calibrate -o`.

    Raises:
        WorldError: It is wrong (the message has line and column).
        UsageError: It cannot be read.
    """
    return read_described(Path(path), MeasuredErrors, what="a file written by `mjsim calibrate -o`")


def bias_note(bias: Bias) -> Mapping[str, str]:
    """Return the entries of a recording's metadata about the subtracted bias; none without bias."""
    values = bias.model_dump(exclude_defaults=True)
    return {"bias taken away": ", ".join(f"{key} {value:g}" for key, value in values.items())} if values else {}
