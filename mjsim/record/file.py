"""Reads the messages of a recording's file, even if it is truncated."""

import hashlib
import struct
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mcap.records import Attachment, Channel, Footer, Message, Metadata, Schema

from mjsim.record.container import records
from mjsim.sentences import Sentence

WORLD_NAME = "world.yaml"
"""Attachment that holds the text of the world."""
FILES = "files/"
"""Prefix of the names of attached files, followed by the name that the world uses."""
METADATA_NAME = "mjsim"
"""Metadata record with seed, versions and command line."""
PICTURE_SCHEMAS = ("foxglove.CompressedImage", "foxglove.RawImage")
TIMING_TOPIC = "/timing"


@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message as stored in the file."""

    topic: str
    time: int
    """Simulated [ns]."""
    data: bytes
    schema: str
    """Name of its schema."""


@dataclass(slots=True)
class Head:
    """The part of a recording before its first message."""

    files: dict[str, bytes] = field(default_factory=dict)
    """Attachments by name."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    """Records by name."""
    schemas: dict[str, Schema] = field(default_factory=dict)
    """Schemas of each topic that has one."""
    whole: bool = False
    """Whether the file is complete; known after its last message."""


def raw_messages(
    path: Path, *, topics: Collection[str] | None = None, head: Head | None = None
) -> Iterator[RawMessage]:
    """Yield the messages of a file in order, up to its end or the first broken record.

    Args:
        path: An MCAP file.
        topics: Only these; by default all.
        head: Filled with attachments and metadata as they are read.

    Raises:
        UsageError: The file cannot be read.
        RecordingError: It is not an MCAP file, or exceeds a limit.
    """
    head = Head() if head is None else head
    channels: dict[int, tuple[str, str] | None] = {}
    schemas: dict[int, Schema] = {}
    for record in records(path):
        if isinstance(record, Message):
            channel = channels.get(record.channel_id)
            if channel is not None:
                yield RawMessage(channel[0], record.log_time, record.data, channel[1])
        elif isinstance(record, Schema):
            schemas[record.id] = record
        elif isinstance(record, Channel):
            selected, schema = topics is None or record.topic in topics, schemas.get(record.schema_id)
            channels[record.id] = (record.topic, "" if schema is None else schema.name) if selected else None
            if schema is not None:
                head.schemas[record.topic] = schema
        elif isinstance(record, Attachment):
            head.files[record.name] = record.data
        elif isinstance(record, Metadata):
            head.metadata[record.name] = {**head.metadata.get(record.name, {}), **record.metadata}
        elif isinstance(record, Footer):
            head.whole = True


def numeric_topics(path: str | Path) -> dict[str, str]:
    """Return topic -> SHA-256 of its times and messages, for all topics that are the same in equal runs.

    Pictures, which depend on the OpenGL backend, and wall-clock times are left out.
    """
    hashes: dict[str, Any] = {}
    for message in raw_messages(Path(path)):
        if message.topic == TIMING_TOPIC or message.schema in PICTURE_SCHEMAS:
            continue
        digest = hashes.setdefault(message.topic, hashlib.sha256())
        digest.update(struct.pack("<QQ", message.time, len(message.data)))
        digest.update(message.data)
    return {topic: digest.hexdigest() for topic, digest in sorted(hashes.items())}


def same_run(first: str | Path, second: str | Path) -> bool:
    """Return whether two recordings have the same bytes in every numeric topic."""
    return numeric_topics(first) == numeric_topics(second)


def picture_of(data: bytes) -> tuple[bytes, str]:
    """Return the picture's bytes and its format, 'jpeg' or 'png', from a `foxglove.CompressedImage`.

    Raises:
        ValueError: It is not valid, or has another format.
    """
    fields = {number: value for number, value, _ in parts_of(data)}
    picture, form = fields.get(2, b""), fields.get(3, b"").decode()
    if not picture or form not in ("jpeg", "png"):
        raise ValueError(Sentence("a picture of format '{form:.20}'", form))
    return picture, form


def timestamp_of(data: bytes) -> int:
    """Return the timestamp in a `foxglove.CompressedImage` or `RawImage` [ns].

    Raises:
        ValueError: It is not valid.
    """
    timestamp = next((value for number, value, _ in parts_of(data) if number == 1), b"")
    place, numbers = 0, {}
    while place < len(timestamp):
        key, place = _varint(timestamp, place)
        numbers[key >> 3], place = _varint(timestamp, place)
    return numbers.get(1, 0) * 1_000_000_000 + numbers.get(2, 0)


def parts_of(data: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Yield number, value and complete bytes of each field of a Foxglove message.

    Fields are strings, bytes, messages and 32-bit numbers.

    Raises:
        ValueError: It is not valid.

    References:
        Protocol Buffers encoding: a field is a varint key (number << 3 | wire type), then its value.
    """
    place = 0
    while place < len(data):
        began = place
        key, place = _varint(data, place)
        if key & 7 == _FIXED32:
            size = 4
        elif key & 7 == _LENGTH_DELIMITED:
            size, place = _varint(data, place)
        else:
            raise ValueError("a picture or a frame that is not as Foxglove defines it")
        if place + size > len(data):
            raise ValueError("a picture or a frame that ends too early")
        yield key >> 3, data[place : place + size], data[began : place + size]
        place += size


_LENGTH_DELIMITED, _FIXED32 = 2, 5
_VARINT = 70
"""Maximum size of a varint [bits]."""


def _varint(data: bytes, place: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, _VARINT, 7):
        if place == len(data):
            break
        byte = data[place]
        value |= (byte & 0x7F) << shift
        place += 1
        if byte < 0x80:
            return value, place
    raise ValueError("a picture or a frame that is not as Foxglove defines it")


def encodable(metadata: Mapping[str, str]) -> dict[str, str]:
    """Return metadata as valid UTF-8; names of files may contain other bytes, which are escaped."""
    return {key: text.encode("utf-8", "backslashreplace").decode() for key, text in metadata.items()}
