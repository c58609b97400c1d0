"""Recorders whose clock was set back: their messages are read in the order of the file, with continuous times.

Readers sort messages by the time of recording, which mixes the parts before and after.
"""

import re
from collections.abc import Callable, Collection, Generator, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from struct import iter_unpack, unpack_from
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag1.reader import Header, RecordType, read_bytes, read_uint32
from rosbags.rosbag2.storage_mcap import McapReader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader

from mjsim.geometry import Array
from mjsim.logs.bags.parser_faults import ZSTD, BrokenBagError, parsing, unpacked

AGREEING_MESSAGES = 4
"""Number of messages of a topic before and after, which must be evenly spaced."""
MIN_STEP_BACK, MIN_PERIODS, MAX_STEP_BACK = 0.02, 1.5, 3600.0
"""A clock that was set back by less than the first [s], or by fewer periods of a topic, cannot be told from delays;
more than the last is another recording [s]."""
MAX_STEPS_BACK = 1000
"""Topics whose times go back more often are in no order."""
MESSAGE_INDEX = 0x07
"""Type of the record of MCAP with the times of messages."""
NUMBERED = re.compile(r".*?(\d{1,6})(?:\.[a-z]\w*)*")
"""Name of a file of a bag that was split."""
MAX_INDEX = 1 << 26
"""Maximum size of the times of the messages of a chunk [bytes]."""
Messages = Callable[[], Iterator[tuple[str, int, bytes]]]


@dataclass(frozen=True, slots=True, eq=False)
class FileOrder:
    """The messages of a file in its order."""

    topics: Sequence[str]
    """Topic of each message."""
    times: NDArray[np.int64]
    """When they were recorded [ns]."""
    read: Messages
    """Yields topic, time and data of each."""


def order_of(reader: Any) -> FileOrder | None:
    """Return the order of an open file of a bag; None if it does not follow from its index."""
    if isinstance(reader, Reader1):
        return _order_of_bag1(reader) if reader.chunks else None
    if isinstance(reader, Sqlite3Reader):
        return _order_of_sqlite(reader)
    if isinstance(reader, McapReader) and reader.chunks:
        return _order_of_mcap(reader)
    return None


def _order_of_bag1(reader: Reader1) -> FileOrder:
    names = {each.id: each.topic for each in reader.connections}
    numbers = [number for number in reader.indexes if number in names]
    columns = [np.array([*map(tuple, reader.indexes[number])], dtype=np.int64).reshape(-1, 3) for number in numbers]
    entries = np.concatenate([np.zeros((0, 3), dtype=np.int64), *columns])
    topics = np.repeat(np.array(numbers, dtype=np.int64), [len(rows) for rows in columns])
    order = np.lexsort((entries[:, 2], entries[:, 1]))
    times, listed = entries[order, 0], [names[number] for number in topics[order].tolist()]

    def read() -> Iterator[tuple[str, int, bytes]]:
        assert reader.bio is not None
        current, content = -1, BytesIO()
        for (time, place, offset), topic in zip(entries[order].tolist(), listed, strict=True):
            if place != current:
                chunk = reader.chunks[place]
                reader.bio.seek(chunk.datapos)
                current, content = place, BytesIO(chunk.decompressor(read_bytes(reader.bio, chunk.datasize)))
            content.seek(offset)
            while Header.read(content).get_uint8("op") == RecordType.CONNECTION:
                content.seek(read_uint32(content), 1)
            yield topic, time, read_bytes(content, read_uint32(content))

    return FileOrder(listed, times, read)


def _order_of_sqlite(reader: Sqlite3Reader) -> FileOrder:
    assert reader.dbconn is not None
    database, names = reader.dbconn, {each.id: each.topic for each in reader.connections}
    rows = [(names[topic], time) for topic, time in _rows(database, "topic_id, timestamp") if topic in names]

    def read() -> Iterator[tuple[str, int, bytes]]:
        for topic, time, data in _rows(database, "topic_id, timestamp, data"):
            if topic in names:
                yield names[topic], time, data

    return FileOrder([topic for topic, _ in rows], np.array([time for _, time in rows], dtype=np.int64), read)


def _rows(database: Any, columns: str) -> Iterator[Any]:
    yield from database.execute(f"SELECT {columns} FROM messages ORDER BY rowid")


def _order_of_mcap(reader: McapReader) -> FileOrder | None:
    assert reader.bio is not None
    names = {each.id: each.topic for each in reader.connections}
    found: list[tuple[str, int]] = []
    for chunk in sorted(reader.chunks, key=lambda each: each.chunk_start_offset):
        if chunk.message_index_length > MAX_INDEX:
            return None
        reader.bio.seek(chunk.chunk_start_offset + chunk.chunk_length)
        index, at, entries = reader.bio.read(chunk.message_index_length), 0, list[tuple[int, int, int]]()
        while at + 15 <= len(index):
            kind, length, channel, _ = unpack_from("<BQHI", index, at)
            if kind == MESSAGE_INDEX and channel in names:
                entries += [
                    (place, time, channel) for time, place in iter_unpack("<QQ", index[at + 15 : at + 9 + length])
                ]
            at += 9 + length
        found += [(names[channel], time) for _, time, channel in sorted(entries)]
    if len(found) != sum(each.msgcount for each in reader.connections):
        return None

    def read() -> Iterator[tuple[str, int, bytes]]:
        for connection, time, data in reader.messages_scan(reader.connections):
            yield connection.topic, time, data

    return FileOrder([topic for topic, _ in found], np.array([time for _, time in found], dtype=np.int64), read)


class InFileOrder:
    """A reader of a bag that yields its messages in the order of its files, with corrected times."""

    def __init__(self, reader: Any, files: Sequence[FileOrder], rows: Array, shifts: NDArray[np.int64]) -> None:
        """Take an open reader.

        Args:
            reader: Reader of rosbags, or one like it.
            files: Files in order of time.
            rows: Messages before which the clock was set, counted over all files, shape (N,).
            shifts: Offsets added to times before the first of these and from each on, shape (N + 1,) [ns].
        """
        self._reader, self._files, self._rows, self._shifts = reader, files, rows, shifts
        self.connections = reader.connections

    def messages(
        self, connections: Collection[Connection], start: int | None = None
    ) -> Generator[tuple[Connection, int, bytes], None, None]:
        """Yield messages, decompressed if they were compressed one by one: readers of single files do not do that."""
        chosen, row = {each.topic: each for each in connections}, 0
        for file in self._files:
            for topic, time, data in file.read():
                corrected = time + int(self._shifts[np.searchsorted(self._rows, row, side="right")])
                row += 1
                if topic in chosen and (start is None or corrected >= start):
                    yield chosen[topic], corrected, unpacked(data) if data[:4] == ZSTD else data

    def close(self) -> None:
        """Close it."""
        self._reader.close()


def going_on(reader: Any, files: Sequence[Any]) -> tuple[Any, list[tuple[float, float]]]:
    """Return a reader whose times continue where the clock of its recorder was set back.

    Args:
        reader: Reader of a bag.
        files: Readers of its files.

    Returns:
        reader: As given, if the clock was never set back.
        set_back: Times at which it was set back, by the corrected clock, and by how much [s].
    """
    try:
        with parsing():
            orders = [order_of(file) for file in files]
    except BrokenBagError:
        # The order of a damaged file is unknown; its messages are read as far as they go.
        return reader, []
    whole = [order for order in orders if order is not None]
    if len(whole) < len(orders) or not any(len(order.times) for order in whole):
        return reader, []
    known = [order for order in _one_after_the_other(files, whole) if len(order.times)]
    times = np.concatenate([order.times for order in known])
    if not (np.diff(times) < 0).any():
        return reader, []
    numbers: dict[str, int] = {}
    topics = [numbers.setdefault(topic, len(numbers)) for order in known for topic in order.topics]
    found = set_backs(np.array(topics, dtype=np.intp), (times - times[0]) * 1e-9)
    if not found:
        return reader, []
    rows = np.array([row for row, _ in found])
    shifts = np.cumsum([0, *(round(back * 1e9) for _, back in found)])
    # The clock is right in the longest part, as that of headers is.
    ends = [0, *rows.tolist(), len(times)]
    lengths = [int(np.ptp(times[begin:end])) for begin, end in pairwise(ends)]
    shifts -= shifts[int(np.argmax(lengths))]
    moments = (times[rows] + shifts[1:]) * 1e-9
    set_back = list(zip(moments.tolist(), (back for _, back in found), strict=True))
    return InFileOrder(reader, known, rows, shifts), set_back


def _one_after_the_other(files: Sequence[Any], orders: Sequence[FileOrder]) -> list[FileOrder]:
    """Return files by their numbers, as in run_0.mcap, run_1.mcap; without consecutive numbers by their first times."""
    names = [NUMBERED.fullmatch(Path(str(file.path)).name) for file in files]
    numbers = [int(name[1]) if name else -1 for name in names]
    first = min(numbers, default=-1)
    if first < 0 or sorted(numbers) != list(range(first, first + len(numbers))):
        numbers = [int(order.times[0]) if len(order.times) else 0 for order in orders]
    return [orders[k] for k in np.argsort(numbers, kind="stable").tolist()]


def set_backs(topics: NDArray[np.intp], times: Array) -> list[tuple[int, float]]:
    """Return the messages before which the clock of a recorder was set back, and by how much [s].

    Args:
        topics: Topics of each message in the order of the file, shape (N,).
        times: When each was recorded, shape (N,) [s].
    """
    rows_of = [np.flatnonzero(topics == topic) for topic in range(int(topics.max()) + 1)]
    drops = sorted(
        (int(rows[k]), int(rows[k - 1]), period, back, topic)
        for topic, rows in enumerate(rows_of)
        for k, period, back in _drops(times[rows])
    )
    found: list[tuple[int, float]] = []
    while drops:
        # Drops of several topics belong to one event if it fits between their last messages before and first ones
        # after.
        first = drops[0][0]
        together = [drop for drop in drops if drop[1] < first]
        drops = [drop for drop in drops if drop[1] >= first]
        _, back = min((period, back) for _, _, period, back, _ in together)
        # The first messages with the new clock may be of other topics.
        last = max(before for _, before, *_ in together)
        first = next((row for row in range(last + 1, first) if times[row] < times[last]), first)
        others = set(range(len(rows_of))) - {topic for *_, topic in together}
        against = sum(_goes_on(rows_of[topic], times, first, back) for topic in others)
        if against < len(together):
            found.append((first, back))
    return found


def _drops(times: Array) -> Iterator[tuple[int, float, float]]:
    """Yield each message of a topic before which its times went back for good, its period and by how much [s]."""
    rows = np.flatnonzero(np.diff(times) < 0.0) + 1
    for row in rows.tolist() if len(rows) <= MAX_STEPS_BACK else ():
        before, after = times[max(row - AGREEING_MESSAGES, 0) : row], times[row : row + AGREEING_MESSAGES]
        steps = np.concatenate([np.diff(before), np.diff(after)])
        if len(before) < AGREEING_MESSAGES or len(after) < AGREEING_MESSAGES or (steps <= 0.0).any():
            continue
        period = float(np.median(steps))
        missing = before[-1] + period * np.arange(1, AGREEING_MESSAGES + 1) - after
        back = float(np.median(missing))
        if max(MIN_STEP_BACK, MIN_PERIODS * period) < back < MAX_STEP_BACK and np.ptp(missing) < back / 2.0:
            yield row, period, back


def _goes_on(rows: NDArray[np.intp], times: Array, row: int, back: float) -> bool:
    """Return whether the times of a topic contradict that the clock was set back before a message."""
    place = int(np.searchsorted(rows, row))
    near = times[rows[max(place - AGREEING_MESSAGES, 0) : place + AGREEING_MESSAGES]]
    if not 0 < place < len(rows) or len(near) < 2 * AGREEING_MESSAGES:
        return False
    return bool(
        MIN_PERIODS * float(np.median(np.abs(np.diff(near)))) < back and times[rows[place]] >= times[rows[place - 1]]
    )
