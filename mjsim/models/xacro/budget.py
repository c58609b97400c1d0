"""Bounds on the computations of a file: the size of each value, the number of steps, and their nesting."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, TypeAlias, TypeVar

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence

Kept = TypeVar("Kept")
Value: TypeAlias = bool | int | float | str | list[Any] | tuple[Any, ...] | dict[Any, Any] | None
"""Types of the values of expressions."""

STEPS = 1_000_000
"""Maximum number of steps in which a file is expanded; a value costs its size."""
MAX_VALUE_SIZE = 100_000
"""Maximum size of a value: characters, or entries including nested ones."""
MAX_BITS = 256
"""Maximum size of a whole number [bits]."""
MAX_CALLS = 750
"""Maximum nesting of elements, macros, properties and expressions [calls of Python, which allows 1000]."""
MAX_NAME_LENGTH, MAX_NAMES = 60, 100
"""Maximum length and number of names that messages suggest."""
CHARACTERS_PER_STEP = 8
"""Number of characters that cost a step."""


class XacroError(ValueError):
    """An error in a xacro file; the message lacks the position."""


class TooLargeError(XacroError):
    """A value of a file is too large."""

    def __init__(self) -> None:
        """Store the message."""
        super().__init__("it gives a number or a text that is too large; make it smaller")


class XacroBudget:
    """Counts steps and nesting while a file is expanded."""

    def __init__(self) -> None:
        self._left, self._depth = STEPS, 0

    def spend(self, steps: int) -> None:
        """Count steps.

        Raises:
            XacroError: There are too many.
        """
        self._left -= steps
        if self._left < 0:
            raise XacroError(Sentence("it takes more than {steps} steps to expand; make it simpler", STEPS))

    def keep(self, value: Kept) -> Kept:
        """Return a new value, and count its size.

        Raises:
            XacroError: It is too large.
        """
        self.spend(weight_of(value))
        return value

    @contextmanager
    def deeper(self, calls: int) -> Iterator[None]:
        """Count calls of Python that are nested in others.

        Raises:
            XacroError: There are too many.
        """
        if self._depth + calls > MAX_CALLS:
            raise XacroError("it is nested too deeply; make it flatter")
        self._depth += calls
        try:
            yield
        finally:
            self._depth -= calls


def likely(name: str, known: Iterable[str]) -> str:
    """Return '; did you mean ...?' or a list of known names, for names of any length."""
    return did_you_mean(
        name[:MAX_NAME_LENGTH], sorted(each for each in known if len(each) <= MAX_NAME_LENGTH)[:MAX_NAMES]
    )


def _require_characters(text: str) -> None:
    try:
        text.encode()
    except UnicodeEncodeError:
        raise XacroError("a text has a lone surrogate (\\ud800 to \\udfff); leave it out") from None


def weight_of(value: object) -> int:
    """Return the number of steps that a pass over a value costs.

    Raises:
        XacroError: It is larger than allowed, or of another kind.
    """
    return 1 + size_of(value) // CHARACTERS_PER_STEP if isinstance(value, str) else size_of(value)


def size_of(value: object) -> int:
    """Return the size of a value with all that it holds, as often as it holds it; at least 1.

    Raises:
        XacroError: It is larger than allowed, or of another kind.
    """
    size, waiting = 0, [value]
    while waiting:
        each = waiting.pop()
        size += 1
        if isinstance(each, str):
            size += len(each)
            _require_characters(each)
        elif isinstance(each, list | tuple):
            waiting.extend(each)
        elif isinstance(each, Mapping):
            waiting.extend(part for entry in each.items() for part in entry)
        elif isinstance(each, int):
            if each.bit_length() > MAX_BITS:
                raise TooLargeError
        elif not isinstance(each, float | None):
            raise XacroError(
                Sentence(
                    "a value of type {name} cannot be used in xacro; write a number or a text", type(each).__name__
                )
            )
        if size + len(waiting) > MAX_VALUE_SIZE:
            raise TooLargeError
    return size
