"""Recordings taken apart, changed by hand, and written again."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

import mjsim
from mjsim.errors import RecordingError

Content = dict[str, Any]


@dataclass
class Parts:
    """A recording taken apart."""

    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    messages: list[tuple[str, Schema, str, int, bytes]] = field(default_factory=list)
    """Topic, schema, encoding, time [ns] and content."""

    def change(self, topic: str, edit: Callable[[Content], object]) -> "Parts":
        """Change every message of a JSON topic."""
        for index, (name, *rest, data) in enumerate(self.messages):
            if name == topic:
                content = json.loads(data)
                edit(content)
                # Numbers that JSON does not have are written as others would.
                self.messages[index] = (name, *rest, json.dumps(content).encode())
        return self

    def put(self, topic: str, data: bytes) -> "Parts":
        """Give every message of a topic other content."""
        self.messages = [(*rest, data if rest[0] == topic else old) for *rest, old in self.messages]
        return self

    def write(self, path: Path, **options: Any) -> Path:
        """Write the recording."""
        with path.open("wb") as stream:
            writer = Writer(stream, **options)
            writer.start()
            for name, data in self.attachments.items():
                writer.add_attachment(0, 0, name, "", data)
            for name, said in self.metadata.items():
                writer.add_metadata(name, said)
            channels: dict[str, int] = {}
            for topic, schema, encoding, log_time, data in self.messages:
                if topic not in channels:
                    number = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[topic] = writer.register_channel(topic, encoding, number)
                writer.add_message(channels[topic], log_time, data, log_time)
            writer.finish()
        return path


def taken_apart(data: bytes) -> Parts:
    """Return the parts of a recording."""
    found, schemas, channels = Parts(), {}, {}
    for item in StreamReader(BytesIO(data)).records:
        if isinstance(item, Attachment):
            found.attachments[item.name] = item.data
        elif isinstance(item, Metadata):
            found.metadata[item.name] = item.metadata
        elif isinstance(item, Schema):
            schemas[item.id] = item
        elif isinstance(item, Channel):
            channels[item.id] = item
        elif isinstance(item, Message):
            channel = channels[item.channel_id]
            schema = schemas[channel.schema_id]
            found.messages.append((channel.topic, schema, channel.message_encoding, item.log_time, item.data))
    return found


def refused(path: Path) -> str:
    """Return the one line in which a file is refused."""
    with pytest.raises(RecordingError) as caught:
        mjsim.read_recording(path)
    line = str(caught.value)
    assert line.isprintable()
    assert str(path) in line
    return line
