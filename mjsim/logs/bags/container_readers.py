"""Readers of bags: those of rosbags, and others that need no index, for truncated files."""

import errno
import functools
import re
from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from heapq import merge
from pathlib import Path
from typing import Any

from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2
from rosbags.rosbag2 import ReaderError
from rosbags.rosbag2.reader import DirectoryReader
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from mjsim.logs.bags.bag_sqlite import SqliteFile
from mjsim.logs.bags.bag_topics import TRANSFORMS
from mjsim.logs.bags.damaged_ros1 import OldBag1, ScannedBag1, is_old
from mjsim.logs.bags.parser_faults import ZSTD, BrokenBagError, parsing, unpacked

METADATA = "metadata.yaml"
MAX_METADATA = 16 << 20
"""Maximum size of metadata [bytes]."""
SCHEMAS = ("ros2msg", "ros2idl", "omgidl", "")
"""Languages of message definitions in MCAP files of ROS 2."""
MIDDLE = re.compile(r"^(\w+)/(\w+)$")
"""Name of a type in ROS 1: package and type."""


def open_reader(files: Mapping[Path, str], *, described: Path | None) -> tuple[Any, str, str]:
    """Return an open reader of a bag, the reason if the bag is truncated, and that if its metadata is wrong, else ''.

    Args:
        files: Files of the bag, with the type of each: '.bag', '.db3' or '.mcap', whatever its name.
        described: The folder of the bag if it has metadata; if that is wrong, the files are read without it.

    Raises:
        BrokenBagError: It is not a bag.
    """
    reason = ""
    if described is not None:
        try:
            return _opened(lambda: _Bag2(described)), "", ""
        except BrokenBagError as error:
            if not files:
                raise
            reason = f"{error}"
    with ExitStack() as undo:
        parts, cuts = [], []
        for file, kind in files.items():
            reader, cut = _open_file(file, kind)
            undo.callback(reader.close)
            parts.append(reader)
            cuts.append(f"{file.name}: {cut}" if cut and len(files) > 1 else cut)
        undo.pop_all()
    return parts[0] if len(parts) == 1 else _Joined(parts), "; ".join(filter(None, cuts)), reason


def _open_file(path: Path, kind: str) -> tuple[Any, str]:
    """Return an open reader of one file, and the reason if the file is truncated, else ''."""
    try:
        part = _opened(lambda: Reader1(path) if kind == ".bag" else _NamedReader2(path, kind))
        if kind not in (".bag", ".mcap") or part.connections:
            return part, ""
        # Its index lists no topics: they may be only among the messages.
        part.close()
        return _scanned(path, kind), ""
    except BrokenBagError as error:
        # A truncated file is tried without its index; for a file that is not a bag at all, the first error says more.
        if kind not in (".bag", ".mcap"):
            raise
        with suppress(BrokenBagError):
            part = _scanned(path, kind)
            if part.connections:
                return part, "" if getattr(part, "is_whole", False) else f"{error}"
            part.close()
        raise


def _scanned(path: Path, kind: str) -> Any:
    """Return an open reader of one file that does not use its index."""
    make: Any = OldBag1 if is_old(path) else ScannedBag1 if kind == ".bag" else _CutMcap
    return _opened(lambda: make(path))


def _opened(make: Callable[[], Any]) -> Any:
    """Create and open a reader; it is closed again if that fails."""
    with parsing(), ExitStack() as undo:
        reader = make()
        undo.callback(lambda: reader.close() if getattr(reader, "bio", None) is not None else None)
        reader.open()
        undo.pop_all()
    return reader


def decoder_of(reader: Any) -> tuple[bool, Callable[[bytes, str], Any]]:
    """Return whether a bag is of ROS 2, and the decoder of messages by type name."""
    first = reader.parts[0] if isinstance(reader, _Joined) else reader
    is_ros1 = isinstance(first, Reader1) or getattr(first, "is_ros1", False)
    store = _store(is_ros1)
    return not is_ros1, store.deserialize_ros1 if is_ros1 else store.deserialize_cdr


@functools.cache  # Cached for the standard types: creating them takes as long as reading a small bag.
def _store(is_ros1: bool) -> Any:
    """Return the standard types of a distribution of ROS."""
    store = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.LATEST)
    for name in TRANSFORMS:
        if name not in store.types:
            store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", name))
    return store


def files_of(reader: Any) -> list[Any]:
    """Return the readers of the files of a bag."""
    if isinstance(reader, _Joined):
        return [file for part in reader.parts for file in files_of(part)]
    storage = getattr(reader, "storage", reader)
    return list(getattr(storage, "storages", [storage]))


class _Schemas(dict[int, Any]):
    """Schemas of an MCAP file; those in languages other than ROS's, such as JSON, are empty."""

    def __setitem__(self, number: int, schema: Any) -> None:
        """Store a schema."""
        super().__setitem__(number, schema if schema.encoding in SCHEMAS else schema._replace(encoding=""))


class _Mcap(McapReader):
    """An MCAP file; without chunks, its messages are in the order of the file."""

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages."""
        whole = super().messages if self.chunks else self.messages_scan
        yield from whole(connections, start, stop)


class _Folder2(DirectoryReader):
    """The folder of a bag of ROS 2 with its metadata."""

    STORAGE_PLUGINS: Mapping[str, Any] = {"sqlite3": SqliteFile, "mcap": _Mcap}

    def open(self) -> None:
        """Open its files."""
        if (size := Path(str(self.path), METADATA).stat().st_size) > MAX_METADATA:
            raise ReaderError(f"it has {size:,} bytes")
        try:
            super().open()
        except OSError as error:
            if error.errno in (errno.EFBIG, errno.ENOSPC):
                raise ReaderError("it unpacks to more than the disk has; free space, or set TMPDIR") from None
            raise
        if not all(isinstance(each.msgcount, int) for each in self.connections):
            raise ReaderError("its counts of messages are not numbers")
        self._packed = self.metadata.compression_mode == "message"
        self.metadata = self.metadata._replace(compression_mode=None)

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages, decompressed if each was compressed."""
        for connection, time, data in super().messages(connections, start, stop):
            yield connection, time, unpacked(data) if self._packed else data


class _Bag2(Reader2):
    """A bag of ROS 2."""

    STORAGE_PLUGINS: Mapping[str, Any] = {"dir": _Folder2, ".db3": SqliteFile, ".mcap": _Mcap}


class _NamedReader2(_Bag2):
    """A file of ROS 2 of a known type, whatever its name."""

    def __init__(self, path: Path, kind: str) -> None:
        self.path, self.is_open = path, False
        storage: Any = self.STORAGE_PLUGINS[kind](path)
        if kind == ".mcap":
            storage.schemas = _Schemas()
        self.storage = storage

    def messages(
        self, connections: Collection[Connection] = (), start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages, decompressed if each was compressed, since the metadata that states it may be missing."""
        for connection, time, data in super().messages(connections, start, stop):
            yield connection, time, unpacked(data) if data[:4] == ZSTD else data


class _Joined:
    """Files of one bag, read together in order of time."""

    def __init__(self, parts: Sequence[Any]) -> None:
        self.parts = parts
        self.connections = [each for part in parts for each in part.connections]

    def messages(
        self, connections: Collection[Connection], start: int | None = None
    ) -> Iterator[tuple[Connection, int, bytes]]:
        """Yield messages in order of time, if each file is in order."""
        topics = {each.topic for each in connections}
        chosen = ((part, [each for each in part.connections if each.topic in topics]) for part in self.parts)
        # For readers, no connections means all of them.
        streams = [part.messages(each, start=start) for part, each in chosen if each]
        return merge(*streams, key=lambda found: found[1])

    def close(self) -> None:
        """Close all files."""
        for part in self.parts:
            part.close()


class _CutMcap(McapReader):
    """An MCAP file of any profile, without its summary, read from the first to the last complete record."""

    is_whole, is_ros1 = False, False
    """Whether all its data is there, and whether its messages are of ROS 1."""

    def _open(self) -> None:
        assert self.bio is not None
        self.schemas = _Schemas()
        self.data_start = 8
        self.data_end = self._end_of_records()
        self.meta_scan()
        self.is_ros1 = any(channel.message_encoding == "ros1" for channel in self.channels.values())
        encoding, counts = "ros1" if self.is_ros1 else "cdr", getattr(self.statistics, "channel_message_counts", {})
        self.connections = [
            each._replace(msgtype=MIDDLE.sub(r"\1/msg/\2", each.msgtype), msgcount=counts.get(each.id, 0))
            for each in self.connections
            if self.channels[each.id].message_encoding == encoding
        ]

    def _end_of_records(self) -> int:
        """Return the end of the last complete record with data."""
        assert self.bio is not None
        size = self.bio.seek(0, 2)
        end = 8
        while end + 9 <= size:
            self.bio.seek(end)
            kind, length = self.bio.read(1), int.from_bytes(self.bio.read(8), "little")
            # Beyond the end of data there is nothing left to read.
            self.is_whole = kind == b"\x0f"
            if self.is_whole or end + 9 + length > size:
                break
            end += 9 + length
        return end

    def messages(
        self, connections: Collection[Connection], start: int | None = None, stop: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages in the order of the file."""
        yield from self.messages_scan(connections, start, stop)
