"""Depth pictures packed by RVL (run lengths of zeros, then differences in groups of 3 bits), as ROS drivers send them.

References:
    Wilson, Fast Lossless Depth Image Compression, Proceedings of the ACM Conference on Interactive Surfaces and Spaces
    (ISS) 2017.
"""

import struct

import numpy as np
from numpy.typing import NDArray

SIZE = struct.Struct("<II")
"""Head of the data: number of columns and of rows [px]."""
MAX_NIBBLES = 11
"""Maximum number of nibbles in a number of 32 bits."""


def rvl_size(data: bytes) -> tuple[int, int]:
    """Return width and height of a picture [px].

    Raises:
        ValueError: The data are too short.
    """
    if len(data) < SIZE.size:
        raise ValueError("is a damaged depth picture (RVL)")
    width, height = SIZE.unpack_from(data)
    return int(width), int(height)


def unpack_rvl(data: bytes) -> NDArray[np.uint16]:
    """Return the pixels of a picture of 16 bits, shape (height, width); check `rvl_size` first.

    Raises:
        ValueError: The data are damaged.
    """
    width, height = rvl_size(data)
    numbers, pixels = _numbers(data[SIZE.size :]), width * height
    deltas, places = np.zeros(pixels, dtype=np.int64), np.zeros(pixels, dtype=bool)
    pixel = row = 0
    while pixel < pixels:
        if row + 2 > len(numbers):
            raise ValueError("a damaged depth picture (RVL)")
        zeros, count = int(numbers[row]), int(numbers[row + 1])
        pixel, row = pixel + zeros, row + 2
        if not zeros + count or pixel + count > pixels or row + count > len(numbers):
            raise ValueError("a damaged depth picture (RVL)")
        coded = numbers[row : row + count]
        deltas[pixel : pixel + count] = (coded >> 1) ^ -(coded & 1)
        places[pixel : pixel + count] = True
        pixel, row = pixel + count, row + count
    # Differences are from the last pixel that is not zero.
    return np.where(places, np.cumsum(deltas) & 0xFFFF, 0).astype(np.uint16).reshape(height, width)


def _numbers(packed: bytes) -> NDArray[np.int64]:
    """Return the numbers in groups of 3 bits, the lowest first; a fourth bit says that more bits of a number follow."""
    words = np.frombuffer(packed[: len(packed) // 4 * 4], dtype="<u4")
    # In a word of 32 bits the first nibble is the highest.
    nibbles = (words[:, None] >> np.arange(28, -1, -4, dtype=np.uint32) & 0xF).ravel().astype(np.int64)
    ends = np.flatnonzero(nibbles < 8)
    if not len(ends):
        return np.zeros(0, dtype=np.int64)
    nibbles = nibbles[: ends[-1] + 1]
    begins = np.concatenate([[0], ends[:-1] + 1])
    lengths = ends - begins + 1
    if lengths.max() > MAX_NIBBLES:
        raise ValueError("a damaged depth picture (RVL)")
    shifts = 3 * (np.arange(len(nibbles)) - np.repeat(begins, lengths))
    return np.asarray(np.add.reduceat((nibbles & 7) << shifts, begins), dtype=np.int64)
