"""The place in a text to which a path of its world leads."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mjsim.errors import UsageError
from mjsim.sentences import Sentence
from mjsim.world.yaml import Entry, Node, Span

Path = tuple[str | int, ...]


class UnwritableError(UsageError):
    """A change cannot be written into the text; holds the path of the value."""

    def __init__(self, path: Path, message: str) -> None:
        super().__init__(Sentence("{path} {problem}", shown_path(path), message) if path else message)
        self.path = path


def shown_path(path: Sequence[str | int]) -> str:
    """Return a path in readable form: 'walls[0].openings[1].width'."""
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path).lstrip(".")


@dataclass(slots=True)
class TextPlace:
    """The place in the text to which a path of the world leads."""

    path: Path
    """The requested path."""
    own: list[str | int]
    """The written part of it, with indices as in the text, which do not count items of included files."""
    chain: list[Span]
    """The values along it, beginning with the whole text."""
    entries: list[Entry]
    """The entries that contain them; one fewer than values."""
    node: Node | None
    """Node of the last value; None if the text uses nothing that must be expanded."""
    expanded: Any
    """Expanded value of that node."""
    rest: list[str | int]
    """Steps that are not written."""

    @property
    def span(self) -> Span:
        """The last written value."""
        return self.chain[-1]

    @property
    def value(self) -> Any:
        """Its value, with expressions computed."""
        return self.span.plain if self.node is None else self.expanded

    @property
    def count(self) -> int:
        """Its number of items in the world."""
        return len(self.span.entries) if self.node is None else len(self.expanded)

    @property
    def elsewhere(self) -> str | None:
        """The included file that contains the missing part; None if no file does."""
        inner = self.node.items.get(self.rest[0]) if self.node is not None and self.rest else None
        return inner.origin.file if inner is not None and inner.origin is not None else None

    @property
    def is_empty(self) -> bool:
        """Whether its key has no value."""
        return self.span.kind == "scalar" and not self.span.text and not self.span.style and bool(self.entries)
