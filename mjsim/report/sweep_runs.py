"""Reads the runs of a sweep from the files in its folder, for comparison."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.report.comparison import RunFigures, Series
from mjsim.report.labels import Found, settings_of
from mjsim.sentences import Sentence
from mjsim.world import World, load_world, place_in, read_regular, with_settings

Values = list[float | None]
Setting = Annotated[list[Any], Field(min_length=2)]
"""A key of the world, followed by its values."""


class _Plan(BaseModel):
    """The relevant part of `sweep.json`."""

    world: str
    set: list[Setting]

    @property
    def cases(self) -> int:
        """Number of combinations of settings."""
        return math.prod(len(values) for _, *values in self.set)

    def case(self, number: int) -> dict[str, Any]:
        """Return a combination of settings; the last key varies fastest."""
        settings = {}
        for key, *values in reversed(self.set):
            number, choice = divmod(number, len(values))
            settings[str(key)] = values[choice]
        return dict(reversed(settings.items()))


class _Series(BaseModel):
    """Errors of one robot over time."""

    time: list[float]
    position_error_m: Values
    nees: Values
    estimated: bool = True
    # Sweeps of earlier versions stored no paths.
    truth_x_m: Values = []
    truth_y_m: Values = []
    estimate_x_m: Values = []
    estimate_y_m: Values = []


class _Outcome(BaseModel):
    """The relevant part of the file of a run."""

    case: Annotated[int, Field(ge=0)]
    seed: int
    error: str | None
    robots: dict[str, dict[str, Any]]
    series: dict[str, _Series]


File = TypeVar("File", bound=BaseModel)
MAX_BYTES = 1_000_000_000
"""Maximum size of a file of a sweep [bytes]."""


def sweep_runs(folder: Path, *, alone: bool) -> list[Found]:
    """Return the finished runs of a sweep.

    Args:
        folder: Folder of the sweep's files.
        alone: Whether nothing else is compared: then the settings varied by the sweep distinguish its runs, otherwise
            all settings.

    Raises:
        UsageError: A file cannot be read, or no run is finished.
        WorldError: The world of the sweep no longer exists.
    """
    plan = _read(folder, folder / "sweep.json", _Plan)
    files = {file: _read(folder, file, _Outcome) for file in sorted((folder / "runs").glob("*.json"))}
    if not files:
        raise UsageError(
            Sentence("no run of the sweep in '{folder}' has finished; continue it with mjsim sweep", folder)
        )
    for file, outcome in files.items():
        if outcome.case >= plan.cases:
            raise _unreadable(folder, f"{file.name}: case is {outcome.case}; cases are 0 to {plan.cases - 1}")
    numbers = sorted({outcome.case for outcome in files.values()})
    worlds = {number: with_settings(sweep_world(folder), plan.case(number)) for number in numbers}
    settings = {n: _settings_of(plan.case(n)) if alone else settings_of(worlds[n], {}) for n in numbers}
    return [_found(file, outcome, settings[outcome.case], worlds[outcome.case]) for file, outcome in files.items()]


def _settings_of(case: Mapping[str, Any]) -> dict[str, str]:
    return {key: value if isinstance(value, str) else json.dumps(value) for key, value in case.items()}


def _found(file: Path, outcome: _Outcome, settings: Mapping[str, str], world: World) -> Found:
    series = {
        robot: Series(
            time=np.array(each.time, dtype=float),
            position_error_m=np.array(each.position_error_m, dtype=float),
            nees=np.array(each.nees, dtype=float),
            truth=_path(each.truth_x_m, each.truth_y_m),
            estimate=_path(each.estimate_x_m, each.estimate_y_m),
            estimated=each.estimated,
            world=world,
        )
        for robot, each in outcome.series.items()
    }
    run = RunFigures(
        label="", seed=outcome.seed, robots=outcome.robots, series=series, failed=outcome.error is not None
    )
    return Found(run=run, path=file, settings=settings, world=world.name)


def _path(x: Values, y: Values) -> Array | None:
    """Return positions, shape (N, 2) [m]; None if none were stored."""
    return np.array([x, y], dtype=float).T if x else None


def sweep_world(folder: Path) -> World:
    """Return the world of the sweep, without the settings of the cases.

    Raises:
        UsageError: The plan of the sweep cannot be read.
        WorldError: The world no longer exists.
    """
    try:
        return load_world(place_in(folder / "world", _read(folder, folder / "sweep.json", _Plan).world))
    except ValueError as error:
        raise _unreadable(folder, f"sweep.json: 'world': {error}") from None


def _read(folder: Path, file: Path, kind: type[File]) -> File:
    try:
        return kind.model_validate_json(read_regular(file, limit=MAX_BYTES))
    except OSError as error:
        raise _unreadable(folder, f"{file.name}: {error.strerror}") from None
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(map(str, first["loc"]))
        message = f"{first['msg'][0].lower()}{first['msg'][1:]}"
        raise _unreadable(folder, f"{file.name}: {f'{place!r}: ' if place else ''}{message}") from None


def _unreadable(folder: Path, why: str) -> UsageError:
    return UsageError(
        Sentence("the sweep in '{folder}' cannot be read: {why}; sweep again into a new folder", folder, why)
    )
