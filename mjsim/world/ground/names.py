"""Names: valid ones, reserved ones, and those of items unnamed in the world file."""

import unicodedata
from collections.abc import Sequence
from typing import Protocol

from mjsim.sentences import Sentence

RESERVED = ("beacon", "ceiling", "door", "floor", "obstacle", "wall", "world")
"""First part of names in the scene for everything other than robots, mechanisms and people."""
RUN = "run"
"""Key of the statistics of a run among those of its robots."""
INVISIBLE = frozenset(
    "\u034f\u115f\u1160\u17b4\u17b5\u180b\u180c\u180d\u180f\u3164\uffa0"
    + "".join(map(chr, (*range(0xFE00, 0xFE10), *range(0xE0100, 0xE01F0))))
)
"""Letters and marks that Unicode lists as ignorable by default: they are invisible."""


def legible(name: str) -> str:
    """Return a name as `composed`.

    Raises:
        ValueError: It has characters other than letters, digits and their marks, or invisible ones; ASCII is left to
            the pattern of the name.
    """
    if name.isascii():
        return name
    for character in name:
        kind = unicodedata.category(character)
        if character in INVISIBLE or kind in ("Cf", "Cc"):
            raise ValueError(
                Sentence(
                    "name '{name}' has the invisible character U+{character:04X}; write it without",
                    name,
                    ord(character),
                )
            )
        if not character.isascii() and kind[0] not in "LMN":
            raise ValueError(
                Sentence(
                    "name '{name}' has U+{character:04X}, which is neither a letter nor a digit; write it without",
                    name,
                    ord(character),
                )
            )
    if unicodedata.category(name[0])[0] == "M":
        raise ValueError(
            Sentence(
                "name '{name}' begins with the mark U+{code:04X}; begin with a letter or a digit", name, ord(name[0])
            )
        )
    return composed(name)


def composed(text: str) -> str:
    """Return a text in Unicode normal form C, in which equal texts have equal characters."""
    return unicodedata.normalize("NFC", text)


def look_of(name: str) -> str:
    """Return what a name looks like: names that look alike, such as 'a1' and its full-width form, give the same."""
    return name if name.isascii() else unicodedata.normalize("NFKC", name)


class TakenNames:
    """Finds names that equal earlier ones, or look like them; see `look_of`."""

    def __init__(self) -> None:
        self._owners: dict[str, tuple[str, str]] = {}

    def fault(self, name: str, owner: str, *, each: str = "each") -> str | None:
        """Take a name; return why it cannot be taken, or None.

        Args:
            name: The name.
            owner: Owner of the name, for later faults.
            each: Word for the things that need a name of their own.
        """
        name, look = composed(name), look_of(name)
        if look not in self._owners:
            self._owners[look] = name, owner
            return None
        other, place = self._owners[look]
        if name == other:
            return Sentence("name '{name}' is taken by {place}; give {each} its own", name, place, each)
        return Sentence(
            "name '{name}' looks like '{other}' of {place}; give {each} a name that looks different",
            *(name, other, place, each),
        )


def reserved_fault(name: str, *, reserved: Sequence[str] = RESERVED) -> str | None:
    """Return why a robot, a mechanism or a person cannot have a name; None if it can."""
    if name == RUN and RUN in reserved:
        return Sentence(
            "'{name}' is reserved for the statistics of the run, beside those of its robots; give another name", name
        )
    return Sentence("'{name}' is a reserved name in the scene; give another name", name) if name in reserved else None


class Nameable(Protocol):
    """An item with an optional name."""

    @property
    def name(self) -> str | None:
        """The name; None if it has none."""


def item_names(items: Sequence[Nameable]) -> list[str]:
    """Return a name for each item: its own, or its number counted from 1, or the next free number."""
    taken = {item.name for item in items if item.name is not None}
    names = []
    for place, item in enumerate(items, start=1):
        name = item.name
        while name is None:
            name = str(place) if str(place) not in taken else None
            place += 1
        taken.add(name)
        names.append(name)
    return names
