"""Expands the elements of xacro: properties, arguments, conditions, macros, blocks and includes."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from difflib import SequenceMatcher
from pathlib import Path
from typing import Protocol

from mjsim.errors import UsageError, printable
from mjsim.models.xacro.budget import CHARACTERS_PER_STEP, Value, XacroBudget, XacroError, likely
from mjsim.models.xacro.macros import Macro, Macros, macro_of
from mjsim.models.xacro.nodes import NAME, STEPS_PER_ELEMENT, Verbatim, XacroNode, nodes_of
from mjsim.models.xacro.scope import Scope
from mjsim.models.xacro.substitution import Given, Substitution, is_true, literal
from mjsim.models.xacro.xacro_functions import PYTHON, known_names
from mjsim.models.xacro.yaml_in import plain_yaml
from mjsim.models.xml_text import RefusedXmlError, checked_xml
from mjsim.sentences import Sentence

ABSENT = "which was not found"
"""Part of the message about a package that is missing."""
MAX_DEPTH = 100
"""Maximum nesting of elements in a file."""
PREFIXES = ("namespace", "prefix", "tf_prefix")
"""Prefixes of part names that a launch file sets, often undeclared; empty here."""


class Files(Protocol):
    """Files of a robot; nothing outside its folders and the packages that were named."""

    def locate(self, name: str, beside: Path) -> list[Path]:
        """Return the files of a name or pattern, which may begin with `package://NAME/`; raises XacroError."""

    def read(self, path: Path) -> bytes:
        """Return the contents of a file; raises XacroError."""


class Expander:
    """Expands one description; its methods for elements append the expansion to another element."""

    def __init__(self, path: Path, given: Given, files: Files) -> None:
        """Prepare.

        Args:
            path: Path of the description.
            given: Arguments and variables.
            files: Reads other files.
        """
        self.budget = XacroBudget()
        self._files, self._given = files, given
        self._paths = [path]
        self._read: dict[Path, XacroNode] = {}
        self.missing: list[tuple[str, str]] = []
        """Position of each include that was not found, and what is missing; using one of its macros is an error."""
        self.declared: set[str] = set()
        """Names of macros."""
        self._text = Substitution(given, self.budget, lambda: self._paths[-1].parent)
        own: Mapping[str, Callable[..., Value]] = {
            "load_yaml": self._load_yaml,
            "abs_filename": lambda name: str(self._paths[-1].parent / name),
            "arg": self._text.argument,
        }
        self._scope = Scope(self._evaluated, known=known_names(own), undeclared=self._undeclared)
        self._words: Mapping[str, Callable[[XacroNode, XacroNode, Scope, Macros], None]] = {
            "property": self._property,
            "arg": self._argument,
            "include": self._include,
            "macro": self._macro,
            "insert_block": self._insert_block,
            "if": self._condition,
            "unless": self._condition,
            "call": self._call_by_name,
            "element": self._element,
            "attribute": self._attribute,
        }

    @property
    def asked(self) -> frozenset[str]:
        """Names of arguments and variables that the file declares or uses."""
        return frozenset(self._text.asked)

    def expanded(self, root: XacroNode) -> XacroNode:
        """Return the root with all of xacro expanded.

        Raises:
            UsageError: It is invalid; the message has file, line and column.
        """
        into = XacroNode(root.tag, {})
        try:
            with _placed(root):
                self._expand(root, into, self._scope, Macros())
        except RecursionError:  # The caller has used up more of Python's recursion limit than usual.
            raise UsageError(Sentence("{file}: it is nested too deeply; make it flatter", root.file)) from None
        return into

    def _evaluated(self, text: str, scope: Scope) -> Value:
        return literal(self._text.value(text, scope))

    def _undeclared(self, name: str, declared: set[str]) -> object:
        self._text.asked.add(name)
        if name in self._given.arguments:
            return literal(self._given.arguments[name])
        if name in PREFIXES:
            return ""
        if name in PYTHON:
            return PYTHON[name]
        suggestion = likely(name, (key for key in declared if key.isidentifier()))
        hint = suggestion if suggestion.startswith("; did") else "; declare it"
        absent = f"; {self._absent(name)}" if self.missing else ""
        raise XacroError(
            Sentence("no xacro:property '{name:.60}'{hint}, or give --arg {name:.60}=VALUE{absent}", name, hint, absent)
        )

    def _expand(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        """Expand the attributes and children of an element, and append them to another."""
        self.budget.spend(STEPS_PER_ELEMENT + len(node.attributes))
        for name, value in node.attributes.items():
            prefix, colon, _ = name.partition(":")
            if not colon or prefix != "xacro":
                into.attributes[name] = self._text.text(value, scope)
        self._expand_children(node, into, scope, macros)

    def _expand_children(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        with self.budget.deeper(4):
            for child in node.children:
                if isinstance(child, Verbatim):
                    into.children.append(child)
                elif isinstance(child, str):
                    into.children.append(self._text.text(child, scope))
                else:
                    with _placed(child):
                        self._child(child, into, scope, macros)

    def _child(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        if node.word is None:
            made = XacroNode(node.tag, {}, node.file, node.line, node.column)
            into.children.append(made)
            self._expand(node, made, scope, macros)
        else:
            self.budget.spend(STEPS_PER_ELEMENT)
            self._words.get(node.word, self._call)(node, into, scope, macros)

    def _property(self, node: XacroNode, _: XacroNode, scope: Scope, __: Macros) -> None:
        name = self._text.text(node.required("name"), scope)
        _require_identifier(name, "a property")
        given = node.attributes
        if self._flag(node, "remove", scope):
            scope.remove(name)
            return
        if "default" in given and "value" in given:
            raise XacroError(Sentence("the property '{name:.60}' has a value and a default; leave one out", name))
        if "default" in given and name in scope:
            return
        text = given.get("value", given.get("default"))
        target = self._target(node, scope)
        if text is None:
            target.set(f"**{name}", node)
        elif target is not scope or not self._flag(node, "lazy_eval", scope, otherwise=True):
            target.set(name, self._evaluated(text, scope))
        else:
            target.set(name, literal(text), lazy=True)

    def _flag(self, node: XacroNode, name: str, scope: Scope, *, otherwise: bool = False) -> bool:
        text = node.attributes.get(name)
        return otherwise if text is None else is_true(self._text.value(text, scope), text)

    def _target(self, node: XacroNode, scope: Scope) -> Scope:
        """Return the scope in which a property is declared."""
        match node.attributes.get("scope"):
            case "global":
                return scope.outermost()
            case "parent":
                return scope.caller()
        return scope

    def _argument(self, node: XacroNode, _: XacroNode, scope: Scope, __: Macros) -> None:
        name = node.required("name")
        self._text.asked.add(name)
        if name not in self._text.arguments and "default" in node.attributes:
            self._text.arguments[name] = self._text.text(node.attributes["default"], scope)

    def _macro(self, node: XacroNode, _: XacroNode, __: Scope, macros: Macros) -> None:
        name, macro = macro_of(node)
        macros.named[name] = macro
        self.declared.add(name)

    def _condition(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        text = node.required("value")
        if is_true(self._text.value(text, scope), text) == (node.word == "if"):
            self._expand_inside(node, into, scope, macros)

    def _expand_inside(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        """Expand and append the children of an element, and the namespaces that it declares."""
        inside = XacroNode(into.tag, {})
        self._expand_children(node, inside, scope, macros)
        into.children += inside.children
        spaces = {**node.attributes, **inside.attributes}
        for name, value in spaces.items():
            if name.startswith("xmlns:"):
                into.attributes.setdefault(name, value)

    def _element(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        tag = self._text.text(node.required("xacro:name"), scope)
        _require_name(tag)
        attributes = {name: value for name, value in node.attributes.items() if name != "xacro:name"}
        prefix, _, word = tag.rpartition(":")
        word_or_none = word if prefix == "xacro" else None
        made = XacroNode(tag, attributes, node.file, node.line, node.column, word_or_none, node.children)
        with self.budget.deeper(2):
            self._child(made, into, scope, macros)

    def _attribute(self, node: XacroNode, into: XacroNode, scope: Scope, _: Macros) -> None:
        name = self._text.text(node.required("name"), scope)
        _require_name(name)
        into.attributes[name] = self._text.text(node.required("value"), scope)

    def _insert_block(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        name = node.required("name")
        if f"**{name}" in scope:
            with self.budget.deeper(2):
                self._expand_inside(scope.lookup(f"**{name}"), into, scope, macros)
        elif f"*{name}" in scope:
            with self.budget.deeper(2):
                self._child(scope.lookup(f"*{name}"), into, scope, macros)
        else:
            raise XacroError(
                Sentence("there is no block '{name:.60}'; declare it as a parameter '*{name:.60}' of the macro", name)
            )

    def _call_by_name(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        attributes = dict(node.attributes)
        name = self._text.text(node.required("macro"), scope)
        del attributes["macro"]
        call = XacroNode(f"xacro:{name}", attributes, node.file, node.line, node.column, name, node.children)
        with self.budget.deeper(1):
            self._call(call, into, scope, macros)

    def _call(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        """Expand a macro: its parameters and blocks use the caller's scope, its body has its own scope."""
        try:
            macro, outer, known = _found(node.word or "", scope, macros)
        except XacroError as error:
            absent = f"; {self._absent(node.word or '')}" if self.missing else ""
            raise XacroError(f"{error}{absent}") from None
        inner = Scope(self._evaluated, parent=outer)
        values = {
            name: literal(self._text.value(value, scope))
            for name, value in node.attributes.items()
            if not name.startswith("xmlns:")
        }
        blocks = XacroNode(node.tag, {})
        self._expand_children(node, blocks, scope, macros)
        for name, value in self._parameters(macro, values, blocks.elements, scope).items():
            inner.set(name, value)
        with self.budget.deeper(1):
            self._expand_inside(macro.body, into, inner, Macros(known))

    def _parameters(
        self, macro: Macro, values: dict[str, Value], blocks: list[XacroNode], scope: Scope
    ) -> dict[str, Value | XacroNode]:
        """Return the parameters of a macro for a call."""
        names = [name for name in macro.parameters if name.startswith("*")]
        if len(blocks) != len(names):
            raise XacroError(
                Sentence(
                    "the macro takes {count} blocks, but gets {other_count}; give as many", len(names), len(blocks)
                )
            )
        for name in values:
            if name not in macro.parameters:
                raise XacroError(
                    Sentence("the macro has no parameter '{name:.60}'{likely}", name, likely(name, macro.parameters))
                )
        found: dict[str, Value | XacroNode] = {**values, **dict(zip(names, blocks, strict=True))}
        for name in macro.parameters:
            if name not in found:
                found[name] = self._default(macro, name, scope)
        return found

    def _default(self, macro: Macro, name: str, scope: Scope) -> Value:
        default = macro.defaults.get(name)
        if default is not None and default.forward and name in scope:
            value: Value = scope.lookup(name)
            return value
        if default is None or default.text is None:
            raise XacroError(
                Sentence("the macro needs the parameter '{name:.60}'; give it, as {name:.60}=\"...\"", name)
            )
        return self._evaluated(default.text, scope)

    def _include(self, node: XacroNode, into: XacroNode, scope: Scope, macros: Macros) -> None:
        if "ns" in node.attributes:
            space = self._text.text(node.attributes["ns"], scope)
            _require_identifier(space, "a namespace")
            macros.spaces[space] = macros = Macros()
            inner = Scope(self._evaluated, parent=scope, namespace=True)
            scope.set(space, inner)
            scope = inner
        name = self._text.text(node.required("filename"), scope)
        optional = is_true(node.attributes.get("optional", "false"), "optional")
        for path in self._located(node, name):
            with self._inside(path), self.budget.deeper(6):
                try:
                    root = self._root_of(path)
                except XacroError as error:
                    if not str(error).startswith("no file"):
                        raise
                    if not optional:
                        self.missing.append((f"{node.file}:{node.line}:{node.column}", str(error)))
                    continue
                with _placed(root):
                    self._expand_inside(root, into, scope, macros)

    def _located(self, node: XacroNode, name: str) -> list[Path]:
        """Return the files of an include; none, with a note, if its package was not found."""
        try:
            return self._files.locate(name, self._paths[-1].parent)
        except XacroError as error:
            if ABSENT not in str(error):
                raise
            self.missing.append((f"{node.file}:{node.line}:{node.column}", str(error)))
            return []

    def _absent(self, name: str) -> str:
        """Return which missing include is most likely to declare a name."""
        best = max(self.missing, key=lambda each: SequenceMatcher(None, name, each[1]).ratio())
        return ": ".join(best)

    @contextmanager
    def _inside(self, path: Path) -> Iterator[None]:
        self._paths.append(path)
        try:
            yield
        finally:
            self._paths.pop()

    def _contents(self, path: Path) -> bytes:
        data = self._files.read(path)
        self.budget.spend(len(data) // CHARACTERS_PER_STEP)
        return data

    def _root_of(self, path: Path) -> XacroNode:
        """Return the root of an included file."""
        if path not in self._read:
            try:
                self._read[path] = nodes_of(
                    checked_xml(self._contents(path), deepest=MAX_DEPTH), str(path), self.budget
                )
            except RefusedXmlError as error:
                raise XacroError(Sentence("{path} {error}", path, error)) from None
        return self._read[path]

    def _load_yaml(self, name: str) -> Value:
        paths = self._files.locate(str(name), self._paths[-1].parent)
        if len(paths) != 1:
            raise XacroError(Sentence("load_yaml reads one file, not {count}; give the path of one", len(paths)))
        data = self._contents(paths[0])
        with self._inside(paths[0]):
            return plain_yaml(data, str(paths[0]), self.budget, lambda text: self._text.evaluated(text, self._scope))


def _found(name: str, scope: Scope, macros: Macros) -> tuple[Macro, Scope, Macros]:
    """Return a macro by its name, which may begin with namespaces, and where it is defined."""
    macro, at = macros.find(name), macros
    if macro is None:
        *spaces, last = name.split(".")
        for space in spaces:
            found, inner = at.space(space), scope.lookup(space)
            if found is None or not isinstance(inner, Scope):
                raise XacroError(
                    Sentence("no include has the namespace '{space:.60}'; add it to one, as ns=\"...\"", space)
                )
            at, scope = found, inner
        macro = at.find(last)
    if macro is None:
        raise XacroError(Sentence("no macro is called '{name:.60}'{likely}", name, likely(name, at.names())))
    return macro, scope, at


def _require_identifier(name: str, what: str) -> None:
    if not name.isidentifier() or name.startswith("__"):
        raise XacroError(Sentence("{what} cannot be called '{name:.60}'; write letters, digits and _", what, name))


def _require_name(name: str) -> None:
    if not NAME.fullmatch(name):
        raise XacroError(Sentence("'{name:.60}' is not a name in XML; write letters and digits", name))


@contextmanager
def _placed(node: XacroNode) -> Iterator[None]:
    """Add the position of an element to errors in it."""
    try:
        yield
    except XacroError as error:
        raise UsageError(printable(f"{node.file}:{node.line}:{node.column}: {error}")) from None
