"""Files of a comparison: tables, plots, and one HTML page that works offline."""

import html
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from mjsim.output import write_set
from mjsim.report.comparison import Comparison
from mjsim.report.comparison_tables import (
    cell_legend,
    comparison_csv,
    comparison_json,
    comparison_latex,
    mean_rows,
    verdict_rows,
)
from mjsim.report.drawings import drawing_files, png_of, require_formats
from mjsim.report.html_page import html_page, html_table, picture

COMPARISON_FILES = ("comparison.json", "table.csv", "table.tex", "comparison.html")
"""Files of every comparison."""


@np.errstate(over="ignore", invalid="ignore")
def write_comparison(
    comparison: Comparison, folder: Path, *, formats: Sequence[str] = ("png",), overwrite: bool = False
) -> None:
    """Write `comparison.json`, `table.csv`, `table.tex`, the plots and `comparison.html` into a folder.

    Args:
        comparison: The comparison.
        folder: Destination; created if necessary.
        formats: Of the plots: 'png', 'pdf', 'svg'; the page has them in any case.
        overwrite: Whether to replace an earlier comparison, and remove its files that this one does not have; all
            others in the folder stay.

    Raises:
        UsageError: The folder has a comparison, or cannot be written; or a format is unknown.
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
    notes = "".join(f"<li>{html.escape(sentence)}</li>" for sentence in (*comparison.consistency, *comparison.remarks))
    return html_page(
        " and ".join(group.label for group in comparison.groups[:4]),
        "mjsim compare",
        f"<h2>What is certain</h2>{_verdicts(comparison)}",
        f"<h2>What to know</h2><ul>{notes}</ul>" if notes else "",
        f"<h2>Figures: {cell_legend(comparison.groups)}</h2>{_table(comparison)}",
        *(picture(name, data) for name, data in pictures.items()),
    )


def _verdicts(comparison: Comparison) -> str:
    """Return the table of significant differences."""
    rows = verdict_rows(comparison)
    if not rows:
        return "<p>No difference is significant.</p>"
    return html_table(("better", "than", "in", "by [interval]", "pairs"), rows, wide=True)


def _table(comparison: Comparison) -> str:
    heads = ("", *(group.label for group in comparison.groups))
    return html_table(heads, mean_rows(comparison), wide=True)
