"""Expands `include`, `variables` and `repeat` in the nodes of a text, before any model sees them.

A text that uses none of the three is passed through unchanged; otherwise the cost is linear in the output, and bounded.
"""

import posixpath
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from mjsim.errors import Problem
from mjsim.sentences import Sentence
from mjsim.world.files import Source, has_asset, read_asset
from mjsim.world.language.arithmetic import CONSTANTS, FUNCTIONS, INDICES, NAME, Value
from mjsim.world.language.merge_worlds import marked, merged, without
from mjsim.world.language.templates import Budget, Template, TooMuchError
from mjsim.world.yaml import MAX_BYTES, Node, Origin, read_text

MAX_DEPTH = 16
"""Maximum nesting of includes."""
MAX_FILES = 1000
"""Maximum number of included files; a file counts each time."""
MAX_VARIABLES = 1000
_SIGNS = ("${", "include", "variables", "repeat", "\\")
"""A text that uses any of the three contains one of these; a backslash may escape a letter."""


@dataclass(frozen=True, slots=True)
class Expansion:
    """The result of expanding a text."""

    node: Node
    problems: list[Problem]
    included: Mapping[str, bytes]
    """The included files, by their paths relative to the text's folder."""
    variables: Mapping[str, Value]
    """Variables of the text and of the included files."""


def needs_expansion(text: str) -> bool:
    """Return whether a text may use `include`, `variables` or `repeat`."""
    return any(sign in text for sign in _SIGNS)


def expand(node: Node, source: Source, *, variables: Mapping[str, Value] | None = None) -> Expansion:
    """Return the expansion of a text.

    Args:
        node: Value of the text, a mapping.
        source: Origin of the text.
        variables: Values that take precedence over those in the text.
    """
    work = _Expander(source)
    top = _File(name="", folder="", shown=source.file, how="", chain=(_own_name(source),))
    names = dict(variables or {})
    try:
        whole = work.file(node, top, names)
    except TooMuchError as error:
        whole = Node({}, node.line, node.column)
        work.budget.report(source.file, error.node.line, error.node.column, str(error))
    return Expansion(whole, list(work.budget.problems.values()), work.included, names)


@dataclass(frozen=True, slots=True)
class _File:
    """A file during expansion."""

    name: str
    """Its path relative to the folder of the world; empty for the world itself."""
    folder: str
    """Its folder, relative to that of the world."""
    shown: str
    """Name in messages."""
    how: str
    """How it was reached, for messages."""
    chain: tuple[str, ...]
    """Names of the including files, and its own."""

    def origin(self) -> str:
        return Sentence(" ({how})", self.how) if self.how else ""


class _Expander:
    """Expands one world file with all included files."""

    def __init__(self, source: Source) -> None:
        self.budget = Budget()
        self.included: dict[str, bytes] = {}
        self._source = source
        self._bytes = 0
        self._files = 0

    def file(self, node: Node, file: _File, outer: dict[str, Value]) -> Node:
        """Return the expanded mapping of a file; `outer` holds variables of including files, and receives its own."""
        names = self._variables(node.items.get("variables"), file, outer)
        below: Node | None = None
        for path, entry in self._includes(node.items.get("include"), file):
            found = self._included(path, entry, file, names)
            if found is not None:
                below = found if below is None else merged(below, found)
        own = without(node, ("variables", "include"))
        template = Template(self.budget, file.shown, file.origin(), asset=self._asset_resolver(file))
        own = template.whole(own, names)
        outer |= {name: value for name, value in names.items() if name not in outer}
        return own if below is None else merged(below, own)

    def _variables(self, node: Node | None, file: _File, outer: Mapping[str, Value]) -> dict[str, Value]:
        names = dict(outer)
        if node is None:
            return names
        if not isinstance(node.value, dict):
            self._report(file, node, "variables are written as names with values, such as variables: {width: 1.2}")
            return names
        template = Template(self.budget, file.shown, file.origin())
        for name, value in node.items.items():
            wrong = _not_a_name(str(name))
            if wrong is not None or len(names) >= MAX_VARIABLES:
                self._report(
                    file,
                    node.keys[str(name)],
                    wrong or Sentence("more than {max_variables} variables; write fewer", MAX_VARIABLES),
                )
            elif not isinstance(value.value, (bool, int, float, str)):
                self._report(
                    file,
                    value,
                    Sentence("variable '{name}' is not a single value; give a number, a text, true or false", name),
                )
            elif name not in outer:
                names[str(name)] = template.scalar(value, names)
        return names

    def _includes(self, node: Node | None, file: _File) -> list[tuple[str, Node]]:
        if node is None:
            return []
        if not isinstance(node.value, list):
            self._report(file, node, "include is a list of world files, such as include: [hall.yaml]")
            return []
        for entry in node.items.values():
            if not isinstance(entry.value, str):
                self._report(file, entry, "include names world files, such as include: [hall.yaml]")
        return [(entry.value, entry) for entry in node.items.values() if isinstance(entry.value, str)]

    def _included(self, path: str, entry: Node, around: _File, names: dict[str, Value]) -> Node | None:
        """Return the expansion of an included file; None if it cannot be read, which is reported."""
        name = self._resolved(path, around.folder)
        if name in around.chain:
            ring = " > ".join([*around.chain[around.chain.index(name) :], name])
            self._report(around, entry, Sentence("this includes itself: {ring}; leave one of them out", ring))
            return None
        if len(around.chain) > MAX_DEPTH:
            self._report(
                around,
                entry,
                Sentence("includes are nested more than {max_depth} deep; include fewer files", MAX_DEPTH),
            )
            return None
        self.budget.check_time(entry)
        self._files += 1
        if self._files > MAX_FILES:
            raise TooMuchError(
                Sentence("files are included more than {max_files} times; include fewer", MAX_FILES), entry
            )
        how = Sentence("included by {shown}:{line}:{column}", around.shown, entry.line, entry.column)
        if around.how:
            how = Sentence("{first}, {then}", how, around.how)
        folder = posixpath.dirname(name)
        file = _File(name, folder, self._shown(name), how, (*around.chain, name))
        node = self._read(name, path, entry, around, file)
        if node is None:
            return None
        whole = self.file(node, file, names)
        return marked(whole, Origin(file.shown, how))

    def _read(self, name: str, path: str, entry: Node, around: _File, file: _File) -> Node | None:
        start = time.process_time()
        try:
            data = self.included.get(name) or read_asset(name, self._source)
        except ValueError as error:
            self._report(around, entry, str(error))
            return None
        self._bytes += len(data)
        if self._bytes > MAX_BYTES:
            size = f"{MAX_BYTES / 1e6:.0f} MB"
            self._report(
                around,
                entry,
                Sentence("with '{path}' the included files have more than {size}; include less", path, size),
            )
            return None
        self.included[name] = data
        node, problems = read_text(data.decode("utf-8-sig", "surrogateescape"), file=file.shown)
        for problem in problems:
            self.budget.report(file.shown, problem.line, problem.column, problem.message + file.origin())
        self.budget.allow(time.process_time() - start)
        if node is not None and not isinstance(node.value, dict):
            self._report(file, node, "this is not a world file; one begins with 'mjsim: 1'")
            return None
        return node

    def _asset_resolver(self, file: _File) -> Callable[[str], str] | None:
        """Return a function that converts asset paths of a file to paths relative to the folder of the world."""
        return None if not file.folder else lambda path: self._resolved(path, file.folder)

    def _resolved(self, path: str, folder: str) -> str:
        """Return a path relative to the folder of the world: beside the file that names it if it exists there."""
        normalised = posixpath.normpath(posixpath.join(folder, path)) if path.strip() else path
        return normalised if not folder or has_asset(normalised, self._source) else path

    def _shown(self, name: str) -> str:
        """Return the name of an included file in messages."""
        folder = posixpath.dirname(self._source.file.replace("\\", "/"))
        return posixpath.join(folder, name)

    def _report(self, file: _File, place: Node | tuple[int, int], message: str) -> None:
        line, column = place if isinstance(place, tuple) else (place.line, place.column)
        self.budget.report(file.shown, line, column, message + file.origin())


def _own_name(source: Source) -> str:
    return posixpath.basename(source.file.replace("\\", "/"))


def _not_a_name(name: str) -> str | None:
    """Return why a name is not allowed for a variable; None if it is allowed."""
    if not NAME.fullmatch(name):
        return Sentence("'{name}' is not a variable name; write letters, digits and '_', a letter first", name)
    if name in FUNCTIONS or name in CONSTANTS or name in INDICES:
        return Sentence("'{name}' has a meaning of its own in expressions; give the variable another name", name)
    return None
