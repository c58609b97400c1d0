"""Derives the codec of a kind of reading from its declared forms: JSON, a table for each sensor, and arrays."""

from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import Form, FormField, Observation, ReadingType, RobotInfo, all_fields, form_fields
from mjsim.record.readings.codec import Box, Codec, Given, SensorTable, by_name
from mjsim.record.readings.reading_json import wire_of
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
