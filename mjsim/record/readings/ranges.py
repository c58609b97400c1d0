"""Ranges from tags to radio anchors."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mjsim.interface import Observation, RobotInfo
from mjsim.record.readings.codec import Box, Given, SensorTable, by_name
from mjsim.record.readings.derived import derived
from mjsim.world import World, sensors


def _tables(given: Given) -> Iterator[SensorTable]:
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


RANGES = replace(derived("ranges"), tables=_tables, boxes=_boxes)
