"""All numbers of a recording by topic and field, and single ones over time."""

import json
import math
from collections.abc import Iterator
from typing import Any

from mjsim.record import Recording, raw_messages
from mjsim.web.run import plain

SAMPLED = 40
"""Number of messages at the start of a topic in which fields are searched."""
MAX_FIELDS = 4000
"""Maximum number of fields offered per recording."""
MAX_ROWS = 5000
"""Maximum number of rows returned per field; longer series are sampled evenly."""
LONGEST = 64
"""Entries of longer lists are not offered: they are data such as scans."""
DEEPEST = 6
_SKIPPED = {"timestamp", "time", "shown", "entities", "deletions"}


def fields_json(recording: Recording) -> list[tuple[str, str]]:
    """Return (topic, field) of each number in the recording, sorted by topic."""
    seen: dict[str, int] = {}
    found: dict[tuple[str, str], None] = {}
    for message in raw_messages(recording.path):
        seen[message.topic] = seen.get(message.topic, 0) + 1
        if seen[message.topic] > SAMPLED or not message.data.startswith(b"{") or len(found) >= MAX_FIELDS:
            continue
        found |= dict.fromkeys((message.topic, name) for name, _ in numbers_in(_content(message.data)))
    return sorted(found)[:MAX_FIELDS]


def column_json(recording: Recording, topic: str, field: str) -> dict[str, list[float | None]]:
    """Return a field over time: `time` [s] and `values`, None where not finite."""
    time, values = [], []
    for message in raw_messages(recording.path, topics={topic}):
        for name, value in numbers_in(_content(message.data) if message.data.startswith(b"{") else {}):
            if name == field:
                time.append(message.time / 1e9)
                values.append(value)
    keep = slice(None, None, max(1, math.ceil(len(time) / MAX_ROWS)))
    return {"time": plain(time[keep], 6), "values": plain(values[keep], 9)}


def numbers_in(value: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, float]]:
    """Yield name and value of each number in a message: keys joined by dots, list indices in brackets."""
    if isinstance(value, bool | int | float):
        yield name, float(value)
    elif depth >= DEEPEST:
        return
    elif isinstance(value, dict):
        for key, item in value.items():
            if key not in _SKIPPED:
                yield from numbers_in(item, f"{name}.{key}" if name else key, depth + 1)
    elif isinstance(value, list) and len(value) <= LONGEST:
        for k, item in enumerate(value):
            # Beacons, joints and parts of the loop are identified by name, which stays the same when their index
            # changes.
            called = item.get("name", item.get("part")) if isinstance(item, dict) else None
            yield from numbers_in(item, f"{name}[{called if isinstance(called, str) else k}]", depth + 1)


def _content(data: bytes) -> Any:
    try:
        return json.loads(data)
    except (ValueError, RecursionError):
        return None
