"""Readers of bags: those of rosbags, and for files that were cut two that need no index."""

from collections import defaultdict
from collections.abc import Callable, Collection, Generator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag1 import ReaderError as ReaderError1
from rosbags.rosbag1.reader import ChunkInfo, Header, IndexData, RecordType, read_bytes, read_uint32
from rosbags.rosbag2 import Reader as Reader2
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mjsim.logs.bag_topics import TRANSFORMS

MAGIC1 = b"#ROSBAG V2.0\n"


def open_reader(path: Path) -> tuple[Any, str]:
    """Return a reader of a bag, open, and why the bag is cut, empty if it is not.

    Raises whatever the file makes parsers raise.
    """
    kind = path.suffix.lower()
    reader: Any = Reader1(path) if kind == ".bag" else Reader2(path)
    try:
        reader.open()
    # What is cut fails in many ways, and is tried without its index; what is no bag fails there too.
    except Exception as error:
        if kind not in (".bag", ".mcap"):
            raise
        reader = _CutReader1(path) if kind == ".bag" else _CutMcap(path)
        # The first error tells more of what is no bag at all.
        with suppress(Exception):
            reader.open()
        if reader.connections:
            return reader, f"{error}"
        if reader.bio is not None:
            reader.close()
        raise
    return reader, ""


def decoder_of(reader: Any) -> tuple[bool, Callable[[bytes, str], Any]]:
    """Return whether a bag is of ROS 2, and what decodes a message of a named type, as ROS defines that."""
    is_ros1 = isinstance(reader, Reader1)
    store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.LATEST)
    for name in TRANSFORMS:
        if name not in store.types:
            store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", name))
    return not is_ros1, store.deserialize_ros1 if is_ros1 else store.deserialize_cdr


class _CutReader1(Reader1):
    """A bag of ROS 1 without its index: the chunks that are whole are looked through."""

    def open(self) -> None:
        """Open it and find its messages."""
        self.bio = self.path.open("rb")
        if self.bio.readline() != MAGIC1:
            raise ReaderError1("File magic is invalid.")
        Header.read(self.bio, RecordType.BAGHEADER)
        read_bytes(self.bio, read_uint32(self.bio))
        found: dict[int, Connection] = {}
        indexes: dict[int, list[IndexData]] = defaultdict(list)
        # It ends where the file was cut.
        with suppress(ReaderError1, EOFError, OSError, ValueError, RuntimeError):
            while True:
                self._look_through(found, indexes)
        self.indexes = {number: sorted(entries) for number, entries in indexes.items()}
        self.connections = [
            connection._replace(msgcount=len(indexes[number]))
            for number, connection in found.items()
            if number in indexes
        ]

    def _look_through(self, found: dict[int, Connection], indexes: dict[int, list[IndexData]]) -> None:
        """Take the next record."""
        assert self.bio is not None
        position = self.bio.tell()
        header = Header.read(self.bio)
        if header.get_uint8("op") != RecordType.CHUNK:
            read_bytes(self.bio, read_uint32(self.bio))
            return
        self.bio.seek(position)
        chunk = self.read_chunk()
        self.bio.seek(chunk.datapos)
        content = chunk.decompressor(read_bytes(self.bio, chunk.datasize))
        self._list(content, position, found, indexes)
        self.chunks[position] = chunk
        entries = [entry.time for index in indexes.values() for entry in index if entry.chunk_pos == position]
        if entries:
            self.chunk_infos.append(ChunkInfo(position, min(entries), max(entries) + 1, {}))

    def _list(
        self, content: bytes, position: int, found: dict[int, Connection], indexes: dict[int, list[IndexData]]
    ) -> None:
        """List the messages of a chunk, and the connections that it introduces."""
        records, kept = BytesIO(content), self.bio
        while records.tell() < len(content):
            offset = records.tell()
            header = Header.read(records)
            if header.get_uint8("op") == RecordType.CONNECTION:
                records.seek(offset)
                # The parent reads it from its file.
                self.bio = records
                connection = self.read_connection()
                self.bio = kept
                found.setdefault(connection.id, connection)
                continue
            if header.get_uint8("op") == RecordType.MSGDATA:
                indexes[header.get_uint32("conn")].append(IndexData(header.get_time("time"), position, offset))
            read_bytes(records, read_uint32(records))


class _CutMcap(McapReader):
    """An MCAP file without its summary: it is read from the first record to the last whole one."""

    def _open(self) -> None:
        assert self.bio is not None
        self.data_start = 8
        self.data_end = self._end_of_records()
        self.meta_scan()

    def _end_of_records(self) -> int:
        """Return where the last whole record ends that holds data."""
        assert self.bio is not None
        size = self.bio.seek(0, 2)
        end = 8
        while end + 9 <= size:
            self.bio.seek(end)
            kind, length = self.bio.read(1), int.from_bytes(self.bio.read(8), "little")
            # From the end of data on nothing is left to read.
            if kind == b"\x0f" or end + 9 + length > size:
                break
            end += 9 + length
        return end

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages in the order of the file."""
        yield from self.messages_scan(connections, start, stop)
