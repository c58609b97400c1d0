"""Pictures of beacons in configurations of MATLAB: by name, by number, or in a separate list of names."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from mjsim.exchange.matlab.matlab_tables import Entry
from mjsim.world import Source, has_asset

MAX_NAMED = 8
"""Maximum number of missing pictures that a report names."""
PICTURES = (".jpg", ".jpeg", ".png")
POSTERS = "posters/"
"""Folder in assets that is searched for a beacon's picture, if it is not beside the file."""


@dataclass(frozen=True, slots=True)
class NamedPictures:
    """The pictures that a file can name."""

    folder: Path
    """Folder of the file."""
    variable: str = ""
    """Name of the list of names, if there is one."""
    names: tuple[str, ...] = ()
    """Its names, for the beacons in order, or by their numbers from 1."""
    absent: list[str] = field(default_factory=list)
    """Entries that are not pictures, so that their beacons are reflectors."""
    taken: set[str] = field(default_factory=set)
    """The variable, once a name was taken from it."""

    def of(self, item: list[Entry], number: int, count: int) -> str | None:
        """Return the picture of a beacon; None for a reflector, whose entry is added to `absent`.

        Args:
            item: Its values; the fourth is its picture, if there is one.
            number: Its number from 0.
            count: How many beacons there are.
        """
        is_stated = len(item) > 3
        entry = item[3] if is_stated else number + 1
        is_number = not isinstance(entry, str) and entry in range(1, len(self.names) + 1)
        if is_number and (picture_at(self.folder, entry) is None if is_stated else len(self.names) == count):
            self.taken.add(self.variable)
            return self._named(self.names[int(entry) - 1])
        return self._named(entry) if is_stated else None

    def _named(self, entry: Entry) -> str | None:
        if found := picture_at(self.folder, entry):
            return found
        text = _text(entry)
        if entry and text not in self.absent:
            self.absent.append(text)
        return None

    def told_taken(self) -> list[str]:
        """Return the line about the list, if it was used."""
        return [f"pictures of beacons, named by {name}" for name in self.taken]

    def told_absent(self, name: str) -> list[str]:
        """Return the line about values of P that name no picture."""
        if not self.absent:
            return []
        more = len(self.absent) - MAX_NAMED
        values = ", ".join(self.absent[:MAX_NAMED]) + (f" and {more} others" if more > 0 else "")
        which = "which are not pictures" if self.absent[1:] else "which is not a picture"
        return [f"{name} has P = {values}, {which} beside the file or in assets: reflectors"]


def picture_at(folder: Path, entry: Entry) -> str | None:
    """Return the picture that a name or a number names, beside the file or in assets; None if there is none."""
    names = [_text(entry), *(_text(entry) + suffix for suffix in PICTURES)]
    pictures = [name for name in names if Path(name).name == name and Path(name).suffix.lower() in PICTURES]
    known = (each + picture for each in ("", POSTERS) for picture in pictures)
    return next((picture for picture in known if has_asset(picture, Source(folder=folder))), None)


def named_pictures(folder: Path, variables: Mapping[str, Any]) -> NamedPictures:
    """Return the pictures of a file: the list of names is the cell of texts in which most are pictures, if any is."""
    lists = {name: _texts(value) for name, value in variables.items()}
    counts = {name: sum(picture_at(folder, each) is not None for each in texts) for name, texts in lists.items()}
    best = max(counts, key=counts.__getitem__, default="")
    return NamedPictures(folder, best, lists[best]) if counts.get(best) else NamedPictures(folder)


def _texts(value: Any) -> tuple[str, ...]:
    """Return the texts of a cell that holds only texts."""
    rows = [row if isinstance(row, list) else [row] for row in value] if isinstance(value, list) else []
    texts = [each for row in rows for each in row]
    return tuple(texts) if texts and all(isinstance(each, str) for each in texts) else ()


def _text(entry: Entry) -> str:
    return entry if isinstance(entry, str) else f"{entry:g}"
