"""Runs that are to be compared, from wherever they are: recordings, folders of them, sweeps, reports."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import UsageError
from mjsim.record import Recording, Track, read_recording
from mjsim.report import metrics
from mjsim.report.comparison import Comparison, RunFigures, Series, compare_tables
from mjsim.report.labels import file_labels, setting_labels, settings_of
from mjsim.report.paired import CONFIDENCE
from mjsim.report.statistics import known_part, statistics_file

MOST_POINTS = 1000
"""Of a series that is kept of each run, for plots."""

RunSource = str | Path | Recording
"""A recording or its file, or a folder that holds recordings, a sweep or reports."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """A run as it was found, not yet labelled among others."""

    run: RunFigures
    path: Path
    settings: Mapping[str, str]
    world: str
    """Its name."""
    folder: str = ""
    """The label that was given with it, or the folder of several that it was in."""


def compare(
    runs: Iterable[RunSource] | Mapping[str, RunSource | Iterable[RunSource]] | RunSource,
    *,
    confidence: float = CONFIDENCE,
    progress: Callable[[float], None] | None = None,
) -> Comparison:
    """Return what runs tell of the estimators, settings or robots in which they differ.

    Args:
        runs: Recordings, their files, or folders of them; with labels, when given as a mapping. Unlabelled ones are
            grouped by the settings in which they differ, else by the names of their files; several folders by folder.
        confidence: That all intervals of one figure hold at once.
        progress: Called with the share of what is to be read that has been.

    Raises:
        UsageError: A file cannot be read, there is nothing to compare, or one label has a seed twice.
        RecordingError: A file is not a recording.
    """
    found: list[Found] = []
    readers = [(label, read) for label, source in _sources(runs) for read in _readers(source)]
    for done, (label, read) in enumerate(readers, start=1):
        found += [replace(each, folder=label) for each in read()]
        if progress is not None:
            progress(done / len(readers))
    return compare_tables(labelled(found), confidence=confidence)


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
    folders = [source for source in listed if not isinstance(source, Recording) and Path(source).is_dir()]
    for source in listed:
        several = len(listed) > 1 and source in folders
        yield (Path(str(source)).resolve().name if several else "", source)


def labelled(found: Sequence[Found]) -> list[RunFigures]:
    """Return runs with their labels: those given, the settings that differ, or their files, whichever can be paired."""
    given = [each.folder for each in found]
    files = file_labels([each.path for each in found])
    settings = setting_labels([each.settings for each in found], [each.world for each in found]) or files
    choices = [given, _joined(given, settings)] if any(given) else [settings, files, _joined(settings, files)]
    runs = list(zip(settings, (each.run.seed for each in found), strict=True))
    labels = next((choice for choice in choices if _fit(choice, runs)), [str(each.path) for each in found])
    return [replace(each.run, label=label) for each, label in zip(found, labels, strict=True)]


def _fit(labels: Sequence[str], runs: Sequence[tuple[str, int]]) -> bool:
    """Say whether runs of one label have one setting and differ in their seeds; settings and seed of each are given."""
    kinds = {(label, settings) for label, (settings, _) in zip(labels, runs, strict=True)}
    seeds = {(label, seed) for label, (_, seed) in zip(labels, runs, strict=True)}
    return all(labels) and len(kinds) == len(set(labels)) and len(seeds) == len(labels)


def _joined(first: Sequence[str], second: Sequence[str]) -> list[str]:
    return [", ".join(part for part in pair if part) for pair in zip(first, second, strict=True)]


def _readers(source: RunSource) -> list[Callable[[], list[Found]]]:
    """Return what reads the runs of a source, one call each, so that only one is in memory."""
    if isinstance(source, Recording):
        return [lambda: [run_of(source)]]
    path = Path(source)
    if not path.is_dir():
        return [lambda: [run_of(read_recording(path))]]
    if (path / "sweep.json").is_file():
        return [lambda: _sweep_runs(path)]
    recordings = sorted(path.rglob("*.mcap"))
    if recordings:
        return [lambda file=file: [run_of(read_recording(file))] for file in recordings]  # type: ignore[misc]
    raise UsageError(f"no recording in '{path}'; name a folder with .mcap files, or one that mjsim sweep made")


@np.errstate(over="ignore", invalid="ignore")
def run_of(recording: Recording) -> Found:
    """Return the statistics of a recording, its settings, and how its robots fared over time."""
    figures = statistics_file(recording)
    run = figures["run"]
    fault = any(robot["fault"] is not None for robot in figures["robots"].values())
    parts = {name: known_part(track) for name, track in recording.robots.items()}
    return Found(
        run=RunFigures(
            label="",
            seed=recording.seed,
            robots=figures["robots"],
            series={name: _series(part) for name, part in parts.items() if part is not None},
            failed=fault or not run["whole"],
        ),
        path=recording.path,
        settings=settings_of(recording.world, recording.metadata),
        world=recording.world.name,
    )


def _series(track: Track) -> Series:
    rows = slice(None, None, -(-len(track.time) // MOST_POINTS))
    truth, estimate = track.truth[rows], track.estimate[rows]
    return Series(
        time=track.time[rows],
        position_error_m=metrics.position_errors(truth, estimate),
        nees=metrics.normalised_errors(truth, estimate, track.covariance[rows]),
        truth=truth[:, :2],
        estimate=estimate[:, :2],
    )


def _sweep_runs(folder: Path) -> list[Found]:
    """Return the runs of a sweep, from the file of each."""
    try:
        plan = json.loads((folder / "sweep.json").read_bytes())
        files = sorted((folder / "runs").glob("*.json"))
        outcomes = [(file, json.loads(file.read_bytes())) for file in files]
    except (OSError, ValueError) as error:
        raise UsageError(f"the sweep in '{folder}' cannot be read: {error}") from None
    if not outcomes:
        raise UsageError(f"no run in '{folder}' is done yet; let mjsim sweep go on")
    return [_sweep_run(file, plan, outcome) for file, outcome in outcomes]


def _sweep_run(file: Path, plan: Mapping[str, Any], outcome: Mapping[str, Any]) -> Found:
    """Return a run of a sweep; `case` counts the combinations of settings, the last key fastest."""
    number, settings = int(outcome["case"]), {}
    for key, *values in reversed(plan["set"]):
        number, choice = divmod(number, len(values))
        value = values[choice]
        settings[key] = value if isinstance(value, str) else json.dumps(value)
    series = {
        robot: Series(**{name: np.array(each[name], dtype=float) for name in ("time", "position_error_m", "nees")})
        for robot, each in outcome["series"].items()
    }
    return Found(
        run=RunFigures(
            label="",
            seed=int(outcome["seed"]),
            robots=outcome["robots"],
            series=series,
            failed=outcome["error"] is not None,
        ),
        path=file,
        settings=dict(reversed(settings.items())),
        world=Path(plan["world"]).stem,
    )
