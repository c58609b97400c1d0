"""Tables of a comparison: lines for a terminal, CSV, LaTeX and JSON."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from mjsim.report.comparison import Compared, Comparison, Group
from mjsim.report.figures import FIGURES, ReportFigure
from mjsim.report.paired import CONFIDENCE
from mjsim.report.tables import csv_text, latex_float, latex_row, latex_text
from mjsim.sentences import Sentence

MAX_COLUMNS = 3
"""Maximum number of groups beside each other in a table; others follow below."""
WIDTH = 32
"""Maximum width of a column in a terminal [characters]."""


def comparison_lines(comparison: Comparison) -> list[str]:
    """Return a comparison as lines for a terminal: means with intervals, significant differences, notes."""
    lines = []
    for groups in _abreast(comparison.groups):
        lines += [*_lines_of(groups), ""]
    lines += _verdict_lines(comparison)
    if comparison.differences and not comparison.verdicts:
        lines.append("No difference is significant.")
    lines += [
        *(f"{sentence}." for sentence in comparison.consistency),
        *(f"Note: {sentence}." for sentence in comparison.remarks),
    ]
    return lines


def _verdict_lines(comparison: Comparison) -> Iterator[str]:
    """Yield significant differences, grouped by pairs of groups."""
    significant = [item for item in comparison.differences if item.difference.verdict]
    for better, worse in dict.fromkeys((item.better, item.worse) for item in significant):
        own = [item for item in significant if (item.better, item.worse) == (better, worse)]
        yield Sentence("{better} is better than {worse} ({pairs} pairs), by:", better, worse, own[0].difference.pairs)
        yield from (f"  {item.figure.title:<30}{item.size}" for item in own)


def comparison_csv(comparison: Comparison) -> str:
    """Return a row for each group and statistic, then one for each difference, with all digits."""
    columns = ("kind", "label", "robot", "figure", "unit", "count", "mean", "low", "high", "confidence", "verdict")
    rows = [
        (
            *("mean", group.label, group.robot, figure.key, figure.unit),
            *(summary.count, summary.mean, summary.low, summary.high, CONFIDENCE, None),
        )
        for group in comparison.groups
        for figure in FIGURES
        if (summary := group.spreads.get(figure.key)) is not None
    ]
    return csv_text(columns, [*rows, *map(_difference_row, comparison.differences)])


def _difference_row(item: Compared) -> Sequence[Any]:
    difference, sentence = item.difference, item.sentence if item.difference.verdict else None
    head = ("difference", f"{item.second} - {item.first}", None, item.figure.key, item.figure.unit)
    return (*head, difference.pairs, difference.mean, difference.low, difference.high, difference.confidence, sentence)


def comparison_latex(comparison: Comparison) -> str:
    """Return the means and their intervals for LaTeX with booktabs; a table for every three groups.

    Significant differences follow in comments.
    """
    tables = []
    for groups in _abreast(comparison.groups):
        rows = [
            latex_row((latex_text(figure.heading), *(_latex_cell(figure, group) for group in groups)))
            for figure in _shown(groups)
        ]
        heads = ("", *(group.label for group in groups))
        caption = f"{cell_legend(groups).capitalize()}; {_counts(groups)}."
        tables.append(latex_float("l" + "r" * len(groups), heads, rows, caption=caption))
    # For the text; a caption has no space for them.
    tables += [f"% {latex_text(sentence)}.\n" for sentence in comparison.verdicts]
    return "\n".join(tables)


def comparison_json(comparison: Comparison) -> dict[str, Any]:
    """Return `comparison.json`: 'groups', 'differences', 'verdicts', 'consistency', 'remarks'."""
    return {
        "groups": [
            {
                "label": group.label,
                "robot": group.robot,
                "failed": list(group.failed),
                "figures": {
                    key: {**asdict(summary), "values": {str(seed): value for seed, value in group.values[key].items()}}
                    for key, summary in group.spreads.items()
                },
            }
            for group in comparison.groups
        ],
        "differences": [
            {
                "figure": item.figure.key,
                "unit": item.figure.unit,
                "first": item.first,
                "second": item.second,
                **asdict(item.difference),
            }
            for item in comparison.differences
        ],
        "verdicts": list(comparison.verdicts),
        "consistency": list(comparison.consistency),
        "remarks": list(comparison.remarks),
    }


def mean_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Return the heading of each statistic, then its mean with its interval in each group."""
    groups = comparison.groups
    return [(figure.heading, *(interval_text(figure, group) for group in groups)) for figure in _shown(groups)]


def verdict_rows(comparison: Comparison) -> list[tuple[str, ...]]:
    """Return significant differences: better group, other group, statistic, difference, and number of pairs."""
    return [
        (item.better, item.worse, item.figure.title, item.size, str(item.difference.pairs))
        for item in comparison.differences
        if item.difference.verdict
    ]


def interval_text(figure: ReportFigure, group: Group) -> str:
    """Return the mean of a statistic and its interval; for few runs its range, in round brackets."""
    summary = group.spreads.get(figure.key)
    if summary is None:
        return "-"
    mean = figure.text(summary.mean) if figure.digits else f"{summary.mean:.3g}"
    if summary.low is not None and summary.high is not None:
        return f"{mean} [{_short(figure, summary.low)}, {_short(figure, summary.high)}]"
    values = group.values[figure.key].values()
    return (
        mean
        if summary.count == 1
        else Sentence("{mean} ({low} to {high})", mean, _short(figure, min(values)), _short(figure, max(values)))
    )


def cell_legend(groups: Sequence[Group]) -> str:
    """Return the explanation of the brackets of `interval_text` in the cells of a table."""
    summaries = [summary for group in groups for summary in group.spreads.values()]
    sure = any(summary.low is not None for summary in summaries)
    few = any(summary.low is None and summary.count > 1 for summary in summaries)
    if few:
        return "mean [95 % interval] (min to max)" if sure else "mean (min to max)"
    return "mean [95 % interval]" if sure else "mean"


def _short(figure: ReportFigure, value: float) -> str:
    return figure.text(value) if figure.digits else f"{value:.3g}"


def _abreast(groups: Sequence[Group]) -> Iterator[Sequence[Group]]:
    """Yield the groups beside each other."""
    return (groups[first : first + MAX_COLUMNS] for first in range(0, len(groups), MAX_COLUMNS))


def _shown(groups: Sequence[Group]) -> Iterator[ReportFigure]:
    """Yield the statistics that at least one group has."""
    return (figure for figure in FIGURES if any(figure.key in group.spreads for group in groups))


def _counted(group: Group) -> str:
    count = max((summary.count for summary in group.spreads.values()), default=0)
    return "1 run" if count == 1 else Sentence("{count} runs", count)


def _counts(groups: Sequence[Group]) -> str:
    """Return the numbers of runs of groups, in short form."""
    counts = list(map(_counted, groups))
    return (
        Sentence("{counts} each", counts[0])
        if len(set(counts)) == 1
        else Sentence("{counts}, from left to right", ", ".join(counts))
    )


def _lines_of(groups: Sequence[Group]) -> Iterator[str]:
    """Yield the lines of a table of groups beside each other."""
    columns = [[_fitted(group.label), _counted(group)] for group in groups]
    figures = list(_shown(groups))
    for column, group in zip(columns, groups, strict=True):
        column += [interval_text(figure, group) for figure in figures]
    widths = [max(map(len, column)) for column in columns]
    heads = ["", cell_legend(groups), *(figure.heading for figure in figures)]
    first = max(map(len, heads))
    for head, *cells in zip(heads, *columns, strict=True):
        yield f"{head:<{first}}" + "".join(f"   {cell:>{width}}" for cell, width in zip(cells, widths, strict=True))


def _fitted(label: str) -> str:
    """Return the end of a label, no wider than a column."""
    return label if len(label) <= WIDTH else f"...{label[3 - WIDTH :]}"


def _latex_cell(figure: ReportFigure, group: Group) -> str:
    return latex_text(interval_text(figure, group))
