"""Comparison of runs for the page: the results of `mjsim compare`, and data for plots."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import MjsimError
from mjsim.geometry import Array
from mjsim.report import (
    FEW,
    STATES,
    Comparison,
    Group,
    Series,
    chi_square_bounds,
    compare,
    comparison_csv,
    comparison_json,
    mean_of,
    mean_rows,
    middle_of,
    shared_seed,
    told_in_cells,
    verdict_rows,
)
from mjsim.web.answers import RefusedError
from mjsim.web.folder import Folder
from mjsim.web.past import plain

MOST = 60
"""Recordings and folders of sweeps that are compared at once."""


def compared(folder: Folder, names: Sequence[str]) -> Comparison:
    """Compare recordings and sweeps of a folder, as `mjsim compare` does.

    Raises:
        RefusedError: There are none, too many, one leads out of the folder, cannot be read, or cannot be compared.
    """
    if not 1 <= len(names) <= MOST:
        raise RefusedError(400, f"{len(names)} recordings are chosen; choose 1 to {MOST}")
    paths = [folder.path(name) for name in dict.fromkeys(names)]
    for name, path in zip(dict.fromkeys(names), paths, strict=True):
        if not path.exists():
            raise RefusedError(404, f"no file '{name:.80}'; it may have been moved or removed")
    try:
        return compare(paths)
    except MjsimError as error:
        raise RefusedError(400, str(error).replace(f"{folder.root}/", "")) from None


@np.errstate(over="ignore", invalid="ignore")  # an estimate may be anywhere
def comparison_told(comparison: Comparison, *, scene: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what the page shows of a comparison.

    Args:
        comparison: What is told.
        scene: The plan on which paths are drawn; None for none.
    """
    seed = shared_seed(comparison.groups)
    told = comparison_json(comparison)
    most = max((len(group.series) for group in comparison.groups), default=0)
    return {
        "groups": [_group(group, seed) for group in comparison.groups],
        "scene": scene,
        "nees": {"expected": STATES, "band": plain(chi_square_bounds(STATES, count=max(most, 1)), 3)},
        "cells": told_in_cells(comparison.groups),
        "means": mean_rows(comparison),
        "certain": verdict_rows(comparison),
        "know": [*comparison.consistency, *comparison.remarks],
        "differences": told["differences"],
        "csv": comparison_csv(comparison),
    }


def first_recording(folder: Folder, names: Sequence[str]) -> Path | None:
    """Return the first that is no folder; its world is the plan on which paths are drawn."""
    return next((path for path in map(folder.path, names) if path.is_file()), None)


def _group(group: Group, seed: int | None) -> dict[str, Any]:
    """Return the lines of a group, and the runs whose paths are drawn: few, or the one of the shared seed."""
    runs = list(group.series.values())
    few = len(runs) <= FEW
    errors = [{"seed": each, **_line(run, run.position_error_m)} for each, run in group.series.items()] if few else []
    drawn = {each: series for each, series in group.series.items() if few or each == seed}
    return {
        "label": group.label,
        "runs": len(runs),
        "errors": errors if few else [_spread(runs)],
        "nees": _mean_nees(runs),
        "paths": [_path(each, series) for each, series in drawn.items() if series.truth is not None],
    }


def _line(series: Series, values: Array) -> dict[str, Any]:
    return {"time": plain(series.time), "values": plain(values)}


def _spread(runs: Sequence[Series]) -> dict[str, Any]:
    """Return the median of many runs, and where nine of ten lie."""
    time, (low, median, high) = middle_of(runs, lambda series: series.position_error_m)
    return {"time": plain(time), "values": plain(median), "low": plain(low), "high": plain(high)}


def _mean_nees(runs: Sequence[Series]) -> dict[str, Any]:
    time, values = mean_of(runs, lambda series: series.nees)
    return {"time": plain(time), "values": plain(values, 3)}


def _path(seed: int, series: Series) -> dict[str, Any]:
    return {
        "seed": seed,
        "time": plain(series.time),
        "truth": plain(series.truth),
        "estimate": plain(series.estimate),
    }
