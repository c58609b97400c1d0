"""Macros of xacro files: their parameters, defaults and blocks."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from mjsim.models.xacro.budget import XacroError
from mjsim.models.xacro.nodes import XacroNode
from mjsim.sentences import Sentence

_WITH_DEFAULT = re.compile(
    r"\s*(?P<name>[^\s:=]+)\s*:?=\s*(?P<forward>\^\|?)?"
    r"(?P<default>\$\{[^}]*\}(?=\s|\Z)|\$\([^)]*\)(?=\s|\Z)|(?:'[^']*'|\"[^\"]*\"|[^\s'\"])+|)(?:\s+|\Z)"
)
"""A parameter with the value that it has by default: `name:=1`, `name:='a b'`, `name:=^`, `name:=^|1`."""
_PLAIN = re.compile(r"\s*(?P<name>\S+)\s*")
MAX_PARAMETERS = 200
"""Maximum number of parameters."""


@dataclass(frozen=True, slots=True)
class Default:
    """Value of a parameter that a call does not name."""

    forward: bool
    """Whether it takes the property of this name where the macro is called, if there is one."""
    text: str | None
    """Its value otherwise."""


@dataclass(frozen=True, slots=True)
class Macro:
    """A macro as a file defines it."""

    body: XacroNode
    parameters: tuple[str, ...]
    """Names; those of blocks begin with `*` or `**`."""
    defaults: dict[str, Default]


@dataclass(slots=True)
class Macros:
    """Macros by name: those of a macro call or a namespace, and those that enclose them."""

    parent: "Macros | None" = None
    named: dict[str, Macro] = field(default_factory=dict)
    spaces: dict[str, "Macros"] = field(default_factory=dict)
    """Those of included files, by namespace."""

    def find(self, name: str) -> Macro | None:
        """Return a macro by its plain name."""
        return next((each.named[name] for each in self._outwards() if name in each.named), None)

    def space(self, name: str) -> "Macros | None":
        """Return the macros of a namespace."""
        return next((each.spaces[name] for each in self._outwards() if name in each.spaces), None)

    def names(self) -> set[str]:
        """Return the names of all."""
        return {name for each in self._outwards() for name in each.named}

    def _outwards(self) -> Iterator["Macros"]:
        macros: Macros | None = self
        while macros is not None:
            yield macros
            macros = macros.parent


def macro_of(node: XacroNode) -> tuple[str, Macro]:
    """Return a macro with its name.

    Raises:
        XacroError: Its definition is invalid.
    """
    name = node.required("name").removeprefix("xacro:")
    if name == "call" or "." in name:
        raise XacroError(Sentence("a macro cannot be called '{name:.60}'; choose another name, without dots", name))
    parameters, defaults = parameters_of(node.attributes.get("params", ""))
    return name, Macro(node, parameters, defaults)


def parameters_of(text: str) -> tuple[tuple[str, ...], dict[str, Default]]:
    """Return the names of a macro's parameters, and their defaults.

    Raises:
        XacroError: There are too many.
    """
    names: list[str] = []
    defaults: dict[str, Default] = {}
    at = 0
    while at < len(text) and not text[at:].isspace():
        match = _WITH_DEFAULT.match(text, at)
        if match is not None:
            defaults[match["name"]] = Default(match["forward"] is not None, match["default"] or None)
        else:
            match = _PLAIN.match(text, at)
        if match is None or len(names) >= MAX_PARAMETERS:
            raise XacroError(
                Sentence("a macro has more than {max_parameters} parameters; make it simpler", MAX_PARAMETERS)
            )
        names.append(match["name"])
        at = match.end()
    return tuple(names), defaults
