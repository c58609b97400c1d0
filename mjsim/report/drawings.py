"""Converts drawings to files: PNG for screens, PDF and SVG for papers."""

import io
import warnings
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING

from mjsim.errors import UsageError, did_you_mean
from mjsim.progress import say
from mjsim.sentences import Sentence

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NO_GLYPH = "missing from font"
"""Part of matplotlib's warning about a character that is missing from a font."""
FORMATS = ("png", "pdf", "svg")
_NO_DATE: dict[str, dict[str, None]] = {"png": {}, "pdf": {"CreationDate": None}, "svg": {"Date": None}}
"""Omits the date, so that the same drawing has the same bytes."""


def parse_formats(text: str) -> tuple[str, ...]:
    """Return the formats in a list such as 'png,pdf'.

    Raises:
        UsageError: One of them is unknown.
    """
    return require_formats([word.strip().lower() for word in text.split(",")])


def require_formats(formats: Sequence[str]) -> tuple[str, ...]:
    """Return formats without duplicates.

    Raises:
        UsageError: One of them is unknown, or there is none.
    """
    for word in formats or [""]:
        if word not in FORMATS:
            raise UsageError(
                Sentence("no format '{word:.20}' for plots{did_you_mean}", word, did_you_mean(word, FORMATS))
            )
    return tuple(dict.fromkeys(formats))


def drawing_as(figure: "Figure", form: str) -> bytes:
    """Return a drawing as the contents of a file in one of `FORMATS`."""
    from matplotlib import rc_context

    buffer = io.BytesIO()
    # Publishers reject Type 3 fonts, matplotlib's default; without a salt the ids in SVG are random.
    with rc_context({"pdf.fonttype": 42, "svg.hashsalt": "mjsim"}), warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        figure.savefig(buffer, format=form, metadata=_NO_DATE[form])
    for warning in told:
        if _NO_GLYPH in str(warning.message):
            _say_boxes()
        else:
            warnings.warn_explicit(warning.message, warning.category, warning.filename, warning.lineno)
    return buffer.getvalue()


@cache
def _say_boxes() -> None:
    """Warn, once in a process, that the font of plots lacks characters."""
    say("plots show boxes for letters that their font does not have; tables and pages show the names themselves")


def plot_text(text: str) -> str:
    """Return a text, such as the name of a file, that plots show literally: not as a formula, and always in legends."""
    shown = text.replace("$", r"\$")
    return f" {shown}" if shown.startswith("_") else shown


def png_of(figure: "Figure") -> bytes:
    """Return a drawing as the contents of a PNG file."""
    return drawing_as(figure, "png")


def drawing_files(
    figures: Mapping[str, "Figure"], formats: Sequence[str], *, pictures: Mapping[str, bytes] | None = None
) -> dict[str, bytes]:
    """Return the contents of files by name, such as 'path.pdf'.

    Args:
        figures: Drawings by the names of the files without suffix.
        formats: Formats in which each is written.
        pictures: Those that are already PNG, by the same names.
    """
    drawn = {f"{name}.png": data for name, data in (pictures or {}).items()}
    names = [(name, form, f"{name}.{form}") for name in figures for form in formats]
    return {file: drawn.get(file) or drawing_as(figures[name], form) for name, form, file in names}
