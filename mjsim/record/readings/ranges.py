"""Ranges from tags to radio anchors."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from mjsim.interface import AnchorRanges, Observation, RobotInfo
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, flat
from mjsim.record.readings.codec import Box, Codec, SensorTable, by_name
from mjsim.world import World, sensors


def _messages(readings: Mapping[str, AnchorRanges]) -> list[Message]:
    return [
        {
            "name": name,
            "stamp": float(reading.stamp),
            "anchors": list(reading.ranges),
            "ranges": flat([*reading.ranges.values()]),
            "variance": float(reading.variance),
        }
        for name, reading in readings.items()
    ]


def _readings(messages: Sequence[Message]) -> dict[str, AnchorRanges]:
    return {
        item["name"]: AnchorRanges(
            item["stamp"], dict(zip(item["anchors"], item["ranges"], strict=True)), item["variance"]
        )
        for item in messages
    }


def _tables(given: Sequence[tuple[float, Mapping[str, AnchorRanges]]]) -> Iterator[SensorTable]:
    for name, times, readings in by_name(given):
        anchors = list(dict.fromkeys(anchor for reading in readings for anchor in reading.ranges))
        ranges = [[reading.ranges.get(anchor) for anchor in anchors] for reading in readings]
        arrays = {
            **times,
            "ranges": np.array(ranges, dtype=float).reshape(len(readings), len(anchors)),
            "anchors": np.array(anchors, dtype=np.str_),
        }
        columns = {
            **{when: column.tolist() for when, column in times.items()},
            **{f"range_{anchor}": [row[column] for row in ranges] for column, anchor in enumerate(anchors)},
        }
        yield SensorTable(name=f"ranges_{name}", columns=columns, arrays=arrays)


def _boxes(uwb: sensors.Uwb, info: RobotInfo, world: World) -> Mapping[str, Box]:
    anchors = [beacon.name for beacon in world.beacons if beacon.anchor and beacon.on != info.name]
    farthest = uwb.range[1]

    def read(seen: Observation) -> ArrayLike | None:
        reading = seen.ranges.get(uwb.uwb)
        return None if reading is None else [reading.ranges.get(anchor, farthest) for anchor in anchors]

    return {"": Box(read=read, low=0.0, high=farthest, shape=(len(anchors),), first=farthest)}


RANGES = Codec(
    field="ranges",
    schema=schema.readings(
        "To radio anchors, where due",
        {
            "anchors": schema.listed({"type": "string"}, "Names of those heard"),
            "ranges": schema.numbers("Distance in space to each of them [m]"),
            "variance": schema.number("Of each range in line of sight [m^2]"),
        },
    ),
    encode=_messages,
    decode=_readings,
    sparse=True,
    sensor="uwb",
    tables=_tables,
    boxes=_boxes,
)
