"""A comparison as files: tables, plots, and one HTML page that opens offline."""

import html
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mjsim.output import write_set
from mjsim.report.comparison import Comparison
from mjsim.report.comparison_tables import (
    comparison_csv,
    comparison_json,
    comparison_latex,
    interval_text,
    told_in_cells,
)
from mjsim.report.drawings import drawing_files, png_of, require_formats
from mjsim.report.figures import FIGURES
from mjsim.report.page import STYLE, picture

COMPARISON_FILES = ("comparison.json", "table.csv", "table.tex", "comparison.html")
"""Of every comparison."""


@np.errstate(over="ignore", invalid="ignore")
def write_comparison(
    comparison: Comparison, folder: Path, *, formats: Sequence[str] = ("png",), overwrite: bool = False
) -> None:
    """Write `comparison.json`, `table.csv`, `table.tex`, the plots and `comparison.html` into a folder.

    Args:
        comparison: What is written.
        folder: Where to; made if need be.
        formats: Of the plots: 'png', 'pdf', 'svg'; the page has them in any case.
        overwrite: Whether the files of an earlier comparison are replaced or, where this one has none of their name,
            removed; all others in the folder stay.

    Raises:
        UsageError: The folder holds a comparison, or cannot be written; or a format is not known.
    """
    from mjsim.report.comparison_plots import PLOTS

    formats = require_formats(formats)
    drawn = {name: drawing for name, draw in PLOTS if (drawing := draw(comparison)) is not None}
    pictures = {name: png_of(drawing) for name, drawing in drawn.items()}
    files = {
        "comparison.json": (json.dumps(comparison_json(comparison), indent=1, allow_nan=False) + "\n").encode(),
        "table.csv": comparison_csv(comparison).encode(),
        "table.tex": comparison_latex(comparison).encode(),
        **drawing_files(drawn, formats, pictures=pictures),
        "comparison.html": _page(comparison, pictures).encode(),
    }
    write_set(folder, files, of="comparison", overwrite=overwrite)


def _page(comparison: Comparison, pictures: dict[str, bytes]) -> str:
    title = " and ".join(group.label for group in comparison.groups[:4])
    know = "".join(f"<li>{html.escape(told)}</li>" for told in (*comparison.consistency, *comparison.remarks))
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{html.escape(title)} - mjsim compare</title>'
        f'<meta name="viewport" content="width=device-width"><style>{STYLE}</style>'
        f"<h1>{html.escape(title)}</h1>"
        f"<h2>What is certain</h2>{_verdicts(comparison)}"
        + (f"<h2>What to know</h2><ul>{know}</ul>" if know else "")
        + f"<h2>Figures: {told_in_cells(comparison.groups)}</h2>{_table(comparison)}"
        + "".join(picture(name, data) for name, data in pictures.items())
        + "</html>\n"
    )


def _verdicts(comparison: Comparison) -> str:
    """Return the table of what is certain."""
    rows = "".join(
        f"<tr><td>{html.escape(item.better)}</td><td>{html.escape(item.worse)}</td>"
        f"<td>{html.escape(item.figure.title)}</td><td>{item.size}</td><td>{item.difference.pairs}</td></tr>"
        for item in comparison.differences
        if item.difference.verdict
    )
    if not rows:
        return "<p>No figure is certain to be better in one than in another.</p>"
    heads = "".join(f"<th>{head}</th>" for head in ("better", "than", "in", "by [interval]", "pairs"))
    return f'<div class="wide"><table><thead><tr>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'


def _table(comparison: Comparison) -> str:
    groups = comparison.groups
    heads = "".join(f"<th>{html.escape(group.label)}</th>" for group in groups)
    rows = "".join(
        f"<tr><td>{html.escape(figure.heading)}</td>"
        + "".join(f"<td>{interval_text(figure, group)}</td>" for group in groups)
        + "</tr>"
        for figure in FIGURES
        if any(figure.key in group.spreads for group in groups)
    )
    return f'<div class="wide"><table><thead><tr><th></th>{heads}</tr></thead><tbody>{rows}</tbody></table></div>'
