"""Trees as one line of JSON, for programs in any language."""

import base64
import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.interface.trees import RecordList, Stack, Text, Tree


def json_line(tree: Tree) -> bytes:
    """Return a tree as a line of JSON.

    A `Stack`, or a float64 array of at most 64 numbers, becomes nested lists; other arrays, such as pictures, become
    `{shape, type, base64}`, rows first. JSON has no infinity: +inf becomes null, -inf (nearer than a sensor measures)
    0.
    """
    return json.dumps(_plain(tree), separators=(",", ":"), allow_nan=False).encode() + b"\n"


def _plain(tree: Tree) -> Any:
    if isinstance(tree, float):
        return _number(tree)
    if isinstance(tree, Mapping):
        return {key: _plain(value) for key, value in tree.items()}
    if isinstance(tree, Stack):
        return _nested(tree.items)
    if isinstance(tree, np.ndarray):
        return _nested(tree) if tree.dtype == np.float64 and tree.size <= 64 else _packed(tree)
    if isinstance(tree, RecordList):
        return [_plain(row) for row in tree.rows]
    if isinstance(tree, Text):
        return tree.text
    if isinstance(tree, (list, tuple)):
        return [_plain(item) for item in tree]
    return tree.item() if isinstance(tree, np.generic) else tree


def _number(value: float) -> float | None:
    if math.isfinite(value):
        return float(value)
    return 0.0 if value == -math.inf else None


def _nested(array: NDArray[Any]) -> Any:
    if np.isfinite(array).all():
        return array.tolist()
    return [_nested(item) if item.ndim else _number(float(item)) for item in array]


def _packed(array: NDArray[Any]) -> dict[str, Any]:
    order = array.dtype.newbyteorder("<")
    data = base64.b64encode(np.ascontiguousarray(array, dtype=order).tobytes()).decode()
    return {"shape": list(array.shape), "type": str(array.dtype), "base64": data}
