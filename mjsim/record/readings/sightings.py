"""Sightings of beacons, and their true beacons."""

import sys
from collections.abc import Sequence

from mjsim.interface import Sighting
from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message, flat, number, numbers
from mjsim.record.readings.codec import Codec, Topic
from mjsim.record.tick import Tick


def sighting_messages(sightings: Sequence[Sighting]) -> list[Message]:
    """Return all numbers of sightings."""
    return [_message(sighting) for sighting in sightings]


def _message(sighting: Sighting) -> Message:
    message = {
        "stamp": float(sighting.stamp),
        "range": float(sighting.range),
        "bearing": float(sighting.bearing),
        "covariance": flat(sighting.covariance),
    }
    if sighting.name is not None:
        message["name"] = sighting.name
    if sighting.corners is not None:
        message["corners"] = flat(sighting.corners)
    return message


def sightings_of(messages: Sequence[Message]) -> tuple[Sighting, ...]:
    """Return the sightings in messages."""
    return tuple(
        Sighting(
            stamp=item["stamp"],
            name=sys.intern(item["name"]) if item.get("name") is not None else None,
            range=number(item["range"]),
            bearing=item["bearing"],
            covariance=numbers(item["covariance"], 2, 2),
            corners=numbers(item["corners"], -1, 2) if "corners" in item else None,
        )
        for item in messages
    )


def _identities_message(tick: Tick, robot: str) -> Message | None:
    """Return the true beacon of each sighting of the sensors, an empty name for a false sighting."""
    identities = tick.identities.get(robot)
    return {"time": tick.time, "names": [name or "" for name in identities]} if identities else None


def identities_of(message: Message) -> tuple[str | None, ...]:
    """Return the true beacons in a message, None for a false sighting."""
    return tuple(name or None for name in message["names"])


SIGHTINGS_SCHEMA = schema.listed(
    schema.keyed(
        {
            "stamp": schema.number("[s]"),
            "name": schema.text("Left out when the sensor cannot tell"),
            "range": schema.number("Horizontal, from the robot's origin [m]"),
            "bearing": schema.number("From the robot's x axis, left positive [rad]"),
            "covariance": schema.numbers("Of (range, bearing), 2 x 2", count=4),
            "corners": schema.numbers(
                "u, v of 4 corners from the picture's own top left clockwise [px]; left out without"
            ),
        },
        optional=("name", "corners"),
    ),
    "Beacons seen",
)
SIGHTINGS = Codec(
    field="sightings",
    schema=SIGHTINGS_SCHEMA,
    encode=sighting_messages,
    decode=sightings_of,
    sensor="beacons",
    topic=Topic(
        name="identities",
        schema=schema.topic(
            "mjsim.Identities",
            "Which beacons the sensors truly saw; no module is told.",
            {
                "names": schema.listed(
                    {"type": "string"}, "Of each of the first sightings of the tick; empty for one of nothing"
                )
            },
        ),
        message=_identities_message,
    ),
)
