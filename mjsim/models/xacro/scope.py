"""Properties of a xacro file by name: those of macros, of included namespaces, and of the whole file."""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from mjsim.models.xacro.budget import XacroError
from mjsim.sentences import Sentence


class Scope:
    """Properties of a macro call, of a namespace or of a file, and all that encloses them."""

    def __init__(
        self,
        evaluate: Callable[[str, "Scope"], Any],
        *,
        parent: "Scope | None" = None,
        namespace: bool = False,
        known: Mapping[str, Any] | None = None,
        undeclared: Callable[[str, set[str]], Any] | None = None,
    ) -> None:
        """Create a scope without properties.

        Args:
            evaluate: Returns the value of a property's text.
            parent: The enclosing scope, or None.
            namespace: Whether it belongs to an included file.
            known: Functions and constants that need no property; of the outermost scope.
            undeclared: Returns the value of a name that is not a property, given all that are; outermost scope only.
        """
        self._evaluate, self.parent, self.namespace = evaluate, parent, namespace
        self._known, self._undeclared = known or {}, undeclared
        self._values: dict[str, Any] = {}
        self._texts: set[str] = set()
        self._resolving: list[str] = []

    def lookup(self, name: str) -> Any:
        """Return what a name stands for; a property whose text has not been used yet is evaluated.

        Raises:
            XacroError: There is no such property, or it refers to itself.
        """
        for scope in self._outwards():
            if name in scope._values:
                return scope._resolved(name)
            last = scope
        if name in last._known:
            return last._known[name]
        return (last._undeclared or _refuse)(name, {key for scope in self._outwards() for key in scope._values})

    def __contains__(self, name: str) -> bool:
        """Return whether a name stands for something."""
        return any(name in scope._values or name in scope._known for scope in self._outwards())

    def set(self, name: str, value: Any, *, lazy: bool = False) -> None:
        """Store a property; a lazy text is evaluated when it is used."""
        self._values[name] = value
        (self._texts.add if lazy and isinstance(value, str) else self._texts.discard)(name)

    def remove(self, name: str) -> None:
        """Remove a property from the scope that has it."""
        for scope in self._outwards():
            scope._values.pop(name, None)
            scope._texts.discard(name)

    def outermost(self) -> "Scope":
        """Return the scope of the file."""
        return list(self._outwards())[-1]

    def caller(self) -> "Scope":
        """Return the scope from which a macro is called.

        Raises:
            XacroError: This is not the scope of a macro.
        """
        for scope in self._outwards():
            if scope is not self and (self.namespace or not scope.namespace):
                return scope
        raise XacroError('scope="parent" is for properties of macros; leave it out')

    def _outwards(self) -> Iterator["Scope"]:
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def _resolved(self, name: str) -> Any:
        if name in self._texts:
            if name in self._resolving:
                path = " -> ".join([*self._resolving, name])
                raise XacroError(
                    Sentence(
                        "the property '{name}' refers to itself ({path:.100}); correct its xacro:property", name, path
                    )
                )
            self._resolving.append(name)
            try:
                self._values[name] = self._evaluate(self._values[name], self)
            finally:
                self._resolving.remove(name)
            self._texts.discard(name)
        return self._values[name]


def _refuse(name: str, _: set[str]) -> Any:
    raise XacroError(Sentence("no xacro:property '{name}'; declare it", name))
