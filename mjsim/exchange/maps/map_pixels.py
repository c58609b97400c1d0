"""Reads map images: PGM, PPM, PBM, PNG, JPEG and BMP of any depth and number of channels, as fractions of white."""

import re

import numpy as np
from numpy.typing import NDArray

from mjsim.exchange.maps.png_in import HEAD, plain_png
from mjsim.geometry import Array
from mjsim.models import FIRST_BYTES, any_picture_size, bounded_size

Cells = NDArray[np.bool_]
_GAP = rb"(?:\s|#[^\n]*\n)+"
_SIZE = re.compile(rb"P([1-6])" + _GAP + rb"(\d{1,9})" + _GAP + rb"(\d{1,9})")
_LARGEST = re.compile(_GAP + rb"(\d{1,9})")
_HEAD = 4096
"""Maximum size of a header, including comments [bytes]."""


def gray_of(data: bytes) -> tuple[Array, Cells]:
    """Return whiteness, 0 to 1, averaged over channels, and opacity of each pixel, each of shape (rows, columns).

    Raises:
        ValueError: The data is not such an image, is truncated, or has too many pixels.
    """
    if not data:
        raise ValueError("is empty; write a PGM or PNG picture")
    channels = _decoded(data) if data.startswith(FIRST_BYTES) else _of_pnm(data)
    opaque = np.ones(channels.shape[:2], dtype=bool)
    if channels.shape[2] in (2, 4):
        opaque, channels = channels[..., -1] >= 0.5, channels[..., :-1]
    return np.asarray(channels.mean(axis=2, dtype=np.float32)), opaque


def claimed_pixels(data: bytes) -> int:
    """Return the number of pixels that a picture claims to have; 0 if it is not such a picture."""
    head = _SIZE.match(data[:_HEAD])
    try:
        columns, rows = map(int, head.groups()[1:]) if head else any_picture_size(data)
    except ValueError:
        return 0
    return columns * rows


def _decoded(data: bytes) -> NDArray[np.float32]:
    """Return the channels of a PNG, JPEG or BMP, alpha last, 0 to 1, shape (rows, columns, channels)."""
    import cv2

    any_picture_size(data)
    data = plain_png(data) if data.startswith(HEAD) else data
    picture = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    if picture is None or picture.dtype not in (np.uint8, np.uint16):
        raise ValueError("cannot be read as a map; write it as a PGM or PNG picture")
    largest = 255.0 if picture.dtype == np.uint8 else 65535.0
    picture = picture if picture.ndim == 3 else picture[..., None]
    return np.asarray(picture.astype(np.float32) / np.float32(largest))


def _of_pnm(data: bytes) -> NDArray[np.float32]:
    """Return the channels of a portable bitmap, greymap or pixmap, 0 to 1, shape (rows, columns, channels).

    References:
        Netpbm manual pages pbm(5), pgm(5) and ppm(5).
    """
    head = _SIZE.match(data[:_HEAD])
    if head is None:
        raise ValueError("is not a PGM, PPM, PNG or JPEG picture; convert it")
    kind, columns, rows = (int(number) for number in head.groups())
    largest, end = 1, head.end()
    if kind not in (1, 4):
        limit = _LARGEST.match(data[: _HEAD + 20], end)
        largest, end = (int(limit[1]), limit.end()) if limit else (0, end)
    if not columns or not rows or not 0 < largest <= 65535:
        raise ValueError(
            f"is a picture of {columns} x {rows} pixels with values up to {largest}; write 8 or 16 bits per pixel"
        )
    bounded_size(columns, rows)
    depth = 3 if kind in (3, 6) else 1
    values = _plain(data[end:], kind) if kind < 4 else _raw(data[end + 1 :], kind, columns, largest)
    if len(values) < rows * columns * depth:
        raise ValueError(f"is truncated; {columns} x {rows} pixels need {rows * columns * depth} numbers")
    share = values[: rows * columns * depth].astype(np.float32).reshape(rows, columns, depth) / np.float32(largest)
    return np.asarray(1.0 - share if kind in (1, 4) else np.minimum(share, 1.0), dtype=np.float32)


def _raw(data: bytes, kind: int, columns: int, largest: int) -> NDArray[np.generic]:
    """Return the values of a binary image."""
    if kind == 4:
        stride = (columns + 7) // 8
        whole = np.frombuffer(data[: len(data) // stride * stride], dtype=np.uint8).reshape(-1, stride)
        return np.unpackbits(whole, axis=1)[:, :columns].ravel()
    if largest < 256:
        return np.frombuffer(data, dtype=np.uint8)
    return np.frombuffer(data[: len(data) // 2 * 2], dtype=">u2")


def _plain(data: bytes, kind: int) -> NDArray[np.generic]:
    """Return the values of a text image; bits need no spaces between them."""
    text = re.sub(rb"#[^\n]*", b"", data)
    words = re.findall(rb"[01]", text) if kind == 1 else text.split()
    try:
        return np.array(words, dtype=np.int64) if words else np.zeros(0, dtype=np.int64)
    except (ValueError, OverflowError):
        raise ValueError("holds a value that is not a number; export it again") from None
