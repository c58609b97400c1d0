"""Bags of ROS 1 and ROS 2 as files: their topics, and the bytes of their messages, without ROS.

    x.bag                      ROS 1, version 2.0; chunks plain, bz2 or lz4
    folder with metadata.yaml  ROS 2; files below
    x.db3, x.mcap              ROS 2: SQLite, or MCAP with chunks plain, lz4 or zstd; ROS 1 in MCAP

A folder whose metadata is missing or wrong is read file by file; files of one bag have the same name with a number at
the end. A file that was truncated or not closed is read up to its end. Messages of standard types are decoded.
"""

import re
import struct
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from numpy.typing import NDArray

from mjsim.closing import Closes
from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.logs.bags.parser_faults import BrokenBagError, parsing

MAGICS = {b"#ROSBAG V": ".bag", b"SQLite format 3\x00": ".db3", b"\x89MCAP": ".mcap"}
"""First bytes of files -> usual suffix of their names."""
PROFILE = slice(17, 25)
"""Position of the profile in an MCAP file: after its magic and the head of its first record."""
ROS2 = b"\x04\x00\x00\x00ros2"
METADATA = "metadata.yaml"
"""Name of the metadata file in the folder of a ROS 2 bag."""
NUMBER = re.compile(r"_\d+$")
"""Number at the end of the name of one of several files of a bag."""
MIN_SKIP_NS = 10_000_000_000
"""To reach a message more than this much later, skip instead of reading on [ns]."""
MAX_WAITING = 64 << 20
"""Maximum size of messages kept while reading on to another one [bytes]."""


@dataclass(frozen=True, slots=True)
class RosMessage:
    """A message as stored in a bag."""

    topic: str
    time: int
    """When it was recorded [ns]."""
    data: bytes


def is_bag(path: Path) -> bool:
    """Return whether a file begins like a bag, or a folder contains one."""
    if path.is_dir():
        return (path / METADATA).is_file() or bool(_files_in(path))
    return path.is_file() and _kind_of(path) is not None


class Bag(Closes):
    """A bag opened for reading; only one thread may use it.

    Raises:
        UsageError: The package that reads bags is not installed, or this is not a bag; every method raises the latter.
    """

    def __init__(self, path: Path) -> None:
        """Open it."""
        self.path = path
        try:
            from mjsim.logs.bags.bag_order import going_on
            from mjsim.logs.bags.container_readers import decoder_of, files_of, open_reader
        except ImportError as error:
            raise UsageError(
                f"ROS bags need a package that is not installed ({error.name}): pip install 'mjsim[ros]'"
            ) from None
        described = path if (path / METADATA).is_file() else None
        for each in path.iterdir() if described is not None else ():
            # A pipe without a writer would block forever.
            if each.exists() and not each.is_file() and not each.is_dir():
                raise UsageError(f"cannot read '{each}': it is not a file; copy its contents into one")
        try:
            files = {file: _kind_of(file) or file.suffix.lower() for file in _files_of(path)}
            self._reader, self.cut, self.misdescribed = open_reader(files, described=described)
            with parsing():
                self.is_ros2, self._decode = decoder_of(self._reader)
                self._reader, self.set_back = going_on(self._reader, files_of(self._reader))
        except BrokenBagError as error:
            raise UsageError(f"'{path}' is not a readable bag: {error}"[:MAX_MESSAGE_LENGTH]) from None
        # `set_back`: when the clock of the recorder was set back, and by how much [s]; its times go on there.
        self.types: Mapping[str, str] = {each.topic: each.msgtype for each in self._reader.connections}
        """Topic -> name of its type, such as 'sensor_msgs/msg/LaserScan'."""
        self.counts: Counter[str] = Counter()
        """Topic -> number of its messages, from the index of the bag."""
        for each in self._reader.connections:
            self.counts[each.topic] += each.msgcount

    def messages(self, topics: Collection[str], *, start: int | None = None) -> Iterator[RosMessage]:
        """Yield the messages of some topics in the order in which they were recorded.

        If a bag is damaged, only the messages before the damage are read; `cut` has the reason.

        Args:
            topics: Topics of the bag.
            start: Skip messages recorded before [ns].
        """
        chosen = [each for each in self._reader.connections if each.topic in topics]
        if not chosen:
            return
        found = self._reader.messages(chosen, start=start)
        try:
            with parsing():
                for connection, time, data in found:
                    yield RosMessage(connection.topic, time, bytes(data))
        except BrokenBagError as error:
            self.cut = self.cut or f"{error}"

    def decode(self, message: RosMessage) -> Any:
        """Return a decoded message, with the field names of ROS.

        Raises:
            ValueError: It does not match its type.
        """
        try:
            with parsing():
                return self._decode(message.data, self.types[message.topic])
        except BrokenBagError as error:
            raise ValueError(f"a message on '{message.topic}' is not of its type: {error}") from error

    def stamp(self, message: RosMessage) -> float:
        """Return the stamp of the header at the start of a message, 0 if it is too short to have one [s].

        Both serialisations have it at the same place: after the sequence number of ROS 1, or after the CDR
        encapsulation, which gives the byte order.
        """
        if len(message.data) < 12:
            return 0.0
        order = ">" if self.is_ros2 and message.data[1] == 0 else "<"
        seconds, nanoseconds = struct.unpack_from(f"{order}II", message.data, 4)
        return float(seconds) + 1e-9 * float(nanoseconds)

    def close(self) -> None:
        """Close the file."""
        self._reader.close()


class BagMessages:
    """Gives messages of a bag by topic and index; efficient if the indices of each topic mostly ascend."""

    def __init__(self, bag: Bag, times: Mapping[str, NDArray[np.int64]]) -> None:
        """Store when the messages of each topic were recorded, in the order of the bag [ns]."""
        self._bag, self._times = bag, times
        self._sorted = all((np.diff(column) >= 0).all() for column in times.values())
        self._waiting: dict[tuple[str, int], RosMessage] = {}
        self._held = 0
        self._begin(None)

    def take(self, topic: str, number: int) -> RosMessage:
        """Return a message of a topic.

        Raises:
            UsageError: It cannot be read again.
        """
        key = topic, number
        if key not in self._waiting and (number < self._next[topic] or self._is_far(topic, number)):
            self._begin(int(self._times[topic][number]))
        while key not in self._waiting:
            message = next(self._messages, None)
            if message is None:
                raise UsageError(f"'{self._bag.path}': message {number} on '{topic}' cannot be read again")
            self._keep(message, key)
        found = self._waiting.pop(key)
        self._held -= len(found.data)
        self._drop(lambda other: other[0] == topic and other[1] < number)
        return found

    def _keep(self, message: RosMessage, needed: tuple[str, int]) -> None:
        key = message.topic, self._next[message.topic]
        self._next[message.topic] += 1
        if key != needed and self._held + len(message.data) > MAX_WAITING:
            # It is read again when needed.
            return
        self._waiting[key] = message
        self._held += len(message.data)

    def _drop(self, is_over: Any) -> None:
        for key in [key for key in self._waiting if is_over(key)]:
            self._held -= len(self._waiting.pop(key).data)

    def _is_far(self, topic: str, number: int) -> bool:
        times, following = self._times[topic], self._next[topic]
        return self._sorted and following < len(times) and int(times[number] - times[following]) > MIN_SKIP_NS

    def _begin(self, time: int | None) -> None:
        """Read from a time on [ns], or from the start if the bag is not in order of time."""
        self._waiting, self._held = {}, 0
        start = time if self._sorted else None
        self._messages = self._bag.messages(self._times.keys(), start=start)
        self._next = {
            topic: 0 if start is None else int(np.searchsorted(times, start)) for topic, times in self._times.items()
        }


def _files_of(path: Path) -> list[Path]:
    """Return the files of a bag.

    Raises:
        UsageError: They belong to several bags, and there is no metadata.
    """
    if not path.is_dir():
        return [path]
    files = _files_in(path)
    # A recorder that splits a bag numbers its files.
    if (
        len({(NUMBER.sub("", file.stem), file.suffix.lower()) for file in files}) > 1
        and not (path / METADATA).is_file()
    ):
        raise UsageError(f"'{path}' has no {METADATA} and {len(files)} files of bags; name one of them")
    return files


def _files_in(folder: Path) -> list[Path]:
    """Return the files of a folder that are bags by name and content."""
    named = (file for file in folder.iterdir() if file.suffix.lower() in MAGICS.values())
    return sorted(file for file in named if file.is_file() and _kind_of(file) is not None)


def _kind_of(file: Path) -> str | None:
    """Return '.bag', '.db3' or '.mcap' from the first bytes of a file, whatever its name; None if it is not a bag."""
    with file.open("rb") as stream:
        head = stream.read(PROFILE.stop)
    kind = next((kind for magic, kind in MAGICS.items() if head.startswith(magic)), None)
    return None if kind == ".mcap" and head[PROFILE] != ROS2 and not _holds_ros(file) else kind


def _holds_ros(file: Path) -> bool:
    """Return whether an MCAP file without the profile of ROS 2 has messages of ROS, as converters write them."""
    return not {"ros1msg", "ros2msg", "ros2idl"}.isdisjoint(schemas_of(file).values())


def schemas_of(file: Path) -> dict[str, str]:
    """Return name -> language of the schemas in the summary of an MCAP file; empty for a broken file."""
    with suppress(McapError, UnicodeDecodeError, ValueError, OSError), file.open("rb") as stream:
        summary = make_reader(stream).get_summary()
        known = () if summary is None else summary.schemas.values()
        return {schema.name: schema.encoding for schema in known}
    return {}
