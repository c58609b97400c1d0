"""Instantiates parts of a text for a set of names: evaluates expressions, repeats items."""

import math
import re
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pydantic import ValidationError

from mjsim.errors import Problem
from mjsim.sentences import Sentence
from mjsim.world.ground import KEY, path_of, sentence
from mjsim.world.language.arithmetic import INDICES, Expression, Value, shown_number
from mjsim.world.language.merge_worlds import mergeable, without
from mjsim.world.language.repeats import MAX_REPEATS, NAMES, Place, Repeat, indices, placing
from mjsim.world.yaml import Node, Origin, place_of

MAX_ITEMS = 100_000
"""Maximum number of repeated items."""
MAX_VALUES = 2_000_000
"""Maximum number of keys and values produced by repetitions."""
MAX_TIME = 2.0
"""Time limit of the expansion, without reading files [s]."""
MAX_SOURCE, MAX_TEXT_LENGTH = 10_000, 2000
"""Maximum length of a text with expressions, and of its result [characters]."""
_NUMBERED = ("openings",)
"""Lists inside items whose own items have names that are unique in the world."""
_PIECE = re.compile(r"\$\$\{|\$\{([^{}]*)\}|\$\{")
_ASSETS = ("image", "texture", "model")
"""Keys that name a file."""

Names = Mapping[str, Value]
Make = Callable[[Names], Node]
MakeValue = Callable[[Names], Any]


class TooMuchError(Exception):
    """Expansion has reached a limit; holds the node at which it did."""

    def __init__(self, message: str, node: Node) -> None:
        super().__init__(message)
        self.node = node


class Budget:
    """Remaining limits of one expansion, and the errors found, one per place."""

    def __init__(self) -> None:
        self.problems: dict[tuple[str, int, int], Problem] = {}
        self._items = self._values = 0
        self._end = time.process_time() + MAX_TIME

    def allow(self, seconds: float) -> None:
        """Exclude time that was not spent on expansion [s]."""
        self._end += seconds

    def check_time(self, node: Node) -> None:
        """Raise TooMuchError if the time limit is exceeded."""
        if time.process_time() > self._end:
            raise TooMuchError(
                Sentence("expanding takes more than {max_time:g} s; repeat or include less", MAX_TIME), node
            )

    def check_items(self, node: Node, copies: int) -> None:
        """Raise TooMuchError if this many more items exceed the limit."""
        if self._items + copies > MAX_ITEMS:
            raise TooMuchError(Sentence("repeating produces more than {max_items} items; repeat less", MAX_ITEMS), node)

    def take(self, node: Node, size: int) -> None:
        """Count one more item, with a number of values."""
        self._items += 1
        self._values += size
        if self._values > MAX_VALUES:
            raise TooMuchError(
                Sentence("repeating produces more than {max_values} values; repeat less", MAX_VALUES), node
            )
        if self._items % 256 == 0:
            self.check_time(node)

    def report(self, file: str, line: int, column: int, message: str) -> None:
        """Store an error, unless there is one for this place."""
        self.problems.setdefault((file, line, column), Problem(file, line, column, message))


class Template:
    """Instantiates the nodes of one file's text.

    A part that is the same for all names is used as it is: the cost of repetition depends only on what differs.
    """

    def __init__(self, budget: Budget, file: str, how: str = "", *, asset: Callable[[str], str] | None = None) -> None:
        """Store what applies to the whole file.

        Args:
            budget: Limits of the whole expansion.
            file: Name of the file in messages.
            how: End of messages.
            asset: Converts an asset path in the file to a path relative to the folder of the world.
        """
        self._budget, self._file, self._how, self._asset = budget, file, how, asset
        self._renewed: set[int] = set()
        """Parts whose nodes are rebuilt; in all others only values differ."""
        self._depth = 0
        """Number of repeats around the current position."""

    def whole(self, node: Node, names: Names) -> Node:
        """Return the instance of a file's mapping."""
        self._mark_repeating(node, foreign=False)
        self._renewed |= {id(part) for part in mergeable(node)}
        make = self._part(node, "", foreign=False)
        return node if make is None else make(names)

    def scalar(self, node: Node, names: Names) -> Value:
        """Return the value of a scalar; its text if it cannot be evaluated, which is reported."""
        make = self._text(node) if isinstance(node.value, str) else None
        value: Value = node.value if make is None else make(names)
        return value

    def _mark_repeating(self, node: Node, *, foreign: bool) -> bool:
        """Record every part in which an item is repeated, and return whether this is one."""
        foreign = foreign or (isinstance(node.value, dict) and "use" in node.items)
        found = False
        for item in node.items.values():
            own = isinstance(node.value, list) and _is_repeated(item) and not foreign
            if item.items and self._mark_repeating(item, foreign=foreign) | own:
                found = True
        if found:
            self._renewed.add(id(node))
        return found

    def _part(self, node: Node, key: str, *, foreign: bool) -> Make | None:
        """Return a function that instantiates a part; None if the part is constant.

        Args:
            node: The part.
            key: Its key; for an item of a list, the key of the list.
            foreign: Whether it belongs to a user's module, whose keys mjsim does not know.
        """
        if id(node) in self._renewed:
            foreign = foreign or "use" in node.items
            return self._mapping(node, foreign) if isinstance(node.value, dict) else self._list(node, key, foreign)
        make = self._value(node, key, foreign=foreign)
        if make is None:
            return None
        return lambda names: Node(make(names), node.line, node.column, node.items, node.keys, node.size)

    def _mapping(self, node: Node, foreign: bool) -> Make:
        parts = {key: self._part(item, str(key), foreign=foreign) for key, item in node.items.items()}

        def make(names: Names) -> Node:
            items = {key: node.items[key] if part is None else part(names) for key, part in parts.items()}
            value = {key: item.value for key, item in items.items()}
            size = 1 + len(items) + sum(item.size for item in items.values())
            return Node(value, node.line, node.column, items, node.keys, size)

        return make

    def _list(self, node: Node, key: str, foreign: bool) -> Make:
        items = [(item, not foreign and _is_repeated(item)) for item in node.items.values()]
        makes = [
            self._repeated(item, key) if repeated else self._part(item, key, foreign=foreign)
            for item, repeated in items
        ]

        def make(names: Names) -> Node:
            nodes: list[Node] = []
            for (item, repeated), part in zip(items, makes, strict=True):
                made = item if part is None else part(names)
                nodes += made.items.values() if repeated else [made]
            values, size = [made.value for made in nodes], 1 + sum(made.size for made in nodes)
            return Node(values, node.line, node.column, dict(enumerate(nodes)), size=size)

        return make

    def _value(self, node: Node, key: str, *, foreign: bool) -> MakeValue | None:
        """Return a function that evaluates a part without repeats; None if the part is constant."""
        value = node.value
        if isinstance(value, str):
            return self._path(node) if key in _ASSETS and not foreign and self._asset else self._text(node)
        if not isinstance(value, (dict, list)):
            return None
        foreign = foreign or "use" in node.items
        parts = {
            step: make
            for step, item in node.items.items()
            if (make := self._value(item, key if isinstance(value, list) else str(step), foreign=foreign)) is not None
        }
        if self._depth and key in _NUMBERED and isinstance(value, dict) and _name_to_number(node) == "name":
            parts["name"] = self._numbered(node.items["name"])
        if not parts:
            return None
        changing: list[tuple[Any, MakeValue]] = list(parts.items())

        def make_value(names: Names) -> Any:
            made = value.copy()
            for step, make in changing:
                made[step] = make(names)
            return made

        return make_value

    def _repeated(self, node: Node, within: str) -> Make:
        """Return a function that makes all repetitions of an item, as a list."""
        spec, item = node.items["repeat"], without(node, ("repeat",))
        letters = INDICES[self._depth :][: len(spec.items) if isinstance(spec.value, list) else 1]
        count = self._value(spec, "repeat", foreign=True)
        inside = id(node) in self._renewed
        if inside:
            self._renewed.add(id(item))
        self._depth += len(letters)
        # If nothing inside is repeated, repetitions share the nodes of their parts: only values differ.
        body = self._part(item, within, foreign=False) if inside else None
        value = None if inside else self._value(item, within, foreign=False)
        self._depth -= len(letters)
        naming = None if within in _NUMBERED else _name_to_number(item)

        def make(names: Names) -> Node:
            steps = self._steps(spec, spec.value if count is None else count(names))
            if len(steps) > len(letters):
                self._report(spec, Sentence("repeats are nested more than {max_depth} deep; nest fewer", len(INDICES)))
            if not letters or len(steps) != len(letters):
                return Node([item.value], node.line, node.column, {0: item})
            copies, faults = math.prod(step.times for step in steps), len(self._budget.problems)
            self._budget.check_items(node, copies)
            nodes: list[Node] = []
            inner = dict(names)
            place = None
            for index in indices(steps):
                inner.update(zip(letters, index, strict=True))
                made = item if body is None else body(inner)
                keys = dict(made.value) if value is None else value(inner)
                self._budget.take(node, made.size)
                if place is None:
                    place = self._placing(keys, spec, steps, within)
                if len(self._budget.problems) > faults:
                    break
                place(keys, index)
                if naming is not None and isinstance(keys[naming], str):
                    keys[naming] = "-".join([keys[naming], *(str(number + 1) for number in index)])
                origin = Origin(None, "", index, copies)
                nodes.append(Node(keys, made.line, made.column, made.items, made.keys, made.size, origin))
            return Node([made.value for made in nodes], node.line, node.column, dict(enumerate(nodes)))

        return make

    def _placing(self, keys: Mapping[str, Any], spec: Node, steps: Sequence[Repeat], within: str) -> Place:
        try:
            return placing(keys, steps, within=within)
        except ValueError as error:
            self._report(spec, str(error))
            return placing(keys, (), within=within)

    def _steps(self, node: Node, value: Any) -> list[Repeat]:
        """Return the repeats of an item, outermost first; none if one of them is invalid, which is reported."""
        parts = list(value) if isinstance(value, list) else [value]
        if not 1 <= len(parts) <= MAX_REPEATS:
            self._report(
                node,
                Sentence(
                    "repeat is a list of {count}; it must be one repeat or 2 to {max_repeats}", len(parts), MAX_REPEATS
                ),
            )
            return []
        steps = []
        for index, part in enumerate(parts):
            try:
                steps.append(Repeat.model_validate(part))
            except ValidationError as error:
                for details in error.errors(include_url=False):
                    path = path_of(details)
                    whole = (*([index] if isinstance(value, list) else []), *path)
                    unknown = details["type"] == "extra_forbidden"
                    place = place_of(node, (*whole, KEY) if unknown else whole)
                    self._report(place, sentence(details, path or ("repeat",), Repeat))
        return steps if len(steps) == len(parts) else []

    def _numbered(self, node: Node) -> MakeValue:
        """Return a function that makes the name of something inside an item, numbered by all repeats around it."""
        text = self._text(node)

        def make(names: Names) -> str:
            name = node.value if text is None else text(names)
            return "-".join([str(name), *(str(int(names[letter]) + 1) for letter in INDICES if letter in names)])

        return make

    def _path(self, node: Node) -> MakeValue:
        """Return a function that makes an asset path relative to the folder of the world."""
        text, asset = self._text(node), self._asset
        assert asset is not None
        return lambda names: asset(str(node.value if text is None else text(names)))

    def _text(self, node: Node) -> MakeValue | None:
        """Return a function for a text with expressions; a text of a single expression keeps the type of its value."""
        if "${" not in node.value:
            return None
        self._budget.check_time(node)
        try:
            pieces = _pieces(node.value)
        except ValueError as error:
            self._report(node, str(error))
            return None
        alone = pieces[0] if len(pieces) == 1 else None

        def make(names: Names) -> Value:
            try:
                if isinstance(alone, Expression):
                    return alone.value(names)
                values = [piece.value(names) if isinstance(piece, Expression) else piece for piece in pieces]
                return _joined([shown_number(value) for value in values])
            except ValueError as error:
                self._report(node, str(error))
                return str(node.value)

        return make

    def _report(self, place: Node | tuple[int, int], message: str) -> None:
        line, column = place if isinstance(place, tuple) else (place.line, place.column)
        self._budget.report(self._file, line, column, message + self._how)


def _is_repeated(node: Node) -> bool:
    return isinstance(node.value, dict) and "repeat" in node.items


def _pieces(text: str) -> list[str | Expression]:
    """Return a text split at its expressions; `$${` stands for `${`.

    Raises:
        ValueError: An expression is not closed, or is invalid.
    """
    if len(text) > MAX_SOURCE:
        raise ValueError(
            Sentence(
                "a text of {count} characters with expressions in it; write at most {max_source}", len(text), MAX_SOURCE
            )
        )
    found: list[str | Expression] = []
    end = 0
    for match in _PIECE.finditer(text):
        found.append(text[end : match.start()])
        end = match.end()
        if match.group() == "$${":
            found.append("${")
        elif match.group() == "${":
            raise ValueError(
                Sentence(
                    "{text!r:.60} has a '${{' without its '}}'; close it, or write"
                    " '$${{' for the characters themselves",
                    text,
                )
            )
        else:
            found.append(Expression(match.group(1)))
    found.append(text[end:])
    return [piece for piece in found if piece]


def names_in(text: str) -> frozenset[str]:
    """Return the variables and indices in the expressions of a text; none if one of them is invalid."""
    try:
        pieces = _pieces(text)
    except ValueError:
        return frozenset()
    return frozenset().union(*(piece.names for piece in pieces if isinstance(piece, Expression)))


def _joined(texts: Sequence[str]) -> str:
    length = sum(map(len, texts))
    if length > MAX_TEXT_LENGTH:
        raise ValueError(
            Sentence(
                "the result has {length} characters; it must have at most {max_text_length}", length, MAX_TEXT_LENGTH
            )
        )
    return "".join(texts)


def _name_to_number(node: Node) -> str | None:
    """Return the key of an item's name; None if it has none, or if the name itself depends on the repetition."""
    key = next((key for key in NAMES if isinstance(node.value.get(key), str)), None)
    try:
        pieces = [] if key is None else _pieces(node.value[key])
    except ValueError:
        return None
    numbered = any(isinstance(piece, Expression) and not piece.names.isdisjoint(INDICES) for piece in pieces)
    return None if numbered else key
