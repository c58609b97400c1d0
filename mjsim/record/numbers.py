"""Conversion of numbers and times to and from messages."""

import base64
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mjsim.geometry import Array

Message = dict[str, Any]
"""A JSON object."""


def flat(values: ArrayLike) -> list[float]:
    """Return an array's numbers, row by row."""
    numbers: list[float] = np.asarray(values, dtype=float).ravel().tolist()
    return numbers


def distances(values: ArrayLike) -> list[float | None]:
    """Return distances, with None for +infinity (no return)."""
    return [None if distance == math.inf else distance for distance in flat(values)]


def number(value: float | None) -> float:
    """Return a number read from JSON, where None stands for +infinity."""
    return math.inf if value is None else value


def numbers(values: Sequence[float | None], *shape: int) -> Array:
    """Return an array of numbers read from JSON, where None stands for +infinity."""
    array = np.array(values, dtype=float).reshape(shape or -1)
    array[np.isnan(array)] = np.inf
    return array


def packed(values: ArrayLike, kind: str = "<f8") -> str:
    """Return numbers as base64, little-endian, row by row; doubles unless another NumPy type is given."""
    return base64.b64encode(np.asarray(values, dtype=kind).tobytes()).decode()


def unpacked(text: str, *shape: int, kind: str = "<f8") -> NDArray[Any]:
    """Return packed numbers, of the type that they were packed as, shape (n,) unless given."""
    dtype = np.dtype(kind)
    return np.frombuffer(base64.b64decode(text), dtype=dtype).reshape(shape or -1).astype(dtype.newbyteorder("="))


def stamp_json(time: float) -> Message:
    """Return a time for JSON messages, rounded to 1 ns."""
    sec, nsec = divmod(nanoseconds(time), 1_000_000_000)
    return {"sec": sec, "nsec": nsec}


def nanoseconds(time: float) -> int:
    """Return a time for files, rounded [ns]."""
    return round(time * 1e9)
