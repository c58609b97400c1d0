"""Scans of 2-D lidars."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
from foxglove.channels import LaserScanChannel
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import Observation, RobotInfo, Scan
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, packed, unpacked
from mjsim.record.readings.codec import Box, Codec, DrawnTopic, SensorTable, by_name
from mjsim.record.scene import laser_message
from mjsim.world import Lidar, World


def _messages(scans: Mapping[str, Scan]) -> list[Message]:
    return [_message(name, scan) for name, scan in scans.items()]


def _message(name: str, scan: Scan) -> Message:
    message: Message = {
        "name": name,
        "stamp": float(scan.stamp),
        "angle_min": float(scan.angle_min),
        "angle_increment": float(scan.angle_increment),
        "range_min": float(scan.range_min),
        "range_max": float(scan.range_max),
        "ranges": packed(scan.ranges),
    }
    if scan.intensities is not None:
        message["intensities"] = packed(scan.intensities)
    return message


def _scans(messages: Sequence[Message]) -> dict[str, Scan]:
    return {
        item["name"]: Scan(
            stamp=item["stamp"],
            ranges=unpacked(item["ranges"]),
            angle_min=item["angle_min"],
            angle_increment=item["angle_increment"],
            range_min=item["range_min"],
            range_max=item["range_max"],
            intensities=unpacked(item["intensities"]) if "intensities" in item else None,
        )
        for item in messages
    }


def _tables(given: Sequence[tuple[float, Mapping[str, Scan]]]) -> Iterator[SensorTable]:
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


SCANS = Codec(
    field="scans",
    schema=schema.readings(
        "Of lidars, where due",
        {
            "angle_min": schema.number("Of the first beam, left positive [rad]"),
            "angle_increment": schema.number("From beam to beam [rad]"),
            "range_min": schema.number("[m]"),
            "range_max": schema.number("[m]"),
            "ranges": schema.packed("one a beam [m]; infinite as ROS REP 117 has it"),
            "intensities": schema.packed("one a beam; left out unless the lidar tells"),
        },
        optional=("intensities",),
    ),
    encode=_messages,
    decode=_scans,
    optional=True,
    sensor="lidar",
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
