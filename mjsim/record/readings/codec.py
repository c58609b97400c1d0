"""How one kind of reading is recorded, read back, exported and told in arrays: each kind has a `Codec`."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from foxglove import Context
from numpy.typing import ArrayLike, DTypeLike

from mjsim.geometry import Array
from mjsim.interface import Observation, RobotInfo, SensorInfo
from mjsim.record.json_schema import Schema
from mjsim.record.numbers import Message
from mjsim.record.tick import Tick
from mjsim.world import World


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A topic beside the observation, for people who plot, or for what no module is told."""

    name: str
    """The topic of robot R is '/R/NAME'."""
    schema: Schema
    message: Callable[[Tick, str], Message | None]
    """Tick and robot -> message; None for no message at this tick."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadingTopic:
    """A topic of each sensor with a message for each reading, as programs of others plot them."""

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
    """Writes what stands once at the start: context, name of the sensor's frame, data sheet."""
    is_picture: bool = False
    """Whether it can be drawn again from the states, so that a recording may do without."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorTable:
    """All readings of one sensor, as files of tables and of arrays have them."""

    name: str
    """'imu_NAME' and so on."""
    columns: Mapping[str, Iterable[Any]]
    """Header -> one value a row, for CSV."""
    arrays: Mapping[str, Array]
    """Name -> one row a reading, for NumPy and MATLAB."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Box:
    """An array of fixed shape and bounds that tells of a sensor, for learning."""

    read: Callable[[Observation], ArrayLike | None]
    """Observation -> array; None when there is no reading at this tick."""
    low: ArrayLike
    """What is smaller is given as this; broadcast to the shape."""
    high: ArrayLike
    """What is larger is given as this."""
    shape: tuple[int, ...]
    dtype: DTypeLike = np.float32
    first: float = 0.0
    """What fills it before the first reading."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Codec:
    """How one field of `Observation` is recorded: to JSON and back exactly, and what else is made of it.

    What makes a message copies every number out of its arrays, so that a module that changes its arrays later does not
    change what was recorded.
    """

    field: str
    """Of `Observation`; the same key in `/R/observation`."""
    schema: Schema
    encode: Callable[[Any], Any]
    """Value of the field -> JSON."""
    decode: Callable[[Any], Any] | None = None
    """JSON -> value of the field; None for what is not read back."""
    optional: bool = False
    """Whether recordings that were made earlier may lack it."""
    sparse: bool = False
    """Whether it is left out of an observation that has none; then it is optional too."""
    sensor: str | None = None
    """The kind of sensor whose readings these are."""
    topic: Topic | None = None
    stream: ReadingTopic | None = None
    drawings: tuple[DrawnTopic, ...] = ()
    tables: Callable[[Sequence[tuple[float, Any]]], Iterable[SensorTable]] | None = None
    """When modules were given a value [s], and the value, of all ticks that have one -> a table for each sensor."""
    boxes: Callable[[Any, RobotInfo, World], Mapping[str, Box]] | None = None
    """Sensor as the world has it, data sheet of its robot, and world -> arrays by what follows the sensor's name in
    theirs; None where one array tells of all such sensors at once."""


def by_name(given: Sequence[tuple[float, Mapping[str, Any]]]) -> Iterator[tuple[str, dict[str, Array], list[Any]]]:
    """Yield of each sensor its name, when readings were given and taken (`time`, `stamp`) [s], and the readings.

    Args:
        given: When modules were given readings [s], and those by the names of their sensors.
    """
    for name in dict.fromkeys(name for _, readings in given for name in readings):
        rows = [(time, readings[name]) for time, readings in given if name in readings]
        times = {"time": np.array([time for time, _ in rows]), "stamp": np.array([each.stamp for _, each in rows])}
        yield name, times, [each for _, each in rows]


def axes(name: str, values: Array) -> dict[str, list[float]]:
    """Return columns `name_x`, `name_y` and `name_z` of rows of vectors, shape (n, 3)."""
    return {f"{name}_{axis}": column for axis, column in zip("xyz", values.T.tolist(), strict=True)}
