"""Loads runs to compare from recordings, folders of them, and sweeps."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.record import Recording, Track, read_recording
from mjsim.report import metrics
from mjsim.report.comparison import Comparison, RunFigures, Series, compare_tables
from mjsim.report.labels import Found, differing_worlds, labelled, settings_of
from mjsim.report.paired import CONFIDENCE
from mjsim.report.statistics import known_part, statistics_file
from mjsim.report.sweep_runs import sweep_runs
from mjsim.sentences import Sentence
from mjsim.world import World

MAX_POINTS = 1000
"""Maximum number of points of a series kept for each run, for plots."""

RunSource = str | Path | Recording
"""A recording or its file, or a folder with recordings or a sweep."""


def compare(
    runs: Iterable[RunSource] | Mapping[str, RunSource | Iterable[RunSource]] | RunSource,
    *,
    confidence: float = CONFIDENCE,
    progress: Callable[[float], None] | None = None,
) -> Comparison:
    """Compare the estimators, settings or robots in which runs differ.

    Args:
        runs: Recordings, their files, or folders of them; a mapping gives labels. Runs without label are grouped by the
            settings in which they differ, or else by the names of their files; folders among others by folder.
        confidence: Confidence with which all intervals of one statistic hold simultaneously.
        progress: Called with the progress of reading, 0 to 1.

    Raises:
        UsageError: A file cannot be read, there is nothing to compare, or one label has a seed twice.
        RecordingError: A file is not a recording.
    """
    found: list[Found] = []
    sources = list(_sources(runs))
    readers = [(label, read) for label, source in sources for read in _readers(source, alone=len(sources) == 1)]
    for done, (label, read) in enumerate(readers, start=1):
        found += [replace(each, folder=label) for each in read()]
        if progress is not None:
            progress(done / len(readers))
    comparison = compare_tables(labelled(found), confidence=confidence)
    remark = differing_worlds(found)
    return replace(comparison, remarks=(remark, *comparison.remarks)) if remark else comparison


def _sources(
    runs: Iterable[RunSource] | Mapping[str, RunSource | Iterable[RunSource]] | RunSource,
) -> Iterable[tuple[str, RunSource]]:
    """Yield label and source; labels are empty where none is given."""
    if isinstance(runs, Mapping):
        for label, given in runs.items():
            each = [given] if isinstance(given, (str, Path, Recording)) else given
            yield from ((label, source) for source in each)
        return
    listed = [runs] if isinstance(runs, (str, Path, Recording)) else list(runs)
    folders = [Path(each) for each in listed if not isinstance(each, Recording) and Path(each).is_dir()]
    names = Counter(folder.resolve().name for folder in folders)
    for source in listed:
        if len(listed) == 1 or isinstance(source, Recording) or not Path(source).is_dir():
            yield "", source
        else:
            name = Path(source).resolve().name
            yield name if names[name] == 1 else str(source), source


def _readers(source: RunSource, *, alone: bool) -> list[Callable[[], list[Found]]]:
    """Return functions that each read one run of a source, so that only one is in memory."""
    if isinstance(source, Recording):
        return [lambda: [run_of(source)]]
    path = Path(source)
    if not path.is_dir():
        return [partial(_recorded, path)]
    if (path / "sweep.json").is_file():
        return [partial(sweep_runs, path, alone=alone)]
    recordings = sorted(path.rglob("*.mcap"))
    if recordings:
        return [partial(_recorded, file) for file in recordings]
    raise UsageError(
        Sentence("no recording in '{path}'; name a folder with .mcap files, or one that mjsim sweep made", path)
    )


def _recorded(file: Path) -> list[Found]:
    return [run_of(read_recording(file))]


@np.errstate(over="ignore", invalid="ignore")
def run_of(recording: Recording) -> Found:
    """Return the statistics of a recording, its settings, and the errors of its robots over time."""
    figures = statistics_file(recording)
    run = figures["run"]
    fault = any(robot["fault"] is not None for robot in figures["robots"].values())
    parts = {name: known_part(track) for name, track in recording.robots.items()}
    return Found(
        run=RunFigures(
            label="",
            seed=recording.seed,
            robots=figures["robots"],
            series={
                name: _series(recording.world, part, estimated=recording.has_estimator(name))
                for name, part in parts.items()
                if part is not None
            },
            failed=fault or not run["whole"],
        ),
        path=recording.path,
        settings=settings_of(recording.world, recording.metadata),
        world=recording.world.name,
    )


def _series(world: World, track: Track, *, estimated: bool) -> Series:
    rows = slice(None, None, -(-len(track.time) // MAX_POINTS))
    truth, estimate = track.truth[rows], track.estimate[rows]
    return Series(
        time=track.time[rows],
        position_error_m=metrics.position_errors(truth, estimate),
        nees=metrics.normalised_errors(truth, estimate, track.covariance[rows])
        if estimated
        else np.full(len(truth), np.nan),
        truth=truth[:, :2],
        estimate=estimate[:, :2],
        estimated=estimated,
        world=world,
    )
