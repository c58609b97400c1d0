"""What became of the contents of an imported file: kept, guessed, mended, added or left out, and why.

Importers collect `FileItem`s, and end their report with `inventory(items)`; nothing is dropped or guessed without one.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from mjsim.sentences import number_of

MAX_NAMES = 8
"""Maximum number of names in a line."""


class Fate(StrEnum):
    """What became of a part of a file, in the order of the list."""

    KEPT = "kept"
    GUESSED = "guessed"
    MENDED = "mended"
    ADDED = "added"
    LEFT_OUT = "left out"


@dataclass(frozen=True, slots=True)
class FileItem:
    """A part of a file, and what became of it."""

    fate: Fate
    kind: str
    """A noun, such as 'lidar'; or a whole phrase, if there is no name."""
    name: str = ""
    """Its name in the file."""
    why: str = ""
    """The reason, or what it became; what the user can do about it."""


def told(fate: Fate, why: object) -> str:
    """Return the value of an entry in the metadata of a recording that says what became of a part of a file."""
    return f"{fate}: {why}"


def fate_of(fact: str, value: str) -> tuple[Fate, str]:
    """Return what became of something, and why, from a fact in the metadata of a recording: see `told`.

    A fact whose name ends in 'left out' says how much was left out.
    """
    fate, colon, why = value.partition(": ")
    if colon and fate in list(map(str, Fate)):
        return Fate(fate), why
    return Fate.LEFT_OUT if fact.endswith(f" {Fate.LEFT_OUT}") else Fate.KEPT, value


def inventory(items: Iterable[FileItem]) -> list[str]:
    """Return a line for each fate, kind and reason, with the names of its items, in the order of `Fate`."""
    groups: dict[tuple[Fate, str, str], list[str]] = {}
    for item in items:
        groups.setdefault((item.fate, item.kind, item.why), []).append(item.name)
    order = list(Fate)
    ordered = sorted(groups.items(), key=lambda group: order.index(group[0][0]))
    return [f"{fate}: {_called(kind, names)}" + (f": {why}" if why else "") for (fate, kind, why), names in ordered]


def _called(kind: str, names: list[str]) -> str:
    """Return 'lidar 'a'', or '3 lidars 'a', 'b' and 1 more'; names that are equal are written once."""
    known = [f"'{name}'" for name in dict.fromkeys(names) if name]
    more = f" and {len(known) - MAX_NAMES} more" if len(known) > MAX_NAMES else ""
    listed = ", ".join(known[:MAX_NAMES]) + more
    head = kind if len(names) == 1 else number_of(len(names), kind)
    return f"{head} {listed}" if listed else head
