"""The records of an MCAP file, within bounds: reading terminates and uses bounded memory for any file.

A file may be truncated anywhere, since a run may be killed at any time; the data before that is valid. A broken record
therefore ends the file without an error. Sizes beyond those of any recording of mjsim are errors.
"""

import struct
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, Any, cast

import zstandard
from lz4.frame import LZ4FrameDecompressor
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, DataEnd, Footer, McapRecord, Message, Metadata, Schema

from mjsim.errors import RecordingError, UsageError
from mjsim.sentences import Sentence

MAGIC = b"\x89MCAP0\r\n"
"""Begins and ends every MCAP file."""
MAX_RECORD = 1 << 28
"""Maximum size of one record, as stored in the file and decompressed [bytes]."""
MAX_CHUNK = 1 << 27
"""Maximum content of a chunk [bytes]; ours hold 1 MB, or one larger picture."""
MAX_HELD = 1 << 30
"""Maximum size of all attachments, metadata, schemas and channels together [bytes]."""
MIN_BYTES, DECOMPRESSION_LIMITS = 1 << 26, 32
"""Maximum decompressed size of a file: the sum of a constant [bytes] and a multiple of its size; ours have at most 8
times."""
MIN_MESSAGES, MESSAGE_BYTES = 1_000_000, 4
"""Maximum number of messages: a constant, plus one per this many bytes; ours have one per 40 bytes."""
PIECE_BYTES = 1 << 20
"""Bytes to read at once when skipping."""


def is_mcap(path: Path) -> bool:
    """Return whether a file begins as an MCAP file does."""
    if _is_endless(path):
        return False
    try:
        with path.open("rb") as stream:
            return stream.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def _is_endless(path: Path) -> bool:
    """Return whether opening a path may block forever, as that of a pipe to which nobody writes."""
    return path.exists() and not path.is_file() and not path.is_dir()


def records(path: Path) -> Iterator[McapRecord]:
    """Yield the records of a file, including those in chunks, up to its end or the first broken record.

    Indexes and statistics are left out; the footer appears only if the file is complete.

    Raises:
        UsageError: The file cannot be read.
        RecordingError: It is not an MCAP file, or exceeds a limit.
    """
    with _opened(path) as (stream, size):
        if size == 0:
            raise RecordingError(Sentence("'{path}' is empty; it is not a recording", path))
        bounded, budget = _Bounded(stream, size), _Budget(path, size)
        data = ReadDataStream(cast(IO[bytes], bounded), calculate_crc=True)
        try:
            if data.read(len(MAGIC)) != MAGIC:
                raise RecordingError(Sentence("'{path}' is not an MCAP file, so it is not a recording", path))
            yield from _records(data, bounded, budget)
        # Exceptions of the reader for a truncated or damaged file; everything before is valid.
        except (McapError, struct.error, ValueError, zstandard.ZstdError, _BrokenError):
            if data.count < len(MAGIC):
                raise RecordingError(Sentence("'{path}' is not an MCAP file, so it is not a recording", path)) from None


class _BrokenError(Exception):
    """The file is not valid MCAP from here on."""


class _Bounded:
    """A stream that refuses to read beyond its end, since a length in a file may be wrong."""

    def __init__(self, stream: IO[bytes], size: int) -> None:
        self._stream = stream
        self.left = size
        """[bytes]"""

    def read(self, length: int) -> bytes:
        """Return exactly this number of bytes."""
        if not 0 <= length <= self.left:
            raise EndOfFile
        data = self._stream.read(length)
        self.left -= len(data)
        if len(data) < length:
            raise EndOfFile
        return data


class _Budget:
    """Remaining budget of a file."""

    def __init__(self, path: Path, size: int) -> None:
        self._path = path
        self._bytes = MIN_BYTES + DECOMPRESSION_LIMITS * size
        self._messages = MIN_MESSAGES + size // MESSAGE_BYTES
        self._held = MAX_HELD

    def unpack(self, size: int) -> None:
        """Count decompressed bytes."""
        self._bytes -= size
        if self._bytes < 0:
            raise self.exceeded("decompresses to far more than any recording")

    def message(self) -> None:
        """Count a message."""
        self._messages -= 1
        if self._messages < 0:
            raise self.exceeded("holds far more messages than any recording of its size")

    def hold(self, size: int) -> None:
        """Count bytes that stay in memory."""
        self._held -= size
        if self._held < 0:
            raise self.exceeded(f"has attachments and names of more than {MAX_HELD / 1e9:.1f} GB")

    def record(self, size: int, *, limit: int = MAX_RECORD) -> None:
        """Check the size of one record."""
        if size > limit:
            raise self.exceeded(f"has a record of more than {limit / 1e6:.0f} MB")

    def exceeded(self, problem: str) -> RecordingError:
        """Return the error for an exceeded limit."""
        return RecordingError(
            Sentence("'{path}' {problem}; it was not made by mjsim, or is damaged", self._path, problem)
        )


@contextmanager
def _opened(path: Path) -> Iterator[tuple[IO[bytes], int]]:
    """Open a file for the block, which gets it with its size; errors of the file system in the block are not caught."""
    if _is_endless(path):
        raise UsageError(Sentence("cannot read '{path}': it is a pipe or a device; name a file", path))
    try:
        with path.open("rb") as stream:
            yield stream, path.stat().st_size
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError(Sentence("no file '{path}'; name a recording", path)) from None
    except IsADirectoryError:
        raise UsageError(Sentence("'{path}' is a folder; name a recording", path)) from None
    except OSError as error:
        raise UsageError(Sentence("cannot read '{path}': {strerror}", path, error.strerror)) from None


_READ: dict[int, Any] = {
    Opcode.ATTACHMENT: Attachment,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.DATA_END: DataEnd,
    Opcode.FOOTER: Footer,
    Opcode.METADATA: Metadata,
    Opcode.SCHEMA: Schema,
}
_HELD = (Attachment, Channel, Metadata, Schema)
_RECORD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<HIQQ")


def _records(data: ReadDataStream, bounded: _Bounded, budget: _Budget) -> Iterator[McapRecord]:
    while True:
        before = data.checksum()
        opcode, length = data.read1(), data.read8()
        # The last record of a truncated file; the length of one that is still being written is not known yet.
        if length > bounded.left:
            raise _BrokenError
        record: McapRecord | None = None
        if opcode in _READ or opcode == Opcode.MESSAGE:
            budget.record(length)
            record = _record(opcode, data.read(length))
        else:
            _pass_over(data, length)
        if isinstance(record, Chunk):
            yield from _unpacked(record, budget)
        elif isinstance(record, DataEnd):
            if record.data_section_crc not in (0, before):
                raise _BrokenError
        elif isinstance(record, Footer):
            if data.read(len(MAGIC)) == MAGIC:
                yield record
            return
        elif record is not None:
            if isinstance(record, Message):
                budget.message()
            elif isinstance(record, _HELD):
                budget.hold(length)
            yield record


def _record(opcode: int, content: bytes) -> McapRecord:
    """Return the record with some content."""
    if opcode == Opcode.MESSAGE:
        if len(content) < _MESSAGE.size:
            raise _BrokenError
        channel, sequence, log_time, publish_time = _MESSAGE.unpack_from(content)
        return Message(
            channel_id=channel,
            log_time=log_time,
            data=content[_MESSAGE.size :],
            publish_time=publish_time,
            sequence=sequence,
        )
    record: McapRecord = _READ[opcode].read(ReadDataStream(cast(IO[bytes], _Bounded(BytesIO(content), len(content)))))
    return record


def _pass_over(data: ReadDataStream, length: int) -> None:
    while length > 0:
        length -= len(data.read(min(length, PIECE_BYTES)))


def _unpacked(chunk: Chunk, budget: _Budget) -> Iterator[McapRecord]:
    """Yield the records in a chunk."""
    content = _decompressed(chunk, budget)
    if chunk.uncompressed_crc not in (0, zlib.crc32(content)):
        raise _BrokenError
    place = 0
    while place < len(content):
        opcode, length = _RECORD.unpack_from(content, place)
        begins = place + _RECORD.size
        place = begins + length
        if place > len(content):
            raise _BrokenError
        if opcode == Opcode.MESSAGE:
            budget.message()
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            budget.hold(length)
        else:
            continue
        yield _record(opcode, content[begins:place])


def _decompressed(chunk: Chunk, budget: _Budget) -> bytes:
    """Return the content of a chunk; never decompress more than its stated size or the limit."""
    limit = min(chunk.uncompressed_size, MAX_CHUNK) + 1
    if chunk.compression == "zstd":
        content = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(limit)
    elif chunk.compression == "lz4":
        content = _without_lz4(chunk.data, limit)
    elif chunk.compression == "":
        content = chunk.data[:limit]
    else:
        raise budget.exceeded(f"is compressed by '{chunk.compression:.20}', not by zstd or lz4")
    budget.record(len(content), limit=MAX_CHUNK)
    budget.unpack(len(content))
    if len(content) != chunk.uncompressed_size:
        raise _BrokenError
    return content


def _without_lz4(data: bytes, limit: int) -> bytes:
    """Return at most this many decompressed bytes of LZ4 data."""
    try:
        content: bytes = LZ4FrameDecompressor().decompress(data, max_length=limit)
    # All exceptions for data that it cannot read.
    except RuntimeError:
        raise _BrokenError from None
    return content
