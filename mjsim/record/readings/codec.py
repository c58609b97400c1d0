"""How one kind of reading is recorded, read back, exported and converted to arrays: each kind has a `Codec`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from foxglove import Context
from numpy.typing import ArrayLike, DTypeLike

from mjsim.geometry import Array
from mjsim.interface import Observation, RobotInfo, SensorInfo, named
from mjsim.record.json_schema import Schema
from mjsim.record.numbers import Message
from mjsim.record.tick import Tick
from mjsim.world import World

Given = Sequence[tuple[float, Any]]
"""Times at which modules received readings [s], and the readings, for all ticks with any."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A topic beside the observation, for plots, or for data that modules do not get."""

    name: str
    """The topic of robot R is '/R/NAME'."""
    schema: Schema
    message: Callable[[Tick, str], Message | None]
    """Tick and robot -> message; None for no message at this tick."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadingTopic:
    """A topic of each sensor with a message per reading, for plots in other programs."""

    name: str
    """The topic of sensor S of robot R is '/R/S/NAME'."""
    schema: Schema
    messages: Callable[[str, Any], Iterable[tuple[str, Message]]]
    """Robot and value of the field -> topic and message of each reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawnTopic:
    """Messages in a format that Foxglove draws, one for each reading of a sensor."""

    topic: Callable[[str, str], str]
    """Robot and sensor -> topic."""
    channel: Callable[..., Any]
    """A channel of `foxglove.channels`."""
    message: Callable[[Any, str], Any]
    """Reading and name of the sensor's frame -> message of `foxglove.messages`, or None for none; called in the
    writer's thread."""
    begin: Callable[[Context, str, SensorInfo], None] = lambda context, frame, info: None
    """Writes the message at the start of the topic, from context, name of the sensor's frame and data sheet."""
    is_picture: bool = False
    """Whether it can be rendered again from the states, so that a recording may omit it."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorTable:
    """All readings of one sensor, for exports to tables and arrays."""

    name: str
    """'imu_NAME' and so on."""
    columns: Mapping[str, Iterable[Any]]
    """Header -> one value per row, for CSV."""
    arrays: Mapping[str, Array]
    """Name -> one row per reading, for NumPy and MATLAB."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Box:
    """An array of fixed shape and bounds with the readings of a sensor, for learning."""

    read: Callable[[Observation], ArrayLike | None]
    """Observation -> array; None if there is no reading at this tick."""
    low: ArrayLike
    """Lower bound, to which values are clipped; broadcast to the shape."""
    high: ArrayLike
    """Upper bound, to which values are clipped."""
    shape: tuple[int, ...]
    dtype: DTypeLike = np.float32
    first: float = 0.0
    """Value before the first reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Codec:
    """How one field of `Observation` is recorded (to JSON and back, exactly), exported and shown; see `derived`."""

    field: str
    """Name of the field of `Observation`, and its key in `/R/observation`."""
    schema: Schema
    encode: Callable[[Any], Any]
    """Value of the field -> JSON."""
    decode: Callable[[Any], Any]
    """JSON -> value of the field."""
    is_read: bool
    """Whether it is read back; pictures, which are stored beside the observation, are not."""
    optional: bool
    """Whether recordings may lack it."""
    sparse: bool
    """Whether it is left out of an observation without readings."""
    sensor: str | None
    """The kind of sensor whose readings these are."""
    topic: Topic | None = None
    stream: ReadingTopic | None = None
    drawings: tuple[DrawnTopic, ...] = ()
    tables: Callable[[Given], Iterable[SensorTable]] | None = None
    """Readings of a robot -> a table for each sensor."""
    boxes: Callable[[Any, RobotInfo, World], Mapping[str, Box]] | None = None
    """Sensor in the world file, data sheet of its robot, and world -> arrays by the suffix that follows the sensor's
    name; None if one array covers all such sensors."""


def by_name(given: Given) -> Iterator[tuple[str, dict[str, Array], list[Any]]]:
    """Yield for each sensor its name, times of receiving and taking its readings (`time`, `stamp`) [s], and these."""
    found: dict[str, list[tuple[float, Any]]] = {}
    for time, readings in given:
        for name, reading in named(readings):
            found.setdefault(name, []).append((time, reading))
    for name, rows in found.items():
        times = {"time": np.array([time for time, _ in rows]), "stamp": np.array([each.stamp for _, each in rows])}
        yield name, times, [each for _, each in rows]
