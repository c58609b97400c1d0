"""The commands `report` and `compare`: what recordings tell."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.progress import tracked

Begin = Annotated[float | None, typer.Option("--from", metavar="S", help="Only from this time on [s].")]
End = Annotated[float | None, typer.Option("--to", metavar="S", help="Only until this time [s].")]


def report(
    recording: Annotated[Path, typer.Argument(metavar="RUN.mcap", help="A recording.")],
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder of the report.")],
    begin: Begin = None,
    end: End = None,
) -> None:
    """Write statistics.json, report.html, tables and plots of a run or a part of it; print the key figures."""
    from mjsim.record import read_recording
    from mjsim.report import key_table, write_report

    figures = write_report(read_recording(recording).between(begin, end), output)
    print(*key_table(figures), sep="\n")


def compare(
    runs: Annotated[
        list[Path], typer.Argument(metavar="RUN.mcap...", help="Recordings, folders of them, or a sweep's folder.")
    ],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Also write tables, plots and comparison.html.")
    ] = None,
    confidence: Annotated[float, typer.Option(help="That all intervals of a figure hold at once.")] = 0.95,
) -> None:
    """Compare runs by what differs in them, pair by pair with the same seed; say what is certain."""
    from mjsim.report import compare as compare_runs
    from mjsim.report import comparison_lines, write_comparison

    with tracked("compare", total=100.0, unit="%") as advance:
        comparison = compare_runs(runs, confidence=confidence, progress=lambda share: advance(100.0 * share))
    if output is not None:
        write_comparison(comparison, output)
    print(*comparison_lines(comparison), sep="\n")
