"""The commands `report` and `compare`: statistics of recordings."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Begin, End, Formats, Overwrite, RunFile, recorded
from mjsim.output import free_paths
from mjsim.progress import tracked


def report(
    recording: RunFile,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for the report.")],
    begin: Begin = None,
    end: End = None,
    formats: Formats = "png",
    overwrite: Overwrite = False,
) -> None:
    """Write statistics, tables and plots of a run.

    Write statistics.json, report.html, tables and plots of the run or a section of it; print the key statistics.
    """
    from mjsim.report import REPORT_FILES, key_table, parse_formats, write_report

    kinds = parse_formats(formats)
    free_paths(output, REPORT_FILES, overwrite=overwrite)
    run = recorded(recording).between(begin, end)
    figures = write_report(run, output, formats=kinds, overwrite=overwrite)
    print(*key_table(figures), sep="\n")


def compare(
    runs: Annotated[
        list[Path],
        typer.Argument(metavar="RUN.mcap...", help="Recordings, folders with recordings, or folders of sweeps."),
    ],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Also write tables, plots and comparison.html.")
    ] = None,
    confidence: Annotated[float, typer.Option(help="Joint confidence level of all intervals of a statistic.")] = 0.95,
    formats: Formats = "png",
    overwrite: Overwrite = False,
) -> None:
    """Compare runs, and report significant differences.

    Runs are grouped by their settings and paired by seed.
    """
    from mjsim.report import COMPARISON_FILES, comparison_lines, parse_formats, write_comparison
    from mjsim.report import compare as compare_runs

    kinds = parse_formats(formats)
    if output is not None:
        free_paths(output, COMPARISON_FILES, overwrite=overwrite)
    with tracked("compare", total=100.0, unit="%") as advance:
        comparison = compare_runs(runs, confidence=confidence, progress=lambda share: advance(100.0 * share))
    if output is not None:
        write_comparison(comparison, output, formats=kinds, overwrite=overwrite)
    print(*comparison_lines(comparison), sep="\n")
