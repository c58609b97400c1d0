"""Writes an imported world as text: a comment on its origin, then the world."""

from collections.abc import Sequence

from mjsim.world import World, format_world


def world_text(world: World, *, notes: Sequence[str]) -> str:
    """Return the text of a world, with notes as a comment before it."""
    lines = (f"# {line}".rstrip() for note in notes for line in note.splitlines())
    return "\n".join([*lines, _spaced(format_world(world))])


def _spaced(text: str) -> str:
    """Return a world's text with an empty line before each list of items."""
    spaced = []
    for line in text.splitlines():
        if line in ("walls:", "obstacles:", "beacons:", "robots:", "run:"):
            spaced.append("")
        spaced.append(line)
    return "\n".join(spaced) + "\n"
