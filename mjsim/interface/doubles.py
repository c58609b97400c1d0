"""Encodes trees as binary doubles for Octave, with an expression that rebuilds the struct; decodes Octave's answers.

The expression depends on the structure alone, not on the numbers: Octave compiles it once, as a function of `d`
(numbers), `e` (where the numbers of each list of varying length end) and `b` (bytes of pictures).
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface.trees import Named, RecordList, Stack, Text, Tree
from mjsim.spelling import ascii_name

_MIN_BULK_ENTRIES = 64
"""Minimum number of entries with which an array is copied as a whole."""


def octave_names(names: Iterable[str]) -> dict[str, str]:
    """Return the field for each name.

    Raises:
        ValueError: Two names become the same field.
    """
    fields: dict[str, str] = {}
    for name in names:
        same = next((other for other, made in fields.items() if made == ascii_name(name)), None)
        if same is not None:
            raise ValueError(f"'{same}' and '{name}' both become the field '{fields[same]}'; rename one")
        fields[name] = ascii_name(name)
    return fields


@dataclass(slots=True)
class Doubles:
    """A tree encoded for Octave."""

    code: str = ""
    """Expression of `d`, `e` and `b`."""
    fixed: list[float] = field(default_factory=list)
    counted: list[Array] = field(default_factory=list)
    bytes: list[NDArray[np.uint8]] = field(default_factory=list)
    _used: int = 0

    def numbers(self) -> tuple[Array, Array]:
        """Return `d` and `e`."""
        ends = np.cumsum([len(self.fixed), *(len(each) for each in self.counted)], dtype=float)
        return np.concatenate([np.array(self.fixed, dtype=float), *self.counted]), ends

    def put(self, tree: Tree) -> str:
        """Take a tree, and return the expression that builds it."""
        if isinstance(tree, (bool, np.bool_)):
            return "true" if tree else "false"
        if isinstance(tree, (int, float, np.integer, np.floating)):
            self.fixed.append(float(tree))
            return f"d({len(self.fixed)})"
        if tree is None:
            return "[]"
        if isinstance(tree, str):
            return quoted(tree)
        if isinstance(tree, Mapping):
            return self._struct(tree)
        if isinstance(tree, Stack):
            return self._stack(tree.items)
        if isinstance(tree, np.ndarray):
            return self._picture(tree) if tree.dtype == np.uint8 else self._array(np.asarray(tree, dtype=float))
        if isinstance(tree, Text):
            return f"char({self._stack(np.frombuffer(tree.text.encode(), np.uint8).astype(float))})"
        return self._table(tree) if isinstance(tree, RecordList) else self._list(tree)

    def _struct(self, tree: Mapping[str, Tree]) -> str:
        names = octave_names(tree) if isinstance(tree, Named) else {name: name for name in tree}
        parts = []
        for name, value in tree.items():
            if isinstance(tree, Named) and isinstance(value, Mapping):
                value = {**value, "name": name}
            code = self.put(value)
            parts.append(f"'{names[name]}',{{{code}}}" if code.startswith("{") else f"'{names[name]}',{code}")
        return f"struct({','.join(parts)})"

    def _list(self, items: Sequence[Tree]) -> str:
        """Put a list: numbers become a row, rows of equal length a matrix, and anything else a cell array."""
        try:
            array = np.array(items)
        except ValueError:
            array = np.array(None)
        if array.dtype.kind in "iuf" and 0 < array.ndim <= 2 and array.size:
            return self._array(np.atleast_2d(array).astype(float))
        return f"{{{','.join(self.put(item) for item in items)}}}"

    def _table(self, table: RecordList) -> str:
        if not table.rows:
            empty = [f"'{key}',{{}}" for key in table.keys]
            return f"struct({','.join(empty)})"
        return f"[{','.join(self.put({key: row[key] for key in table.keys}) for row in table.rows)}]"

    def _stack(self, items: Array) -> str:
        self.counted.append(np.moveaxis(items, 0, -1).ravel(order="F").astype(float, copy=False))
        shape = ",".join(map(str, items.shape[1:] or (1,)))
        last = len(self.counted)
        return f"reshape(d(e({last})+1:e({last + 1})),{shape},[])"

    def _array(self, array: Array) -> str:
        shape = ",".join(map(str, array.shape if array.ndim > 1 else (*array.shape, 1)))
        if array.size > _MIN_BULK_ENTRIES:
            self.counted.append(array.ravel(order="F"))
            return f"reshape(d(e({len(self.counted)})+1:e({len(self.counted) + 1})),{shape})"
        begin = len(self.fixed) + 1
        self.fixed += array.ravel(order="F").tolist()
        return f"reshape(d({begin}:{len(self.fixed)}),{shape})"

    def _picture(self, array: NDArray[np.uint8]) -> str:
        self.bytes.append(array.ravel(order="F"))
        begin, self._used = self._used + 1, self._used + array.size
        return f"reshape(b({begin}:{self._used}),{','.join(map(str, array.shape))})"


def doubles_of(tree: Tree) -> Doubles:
    """Return a tree as an expression with its numbers and bytes.

    Raises:
        ValueError: Two names chosen by the user become the same field.
    """
    made = Doubles()
    made.code = made.put(tree)
    return made


def quoted(text: str) -> str:
    """Return a text as an expression; bytes of UTF-8 where it holds more than plain characters."""
    if text.isascii() and text.isprintable():
        return "'" + text.replace("'", "''") + "'"
    return f"char([{' '.join(map(str, text.encode()))}])"


def answer_of(data: bytes, fields: Sequence[str]) -> dict[str, Any]:
    """Return Octave's answer as written by `mjsim_pack.m`: per field an array, or a text that describes its type.

    Missing fields are left out.
    """
    numbers, at = np.frombuffer(data, dtype=float), 0
    answer: dict[str, Any] = {}
    for name in fields:
        kind, count = int(numbers[at]), int(numbers[at + 1])
        sizes = numbers[at + 2 : at + 2 + count].astype(int)
        at += 2 + count
        body = numbers[at : at + int(sizes.prod())]
        at += len(body)
        if kind == 1:
            answer[name] = body.reshape(sizes, order="F")
        elif kind == 2:
            answer[name] = bytes(body.astype(np.uint8)).decode(errors="replace")
        elif kind == 3:
            answer[name] = json.loads(bytes(body.astype(np.uint8)))
    return answer
