"""Normally distributed errors of pixels, from two random bytes per value."""

import math
from typing import Any

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

WORD_BYTES = 8
"""Bytes that a generator makes at a time."""


class PixelNoise:
    """Independent Gaussian errors of all values of a picture, rounded to integers."""

    def __init__(self, deviation: float, stream: Generator) -> None:
        """Tabulate the errors for 65536 equally likely values, so that each pixel value only takes two random bytes.

        Args:
            deviation: Standard deviation.
            stream: Random stream.
        """
        from scipy.special import ndtri  # Computed later, so that a camera without noise does not wait for it.

        self._normal = ndtri((np.arange(1 << 16) + 0.5) / (1 << 16))
        self._stream, self._errors = stream, np.empty((0, 0), dtype=np.int16)
        self.widen(deviation)

    def widen(self, deviation: float) -> None:
        """Use another standard deviation from now on; errors that 16 bits do not hold are clipped."""
        limits = np.iinfo(np.int16)
        self._table = np.clip(np.rint(deviation * self._normal), limits.min, limits.max).astype(np.int16)

    def add_to(self, image: NDArray[np.integer[Any]]) -> None:
        """Add new noise to a picture of any depth of at most 16 bits, in place; the sum is clipped."""
        flat = self.draw(image.shape).reshape(image.shape[0], -1)
        if self._errors.shape != flat.shape:
            self._errors = np.empty(flat.shape, dtype=np.int16)
        cv2.LUT(flat, self._table, dst=self._errors)
        flat_image = image.reshape(flat.shape)
        depth = cv2.CV_8U if image.dtype == np.uint8 else cv2.CV_16S
        cv2.add(flat_image, self._errors, dst=flat_image, dtype=depth)

    def draw(self, shape: tuple[int, ...]) -> NDArray[np.uint16]:
        """Return the random numbers for a picture's values."""
        count = 2 * math.prod(shape)
        if count % WORD_BYTES:
            drawn = np.frombuffer(self._stream.bytes(count), dtype=np.uint16)
        else:  # the same bytes, in half the time
            drawn = self._stream.bit_generator.random_raw(count // WORD_BYTES).view(np.uint16)
        return drawn.reshape(shape)
