"""Decompresses parts of bags within a bound: a few bytes may claim to be any number of gigabytes."""

import shutil
import sys
from bz2 import BZ2Decompressor
from collections.abc import Callable
from pathlib import Path
from tempfile import gettempdir
from typing import Any

from lz4.frame import LZ4FrameDecompressor
from rosbags.rosbag1 import reader as rosbag1
from rosbags.rosbag2 import storage_mcap

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of zstd data; CDR messages start with a zero."""
MAX_PART = 1 << 30
"""Maximum size of a chunk or of a message [bytes]."""
SPARE = 1 << 30
"""Space that stays free on the disk to which a file is unpacked [bytes]."""
_STEP = 1 << 22
MAGICS = (b"SQLite format 3\x00", b"\x89MCAP")
"""First bytes of the files of a ROS 2 bag."""


def unpacked(data: bytes, *, limit: int = MAX_PART) -> bytes:
    """Return decompressed zstd data.

    Raises:
        ValueError: They were cut, or would be larger than the limit [bytes].
    """
    return _bounded(zstd.ZstdDecompressor, data, limit)


def _bounded(make: Callable[[], Any], data: bytes, limit: int) -> bytes:
    """Return decompressed data of one or several streams, one after the other."""
    parts: list[bytes] = []
    left = limit
    while data:
        unpacker = make()
        parts.append(unpacker.decompress(data, left + 1))
        left -= len(parts[-1])
        if left < 0:
            raise ValueError(f"a part unpacks to more than {limit:,} bytes")
        if not unpacker.eof:
            raise ValueError("a compressed part was cut")
        data = unpacker.unused_data or b""
    return parts[0] if len(parts) == 1 else b"".join(parts)


def bound_unpacking() -> None:
    """Give the readers of rosbags decompressors with a bound; what they return for valid data stays the same."""
    storage_mcap.DECOMPRESSORS.update(
        zstd=lambda data, size: _bounded(zstd.ZstdDecompressor, data, min(size, MAX_PART)),
        lz4=lambda data, size: _bounded(LZ4FrameDecompressor, data, min(size, MAX_PART)),
    )
    rosbag1.decompressors.update(
        bz2=lambda data: _bounded(BZ2Decompressor, data, MAX_PART),
        lz4=lambda data: _bounded(LZ4FrameDecompressor, data, MAX_PART),
    )


def require_unpackable(file: Path) -> None:
    """Check that a file compressed as a whole is one of a bag, and that there is space to unpack it.

    Raises:
        ValueError: It is not of a bag, or there is too little space.
    """
    free, size = shutil.disk_usage(gettempdir()).free - SPARE, 0
    with zstd.open(file, "rb") as content:
        while part := content.read(_STEP):
            if not size and not part.startswith(MAGICS):
                raise ValueError(f"{file.name} holds neither SQLite nor MCAP")
            size += len(part)
            if size > free:
                space = f"the {max(free, 0) >> 20:,} MB that are free in '{gettempdir()}'"
                raise ValueError(f"{file.name} unpacks to more than {space}; free space, or set TMPDIR")
