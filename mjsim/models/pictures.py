"""Recognises pictures from the header and the end of a file, without decoding them."""

import struct

MOST_PIXELS = 40_000_000


def picture_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a PNG or JPEG file [px].

    Raises:
        ValueError: It is neither, is truncated, or has too many pixels.

    References:
        PNG specification (W3C, 2003), sections 5.2 and 11.2.2; ITU-T T.81 (JPEG), annex B.
    """
    if data.startswith(b"\x89PNG\r\n\x1a\n"):
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
        raise ValueError(f"is a picture of {width} x {height} pixels; both must be above 0")
    if width * height > MOST_PIXELS:
        raise ValueError(
            f"is a picture of {width * height / 1e6:.0f} megapixels; it must have at most {MOST_PIXELS / 1e6:.0f}"
        )
    return width, height


def _png_size(data: bytes) -> tuple[int, int]:
    if len(data) < 33 or data[12:16] != b"IHDR":
        raise ValueError("is a damaged PNG picture; save it again")
    place = 8
    while place + 12 <= len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        place += 12 + length
        if kind == b"IEND":
            width, height = struct.unpack(">II", data[16:24])
            return width, height
    raise ValueError("is a truncated PNG picture; save it again")


def _jpeg_size(data: bytes) -> tuple[int, int]:
    place = 2
    while place + 9 <= len(data) and data[place] == 0xFF:
        kind = data[place + 1]
        if kind == 0xFF:  # a fill byte
            place += 1
        elif 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):  # a frame header
            height, width = struct.unpack(">HH", data[place + 5 : place + 9])
            if b"\xff\xd9" not in data[-4096:]:
                raise ValueError("is a truncated JPEG picture; save it again")
            return width, height
        else:
            place += 2 + struct.unpack(">H", data[place + 2 : place + 4])[0]
    raise ValueError("is a damaged JPEG picture; save it again")
