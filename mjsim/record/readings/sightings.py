"""Sightings of beacons, and their true beacons."""

from dataclasses import replace

from mjsim.record import json_schema as schema
from mjsim.record.numbers import Message
from mjsim.record.readings.codec import Topic
from mjsim.record.readings.derived import derived
from mjsim.record.tick import Tick


def _identities_message(tick: Tick, robot: str) -> Message | None:
    """Return the true beacon of each sighting of the sensors, an empty name for a false sighting."""
    identities = tick.identities.get(robot)
    return {"time": tick.time, "names": [name or "" for name in identities]} if identities else None


def identities_of(message: Message) -> tuple[str | None, ...]:
    """Return the true beacons in a message, None for a false sighting."""
    return tuple(name or None for name in message["names"])


SIGHTINGS = replace(
    derived("sightings"),
    topic=Topic(
        name="identities",
        schema=schema.topic(
            "mjsim.Identities",
            "True beacon of each sighting; modules do not get this.",
            {
                "names": schema.listed(
                    {"type": "string"}, "Of each of the first sightings of the tick; empty for one of nothing"
                )
            },
        ),
        message=_identities_message,
    ),
)
