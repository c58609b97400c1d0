"""Summary of a recording, read from its head and its end alone: for lists of many recordings."""

import json
import re
import struct
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import SeekingReader

from mjsim.record.file import METADATA_NAME, WORLD_NAME, Head, raw_messages
from mjsim.record.recording_reader import world_in
from mjsim.world import World

_NAME = re.compile(r"^name:[ \t]*(\S.*?)[ \t]*(?:#.*)?$", re.MULTILINE)


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingSummary:
    """The world and robots of a recording."""

    world: str
    """Name of its world; '' if it has none."""
    robots: tuple[str, ...]
    """Names of its robots."""
    seconds: float | None
    """Time of its last message [s]; None if the file ends early."""


def recording_summary(path: Path) -> RecordingSummary:
    """Return the summary of a recording; only its head and its end are read.

    Raises:
        UsageError: The file cannot be read.
        RecordingError: It is not an MCAP file, or exceeds a limit.
    """
    head = _head(path)
    named = _NAME.search(head.files.get(WORLD_NAME, b"").decode(errors="replace"))
    robots = _robots(head.metadata.get(METADATA_NAME, {}))
    return RecordingSummary(world=named[1].strip("'\"") if named else "", robots=robots, seconds=_seconds(path))


def recorded_world(path: Path) -> World:
    """Return the world of a recording.

    Raises:
        UsageError: The file cannot be read.
        RecordingError: It is not a recording, or its world cannot be read.
    """
    return world_in(path, _head(path))


def _head(path: Path) -> Head:
    head = Head()
    next(raw_messages(path, head=head), None)
    return head


def _robots(metadata: dict[str, str]) -> tuple[str, ...]:
    try:
        modules = json.loads(metadata.get("modules", "{}"))
    except ValueError:
        return ()
    return tuple(modules) if isinstance(modules, dict) else ()


def _seconds(path: Path) -> float | None:
    """Return when a recording ends [s], by the statistics at the end of its file; None if there are none."""
    try:
        with path.open("rb") as stream:
            summary = SeekingReader(stream).get_summary()
    # Exceptions of the reader for a file that was cut, or is damaged there.
    except (McapError, OSError, struct.error, ValueError, OverflowError, MemoryError):
        return None
    found = None if summary is None else summary.statistics
    return None if found is None else found.message_end_time / 1e9
