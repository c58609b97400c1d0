"""The light map that is drawn: maps of groups of lights, each times a weight, added up and encoded in 8 bits."""

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.light import GAMMA, BakedLight

DITHER_SEED = 39
"""Seed of the noise that is added before values are rounded, so that smooth light has no steps."""


class LightMix:
    """Adds up the maps again when weights change; the result depends on the weights alone, to the last bit."""

    def __init__(self, baked: BakedLight) -> None:
        """Keep the maps of the groups."""
        self._maps = [group.texels for group in baked.groups]
        self.height, self.width = self._maps[0].shape[:2]
        self._spans = [_rows(each) for each in self._maps]
        self._weights = np.full((len(self._maps), 3), np.nan)
        self._codes = _codes(baked.exposure)
        noise = np.random.default_rng(DITHER_SEED).integers(0, 256, (self.height, self.width, 1), dtype=np.uint16)
        self._noise: NDArray[np.uint16] = noise

    def changed(self, weights: Array) -> tuple[int, NDArray[np.uint8]] | None:
        """Return the rows that new weights change, encoded, with the number of the first; None if none change.

        Args:
            weights: Factor of each group, red, green and blue, shape (groups, 3).
        """
        different = np.flatnonzero((weights != self._weights).any(axis=1))
        everything = np.isnan(self._weights).any()
        self._weights = np.array(weights)
        spans = [self._spans[group] for group in different.tolist() if self._spans[group][1]]
        if everything:
            spans = [(0, self.height)]
        if not spans:
            return None
        first, last = min(span[0] for span in spans), max(span[1] for span in spans)
        return first, self._encoded(first, last)

    def _encoded(self, first: int, last: int) -> NDArray[np.uint8]:
        """Return rows of the map, shape (last - first, width, 3)."""
        light = np.zeros((last - first, self.width, 3), dtype=np.float32)
        for texels, (start, end), weight in zip(self._maps, self._spans, self._weights, strict=True):
            low, high = max(start, first), min(end, last)
            if low < high and weight.any():
                light[low - first : high - first] += texels[low:high] * weight.astype(np.float32)
        codes = self._codes[light.astype(np.float16).view(np.uint16)]
        codes += self._noise[first:last]
        codes >>= 8
        return codes.astype(np.uint8)


def _codes(exposure: float) -> NDArray[np.uint16]:
    """Return the value, in 256ths of a step of 8 bits, of light given as the bits of a half-precision number."""
    light = np.arange(1 << 16, dtype=np.uint16).view(np.float16).astype(np.float64)
    light = np.nan_to_num(light, nan=0.0, posinf=65504.0, neginf=0.0)
    values = np.clip(light * exposure, 0.0, 1.0) ** (1.0 / GAMMA)
    return np.rint(values * (255 * 256)).astype(np.uint16)


def _rows(texels: NDArray[np.float16]) -> tuple[int, int]:
    """Return the first row that is not dark, and the one after the last; 0 and 0 if all are."""
    lit = np.flatnonzero((texels != 0).any(axis=(1, 2)))
    return (int(lit[0]), int(lit[-1]) + 1) if len(lit) else (0, 0)
