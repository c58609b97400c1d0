"""Scans of 2-D lidars."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from foxglove.channels import LaserScanChannel
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import Observation, RobotInfo, Scan
from mjsim.record.drawn import laser_message
from mjsim.record.readings.codec import Box, DrawnTopic, Given, SensorTable, by_name
from mjsim.record.readings.derived import derived
from mjsim.world import Lidar, World


def _tables(given: Given) -> Iterator[SensorTable]:
    for name, times, scans in by_name(given):
        yield _table(name, times, scans)


def _table(name: str, times: Mapping[str, Array], scans: Sequence[Scan]) -> SensorTable:
    first = scans[0]
    arrays = {
        **times,
        "ranges": np.array([scan.ranges for scan in scans]),
        "angles": first.angles(),
    }
    if first.intensities is not None:
        arrays["intensities"] = np.array([scan.intensities for scan in scans], dtype=float)
    columns = {
        **{when: column.tolist() for when, column in times.items()},
        "angle_min": [scan.angle_min for scan in scans],
        "angle_increment": [scan.angle_increment for scan in scans],
        **{f"range_{beam}": column for beam, column in enumerate(arrays["ranges"].T.tolist())},
    }
    return SensorTable(name=f"scan_{name}", columns=columns, arrays=arrays)


def _boxes(lidar: Lidar, info: RobotInfo, world: World) -> Mapping[str, Box]:
    farthest = lidar.range[1]

    def read(seen: Observation) -> ArrayLike | None:
        scan = seen.scans.get(lidar.lidar)
        return None if scan is None else scan.ranges

    return {"": Box(read=read, low=0.0, high=farthest, shape=(lidar.beams,), first=farthest)}


SCANS = replace(
    derived("scans"),
    drawings=(
        DrawnTopic(
            topic=lambda robot, lidar: f"/{robot}/scan",
            channel=LaserScanChannel,
            message=laser_message,
        ),
    ),
    tables=_tables,
    boxes=_boxes,
)
