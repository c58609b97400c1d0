"""Contents of a recording by topic: numbers with their units, single numbers over time, and raw messages."""

import json
import math
import re
from collections.abc import Iterator
from typing import Any

from mjsim.record import Head, RawMessage, Recording, raw_messages
from mjsim.web.run import plain

SAMPLED_MESSAGES = 40
"""Number of messages at the start of a topic in which fields are searched."""
MAX_FIELDS = 4000
"""Maximum number of fields offered per recording."""
MAX_ROWS = 5000
"""Maximum number of rows returned per field; longer series are sampled evenly."""
MAX_LIST_LENGTH = 64
"""Entries of longer lists are not offered: they are data such as scans."""
MAX_DEPTH = 6
TIME_ROUNDING_NS = 1e3
"""Times that differ by less are equal [ns]."""
SHOWN_TEXT = 200
"""Maximum length of a text in a message that is shown [characters]."""
_UNIT = re.compile(r"\[([^\]]+)\]")
"""Unit at the end of a description."""
_SKIPPED = {"timestamp", "time", "shown", "entities", "deletions"}


def fields_json(recording: Recording) -> dict[str, Any]:
    """Return the topics and fields of a recording.

    Returns:
        `fields`: (topic, field) of each number, sorted by topic. `topics`: by name, the type of its messages, what they
        are `about`, their `count`, and `units` of its numbers by the name of the field without indices.
    """
    seen: dict[str, int] = {}
    found: dict[tuple[str, str], None] = {}
    head = Head()
    for message in raw_messages(recording.path, head=head):
        seen[message.topic] = seen.get(message.topic, 0) + 1
        if seen[message.topic] > SAMPLED_MESSAGES or not message.data.startswith(b"{") or len(found) >= MAX_FIELDS:
            continue
        found |= dict.fromkeys((message.topic, name) for name, _ in numbers_in(_content(message.data)))
    topics = {topic: {**_described(head, topic), "count": count} for topic, count in sorted(seen.items())}
    return {"fields": sorted(found)[:MAX_FIELDS], "topics": topics}


def message_json(recording: Recording, topic: str, time: float) -> dict[str, Any] | None:
    """Return the last message of a topic until a time [s]: `time`, size in `bytes`, and `content`, None if not JSON."""
    newest: RawMessage | None = None
    for message in raw_messages(recording.path, topics={topic}):
        if message.time > 1e9 * time + TIME_ROUNDING_NS:
            break
        newest = message
    if newest is None:
        return None
    content = _shortened(_content(newest.data)) if newest.data.startswith(b"{") else None
    return {"time": newest.time / 1e9, "bytes": len(newest.data), "content": content}


def _described(head: Head, topic: str) -> dict[str, Any]:
    schema = head.schemas.get(topic)
    if schema is None:
        return {"type": "", "about": "", "units": {}}
    content = _content(schema.data) if schema.encoding == "jsonschema" else None
    about = str(content.get("description", "")) if isinstance(content, dict) else ""
    return {"type": schema.name, "about": about.partition(". ")[0], "units": dict(_units_in(content))}


def _units_in(schema: Any, name: str = "", depth: int = 0) -> Iterator[tuple[str, str]]:
    """Yield field and unit of each value with a unit in a JSON Schema, including those in lists and objects."""
    if not isinstance(schema, dict) or depth > MAX_DEPTH:
        return
    if unit := _UNIT.search(str(schema.get("description", ""))):
        yield name, unit[1]
    for key, item in dict(schema.get("properties") or {}).items():
        yield from _units_in(item, f"{name}.{key}" if name else key, depth + 1)
    yield from _units_in(schema.get("items"), name, depth + 1)


def _shortened(value: Any) -> Any:
    """Return a message without the ends of long texts and lists."""
    if isinstance(value, str):
        return value if len(value) <= SHOWN_TEXT else f"{value[:SHOWN_TEXT]}…"
    if isinstance(value, list):
        return [_shortened(each) for each in value[:MAX_LIST_LENGTH]] + ["…"] * (len(value) > MAX_LIST_LENGTH)
    return {key: _shortened(each) for key, each in value.items()} if isinstance(value, dict) else value


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
    elif depth >= MAX_DEPTH:
        return
    elif isinstance(value, dict):
        for key, item in value.items():
            if key not in _SKIPPED:
                yield from numbers_in(item, f"{name}.{key}" if name else key, depth + 1)
    elif isinstance(value, list) and len(value) <= MAX_LIST_LENGTH:
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
