"""Scans and inertial readings to JSON messages and back, exactly; many numbers at once stand as base64."""

import base64
import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array
from mjsim.interface import ImuReading, Scan
from mjsim.interface import Message as RadioMessage

Message = dict[str, Any]


def packed(values: ArrayLike) -> str:
    """Return numbers as base64 of little-endian doubles, row by row."""
    return base64.b64encode(np.asarray(values, dtype="<f8").tobytes()).decode()


def unpacked(text: str, *shape: int) -> Array:
    """Return the numbers of a text, shape (n,) unless given."""
    return np.frombuffer(base64.b64decode(text), dtype="<f8").reshape(shape or -1).astype(float)


def scan_messages(scans: Mapping[str, Scan]) -> list[Message]:
    """Return every number of some scans."""
    return [_scan_message(name, scan) for name, scan in scans.items()]


def _scan_message(name: str, scan: Scan) -> Message:
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


def scans_of(messages: Sequence[Message]) -> dict[str, Scan]:
    """Return the scans of some messages by name."""
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


def imu_messages(readings: Sequence[ImuReading]) -> list[Message]:
    """Return every number of some readings, a message for each sensor."""
    return [
        {"name": name, "readings": packed([(each.stamp, *each.acceleration, *each.turn) for each in group])}
        for name, group in itertools.groupby(readings, key=lambda each: each.name)
    ]


def imu_of(messages: Sequence[Message]) -> tuple[ImuReading, ...]:
    """Return the readings of some messages."""
    return tuple(
        ImuReading(float(row[0]), row[1:4], row[4:], item["name"])
        for item in messages
        for row in unpacked(item["readings"], -1, 7)
    )


def imu_topic_message(time: float, readings: Sequence[ImuReading]) -> Message:
    """Return the readings of a tick as people plot them."""
    return {
        "time": time,
        "readings": [
            {
                "name": each.name,
                "stamp": each.stamp,
                "acceleration": dict(zip("xyz", each.acceleration.tolist(), strict=True)),
                "turn": dict(zip("xyz", each.turn.tolist(), strict=True)),
            }
            for each in readings
        ],
    }


def heard_messages(heard: Sequence[RadioMessage]) -> list[Message]:
    """Return what the radio brought."""
    return [{"sender": each.sender, "stamp": float(each.stamp), "text": each.text} for each in heard]


def heard_of(messages: Sequence[Message]) -> tuple[RadioMessage, ...]:
    """Return what the radio brought, from some messages."""
    return tuple(RadioMessage(item["sender"], item["stamp"], item["text"]) for item in messages)


def identities_message(time: float, identities: Sequence[str | None]) -> Message:
    """Return which beacon each sighting of the sensors is of, an empty name for one of nothing."""
    return {"time": time, "names": [name or "" for name in identities]}


def identities_of(message: Message) -> tuple[str | None, ...]:
    """Return the beacons of a message, None for a sighting of nothing."""
    return tuple(name or None for name in message["names"])
