"""Recordings taken apart, changed at random, and put together again, checksums and all."""

import json
import pickle
import zlib
from dataclasses import dataclass
from functools import cache
from io import BytesIO
from typing import Any

import lz4.frame
import numpy as np
import zstandard
from mcap.data_stream import RecordBuilder
from mcap.records import (
    Attachment,
    Channel,
    Chunk,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    Metadata,
    Schema,
)
from mcap.stream_reader import StreamReader

MAGIC = b"\x89MCAP0\r\n"
WILD: tuple[Any, ...] = (
    *(0, 1, -1, 0.5, 1e308, -1e308, 5e-324, 2**31, 2**63, 10**30, 10**400, True, None),
    *("", "a", "é\x1b[31m\n", "\ud800"),
    *([], {}, [[]], [None], [0], [0] * 9, {"x": 1}, "lion", "scout", "box", "obstacle/box", "../../up", "AAAA", "/etc"),
    *("bump", "fault", "9" * 5000, "a" * 3000, float("nan"), float("inf")),
)
"""Replacements for values."""
WORDS = (
    "",
    "/",
    "//",
    "/state",
    "/timing",
    "/scout",
    "/scout/truth",
    "/idle/estimate",
    "scout/truth",
    "../x",
    "a" * 99,
)
"""Replacements for topics and names."""


@dataclass(slots=True)
class Parts:
    """A recording taken apart: the records before its messages, then the messages with their topics."""

    attachments: list[Attachment]
    metadata: list[Metadata]
    schemas: list[Schema]
    channels: list[Channel]
    messages: list[Message]


def taken_apart(data: bytes) -> Parts:
    """Return the records of a recording."""
    found: dict[type, list[Any]] = {kind: [] for kind in (Attachment, Metadata, Schema, Channel, Message)}
    for record in StreamReader(BytesIO(data)).records:
        if type(record) in found and (not hasattr(record, "id") or record not in found[type(record)]):
            found[type(record)].append(record)
    return Parts(*found.values())


@cache
def _pickled(data: bytes) -> bytes:
    """Return a recording taken apart, as bytes that are quick to copy."""
    return pickle.dumps(taken_apart(data))


def put_together(parts: Parts, rng: np.random.Generator) -> bytes:
    """Return the file of some records, its checksums right, in chunks of some size and kind."""
    head = [Header("", "fuzz"), *parts.attachments, *parts.metadata]
    records = [_packed(record) for record in (*parts.schemas, *parts.channels, *parts.messages)]
    count = int(rng.choice((len(records), 200, 7))) or 1
    chunks = [_chunk(b"".join(records[at : at + count]), rng) for at in range(0, len(records), count)]
    end = [DataEnd(0), Footer(0, 0, 0)]
    return b"".join([MAGIC, *map(_packed, [*head, *chunks, *end]), MAGIC])


def _packed(record: McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()


def _chunk(content: bytes, rng: np.random.Generator) -> Chunk:
    kind = str(rng.choice(("zstd", "zstd", "lz4", "", "gzip"), p=(0.5, 0.2, 0.15, 0.145, 0.005)))
    data = {"zstd": zstandard.compress, "lz4": lz4.frame.compress}.get(kind, bytes)(content)
    says = len(content) if rng.random() < 0.99 else one_of(rng, [0, 1, len(content) + 1, 1 << 40, (1 << 64) - 1])
    crc = zlib.crc32(content) if rng.random() < 0.99 else one_of(rng, [0, 1])
    return Chunk(
        compression=kind,
        data=data,
        message_start_time=0,
        message_end_time=0,
        uncompressed_crc=crc,
        uncompressed_size=says,
    )


def changed_records(rng: np.random.Generator, data: bytes) -> bytes:
    """Return a recording in which a few records are changed, doubled, dropped or moved."""
    parts = pickle.loads(_pickled(data))
    for _ in range(int(rng.choice((1, 1, 1, 2, 3, 8)))):
        _CHANGES[int(rng.choice(len(_CHANGES), p=_ODDS))](rng, parts)
    return put_together(parts, rng)


def one_of(rng: np.random.Generator, items: list[Any]) -> Any:
    """Return an item at random."""
    return items[int(rng.integers(len(items)))]


def _change_value(rng: np.random.Generator, parts: Parts) -> None:
    """Change a value deep in a JSON message, or in all later messages of its topic."""
    message = one_of(rng, parts.messages)
    content = _content(message)
    path = _path(rng, content)
    wild = _wild_for(rng, content, path)
    later = [each for each in parts.messages if each.channel_id == message.channel_id] if rng.random() < 0.3 else []
    for each in [message, *later]:
        if (own := _content(each)) is not None:
            each.data = _with(own, path, wild, drop=rng.random() < 0.05)


def _content(message: Message) -> Any:
    """Return the content of a JSON message; None for any other message."""
    try:
        return json.loads(message.data)
    except ValueError:
        return None


def _wild_for(rng: np.random.Generator, content: Any, path: list[Any]) -> Any:
    """Return a random value for a path, half of the time of the same kind as the current one."""
    for key in path:
        content = content[key]
    if rng.random() < 0.3:
        return one_of(rng, list(WILD))
    if isinstance(content, list):
        return one_of(rng, [content[1:], content * 2, content + content[:1], []])
    kind = float if isinstance(content, int | float) else type(content)
    fitting = [value for value in WILD if isinstance(value, int if kind is float else kind) or type(value) is kind]
    return one_of(rng, fitting or list(WILD))


def _path(rng: np.random.Generator, content: Any) -> list[Any]:
    path: list[Any] = []
    while isinstance(content, dict | list) and content and (not path or rng.random() < 0.85):
        key = one_of(rng, list(content)) if isinstance(content, dict) else int(rng.integers(len(content)))
        path.append(key)
        content = content[key]
    return path


def _with(content: Any, path: list[Any], value: Any, *, drop: bool) -> bytes:
    """Return the JSON of some content with another value at a path, where there is such a path."""
    place = content
    for key in path[:-1]:
        try:
            place = place[key]
        except (LookupError, TypeError):
            break
    if path and isinstance(place, dict) and drop:
        place.pop(path[-1], None)
    elif path and isinstance(place, dict):
        place[path[-1]] = value
    elif path and isinstance(place, list) and place and isinstance(path[-1], int):
        place[path[-1] % len(place)] = value
    else:
        content = value
    return json.dumps(content, ensure_ascii=True).encode()


def _change_bytes(rng: np.random.Generator, parts: Parts) -> None:
    message = one_of(rng, parts.messages)
    message.data = changed_bytes(rng, message.data)


def _drop_or_double(rng: np.random.Generator, parts: Parts) -> None:
    items = one_of(rng, [parts.messages] * 4 + [parts.channels, parts.schemas, parts.attachments, parts.metadata])
    if items:
        at = int(rng.integers(len(items)))
        items[at : at + int(rng.integers(1, 4))] = [] if rng.random() < 0.5 else [items[at]] * 2


def _move(rng: np.random.Generator, parts: Parts) -> None:
    at, to = rng.integers(len(parts.messages), size=2).tolist()
    parts.messages.insert(to, parts.messages.pop(at))


def _rename(rng: np.random.Generator, parts: Parts) -> None:
    """Change a channel's topic or numbers, a schema's or an attachment's name, or a message's time or channel."""
    if not (parts.channels and parts.attachments and parts.messages and parts.schemas):
        return
    word, number = str(one_of(rng, list(WORDS))), int(rng.integers(0, 40))
    choices = (
        lambda: setattr(one_of(rng, parts.channels), "topic", word),
        lambda: setattr(one_of(rng, parts.channels), "topic", one_of(rng, parts.channels).topic),
        lambda: setattr(one_of(rng, parts.channels), "id", number),
        lambda: setattr(one_of(rng, parts.channels), "schema_id", number),
        lambda: setattr(one_of(rng, parts.schemas), "name", word),
        lambda: setattr(one_of(rng, parts.attachments), "name", f"files/{word}"),
        lambda: setattr(one_of(rng, parts.messages), "log_time", int(rng.choice((0, 1, 10**9, 2**63)))),
        lambda: setattr(one_of(rng, parts.messages), "channel_id", number),
    )
    one_of(rng, list(choices))()


def _change_head(rng: np.random.Generator, parts: Parts) -> None:
    """Change the world's text, a file that it names, or the metadata of the run."""
    if rng.random() < 0.5 and parts.metadata:
        said = one_of(rng, parts.metadata).metadata
        key = one_of(rng, [*said, "seconds", "modules", "replayed modules", "replayed robot", "replayed estimator"])
        value = one_of(rng, list(WILD))
        wild = json.dumps({"scout": value}) if rng.random() < 0.5 else repr(value)
        said[key] = wild.encode("utf-8", "replace").decode()
    elif parts.attachments:
        attachment = one_of(rng, parts.attachments)
        attachment.data = changed_bytes(rng, attachment.data)


_CHANGES = (_change_value, _change_bytes, _drop_or_double, _move, _rename, _change_head)
_ODDS = (0.6, 0.08, 0.1, 0.06, 0.08, 0.08)


def changed_bytes(rng: np.random.Generator, data: bytes) -> bytes:
    """Return bytes with a few changed, removed or doubled, or truncated somewhere."""
    for _ in range(int(rng.choice((1, 1, 2, 5)))):
        at = int(rng.integers(len(data) + 1))
        other = int(rng.integers(len(data) + 1))
        piece = data[other : other + int(rng.integers(1, 40))]
        data = one_of(
            rng,
            [
                data[:at] + bytes([int(rng.integers(256))]) + data[at + 1 :],
                data[:at] + bytes([(data[at] if at < len(data) else 0) ^ (1 << int(rng.integers(8)))]) + data[at + 1 :],
                data[:at] + piece + data[at:],
                data[:at] + data[at + len(piece) :],
                data[:at] + bytes(rng.choice((0, 255), size=8).astype(np.uint8)) + data[at + 8 :],
                data[:at],
            ],
        )
    return data
