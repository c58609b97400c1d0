"""The one builder of result pages, from reports to workplaces: HTML that works offline, light and dark.

Pages are made of blocks of plain text; the template escapes all of it.
"""

import base64
import functools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    import jinja2

Cell = tuple[str, str]
"""Text of a cell of a table, and its class."""


class Heading(NamedTuple):
    """A heading below that of the page."""

    text: str
    level: int = 2
    block: str = "heading"


class Paragraph(NamedTuple):
    """A paragraph; its class may be 'run' for the subject of a page, or 'fault'."""

    text: str
    kind: str = ""
    block: str = "paragraph"


class Items(NamedTuple):
    """A list."""

    lines: Sequence[str]
    block: str = "items"


class Code(NamedTuple):
    """A text of several lines, as it is written; it scrolls, also with keys."""

    text: str
    block: str = "code"


@dataclass(frozen=True)
class HtmlTable:
    """A table."""

    heads: Sequence[str]
    """Headers of its columns; '' for a column without header, and none at all for no header row."""
    rows: Iterable[Sequence[str | Cell]]
    kind: str = ""
    """Its class."""
    wide: bool = False
    """Whether its lines are not wrapped and it scrolls, also with keys, if it is wider than the page."""
    block: str = "table"


@dataclass(frozen=True)
class HtmlPicture:
    """A picture."""

    title: str
    source: str
    """Its address."""
    captioned: bool = False
    """Whether its title is below it."""
    block: str = "picture"


Block = Heading | Paragraph | Items | Code | HtmlTable | HtmlPicture


def html_page(title: str, command: str, *blocks: Block, style: str = "") -> str:
    """Return a complete page.

    Args:
        title: Its heading.
        command: The command that wrote it, such as 'mjsim report'.
        blocks: Its contents below the heading.
        style: CSS rules beyond those of all pages.
    """
    return _template().render(title=title, command=command, blocks=blocks, style=style)


def picture(title: str, png: bytes) -> HtmlPicture:
    """Return a picture embedded in its page."""
    return HtmlPicture(title, f"data:image/png;base64,{base64.b64encode(png).decode()}")


@functools.cache
def _template() -> "jinja2.Template":
    import jinja2

    text = Path(__file__).with_name("page.html.jinja").read_text(encoding="utf-8")
    return jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    ).from_string(text)
