"""Options of an import."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from mjsim.logs.resampling.noise_file import UNBIASED, Bias, read_noise
from mjsim.logs.resampling.resample import MotionNoise


@dataclass(frozen=True, slots=True, kw_only=True)
class Wishes:
    """Options of an import; those that a log does not support are refused."""

    rate_hz: float | None = None
    """Ticks per second; by default chosen for the log."""
    begin: float = 0.0
    """Time to skip at the beginning [s]."""
    seconds: float | None = None
    """Duration to import [s]; by default all."""
    robots: Sequence[str] = ()
    """Robots to import from a log with several, by number or name; by default all."""
    topics: Mapping[str, Sequence[str]] = field(default_factory=dict)
    """For a bag: kind of data, such as 'odometry' or 'scan' -> topics to read."""
    deskew: bool = False
    """For a bag: whether beams are moved, by odometry, to where the lidar was at the last one of their scan."""
    known_map: bool = False
    """Whether modules get the positions of landmarks."""
    motion: Mapping[str, float] = field(default_factory=dict)
    """Fields of `MotionNoise` that replace the defaults of the log's format."""
    range_noise: float | None = None
    """Standard deviation of a sighting's range [m]."""
    bearing_noise: float | None = None
    """Standard deviation of a sighting's bearing [rad]."""
    bias: Bias = UNBIASED
    """Systematic errors that are subtracted from odometry and sightings."""

    def measured_by(self, path: str | Path) -> "Wishes":
        """Return these options with noise and bias from a file of `mjsim calibrate -o`; noise set here has priority.

        Raises:
            WorldError: The file is wrong (the message has line and column), or cannot be read.
        """
        errors = read_noise(path)
        return replace(
            self,
            motion={**errors.noise.motion(), **self.motion},
            range_noise=errors.noise.range if self.range_noise is None else self.range_noise,
            bearing_noise=errors.noise.bearing() if self.bearing_noise is None else self.bearing_noise,
            bias=errors.bias,
        )

    def motion_over(self, noise: MotionNoise) -> MotionNoise:
        """Return noise with the requested values replaced."""
        return replace(noise, **self.motion)

    def sighting_over(self, range_deviation: float, bearing_deviation: float) -> tuple[float, float]:
        """Return the standard deviations of a sighting with the requested values replaced [m, rad]."""
        return (
            range_deviation if self.range_noise is None else self.range_noise,
            bearing_deviation if self.bearing_noise is None else self.bearing_noise,
        )
