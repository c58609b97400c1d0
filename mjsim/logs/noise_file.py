"""The file of noise and bias that `mjsim calibrate -o` writes, and what an import makes of it.

    noise: {distance: 0.05, turn: 0.1, range: 0.03, bearing_deg: 1.5}
    bias: {scale: 1.08, turn_deg: 0.2, delay: 0.16, range: 0.09, bearing_deg: -0.2}

Every key may be missing: noise is then that of the log's kind, and there is no bias.
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

NEAREST = 1e-3
"""No sighting is nearer once a bias is taken away [m]."""

Deviation = Annotated[float, Field(ge=0, le=10)]


class MeasuredNoise(Model):
    """Standard deviations; those that are missing are the log kind's."""

    distance: Deviation | None = None
    """Of odometry's way [m/sqrt(m)]."""
    turn: Deviation | None = None
    """Of its turn [rad/sqrt(rad)]."""
    veer: Deviation | None = None
    """Of its heading, for each metre [rad/sqrt(m)]."""
    range: Annotated[float, Field(gt=0, le=100)] | None = None
    """Of a sighting [m]."""
    bearing_deg: Annotated[float, Field(gt=0, le=180)] | None = None
    """Of a sighting."""

    def motion(self) -> dict[str, float]:
        """Return the noise of odometry that was measured, by the fields of `MotionNoise`."""
        told = {"distance": self.distance, "turn": self.turn, "veer": self.veer}
        return {key: value for key, value in told.items() if value is not None}

    def bearing(self) -> float | None:
        """Return the standard deviation of a sighting's bearing [rad]."""
        return None if self.bearing_deg is None else math.radians(self.bearing_deg)


class Bias(Model):
    """Systematic errors of a robot's readings, which are taken away from them."""

    scale: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """Way by odometry over the true way."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """How much too far to the left odometry turns while the robot moves [deg/s]."""
    delay: Annotated[float, Field(ge=-5, le=5)] = 0.0
    """How much later the robot moves than odometry tells [s]."""
    range: Annotated[float, Field(ge=-100, le=100)] = 0.0
    """Told less true [m]."""
    bearing_deg: Annotated[float, Field(ge=-180, le=180)] = 0.0
    """Told less true, left positive."""

    def off_motion(self, step: Odometry, seconds: float) -> Odometry:
        """Return a step that took some time [s] without the errors of odometry; a robot that rests does not turn."""
        if not (step.forward or step.left or step.turn):
            return step
        turn = step.turn - math.radians(self.turn_deg) * seconds
        return replace(step, forward=step.forward / self.scale, left=step.left / self.scale, turn=turn)

    def off_times(self, rows: Array) -> Array:
        """Return odometry whose rows (n, k) begin with their times [s], moved to when the robot moved."""
        return rows + np.array([self.delay] + [0.0] * (rows.shape[1] - 1)) if self.delay else rows

    def off_sighting(self, seen: Sighting) -> Sighting:
        """Return a sighting without the errors of range and bearing."""
        away, bearing = max(seen.range - self.range, NEAREST), seen.bearing - math.radians(self.bearing_deg)
        return replace(seen, range=away, bearing=math.remainder(bearing, 2.0 * math.pi))


UNBIASED = Bias()


class MeasuredErrors(Model):
    """What `mjsim calibrate` measured of a log."""

    noise: MeasuredNoise = MeasuredNoise()
    bias: Bias = UNBIASED


def read_noise(path: str | Path) -> MeasuredErrors:
    """Return the noise and the bias of a file that `mjsim calibrate -o` wrote.

    Raises:
        WorldError: Something in it is wrong (names line and column).
        UsageError: It cannot be read.
    """
    return read_described(Path(path), MeasuredErrors)


def bias_note(bias: Bias) -> Mapping[str, str]:
    """Return what a recording's metadata says of the bias that was taken away; nothing where there is none."""
    told = bias.model_dump(exclude_defaults=True)
    return {"bias taken away": ", ".join(f"{key} {value:g}" for key, value in told.items())} if told else {}
