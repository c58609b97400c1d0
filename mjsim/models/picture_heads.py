"""Reads the size of a picture from its file header, for formats in logs besides PNG and JPEG."""

import struct
from collections.abc import Callable, Mapping

from mjsim.models.picture_sizes import PNG, bounded_size, picture_size

WIDTH, HEIGHT = 256, 257
"""TIFF tags."""
NUMBERS = {3: "H", 4: "I"}
"""Type of a tag's value -> format character for `struct`."""


def any_picture_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a PNG, JPEG, BMP, TIFF or WebP file [px].

    Raises:
        ValueError: It is none of these formats, is truncated, or has too many pixels.

    References:
        BITMAPINFOHEADER as Microsoft documents it; TIFF 6.0, sections 2 and 3; RFC 9649 (WebP) and RFC 6386 (VP8).
    """
    size_of = next((read for head, read in HEADS.items() if data.startswith(head)), None)
    if size_of is None:
        return picture_size(data)
    try:
        return bounded_size(*size_of(data))
    except struct.error:
        raise ValueError("is a truncated picture; save it again") from None


def _bmp_size(data: bytes) -> tuple[int, int]:
    width, height = struct.unpack_from("<ii", data, 18)
    # A negative height means that the first row is at the top.
    return width, abs(height)


def _tiff_size(data: bytes) -> tuple[int, int]:
    """Return the size of the first page [px]."""
    order = "<" if data.startswith(b"I") else ">"
    (place,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, place)
    found = {WIDTH: 0, HEIGHT: 0}
    for entry in range(place + 2, place + 2 + 12 * count, 12):
        tag, kind = struct.unpack_from(f"{order}HH", data, entry)
        if tag in found and kind in NUMBERS:
            (found[tag],) = struct.unpack_from(f"{order}{NUMBERS[kind]}", data, entry + 8)
    return found[WIDTH], found[HEIGHT]


def _webp_size(data: bytes) -> tuple[int, int]:
    kind = data[8:16]
    if kind == b"WEBPVP8 ":
        width, height = struct.unpack_from("<HH", data, 26)
        return width & 0x3FFF, height & 0x3FFF
    if kind == b"WEBPVP8L":
        (bits,) = struct.unpack_from("<I", data, 21)
        return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
    if kind == b"WEBPVP8X":
        low_width, high_width, low_height, high_height = struct.unpack_from("<HBHB", data, 24)
        return (low_width | high_width << 16) + 1, (low_height | high_height << 16) + 1
    raise ValueError("is a damaged WebP picture; save it again")


HEADS: Mapping[bytes, Callable[[bytes], tuple[int, int]]] = {
    b"BM": _bmp_size,
    b"II*\0": _tiff_size,
    b"MM\0*": _tiff_size,
    b"RIFF": _webp_size,
}
"""First bytes of a file -> function that reads its size."""
FIRST_BYTES = (PNG, b"\xff\xd8\xff", *HEADS)
"""First bytes of a file of any of these formats."""
