"""Where a path of a world leads in its text."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mjsim.errors import UsageError
from mjsim.world.yaml import Entry, Node, Span

Path = tuple[str | int, ...]


class UnwritableError(UsageError):
    """A change that cannot be written into the text; holds the path of what was to be changed."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(f"{shown_path(path)} {message}" if path else message)
        self.path = path


def shown_path(path: Sequence[str | int]) -> str:
    """Return a path as people write it: 'walls[0].openings[1].width'."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).lstrip(".")


@dataclass(slots=True)
class TextPlace:
    """Where a path of the world leads in the text."""

    path: Path
    """That was asked for."""
    own: list[str | int]
    """As far as it is written: the same in the text, in which items of included files are not counted."""
    chain: list[Span]
    """The values along it, the whole text first."""
    entries: list[Entry]
    """The entries that hold them; one fewer."""
    node: Node | None
    """What the last of them comes from; None when the text uses nothing that has to be expanded."""
    said: Any
    """What it stands for then."""
    rest: list[str | int]
    """Steps that are not written."""

    @property
    def span(self) -> Span:
        """The last value that is written."""
        return self.chain[-1]

    @property
    def value(self) -> Any:
        """What that stands for, expressions computed."""
        return self.span.plain if self.node is None else self.said

    @property
    def count(self) -> int:
        """How many items it has in the world."""
        return len(self.span.entries) if self.node is None else len(self.said)

    @property
    def elsewhere(self) -> str | None:
        """The included file that holds what is not written here; None when nobody wrote it."""
        inner = self.node.items.get(self.rest[0]) if self.node is not None and self.rest else None
        return inner.origin.file if inner is not None and inner.origin is not None else None

    @property
    def is_empty(self) -> bool:
        """Whether nothing is written behind its key."""
        return self.span.kind == "scalar" and not self.span.text and not self.span.style and bool(self.entries)
