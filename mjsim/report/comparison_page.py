"""Files of a comparison: tables, plots, and one HTML page that works offline."""

import json
from collections.abc import Iterator, Sequence
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
from mjsim.report.html_page import Block, Heading, HtmlTable, Items, Paragraph, html_page, picture

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
        formats: Formats of the plots: 'png', 'pdf', 'svg'; the page has them in any case.
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
    title = " and ".join(group.label for group in comparison.groups[:4])
    return html_page(title, "mjsim compare", *_blocks(comparison, pictures))


def _blocks(comparison: Comparison, pictures: dict[str, bytes]) -> Iterator[Block]:
    yield Heading("What is certain")
    if rows := verdict_rows(comparison):
        yield HtmlTable(("better", "than", "in", "by [interval]", "pairs"), rows, wide=True)
    else:
        yield Paragraph("No difference is significant.")
    if notes := [*comparison.consistency, *comparison.remarks]:
        yield from (Heading("What to know"), Items(notes))
    yield Heading(f"Figures: {cell_legend(comparison.groups)}")
    heads = ("", *(group.label for group in comparison.groups))
    yield HtmlTable(heads, mean_rows(comparison), wide=True)
    yield from (picture(name, data) for name, data in pictures.items())
