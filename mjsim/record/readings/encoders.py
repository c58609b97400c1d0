"""Counts of wheel encoders."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.interface import Observation, RobotInfo, WheelTicks
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message
from mjsim.record.readings.codec import Box, Codec, SensorTable, by_name
from mjsim.world import World, sensors


def _messages(readings: Mapping[str, WheelTicks]) -> list[Message]:
    return [
        {
            "name": name,
            "stamp": float(ticks.stamp),
            "counts": list(ticks.counts),
            "resolution": ticks.resolution,
            "bits": ticks.bits,
        }
        for name, ticks in readings.items()
    ]


def _readings(messages: Sequence[Message]) -> dict[str, WheelTicks]:
    return {
        item["name"]: WheelTicks(item["stamp"], tuple(item["counts"]), item["resolution"], item["bits"])
        for item in messages
    }


def _tables(given: Sequence[tuple[float, Mapping[str, WheelTicks]]]) -> Iterator[SensorTable]:
    for name, times, readings in by_name(given):
        counts = np.array([ticks.counts for ticks in readings], dtype=np.int64)
        arrays = {**times, "counts": counts, "resolution": np.array(readings[0].resolution)}
        columns = {
            **{when: column.tolist() for when, column in times.items()},
            **{f"count_{wheel}": column for wheel, column in enumerate(counts.T.tolist())},
        }
        yield SensorTable(name=f"encoders_{name}", columns=columns, arrays=arrays)


def _boxes(encoders: sensors.Encoders, info: RobotInfo, world: World) -> Mapping[str, Box]:
    half = 1 << (encoders.bits - 1)

    def read(seen: Observation) -> ArrayLike | None:
        ticks = seen.encoders.get(encoders.encoders)
        return None if ticks is None else ticks.counts

    return {"": Box(read=read, low=-half, high=half - 1, shape=(len(info.wheels),), dtype=np.int64)}


ENCODERS = Codec(
    field="encoders",
    schema=schema.readings(
        "Of wheel encoders, where due",
        {
            "counts": schema.listed({"type": "integer"}, "Steps of each driven wheel since the start"),
            "resolution": schema.integer("Steps in one turn of a wheel"),
            "bits": schema.integer("Width of the counters, which wrap around"),
        },
    ),
    encode=_messages,
    decode=_readings,
    sparse=True,
    sensor="encoders",
    tables=_tables,
    boxes=_boxes,
)
