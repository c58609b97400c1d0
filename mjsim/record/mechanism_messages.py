"""Sensor readings of mechanisms: messages, and their rows in a recording."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.mechanics import SensorReadings
from mjsim.record.numbers import Message, flat
from mjsim.sentences import Sentence


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorTrack:
    """Recorded sensor readings of a mechanism. One row per tick, N in all; NaN where nothing was recorded."""

    names: tuple[str, ...]
    """Names of n values, such as 'q4.velocity'."""
    units: tuple[str, ...]
    """Their units, such as 'rad/s'."""
    values: Array
    """Shape (N, n)."""

    def at(self, rows: NDArray[np.intp]) -> "SensorTrack":
        """Return the track at some rows."""
        return SensorTrack(names=self.names, units=self.units, values=self.values[rows])

    def column(self, name: str) -> Array:
        """Return the values of one name, shape (N,); raises ValueError for an unknown name."""
        return np.asarray(self.values[:, self.names.index(name)])


def sensor_messages(time: float, readings: Mapping[str, SensorReadings]) -> list[tuple[str, Message]]:
    """Return the topics and messages of the sensors of all mechanisms at a tick, by the mechanism's name."""
    return [
        (
            f"/{name}/sensors",
            {"time": time, "names": list(read.names), "units": list(read.units), "values": flat(read.values)},
        )
        for name, read in readings.items()
    ]


class SensorRows:
    """Collects the sensor rows of one mechanism while a recording is read."""

    def __init__(self) -> None:
        """Start with no rows; the first message gives names and units."""
        self._names: tuple[str, ...] | None = None
        self._units: tuple[str, ...] = ()
        self._rows: list[list[float] | None] = []
        self._now: list[float] | None = None

    @property
    def width(self) -> int:
        """Numbers in a row."""
        return len(self._names or ())

    def take(self, message: Message) -> None:
        """Take a message; raises ValueError if its sensors differ from those of the previous one."""
        names, units, values = tuple(message["names"]), tuple(message["units"]), message["values"]
        if self._names is None:
            self._names, self._units = names, units
        if names != self._names or not len(names) == len(units) == len(values):
            raise ValueError(Sentence("the mechanism has {width} sensed numbers", self.width))
        self._now = list(values)

    def end_tick(self) -> None:
        """Add a row; NaN for missing messages."""
        self._rows.append(self._now)
        self._now = None

    def track(self) -> SensorTrack:
        """Return everything as arrays."""
        nothing = [np.nan] * self.width
        values = np.array([nothing if row is None else row for row in self._rows], dtype=float)
        return SensorTrack(
            names=self._names or (), units=self._units, values=values.reshape(len(self._rows), self.width)
        )
