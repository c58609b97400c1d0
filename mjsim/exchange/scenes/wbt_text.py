"""Reads the text of Webots worlds and PROTO files (VRML97 with nodes of its own) as a tree of nodes.

References:
    Webots reference manual, Nodes and API functions; ISO/IEC 14772-1:1997 (VRML97), section 4.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from mjsim.errors import UsageError

MAX_DEPTH, MAX_NODES = 100, 200_000
"""Maximum nesting of nodes, and their maximum number."""
# A text without an end is the rest of the file: searching again from each quote in it would take hours.
_TEXT = r'"(?:[^"\\]|\\.)*+"?'
_TOKEN = re.compile(rf'{_TEXT}|[\[\]{{}}]|[^\s,\[\]{{}}"#]+', re.DOTALL)
_COMMENT = re.compile(rf"({_TEXT})|#[^\n]*", re.DOTALL)
_WORD = re.compile(r"[A-Za-z_][\w:.-]*$")


@dataclass(slots=True, eq=False)
class WbtNode:
    """A node: numbers, texts and other nodes by field."""

    kind: str
    fields: "dict[str, list[Item]]" = field(default_factory=dict)

    def values(self, name: str) -> tuple[float, ...]:
        """Return all numbers of a field.

        Raises:
            ValueError: A number is not finite.
        """
        found = tuple(item for item in self.fields.get(name, []) if isinstance(item, float))
        if not all(map(math.isfinite, found)):
            raise ValueError(f"{self.kind}: {name} is not finite; correct it")
        return found

    def numbers(self, name: str, usual: tuple[float, ...]) -> tuple[float, ...]:
        """Return the first numbers of a field; the usual ones if it has too few."""
        found = self.values(name)
        return found[: len(usual)] if len(found) >= len(usual) else usual

    def number(self, name: str, usual: float) -> float:
        """Return the number of a field."""
        return self.numbers(name, (usual,))[0]

    def text(self, name: str, usual: str = "") -> str:
        """Return the first text of a field."""
        return next((item.text for item in self.fields.get(name, []) if isinstance(item, WbtText)), usual)

    def said(self, name: str, *, usual: bool) -> bool:
        """Return the truth value of a field."""
        return next((item for item in self.fields.get(name, []) if isinstance(item, bool)), usual)

    def nodes(self, name: str) -> "list[WbtNode]":
        """Return the nodes of a field."""
        return [item for item in self.fields.get(name, []) if isinstance(item, WbtNode)]

    def node(self, name: str) -> "WbtNode | None":
        """Return the first node of a field."""
        return next(iter(self.nodes(name)), None)


@dataclass(frozen=True, slots=True)
class WbtText:
    """A text in quotes, or the name of a field of a PROTO after IS."""

    text: str
    is_field: bool = False


Item = float | bool | WbtText | WbtNode


@dataclass(frozen=True, slots=True, eq=False)
class _Defined:
    """A node with a name, which others may use."""

    node: WbtNode
    count: int
    """Number of nodes in it, including itself and the nodes that it uses."""
    depth: int
    """Their nesting."""


class Parser:
    """Reads the nodes of a file."""

    def __init__(self, text: str, where: str) -> None:
        """Take the text of a file.

        Args:
            text: The text.
            where: For errors.
        """
        self._where, self._tokens = where, _TOKEN.findall(_COMMENT.sub(lambda match: match[1] or " ", text))
        self._place, self._count, self._deepest = 0, 0, 0
        self._defined: dict[str, _Defined] = {}
        self.protos: list[str] = []
        """Addresses of the PROTO files that it names."""

    def nodes(self) -> Iterator[WbtNode]:
        """Yield the nodes of a world.

        Raises:
            UsageError: The text is malformed.
        """
        while self._place < len(self._tokens):
            token = self._tokens[self._place]
            if token == "IMPORTABLE":
                self._place += 1
            elif token == "EXTERNPROTO":
                self.protos.append(self._next(1).strip('"'))
                self._place += 1
            else:
                yield self._node(0)

    def proto(self) -> tuple[dict[str, "list[Item]"], WbtNode]:
        """Return the fields of a PROTO with their usual values, and its node.

        Raises:
            UsageError: The text is malformed.
        """
        while self._peek() in ("EXTERNPROTO", "IMPORTABLE"):
            self._place += 1 if self._peek() == "IMPORTABLE" else 2
        if self._peek() != "PROTO" or self._next(2) != "[":
            raise self._wrong("PROTO NAME [")
        self._place += 1
        fields: dict[str, list[Item]] = {}
        while self._peek() != "]":
            if self._peek() not in ("field", "vrmlField", "unconnectedField", "exposedField"):
                raise self._wrong("field")
            if self._next(2) == "{":  # Values to choose from.
                self._place += 1
                while self._peek() != "}":
                    self._value(0)
                self._place += 1
            name = self._peek()
            self._place += 1
            fields[name] = self._value(0)
        if self._next(1) != "{":
            raise self._wrong("{")
        self._place += 1
        return fields, self._node(0)

    def _peek(self) -> str:
        if self._place >= len(self._tokens):
            raise UsageError(f"'{self._where}' ends in the middle of a node; it is truncated")
        return str(self._tokens[self._place])

    def _next(self, steps: int) -> str:
        self._place += steps
        return self._peek()

    def _wrong(self, wanted: str) -> UsageError:
        return UsageError(
            f"'{self._where}' has '{' '.join(self._peek().split())[:40]}' where '{wanted}' should be; correct it"
        )

    def _enter(self, depth: int, count: int = 1) -> None:
        """Count nodes that reach down to a depth; nodes that are used count where they are used."""
        self._count, self._deepest = self._count + count, max(self._deepest, depth)
        if depth > MAX_DEPTH or self._count > MAX_NODES:
            raise UsageError(f"'{self._where}' has more than {MAX_NODES} nodes, or nests them over {MAX_DEPTH} deep")

    def _node(self, depth: int) -> WbtNode:
        """Return the node at the current position, which may be named by DEF, or refer to a named one by USE."""
        if self._peek() == "USE":
            return self._used(depth)
        self._enter(depth)
        if self._peek() != "DEF":
            return self._body(depth)
        name = self._next(1)
        self._place += 1
        before, above, self._deepest = self._count - 1, self._deepest, depth
        node = self._body(depth)
        self._defined[name] = _Defined(node, self._count - before, self._deepest - depth)
        self._deepest = max(above, self._deepest)
        return node

    def _used(self, depth: int) -> WbtNode:
        """Return the node that USE names; one that has not ended yet cannot be used in itself."""
        name = self._next(1)
        self._place += 1
        found = self._defined.get(name)
        if found is None:
            raise UsageError(f"'{self._where}' has USE {name[:40]} without a DEF that ends before it; correct it")
        self._enter(depth + found.depth, found.count)
        return found.node

    def _body(self, depth: int) -> WbtNode:
        """Return the kind and fields of the node at the current position."""
        kind = self._peek()
        if not _WORD.match(kind) or self._next(1) != "{":
            raise self._wrong("NODE {")
        node = WbtNode(kind)
        self._place += 1
        while self._peek() != "}":
            # Webots puts the word hidden before saved state of a simulation.
            key = self._next(1) if self._peek() == "hidden" else self._peek()
            if not _WORD.match(key):
                raise self._wrong("a field")
            self._place += 1
            node.fields[key] = self._value(depth)
        self._place += 1
        return node

    def _value(self, depth: int) -> "list[Item]":
        """Return the value of a field as a list."""
        if self._peek() != "[":
            return self._single(depth)
        self._place += 1
        found: list[Item] = []
        while self._peek() != "]":
            found += self._single(depth)
        self._place += 1
        return found

    def _single(self, depth: int) -> "list[Item]":
        """Return a text, a truth value, a node, nothing (NULL), or consecutive numbers."""
        token = self._peek()
        if token in ("TRUE", "FALSE", "NULL"):
            self._place += 1
            return [] if token == "NULL" else [token == "TRUE"]
        if token == "IS":
            name = self._next(1)
            self._place += 1
            return [WbtText(name, is_field=True)]
        if token.startswith('"'):
            self._place += 1
            # A name with a line break would be two lines of a report.
            return [WbtText(" ".join(token[1:-1].replace('\\"', '"').replace("\\\\", "\\").split()))]
        numbers: list[Item] = []
        while self._place < len(self._tokens) and (number := _number(self._tokens[self._place])) is not None:
            numbers.append(number)
            self._place += 1
        return numbers or [self._node(depth + 1)]


def _number(token: str) -> float | None:
    if not token[0].isdigit() and token[0] not in "+-.":
        return None
    try:
        return float(token)
    except ValueError:
        return None


def filled(node: WbtNode, values: "Mapping[str, list[Item]]") -> WbtNode:
    """Return the node of a PROTO with values in place of the names of its fields."""

    def value(items: "list[Item]") -> "list[Item]":
        found: list[Item] = []
        for item in items:
            if isinstance(item, WbtText) and item.is_field:
                found += values.get(item.text, [])
            else:
                found.append(filled(item, values) if isinstance(item, WbtNode) else item)
        return found

    return WbtNode(node.kind, {name: value(items) for name, items in node.fields.items()})


def turned(node: WbtNode, done: "set[int]") -> None:
    """Turn a node and those in it from axes x north, y up, z east (NUE) to x east, y north, z up."""
    if id(node) in done:
        return
    done.add(id(node))
    for name, items in node.fields.items():
        if name in ("point", "vector") or (_is_vector(name, items)):
            for start in range(0, len(items) - 2, 3):
                items[start : start + 3] = items[start + 2], items[start], items[start + 1]
        elif name == "rotation" and len(items) == 4:
            items[:3] = items[2], items[0], items[1]
        elif name in ("size", "floorSize") and len(items) == 2:
            items.reverse()
        for item in items:
            if isinstance(item, WbtNode):
                turned(item, done)


def _is_vector(name: str, items: "list[Item]") -> bool:
    """Return whether a field is a vector in space."""
    if len(items) != 3 or "olor" in name or name in ("attenuation", "rowsHeights", "columnsWidths"):
        return False
    return all(isinstance(item, float) for item in items)
