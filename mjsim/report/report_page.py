"""Files of a report: `statistics.json`, the plots, and one HTML page that works offline."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.output import free_paths, write_set
from mjsim.record import INCOMPLETE, Recording
from mjsim.report.arm_statistics import slides_of
from mjsim.report.drawings import drawing_files, plot_text, png_of, require_formats
from mjsim.report.html_page import Block, Heading, HtmlTable, Paragraph, html_page, picture
from mjsim.report.statistics import known_part, stands, statistics_file
from mjsim.report.tables import csv_table, key_figures, latex_table, shared_errors_of
from mjsim.world import as_motions, event_text, world_notes

if TYPE_CHECKING:
    from matplotlib.figure import Figure

REPORT_FILES = ("statistics.json", "report.html", "table.csv", "table.tex")
"""Files of every report."""


def write_report(
    recording: Recording, folder: Path, *, formats: Sequence[str] = ("png",), overwrite: bool = False
) -> dict[str, Any]:
    """Write statistics, plots and page into a folder, created if necessary; return the content of `statistics.json`.

    Args:
        recording: The recording.
        folder: Destination of the files.
        formats: Formats of the plots: 'png', 'pdf', 'svg'; the page has them in any case.
        overwrite: Whether to replace an earlier report, and remove its files that this one does not have; all others in
            the folder stay.

    Raises:
        UsageError: The folder has a report, or cannot be written; or a format is unknown.
    """
    formats = require_formats(formats)
    free_paths(folder, REPORT_FILES, overwrite=overwrite)
    figures = statistics_file(recording)
    write_set(folder, _files(recording, figures, formats), of="report", overwrite=overwrite)
    return figures


def _files(recording: Recording, figures: dict[str, Any], formats: Sequence[str]) -> dict[str, bytes]:
    """Return the contents of the files by name."""
    files = {
        "statistics.json": (json.dumps(figures, indent=1, allow_nan=False) + "\n").encode(),
        "table.csv": csv_table(figures).encode(),
        "table.tex": latex_table(figures).encode(),
    }
    blocks: list[Block] = []
    for robot in recording.robots:
        drawn = robot_plots(recording, robot)
        with np.errstate(over="ignore", invalid="ignore"):
            pictures = {name: png_of(figure) for name, figure in drawn.items()}
            plots = drawing_files(drawn, formats, pictures=pictures)
        files |= {f"{robot}_{name}": data for name, data in plots.items()}
        of_arms = {}
        for arm, drawn in _drawn_arms(recording, robot):
            of_arms[arm] = {name: png_of(figure) for name, figure in drawn.items()}
            plots = drawing_files(drawn, formats, pictures=of_arms[arm])
            files |= {f"{robot}_{arm}_{name}": data for name, data in plots.items()}
        blocks += [*_blocks(robot, figures["robots"][robot], pictures), *_arm_blocks(robot, of_arms)]
    for name, drawn in _drawn_mechanisms(recording):
        of_mechanism = {kind: png_of(figure) for kind, figure in drawn.items()}
        plots = drawing_files(drawn, formats, pictures=of_mechanism)
        files |= {f"{name}_{kind}": data for kind, data in plots.items()}
        blocks += [Heading(name), *(picture(f"{kind} of {name}", png) for kind, png in of_mechanism.items())]
    files["report.html"] = _page(recording, figures["run"], blocks).encode()
    return files


@np.errstate(over="ignore", invalid="ignore")
def robot_plots(recording: Recording, robot: str, *, only: str | None = None) -> dict[str, "Figure"]:
    """Return the plots of a robot by name, or one of them; dead reckoning alone has no NEES."""
    from mjsim.report.plots import PLOTS

    track = None if stands(recording.world, robot) else known_part(recording.robots[robot])
    if track is None:
        return {}
    estimator = recording.estimator_of(robot)
    selected = [(name, draw) for name, draw in PLOTS if only in (None, name) and (estimator or name != "nees")]
    label = plot_text(estimator or "estimate")
    return {name: figure for name, draw in selected if (figure := draw(recording.world, track, label)) is not None}


def _drawn_arms(recording: Recording, robot: str) -> Iterator[tuple[str, dict[str, "Figure"]]]:
    """Yield the name of each arm of a robot, or 'drive' of a balancing one, and its plots by name."""
    if not recording.joints:
        return
    from mjsim.report.arm_plots import arm_plots, drive_plots

    for name, track in recording.joints.items():
        of, _, arm = name.partition("/")
        if of != robot:
            continue
        if arm == "drive":
            yield arm, drive_plots(recording.time, track)
        else:
            yield arm, arm_plots(recording.time, track, slides_of(recording.world, robot, arm))


def _drawn_mechanisms(recording: Recording) -> Iterator[tuple[str, dict[str, "Figure"]]]:
    """Yield the name of each mechanism, and its plots by name."""
    if not recording.world.mechanisms:
        return
    from mjsim.report.mechanism_plots import mechanism_plots

    for mechanism in recording.world.mechanisms:
        joints, sensors = recording.joints[mechanism.name], recording.readings[mechanism.name]
        slides = np.array(mechanism.assembly.slides, dtype=bool)
        yield mechanism.name, mechanism_plots(recording.time, joints, slides, sensors)


def _arm_blocks(robot: str, pictures: Mapping[str, Mapping[str, bytes]]) -> Iterator[Block]:
    for arm, drawn in pictures.items():
        yield Heading(f"{robot}/{arm}")
        yield from (picture(f"{name} of {robot}/{arm}", png) for name, png in drawn.items())


def _blocks(robot: str, figures: dict[str, Any], pictures: Mapping[str, bytes]) -> Iterator[Block]:
    yield Heading(robot)
    if figures["fault"]:
        yield Paragraph(figures["fault"], "fault")
    yield HtmlTable(("", "estimate", "odometry"), key_figures(figures))
    if note := shared_errors_of(figures):
        yield Paragraph(f"{note}.")
    yield from (picture(f"{name} of {robot}", png) for name, png in pictures.items())


def _times(run: dict[str, Any]) -> Iterator[Block]:
    """Yield the table of the computing times of modules and parts of the loop."""
    costs = sorted(run["milliseconds"].items(), key=lambda item: -item[1]["mean"])
    if rows := [(part, f"{cost['mean']:.3f}", f"{cost['p99']:.3f}") for part, cost in costs]:
        yield Heading("Wall-clock time per tick")
        yield HtmlTable(("", "mean [ms]", "99th percentile [ms]"), rows)


def _events(recording: Recording, title: str, *kinds: str) -> tuple[Block, ...]:
    """Return a table of the robots' events of some kinds; none without any."""
    events = [event for track in recording.robots.values() for event in track.events if event.kind in kinds]
    return (Heading(title), HtmlTable((), [(each.text, f"{each.time:.2f} s") for each in events])) if events else ()


def _page(recording: Recording, run: dict[str, Any], blocks: Iterable[Block]) -> str:
    factor = "" if run["real_time_factor"] is None else f", {run['real_time_factor']:.1f} times real time"
    happened = [(event_text(event), f"{event.time:.2f} s") for event in as_motions(recording.events)]
    story = (Heading("Events of the world"), HtmlTable((), happened)) if happened else ()
    stops = _events(recording, "Blocked robots", "blocked")
    stops += _events(recording, "Lost robots", "lost", "found")
    cut = "" if run["whole"] else f"; {INCOMPLETE}"
    about = Paragraph(f"{run['sim_seconds']:.1f} s simulated{factor}, seed {run['seed']}{cut}", "run")
    notes = (Paragraph(f"{note.message}.") for note in world_notes(recording.world))
    return html_page(recording.world.name, "mjsim report", about, *notes, *blocks, *stops, *story, *_times(run))
