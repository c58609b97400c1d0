"""Reduces PNG files to what a decoder accepts silently: fully checked, without chunks other than the image."""

import struct
import zlib
from collections.abc import Iterator, Sequence

HEAD = b"\x89PNG\r\n\x1a\n"
IMAGE_CHUNKS = (b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"IEND")
"""Chunks that affect the image."""
CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Number of channels of each colour type."""
PASSES = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and column and row steps, of each pass of an interlaced image."""
STEP_BYTES = 1 << 20
"""Bytes decompressed at a time."""
DAMAGED = "is a damaged PNG picture; save it again"


def plain_png(data: bytes) -> bytes:
    """Return a PNG file that contains only the image.

    Raises:
        ValueError: The file is truncated or damaged.

    References:
        W3C, Portable Network Graphics (PNG) Specification, second edition, sections 5, 7.2, 8 and 10.
    """
    chunks = [(kind, body) for kind, body in _chunks(data) if kind in IMAGE_CHUNKS]
    if chunks[0][0] != b"IHDR" or len(chunks[0][1]) != 13:
        raise ValueError(DAMAGED)
    columns, rows, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", chunks[0][1])
    if color not in CHANNELS or depth not in (1, 2, 4, 8, 16) or interlaced > 1:
        raise ValueError(DAMAGED)
    areas = _passes(columns, rows) if interlaced else [(columns, rows)]
    bits = CHANNELS[color] * depth
    if not _holds(
        [body for kind, body in chunks if kind == b"IDAT"], sum(h * (1 + (w * bits + 7) // 8) for w, h in areas)
    ):
        raise ValueError(DAMAGED)
    return HEAD + b"".join(
        struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body)) for kind, body in chunks
    )


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield type and content of each chunk, up to the last.

    Raises:
        ValueError: A chunk is truncated, or its checksum is wrong.
    """
    place, kind = len(HEAD), b""
    while kind != b"IEND":
        if len(data) < place + 12:
            raise ValueError(DAMAGED)
        size, kind = struct.unpack_from(">I4s", data, place)
        end = place + 8 + size
        if len(data) < end + 4 or (
            kind in IMAGE_CHUNKS and struct.unpack_from(">I", data, end)[0] != zlib.crc32(data[place + 4 : end])
        ):
            raise ValueError(DAMAGED)
        yield kind, data[place + 8 : end]
        place = end + 4


def _passes(columns: int, rows: int) -> list[tuple[int, int]]:
    """Return width and height of each non-empty pass of an interlaced image [pixels]."""
    sizes = [(-(-(columns - x) // right), -(-(rows - y) // down)) for x, y, right, down in PASSES]
    return [(width, height) for width, height in sizes if width > 0 and height > 0]


def _holds(parts: Sequence[bytes], size: int) -> bool:
    """Return whether compressed data expands to a given number of bytes, without storing the result."""
    unpacker, left = zlib.decompressobj(), size
    try:
        for part in parts:
            rest = part
            while rest and left > 0:
                left -= len(unpacker.decompress(rest, STEP_BYTES))
                rest = unpacker.unconsumed_tail
        while left > 0 and (more := unpacker.decompress(unpacker.unconsumed_tail, STEP_BYTES)):
            left -= len(more)
    except zlib.error:
        return False
    return left <= 0
