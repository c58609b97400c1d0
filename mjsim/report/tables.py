"""The statistics of a run as tables: lines for a terminal, CSV, LaTeX."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from mjsim.report.consistency import shared_errors
from mjsim.report.figures import FIGURES, figure_value

_LATEX = {
    "\\": r"\textbackslash{}",
    "&": r"\&",
    "%": r"\%",
    "$": r"\$",
    "#": r"\#",
    "_": r"\_",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedbl{}",
}
"""Characters that have a special meaning in LaTeX, with their replacements."""


def key_figures(robot: dict[str, Any]) -> list[tuple[str, str, str]]:
    """Return the non-empty rows of a robot: title, value of the estimate, value of dead reckoning."""
    rows = []
    for figure in FIGURES:
        value = figure_value(robot, figure.key)
        if value is not None:
            wheels = figure_value(robot, figure.odometry) if figure.odometry else None
            rows.append((figure.heading, figure.text(value), "" if wheels is None else figure.text(wheels)))
        elif figure.key == "nees.mean" and (reason := (robot.get("nees") or {}).get("reason")):
            rows.append((figure.heading, reason, ""))
    return rows


def shared_errors_of(robot: Mapping[str, Any]) -> str:
    """Return the line of `shared_errors` for the statistics of a robot."""
    return shared_errors(*(figure_value(robot, key) for key in ("nees.mean", "nis.mean", "nis.pictures")))


def key_table(figures: dict[str, Any]) -> list[str]:
    """Return the key statistics of each robot as lines for a terminal, from the contents of `statistics.json`."""
    lines = []
    for name, robot in figures["robots"].items():
        lines.append(f"{name:<34}{'estimate':>10}{'odometry':>10}")
        lines += [
            f"  {label:<32}{estimate:>10}{odometry:>10}".rstrip() for label, estimate, odometry in key_figures(robot)
        ]
        if robot.get("fault"):
            lines.append(f"  ended by a fault: {robot['fault']}")
        lines += [f"  {shared}"] if (shared := shared_errors_of(robot)) else []
    factor = figures["run"]["real_time_factor"]
    if factor is not None:
        lines.append(f"{'real-time factor of the run':<34}{factor:>10.1f}")
    return lines


def csv_table(figures: dict[str, Any]) -> str:
    """Return a row for each robot and statistic, with all digits; a missing value is an empty field."""
    return csv_text(
        ("robot", "figure", "unit", "estimate", "odometry"),
        (
            (
                name,
                figure.key,
                figure.unit,
                figure_value(robot, figure.key),
                figure_value(robot, figure.odometry) if figure.odometry else None,
            )
            for name, robot in figures["robots"].items()
            for figure in FIGURES
        ),
    )


def latex_table(figures: dict[str, Any]) -> str:
    """Return a table of all robots for LaTeX with the package booktabs."""
    rows = []
    for number, (name, robot) in enumerate(figures["robots"].items()):
        rows += ["\\midrule"] * (number > 0)
        rows.append(f"\\multicolumn{{3}}{{l}}{{\\textit{{{latex_text(name)}}}}} \\\\")
        rows += [latex_row((latex_text(label), *numbers)) for label, *numbers in key_figures(robot)]
    run = figures["run"]
    caption = f"World {run['world']}, seed {run['seed']}, {run['sim_seconds']:.1f} s"
    return latex_float("lrr", ("", "estimate", "odometry"), rows, caption=caption)


def csv_text(header: Sequence[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table as CSV; None is an empty field, and a number reads back exactly."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(header)
    table.writerows(rows)
    return text.getvalue()


def latex_text(text: str) -> str:
    """Return a text with the special characters of LaTeX escaped."""
    return "".join(_LATEX.get(character, character) for character in text if character.isprintable())


def latex_row(cells: Iterable[str]) -> str:
    """Return a row of cells, which are LaTeX already."""
    return f"{' & '.join(cells)} \\\\"


def latex_float(columns: str, heads: Sequence[str], rows: Iterable[str], *, caption: str) -> str:
    """Return a table with its caption.

    Args:
        columns: Alignment of the columns, such as 'lrr'.
        heads: Headers of the columns, plain text.
        rows: The rows, in LaTeX.
        caption: The caption, plain text.
    """
    return "\n".join(
        (
            "% needs \\usepackage{booktabs}",
            "\\begin{table}",
            "\\centering",
            f"\\caption{{{latex_text(caption)}}}",
            f"\\begin{{tabular}}{{{columns}}}",
            "\\toprule",
            latex_row(map(latex_text, heads)),
            "\\midrule",
            *rows,
            "\\bottomrule",
            "\\end{tabular}",
            "\\end{table}",
            "",
        )
    )
