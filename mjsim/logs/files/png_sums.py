"""Checks the checksums of PNG files: OpenCV decodes damaged ones, and prints lines of its own to standard error.

References:
    W3C, Portable Network Graphics (PNG) Specification, second edition, section 5.3.
"""

import struct
import zlib

HEAD = b"\x89PNG\r\n\x1a\n"
REQUIRED_CHUNKS = (b"IHDR", b"PLTE", b"IDAT")
"""Chunks without which there is no picture."""
HEADER = struct.Struct(">I4s")
"""Length and kind of a chunk."""
CHECKSUM_BYTES = 4
"""Length of the checksum after each chunk [bytes]."""


def require_sound(data: bytes) -> None:
    """Check the checksums of a PNG file; other files pass.

    Raises:
        ValueError: One is wrong.
    """
    place, view = len(HEAD), memoryview(data)
    while data.startswith(HEAD) and place + HEADER.size + CHECKSUM_BYTES <= len(data):
        length, kind = HEADER.unpack_from(data, place)
        end = place + HEADER.size + length
        if kind in REQUIRED_CHUNKS and zlib.crc32(view[place + 4 : end]) != int.from_bytes(
            view[end : end + CHECKSUM_BYTES], "big"
        ):
            raise ValueError("a damaged PNG picture")
        place = end + CHECKSUM_BYTES
