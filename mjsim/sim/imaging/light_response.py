"""Tables between pixel values and linear light."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

K = TypeVar("K", np.uint8, np.uint16)
ROOT_OF_WHITE = 1 << 14
"""Square root of the light of white, as integers count it: 14 bits resolve the darkest pixel values as well."""
ROOT_LEVELS = 1 << 15
"""Number of distinct square roots of light; beyond white there is room for four times its light."""


def srgb_light(values: NDArray[np.floating[Any]]) -> Array:
    """Return the linear light of sRGB values in [0, 1].

    References:
        IEC 61966-2-1:1999, section 5.2.
    """
    return np.asarray(np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4), dtype=float)


def light_for(values: NDArray[np.floating[Any]], response: str | tuple[float, ...]) -> Array:
    """Return the light in [0, 1] that a camera with this response encodes as values in [0, 255]."""
    if isinstance(response, str):
        shares = np.asarray(values, dtype=float) / 255.0
        return srgb_light(shares) if response == "srgb" else shares
    return np.asarray(np.interp(values, response, np.linspace(0.0, 1.0, len(response))), dtype=float)


def with_electrons(variance: float) -> NDArray[np.uint16]:
    """Return the table that adds a constant to the light of a root, as read-out noise does to its variance.

    Args:
        variance: What is added, in squared units of the roots.
    """
    roots = np.arange(ROOT_LEVELS, dtype=float)
    return _whole_table(np.rint(np.sqrt(roots * roots + variance)), np.uint16)


def coded(response: str | tuple[float, ...], variance: float) -> NDArray[np.uint8]:
    """Return the table from roots of light, with a constant added to their squares, to the nearest pixel values."""
    ends = np.sqrt(light_for(np.arange(255) + 0.5, response) * ROOT_OF_WHITE**2 + max(variance, 0.0))
    starts = np.concatenate([[0], np.clip(np.ceil(ends), 0, ROOT_LEVELS), [ROOT_LEVELS]]).astype(int)
    return _whole_table(np.repeat(np.arange(256), np.diff(starts)), np.uint8)


def _whole_table(values: NDArray[Any], kind: type[K]) -> NDArray[K]:
    """Return a table of all 16-bit numbers for OpenCV; those that are negative if signed get the first value."""
    return np.concatenate([values, np.full(ROOT_LEVELS, values[0])]).clip(0, ROOT_LEVELS - 1).astype(kind)
