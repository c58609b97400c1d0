"""Copies a recording: every message is kept byte for byte, left out, or followed by new ones."""

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import Writer

from mjsim.closing import Closes
from mjsim.errors import RecordingError
from mjsim.geometry import Pose
from mjsim.output import NewFile
from mjsim.record.container import records
from mjsim.record.drawn import frames_message
from mjsim.record.file import METADATA_NAME, RawMessage, encodable, parts_of
from mjsim.record.json_messages import encode
from mjsim.record.numbers import Message as Values
from mjsim.record.numbers import nanoseconds
from mjsim.record.parse import unfit
from mjsim.record.schemas import ROBOT_TOPICS
from mjsim.sentences import Sentence

CHUNK_BYTES = 1 << 18
"""Maximum number of bytes lost when the process is killed."""


class Copy(Closes):
    """An MCAP file being written from a recording.

    Raises:
        RecordingError: The file cannot be written, or the other is not a recording; every method raises it.
    """

    def __init__(self, source: Path, path: Path, *, metadata: Mapping[str, str], overwrite: bool = False) -> None:
        """Open the new file.

        Args:
            source: A recording.
            path: The MCAP file; it appears once complete ticks are written. Folders are created if necessary.
            metadata: Added to the metadata of the recording, replacing equal keys.
            overwrite: Whether a file at the path may be replaced.
        """
        self._source, self._path, self._metadata = source, path, encodable(metadata)
        self._channels: dict[str, int] = {}
        self._names: dict[int, tuple[str, str]] = {}
        self._sequence = 0
        self._before: int | None = None
        with self._reporting():
            self._place = NewFile(path, overwrite=overwrite)
            self._file = os.fdopen(os.dup(self._place.fileno()), "wb")
            self._writer = Writer(self._file, chunk_size=CHUNK_BYTES)
            self._writer.start(library="mjsim")

    def messages(self) -> Iterator[RawMessage]:
        """Yield the messages of the recording; its head is copied meanwhile."""
        schemas: dict[int, Schema] = {}
        for record in records(self._source):
            if isinstance(record, Message):
                if record.channel_id in self._names:
                    topic, schema = self._names[record.channel_id]
                    yield RawMessage(topic, record.log_time, record.data, schema)
            elif isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                self._copy_channel(record, schemas.get(record.schema_id))
            elif isinstance(record, Attachment):
                with self._reporting():
                    self._writer.add_attachment(0, 0, record.name, record.media_type, record.data)
            elif isinstance(record, Metadata):
                extra = self._metadata if record.name == METADATA_NAME else {}
                with self._reporting():
                    self._writer.add_metadata(record.name, {**record.metadata, **extra})

    def keep(self, message: RawMessage, *, data: bytes | None = None) -> None:
        """Write a message of the recording, with other data if given."""
        self._write(message.topic, message.time, message.data if data is None else data)

    def put(self, topic: str, time: float, message: Values) -> None:
        """Write a new message of a robot's topic at a simulated time [s]."""
        if topic not in self._channels:
            schema = ROBOT_TOPICS[topic.rpartition("/")[2]]
            with self._reporting():
                number = self._writer.register_schema(schema["title"], "jsonschema", json.dumps(schema).encode())
                self._channels[topic] = self._writer.register_channel(topic, "json", number)
        self._write(topic, nanoseconds(time), encode(message))

    def end_tick(self) -> None:
        """Mark the end of a tick; the file is published once a chunk has been written after one."""
        if self._before is None:
            self._before = self._file.tell()
        elif self._file.tell() > self._before:
            self._publish()

    def close(self) -> None:
        """End the file; without a complete tick it is discarded, and an existing file at its path stays."""
        if self._file.closed:
            return
        with self._place, self._reporting(), self._file:
            self._writer.finish()  # type: ignore[no-untyped-call]
            if self._before is not None:
                self._publish()

    def _publish(self) -> None:
        with self._reporting():
            self._file.flush()
            self._place.publish()

    def _copy_channel(self, channel: Channel, schema: Schema | None) -> None:
        if channel.id in self._names:
            return  # A file repeats them at its end.
        self._names[channel.id] = channel.topic, schema.name if schema is not None else ""
        if channel.topic in self._channels:
            return
        with self._reporting():
            number = 0 if schema is None else self._writer.register_schema(schema.name, schema.encoding, schema.data)
            self._channels[channel.topic] = self._writer.register_channel(
                channel.topic, channel.message_encoding, number, channel.metadata
            )

    def _write(self, topic: str, time: int, data: bytes) -> None:
        self._sequence += 1
        with self._reporting():
            self._writer.add_message(self._channels[topic], time, data, time, self._sequence)

    @contextmanager
    def _reporting(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise RecordingError(Sentence("cannot write '{path}': {strerror}", self._path, error.strerror)) from error


def with_frame(data: bytes, name: str, time: float, pose: Pose) -> bytes:
    """Return the data of a `/tf` message with a new pose of one frame.

    Args:
        data: A `foxglove.FrameTransforms`.
        name: Name of the frame; it is not added if it is missing from the message.
        time: Simulated [s].
        pose: Pose of the frame, in the world frame.

    Raises:
        RecordingError: The message is not valid.
    """
    new = frames_message(time, {name: pose}, ()).encode()
    try:
        return b"".join(new if _child(value) == name else whole for _, value, whole in parts_of(data))
    except ValueError as error:
        raise unfit("a message on '/tf'", error) from error


def _child(transform: bytes) -> str:
    """Return the name of the inner frame of a `foxglove.FrameTransform`."""
    return next((value.decode() for number, value, _ in parts_of(transform) if number == _CHILD), "")


_CHILD = 3
