"""Text with `${expressions}` and `$(commands)` in xacro files."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mjsim.models.xacro.budget import Value, XacroBudget, XacroError, likely
from mjsim.models.xacro.expressions import evaluated
from mjsim.models.xacro.scope import Scope
from mjsim.models.xacro.xacro_functions import SUBSTITUTED
from mjsim.sentences import Sentence

PACKAGE = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")
"""Names of ROS packages."""
_TOKEN = re.compile(
    r"\$(?P<escape>\$+[{(])|\$\{(?P<expression>[^}]*)\}|\$\((?P<command>[^)]*)\)|(?P<text>[^$]+|\$[^{($]+|\$\Z)"
)


@dataclass(frozen=True, slots=True)
class Given:
    """Inputs of the user for a file; it gets nothing else from outside its folders."""

    arguments: Mapping[str, str] = field(default_factory=dict)
    """Values of `xacro:arg`."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """Values of `$(env NAME)`."""


def literal(text: Value) -> Value:
    """Return the number or truth value that a text spells, else the text; single quotes around it are removed."""
    if not isinstance(text, str):
        return text
    if len(text) > 1 and text[0] == text[-1] == "'":
        return text[1:-1]
    if "_" in text:  # Python takes 1_000 for a number.
        return text
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return {"true": True, "True": True, "false": False, "False": False}.get(text, text)


def is_true(value: Value, text: str) -> bool:
    """Return whether a condition holds.

    Args:
        value: Value of the condition.
        text: Text as written, for the message.

    Raises:
        XacroError: It is neither true nor false.
    """
    if not isinstance(value, str):
        return bool(value)
    word = value.strip().lower()
    if word in ("true", "false"):
        return word == "true"
    try:
        return bool(float(word))
    except ValueError:
        raise XacroError(
            Sentence("the condition '{text:.60}' is '{value:.40}'; it must be true or false", text, value)
        ) from None


class Substitution:
    """Evaluates text; keeps the arguments of a file."""

    def __init__(self, given: Given, budget: XacroBudget, folder: Callable[[], Path]) -> None:
        """Start with the arguments that are given.

        Args:
            given: Arguments and variables.
            budget: Counts steps and sizes.
            folder: Returns the folder of the file that is being expanded.
        """
        self._given, self._budget, self._folder = given, budget, folder
        self.arguments = dict(given.arguments)
        self.asked: set[str] = set()
        """Names of arguments and variables that the file declares or uses."""
        self._commands: Mapping[str, Callable[..., str]] = {
            "arg": self.argument,
            "find": _package,
            "env": self._variable,
            "optenv": self._optional_variable,
            "dirname": lambda: str(self._folder()),
        }

    def value(self, text: str, scope: Scope) -> Value:
        """Return the value of a text: that of its only expression, or else a text.

        Raises:
            XacroError: It is invalid.
        """
        if "$" not in text:
            return text
        parts: list[Value] = []
        end = 0
        for match in _TOKEN.finditer(text):
            if match.start() != end:
                break
            parts.append(self._part(match, scope))
            end = match.end()
        if end != len(text):
            raise XacroError(
                Sentence("'{text}' is neither ${{...}} nor $(...); write $$ for a dollar", text[end : end + 40])
            )
        return parts[0] if len(parts) == 1 else self._budget.keep("".join(map(str, parts)))

    def text(self, text: str, scope: Scope) -> str:
        """Return the value of a text as it is written into an element."""
        value = self.value(text, scope)
        return value if isinstance(value, str) else self._budget.keep(str(value))

    def evaluated(self, expression: str, scope: Scope) -> Value:
        """Return the value of an expression."""
        with self._budget.deeper(8):
            return evaluated(expression, scope.lookup, self._budget)

    def argument(self, name: str) -> str:
        """Return the value of a `xacro:arg`.

        Raises:
            XacroError: It has none.
        """
        self.asked.add(name)
        if name not in self.arguments:
            raise XacroError(Sentence("xacro:arg '{name:.60}' has no value; give --arg {name:.60}=VALUE", name))
        return self.arguments[name]

    def _part(self, match: "re.Match[str]", scope: Scope) -> Value:
        if match["text"] is not None:
            return str(match["text"])
        if match["escape"] is not None:
            return str(match["escape"])
        if match["expression"] is not None:
            return self.evaluated(self.text(match["expression"], scope), scope)
        return self._command(self.text(match["command"], scope))

    def _command(self, text: str) -> str:
        name, _, rest = text.partition(" ")
        if name == "eval":
            return self._budget.keep(str(evaluated(rest, self._substituted, self._budget)))
        words = text.split()
        command = self._commands.get(words[0] if words else "")
        if command is None:
            problem = f"$({text:.60}) is not known{likely(words[0] if words else '', [*self._commands, 'eval'])}"
            raise XacroError(problem)
        try:
            return command(*words[1:])
        except TypeError:
            raise XacroError(Sentence("$({text:.60}) has too many or too few words; correct it", text)) from None

    def _substituted(self, name: str) -> Any:
        """Return what a name in `$(eval ...)` stands for."""
        if name in SUBSTITUTED:
            return SUBSTITUTED[name]
        value = self.argument(name)
        return {"true": True, "false": False}.get(value.lower(), literal(value))

    def _variable(self, name: str) -> str:
        self.asked.add(name)
        if name not in self._given.environment:
            raise XacroError(
                Sentence("$(env {name:.60}) is not read from your environment; give --env {name:.60}=VALUE", name)
            )
        return self._given.environment[name]

    def _optional_variable(self, name: str, *default: str) -> str:
        self.asked.add(name)
        return self._given.environment.get(name, " ".join(default))


def _package(name: str) -> str:
    """Return the folder of a package as a URI, which readers of files resolve."""
    if not PACKAGE.fullmatch(name):
        raise XacroError(Sentence("'{name:.60}' is not the name of a ROS package; correct $(find ...)", name))
    return f"package://{name}"
