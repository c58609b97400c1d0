"""Names of items in scenes and recordings, also of those that the world file leaves without one."""

from collections.abc import Sequence
from typing import Protocol

RESERVED = ("beacon", "ceiling", "door", "floor", "obstacle", "wall", "world")
"""With these begin the names of what is neither a robot, a mechanism nor a person in the scene."""


class Nameable(Protocol):
    """An item that may carry a name."""

    @property
    def name(self) -> str | None:
        """None when it has none."""


def item_names(items: Sequence[Nameable]) -> list[str]:
    """Return a name for each item: its own, or else its place counted from 1, or the next number that is free."""
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
