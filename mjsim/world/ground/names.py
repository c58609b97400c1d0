"""Names of items in scenes and recordings, including items unnamed in the world file."""

from collections.abc import Sequence
from typing import Protocol

RESERVED = ("beacon", "ceiling", "door", "floor", "obstacle", "wall", "world")
"""First part of names in the scene for everything other than robots, mechanisms and people."""


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
