"""Comparison of runs for the page: the results of `mjsim compare`, and data for plots."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import MjsimError
from mjsim.geometry import Array
from mjsim.report import (
    FEW,
    FIGURES,
    STATES,
    Comparison,
    Group,
    Series,
    cell_legend,
    chi_square_bounds,
    compare,
    comparison_csv,
    comparison_json,
    mean_of,
    mean_rows,
    middle_of,
    sweep_world,
    verdict_rows,
)
from mjsim.sentences import Sentence
from mjsim.web.run import plain
from mjsim.web.server import RefusedError
from mjsim.web.worlds import Folder
from mjsim.world import World

MAX_RECORDINGS = 60
"""Maximum number of recordings and sweep folders in a comparison."""
MAX_PATHS = 20
"""Maximum number of runs per group whose paths are drawn."""


def compared(folder: Folder, names: Sequence[str]) -> Comparison:
    """Compare recordings and sweeps of a folder, as `mjsim compare` does.

    Raises:
        RefusedError: There are none or too many, or one lies outside the folder, cannot be read, or cannot be compared.
    """
    if not 1 <= len(names) <= MAX_RECORDINGS:
        raise RefusedError(
            400, Sentence("{count} recordings are chosen; choose 1 to {max_recordings}", len(names), MAX_RECORDINGS)
        )
    paths = [folder.path(name) for name in dict.fromkeys(names)]
    for name, path in zip(dict.fromkeys(names), paths, strict=True):
        if not path.exists():
            raise RefusedError(404, Sentence("no file '{name:.80}'; it may have been moved or removed", name))
    try:
        return compare(paths)
    except MjsimError as error:
        raise RefusedError(400, str(error).replace(f"{folder.root}/", "")) from None


@np.errstate(over="ignore", invalid="ignore")  # an estimate may be anywhere
def compared_json(comparison: Comparison, *, scene: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return the JSON form of a comparison.

    Args:
        comparison: The comparison.
        scene: The plan on which paths are drawn; None for none.
    """
    seeds = _drawn_seeds(comparison.groups)
    content = comparison_json(comparison)
    runs = max((len(group.series) for group in comparison.groups), default=0)
    return {
        "groups": [_group(group, seeds) for group in comparison.groups],
        "scene": scene,
        "nees": {"expected": STATES, "band": plain(chi_square_bounds(STATES, count=max(runs, 1)), 3)},
        "cells": cell_legend(comparison.groups),
        "means": mean_rows(comparison),
        "certain": verdict_rows(comparison),
        "know": [*comparison.consistency, *comparison.remarks],
        "keys": {figure.title: figure.key for figure in FIGURES},
        "differences": [
            {**each, "title": item.figure.title}
            for each, item in zip(content["differences"], comparison.differences, strict=True)
        ],
        "csv": comparison_csv(comparison),
    }


def first_recording(folder: Folder, names: Sequence[str]) -> Path | None:
    """Return the first name that is not a folder; paths are drawn on the plan of its world."""
    return next((path for path in map(folder.path, names) if path.is_file()), None)


def first_swept_world(folder: Folder, names: Sequence[str]) -> World | None:
    """Return the world of the first sweep; None if there is none, or its world file is missing."""
    found = next((path for path in map(folder.path, names) if (path / "sweep.json").is_file()), None)
    try:
        return None if found is None else sweep_world(found)
    except MjsimError:
        return None


def _drawn_seeds(groups: Sequence[Group]) -> frozenset[int]:
    """Return the seeds whose paths are drawn; seeds common to most groups come first."""
    counts = Counter(seed for group in groups for seed, series in group.series.items() if series.truth is not None)
    return frozenset(sorted(counts, key=lambda seed: (-counts[seed], seed))[:MAX_PATHS])


def _group(group: Group, seeds: frozenset[int]) -> dict[str, Any]:
    """Return the curves of a group, and the paths of its runs with these seeds."""
    runs = list(group.series.values())
    few = len(runs) <= FEW
    errors = [{"seed": each, **_line(run, run.position_error_m)} for each, run in group.series.items()] if few else []
    return {
        "label": group.label,
        "runs": len(runs),
        "errors": errors if few else [_percentiles(runs)],
        "nees": _mean_nees(runs),
        "estimated": any(run.estimated for run in runs),
        "paths": [
            _path(each, series) for each, series in group.series.items() if each in seeds and series.truth is not None
        ],
    }


def _line(series: Series, values: Array) -> dict[str, Any]:
    return {"time": plain(series.time), "values": plain(values)}


def _percentiles(runs: Sequence[Series]) -> dict[str, Any]:
    """Return the median over runs, and the interval that contains 90 % of them."""
    time, (low, median, high) = middle_of([(series.time, series.position_error_m) for series in runs])
    return {"time": plain(time), "values": plain(median), "low": plain(low), "high": plain(high)}


def _mean_nees(runs: Sequence[Series]) -> dict[str, Any]:
    time, values = mean_of([(series.time, series.nees) for series in runs if series.estimated])
    return {"time": plain(time), "values": plain(values, 3)}


def _path(seed: int, series: Series) -> dict[str, Any]:
    return {
        "seed": seed,
        "time": plain(series.time),
        "truth": plain(series.truth),
        "estimate": plain(series.estimate),
    }
