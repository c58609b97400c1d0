"""Reads size and orientation of pictures from the header and the end of a file, without decoding them."""

import struct
from collections.abc import Iterator

from mjsim.sentences import Sentence

MAX_PIXELS = 40_000_000
PNG = b"\x89PNG\r\n\x1a\n"
APP1, SCAN = 0xE1, 0xDA
"""Kinds of segments of a JPEG file."""
ORIENTATION, LONG = 274, 4
"""Tag of TIFF, and the type of its values with 32 bits."""
LYING = 5
"""First of the orientations that exchange width and height."""


def picture_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a PNG or JPEG file [px].

    Raises:
        ValueError: It is neither, is truncated, or has too many pixels.

    References:
        PNG specification (W3C, 2003), sections 5.2 and 11.2.2; ITU-T T.81 (JPEG), annex B.
    """
    if data.startswith(PNG):
        width, height = _png_size(data)
    elif data.startswith(b"\xff\xd8\xff"):
        width, height = _jpeg_size(data)
    else:
        raise ValueError("is not a PNG or JPEG picture; convert it")
    return bounded_size(width, height)


def bounded_size(width: int, height: int) -> tuple[int, int]:
    """Return a size unchanged after checking it [px].

    Raises:
        ValueError: It has no pixels, or too many.
    """
    if width <= 0 or height <= 0:
        raise ValueError(Sentence("is a picture of {width} x {height} pixels; both must be above 0", width, height))
    if width * height > MAX_PIXELS:
        raise ValueError(
            Sentence(
                "is a picture of {width:.0f} megapixels; it must have at most {max_pixels:.0f}",
                width * height / 1000000.0,
                MAX_PIXELS / 1000000.0,
            )
        )
    return width, height


def shown_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a PNG or JPEG file as it is shown, turned as its EXIF data say [px].

    Raises:
        ValueError: As for `picture_size`.
    """
    width, height = picture_size(data)
    return (height, width) if orientation(data) >= LYING else (width, height)


def orientation(data: bytes) -> int:
    """Return the orientation of a PNG or JPEG file, 1 to 8; 1 is upright.

    References:
        CIPA DC-008 (EXIF), section 4.6.5: tag 274; TIFF 6.0, section 2.
    """
    try:
        head = _exif(data)
        order = {b"II*\0": "<", b"MM\0*": ">"}[head[:4]]
        (place,) = struct.unpack_from(f"{order}I", head, 4)
        (count,) = struct.unpack_from(f"{order}H", head, place)
        for entry in range(place + 2, place + 2 + 12 * count, 12):
            tag, kind = struct.unpack_from(f"{order}HH", head, entry)
            if tag == ORIENTATION:
                (value,) = struct.unpack_from(f"{order}{'I' if kind == LONG else 'H'}", head, entry + 8)
                return value if 1 <= value <= 8 else 1
    except (KeyError, struct.error):  # damaged EXIF data are ignored
        pass
    return 1


def _exif(data: bytes) -> bytes:
    """Return the EXIF data of a PNG or JPEG file, from their TIFF header on; empty without any."""
    if data.startswith(PNG):
        return next((part for kind, part in _png_chunks(data) if kind == b"eXIf"), b"")
    parts = (part for kind, part in _jpeg_segments(data) if kind == APP1)
    return next((part[6:] for part in parts if part.startswith(b"Exif\0\0")), b"")


def _png_size(data: bytes) -> tuple[int, int]:
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise ValueError("is a damaged PNG picture; save it again")
    if not any(kind == b"IEND" for kind, _ in _png_chunks(data)):
        raise ValueError("is a truncated PNG picture; save it again")
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Yield kind and content of the complete chunks of a PNG file."""
    place = len(PNG)
    while place + 12 <= len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        # Most of a file is one chunk that nobody looks at.
        yield kind, data[place + 8 : place + 8 + length] if kind == b"eXIf" else b""
        place += 12 + length


def _jpeg_size(data: bytes) -> tuple[int, int]:
    for kind, part in _jpeg_segments(data):
        if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC) and len(part) >= 5:  # a frame header
            height, width = struct.unpack(">HH", part[1:5])
            if b"\xff\xd9" not in data[-4096:]:
                raise ValueError("is a truncated JPEG picture; save it again")
            return width, height
    raise ValueError("is a damaged JPEG picture; save it again")


def _jpeg_segments(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield kind and content of the segments of a JPEG file before its first scan."""
    place = 2
    while place + 4 <= len(data) and data[place] == 0xFF and data[place + 1] != SCAN:
        if data[place + 1] == 0xFF:  # a fill byte
            place += 1
            continue
        (length,) = struct.unpack_from(">H", data, place + 2)
        yield data[place + 1], data[place + 4 : place + 2 + length]
        place += 2 + max(length, 2)
