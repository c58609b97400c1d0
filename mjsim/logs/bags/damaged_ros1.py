"""Bags of ROS 1 that rosbags does not read: those without an index or without chunks, truncated, or of version 1.2."""

from bz2 import BZ2Decompressor
from collections import defaultdict
from collections.abc import Callable, Collection, Generator, Mapping
from contextlib import suppress
from heapq import merge
from io import BytesIO
from itertools import takewhile
from pathlib import Path

from lz4.frame import LZ4FrameDecompressor
from rosbags.interfaces import Connection, ConnectionExtRosbag1, MessageDefinition, MessageDefinitionFormat
from rosbags.rosbag1 import Reader, ReaderError
from rosbags.rosbag1.reader import (
    Chunk,
    ChunkInfo,
    Header,
    IndexData,
    RecordType,
    decompressors,
    normalize,
    read_bytes,
    read_uint32,
)
from rosbags.typesys.msg import normalize_msgtype

MAGIC, OLD_MAGIC = b"#ROSBAG V2.0\n", b"#ROSBAG V1.2\n"
BEGUN: Mapping[str, Callable[[bytes], bytes]] = {
    "none": lambda data: data,
    "bz2": lambda data: BZ2Decompressor().decompress(data),
    "lz4": lambda data: LZ4FrameDecompressor().decompress(data),
}
"""Decompressors for the readable start of a chunk."""
DEFINITION = 1
"""Type of the records of version 1.2 with the type of a topic."""
CUT = (ReaderError, EOFError, OSError, ValueError, RuntimeError)
"""Errors where a file was truncated."""


def is_old(path: Path) -> bool:
    """Return whether a file is a bag of version 1.2."""
    with path.open("rb") as file:
        return file.read(len(OLD_MAGIC)) == OLD_MAGIC


class ScannedBag1(Reader):
    """A bag without its index: chunks are scanned, the last one up to its end, and messages outside of chunks."""

    is_whole = False
    """Whether all its data is there."""

    def open(self) -> None:
        """Open the file and find its messages."""
        self.bio = self.path.open("rb")
        if self.bio.readline() != MAGIC:
            raise ReaderError("File magic is invalid.")
        Header.read(self.bio, RecordType.BAGHEADER)
        read_bytes(self.bio, read_uint32(self.bio))
        found: dict[int, Connection] = {}
        indexes: dict[int, list[IndexData]] = defaultdict(list)
        # It ends where the file was truncated.
        with suppress(*CUT):
            while not self.is_whole:
                is_cut = self._read_record(found, indexes)
                self.is_whole = not is_cut and self.bio.tell() == self.path.stat().st_size
        self.indexes = {number: sorted(entries) for number, entries in indexes.items()}
        self.connections = [
            connection._replace(msgcount=len(indexes[number]))
            for number, connection in found.items()
            if number in indexes
        ]

    def _read_record(self, found: dict[int, Connection], indexes: dict[int, list[IndexData]]) -> bool:
        """Process the next record; return whether the file ends in it."""
        assert self.bio is not None
        position = self.bio.tell()
        header = Header.read(self.bio)
        kind = header.get_uint8("op")
        if kind != RecordType.CHUNK:
            read_bytes(self.bio, read_uint32(self.bio))
            if kind in (RecordType.CONNECTION, RecordType.MSGDATA):
                self._take_alone(position, found, indexes)
            return False
        self.bio.seek(position)
        declared = self.read_chunk()
        chunk = self._rest_of(declared)
        self.bio.seek(chunk.datapos)
        content = chunk.decompressor(read_bytes(self.bio, chunk.datasize))
        # A chunk that was not written to disk is all zeros.
        with suppress(ReaderError):
            self._list(content, position, found, indexes)
        self.chunks[position] = chunk
        # Entries of this chunk are the last ones of each connection.
        own = (takewhile(lambda entry: entry.chunk_pos == position, reversed(index)) for index in indexes.values())
        if entries := [entry.time for each in own for entry in each]:
            self.chunk_infos.append(ChunkInfo(position, min(entries), max(entries) + 1, {}))
        return chunk is not declared

    def _take_alone(self, position: int, found: dict[int, Connection], indexes: dict[int, list[IndexData]]) -> None:
        """Index a message or connection outside of chunks as a chunk of its own."""
        assert self.bio is not None
        end = self.bio.tell()
        self.bio.seek(position)
        self._list(read_bytes(self.bio, end - position), position, found, indexes)
        self.chunks[position] = Chunk(end - position, position, decompressors["none"])

    def _rest_of(self, chunk: Chunk) -> Chunk:
        """Return a chunk, or its start if the file ends in it."""
        available = self.path.stat().st_size - chunk.datapos
        if available >= chunk.datasize:
            return chunk
        packed = next(name for name, each in decompressors.items() if each is chunk.decompressor)
        return Chunk(available, chunk.datapos, BEGUN[packed])

    def _list(
        self, content: bytes, position: int, found: dict[int, Connection], indexes: dict[int, list[IndexData]]
    ) -> None:
        """Index the messages and connections of a chunk."""
        records, original = BytesIO(content), self.bio
        while records.tell() < len(content):
            offset = records.tell()
            header = Header.read(records)
            if header.get_uint8("op") == RecordType.CONNECTION:
                records.seek(offset)
                # The parent class reads it from its file.
                self.bio = records
                try:
                    connection = self.read_connection()
                finally:
                    self.bio = original
                found.setdefault(connection.id, connection)
                continue
            read_bytes(records, read_uint32(records))
            if header.get_uint8("op") == RecordType.MSGDATA:
                indexes[header.get_uint32("conn")].append(IndexData(header.get_time("time"), position, offset))


class OldBag1(Reader):
    """A bag of version 1.2: a sequence of messages, each with the name of its topic; its index is not used."""

    is_whole = False
    """Whether all its data is there."""

    def open(self) -> None:
        """Open the file and find its messages."""
        self.bio = self.path.open("rb")
        self.bio.readline()
        size = self.path.stat().st_size
        found: dict[str, Connection] = {}
        entries: dict[str, list[tuple[int, int, int]]] = defaultdict(list)
        with suppress(*CUT):
            while not self.is_whole:
                header = Header.read(self.bio)
                length, begin = read_uint32(self.bio), self.bio.tell()
                if begin + length > size:
                    break
                kind = header.get_uint8("op")
                if kind == DEFINITION:
                    self._define(header, found)
                elif kind == RecordType.MSGDATA:
                    time = header.get_uint32("sec") * 10**9 + header.get_uint32("nsec")
                    entries[normalize(header.get_string("topic"))].append((time, begin, length))
                self.bio.seek(begin + length)
                self.is_whole = begin + length == size
        self._entries = {each.id: sorted(entries[topic]) for topic, each in found.items() if topic in entries}
        self.connections = [
            each._replace(msgcount=len(self._entries[each.id])) for each in found.values() if each.id in self._entries
        ]

    def _define(self, header: Header, found: dict[str, Connection]) -> None:
        """Store the type of a topic."""
        topic = normalize(header.get_string("topic"))
        definition = MessageDefinition(MessageDefinitionFormat.MSG, header.get_string("def"))
        kind = normalize_msgtype(header.get_string("type"))
        digest, nothing = header.get_string("md5"), ConnectionExtRosbag1(None, None)
        found.setdefault(topic, Connection(len(found), topic, kind, definition, digest, 0, nothing, self))

    def messages(
        self, connections: Collection[Connection] = (), start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages in order of time."""
        assert self.bio is not None
        known = {each.id: each for each in connections or self.connections}
        chosen = [[(*entry, number) for entry in self._entries[number]] for number in known]
        for time, begin, length, number in merge(*chosen):
            if (start is None or time >= start) and (stop is None or time < stop):
                self.bio.seek(begin)
                yield known[number], time, read_bytes(self.bio, length)
