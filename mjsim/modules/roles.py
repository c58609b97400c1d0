"""The roles of user modules, and the methods that each requires; a class is checked before it is instantiated."""

import inspect
from collections.abc import Mapping, Sequence

from mjsim.sentences import Sentence

ROLES: Mapping[str, Sequence[str]] = {
    "observer": ("start", "observe"),
    "estimator": ("start", "update"),
    "navigator": ("start", "command"),
    "avoidance": ("start", "adjust"),
    "controller": ("start", "torques"),
    "drive": ("wheels_from_twist", "twist_from_wheels"),
}
"""Name of a role in the world file -> methods that its class must have (the protocols of `mjsim.interface`)."""


def misfit(role: str, thing: object) -> str | None:
    """Return why an object cannot be the class of a role, in one sentence; None if it can.

    It only looks up methods: it creates no instance, and runs neither properties nor a metaclass's `__getattr__`.

    Args:
        role: One of `ROLES`.
        thing: Object named by `use:`, such as a class.
    """
    if not issubclass(type(thing), type):
        return unmade(role, Sentence("a value of type {type}", type(thing).__name__))
    return _amiss(role, {name: inspect.getattr_static(thing, name, None) for name in ROLES[role]})


def unfit_instance(role: str, module: object) -> str | None:
    """Return why an object cannot fill a role, in one sentence; None if it can. The lookup may run its code."""
    if isinstance(module, type):
        return Sentence("is a class; give an instance of it, {name}(...)", module.__name__)
    return _amiss(role, {name: getattr(module, name, None) for name in ROLES[role]})


def unmade(role: str, kind: str) -> str:
    """Return the message for an object that is not a class."""
    return Sentence("is {kind}; {role} is a class with {methods}", kind, a_role(role), _listed(role))


def lacking(role: str, missing: Sequence[str]) -> str:
    """Return the message for missing methods."""
    return Sentence("has no {missing}; {role} needs {methods}", _methods(missing), a_role(role), _listed(role))


def awaited(method: str) -> str:
    """Return the message for a method that is a coroutine."""
    return Sentence("has `async def {method}`; write `def {method}`, since the simulator does not await", method)


def _amiss(role: str, found: Mapping[str, object]) -> str | None:
    """Return the fault of the methods found for a role, by name."""
    if missing := [name for name, value in found.items() if value is None]:
        return lacking(role, missing)
    for name, value in found.items():
        function = value.__func__ if isinstance(value, (staticmethod, classmethod)) else value
        if inspect.iscoroutinefunction(function) or inspect.isasyncgenfunction(function):
            return awaited(name)
        if not callable(function) and not hasattr(type(function), "__get__"):
            return Sentence("has {name} = {value}; it must be a method", name, _short(function))
    return None


def a_role(role: str) -> str:
    """Return the name of a role with its article."""
    return Sentence("an {role}", role) if role[0] in "aeiou" else Sentence("a {role}", role)


def _listed(role: str) -> str:
    *first, last = (f"{name}()" for name in ROLES[role])
    return Sentence("{first} and {last}", ", ".join(first), last) if first else last


def _methods(names: Sequence[str]) -> str:
    if len(names) == 1:
        return Sentence("method {name}()", names[0])
    return Sentence("methods {names}", " and ".join(f"{name}()" for name in names))


def _short(value: object) -> str:
    """Return a plain value as text, else its type, as `repr` may run a user's code."""
    plain = isinstance(value, (bool, int, float, str)) and type(value).__module__ == "builtins"
    return repr(value)[:40] if plain else Sentence("a value of type {type}", type(value).__name__)
