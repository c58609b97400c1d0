"""Sensor readings of a mechanism at one time."""

from dataclasses import dataclass

from mjsim.geometry import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorReadings:
    """Values with names and units; each array has shape (numbers,)."""

    names: tuple[str, ...]
    """Such as 'q4.velocity', 'q5.force.x', 'energy.kinetic'."""
    units: tuple[str, ...]
    """Such as 'rad/s'."""
    values: Array
