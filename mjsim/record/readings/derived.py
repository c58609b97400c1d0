"""Derives the codec of a kind of reading from the forms beside its fields: JSON, its schema, tables and arrays.

Encoders copy every number out of the arrays, so that a module that changes its arrays later does not change the
recording.
"""

import itertools
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import (
    Form,
    FormField,
    Observation,
    ReadingType,
    RobotInfo,
    all_fields,
    batch_rows,
    form_fields,
    width_of,
)
from mjsim.record import json_schema as schema
from mjsim.record.json_schema import Schema
from mjsim.record.numbers import Message, distances, flat, number, numbers, packed, unpacked
from mjsim.record.readings.codec import Box, Codec, Given, SensorTable, by_name
from mjsim.world import SENSOR_KINDS, AnySensor, World, name_of

REQUIRED_KEYS = ("odometry", "sightings", "proximity", "bump", "cameras")
"""Keys of every observation in a recording, first."""
WRITTEN = (*REQUIRED_KEYS, "scans", "imu", "messages")
"""Keys that are written even without readings; the oldest recordings lack the last of them."""
ORDER = (*WRITTEN, "encoders", "ranges")
"""Keys in the order of recordings; all others follow in that of `Observation`."""


def derived(field: str) -> Codec:
    """Return the codec of a field of `Observation`."""
    part, form = next(each for each in form_fields(Observation) if each[0].name == field)
    kind, wire = part.item, wire_of(part, form)
    sensor = next((each for each, model in SENSOR_KINDS.items() if model.reading == field), None)
    is_read = not part.has_readings or all(each.form or not each.is_required for each in all_fields(kind))
    has_names = is_read and (part.is_mapping or part.is_batch)
    return Codec(
        field=field,
        schema=wire.schema,
        encode=wire.encode,
        decode=wire.decode,
        is_read=is_read,
        optional=field not in REQUIRED_KEYS,
        sparse=field not in WRITTEN,
        sensor=sensor,
        tables=partial(_tables, sensor, kind) if sensor is not None and has_names else None,
        boxes=partial(_boxes, part) if has_names and any(inner.bounds for _, inner in form_fields(kind)) else None,
    )


def _tables(word: str, kind: ReadingType, given: Given) -> Iterator[SensorTable]:
    """Yield the table of each sensor: a column for each number of a reading."""
    for name, times, readings in by_name(given):
        arrays: dict[str, Array] = dict(times)
        columns: dict[str, Iterable[Any]] = {when: column.tolist() for when, column in times.items()}
        for part, form in form_fields(kind):
            if part.name in times:
                continue
            if form.is_fixed:
                arrays[part.name] = np.array(getattr(readings[0], part.name))
            else:
                arrays[part.name] = np.array([getattr(each, part.name) for each in readings])
                columns |= _columns(part, form, arrays[part.name])
        yield SensorTable(name=f"{word}_{name}", columns=columns, arrays=arrays)


def _columns(part: FormField, form: Form, values: Array) -> dict[str, Iterable[Any]]:
    """Return the columns of a field: one, one for each axis of a vector, or one for each of its items."""
    if values.ndim == 1:
        return {part.name: values.tolist()}
    axes = "xyz" if form.shape == (3,) else range(values.shape[1])
    word = part.name.removesuffix("s")
    return {f"{word}_{axis}": column for axis, column in zip(axes, values.T.tolist(), strict=True)}


def _boxes(part: FormField, sensor: AnySensor, info: RobotInfo, world: World) -> Mapping[str, Box]:
    """Return one array of all numbers with declared bounds."""
    bounds = {each.name: form.bounds for each, form in form_fields(part.item) if form.bounds is not None}
    low, high = zip(*bounds.values(), strict=True)

    def read(seen: Observation) -> ArrayLike | None:
        reading = getattr(seen, part.name).get(name_of(sensor))
        return None if reading is None else [getattr(reading, name) for name in bounds]

    return {"": Box(read=read, low=low, high=high, shape=(len(bounds),))}


KINDS = {"<f8": "doubles", "<f4": "singles", "<u2": "16-bit whole numbers"}
"""NumPy type of packed numbers -> its name in schemas."""


@dataclass(frozen=True, slots=True)
class Wire:
    """The JSON form of a value."""

    schema: Schema
    encode: Callable[[Any], Any]
    """Value -> JSON."""
    decode: Callable[[Any], Any]
    """JSON -> value."""


def wire_of(part: FormField, form: Form) -> Wire:
    """Return the JSON form of a field of an observation."""
    if not part.has_readings:
        return _plain(part, form)
    if part.is_batch:
        return _batch(part.item, form)
    reading = _reading(part.item)
    if part.is_mapping:
        return _by_sensor(reading, form)
    if part.is_tuple:
        return Wire(
            schema.listed(reading.schema, form.about),
            lambda readings: [reading.encode(each) for each in readings],
            lambda messages: tuple(reading.decode(each) for each in messages),
        )
    return Wire(reading.schema | {"description": form.about}, reading.encode, reading.decode)


def _by_sensor(reading: Wire, form: Form) -> Wire:
    """Return the form of readings by sensor: a list in which each has the name of its sensor."""
    named = {"name": schema.text("Of the sensor")} | reading.schema["properties"]
    required = ["name", *reading.schema["required"]]
    return Wire(
        schema.listed(reading.schema | {"properties": named, "required": required}, form.about),
        lambda readings: [{"name": name} | reading.encode(each) for name, each in readings.items()],
        lambda messages: {each["name"]: reading.decode(each) for each in messages},
    )


def _batch(kind: ReadingType, form: Form) -> Wire:
    """Return the form of batches of readings: for each sensor its name and packed rows of all numbers."""
    parts = form_fields(kind)
    widths = [width_of(part, each) for part, each in parts]
    columns = [slice(end - width, end) for end, width in zip(itertools.accumulate(widths), widths, strict=True)]
    words = [f"{part.name} x y z" if width == 3 else part.name for (part, _), width in zip(parts, widths, strict=True)]

    def value(row: Any, part: FormField, column: slice) -> Any:
        return float(row[column.start]) if part.kind is float else row[column]

    def decode(messages: Any) -> tuple[Any, ...]:
        return tuple(
            kind(
                **{part.name: value(row, part, column) for (part, _), column in zip(parts, columns, strict=True)},
                name=each["name"],
            )
            for each in messages
            for row in unpacked(each["readings"], -1, sum(widths))
        )

    item = schema.keyed({"name": schema.text("Of the sensor"), "readings": schema.packed(", ".join(words))})
    return Wire(
        schema.listed(item, form.about),
        lambda readings: [
            {"name": name, "readings": packed(batch_rows(kind, [*group]))}
            for name, group in itertools.groupby(readings, key=lambda each: each.name)
        ],
        decode,
    )


@dataclass(frozen=True, slots=True)
class _Key:
    """A key in the message of a reading."""

    key: str
    field: str
    """The field of the reading that it holds."""
    wire: Wire
    is_optional: bool
    """Whether it is left out where the field is None."""


@cache
def _reading(kind: ReadingType) -> Wire:
    """Return the form of a reading: packed numbers come last, and in messages the optional keys."""
    parts = sorted(form_fields(kind), key=lambda each: bool(each[1].packed))
    keys = [key for part, form in parts for key in _keys(part, form)]
    written = [(each.key, each.field, each.wire.encode) for each in sorted(keys, key=lambda each: each.is_optional)]
    takes = {part.name: _taker(part, form) for part, form in parts}

    def encode(reading: Any) -> Message:
        return {key: put(value) for key, field, put in written if (value := getattr(reading, field)) is not None}

    def decode(message: Message) -> Any:
        return kind(**{field: take(message) for field, take in takes.items()})

    optional = [each.key for each in keys if each.is_optional]
    return Wire(schema.keyed({each.key: each.wire.schema for each in keys}, optional=optional), encode, decode)


def _keys(part: FormField, form: Form) -> list[_Key]:
    """Return the keys of a field."""
    if not part.is_mapping:
        return [_Key(part.name, part.name, _plain(part, form), part.is_optional)]
    names = Wire(schema.listed({"type": "string"}, "Names of those heard"), list, list)
    values = Wire(schema.numbers(form.about), lambda numbers: flat([*numbers.values()]), list)
    return [_Key(form.names, part.name, names, False), _Key(part.name, part.name, values, False)]


def _taker(part: FormField, form: Form) -> Callable[[Message], Any]:
    """Return a function that reads a field from a message."""
    if part.is_mapping:
        return lambda message: dict(zip(message[form.names], message[part.name], strict=True))
    decode = _plain(part, form).decode
    if part.is_optional:
        return lambda message: decode(message[part.name]) if part.name in message else None
    return lambda message: decode(message[part.name])


def _plain(part: FormField, form: Form) -> Wire:
    """Return the form of a number, a text, or numbers in a row or an array."""
    about, count = form.about, None if -1 in form.shape else math.prod(form.shape)
    if form.packed:
        kind = form.packed
        return Wire(
            schema.packed(about, KINDS[kind]),
            partial(packed, kind=kind),
            lambda text: unpacked(text, *form.shape, kind=kind),
        )
    if form.is_distance:
        return Wire(schema.distances(about), distances, numbers)
    if part.kind in _PLAIN:
        return _PLAIN[part.kind](about)
    return Wire(schema.numbers(about, count=count), flat, lambda values: numbers(values, *form.shape))


_PLAIN: Mapping[Any, Callable[[str], Wire]] = {
    float: lambda about: Wire(schema.number(about), float, number),
    int: lambda about: Wire(schema.integer(about), int, int),
    str: lambda about: Wire(schema.text(about), str, sys.intern),
    tuple[int, ...]: lambda about: Wire(
        schema.listed({"type": "integer"}, about), lambda values: [*map(int, values)], tuple
    ),
    tuple[float, ...]: lambda about: Wire(schema.numbers(about), flat, tuple),
}
