"""The plan of a sweep: cases (combinations of settings of the world) times seeds."""

import itertools
import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from mjsim.errors import UsageError
from mjsim.report import CONFIDENCE, fewest_pairs, shared_confidence
from mjsim.sim import checked_seed
from mjsim.world import read_value, setting_texts

MAX_RUNS = 1_000_000
_SEEDS = re.compile(r"(\d+)(?::(\d+))?")


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One run of a sweep."""

    case: int
    """Number of its combination of settings, from 0."""
    seed: int
    settings: tuple[str, ...]
    """'KEY=VALUE', as for `mjsim run --set`."""
    seconds: float | None
    """Simulated duration [s]; by default that of the world."""

    @property
    def name(self) -> str:
        """Base name of its files."""
        return f"{self.case:03d}-seed{self.seed:04d}"


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepPlan:
    """All runs of a sweep."""

    seeds: tuple[int, ...]
    settings: Mapping[str, tuple[Any, ...]]
    """Key of the world -> its values; the cases are all combinations."""
    seconds: float | None = None
    """Duration of each run, simulated [s]; by default that of the world."""
    robot: str | None = None
    """The robot in the table; by default all robots."""
    keep: bool = False
    """Whether to keep the recordings."""

    def __post_init__(self) -> None:
        """Check that there are runs, without duplicates."""
        if not self.seeds:
            raise UsageError("no seeds; give at least one, such as 0:10")
        for seed in self.seeds:
            checked_seed(seed)
        _require_once("seed", self.seeds)
        for key, values in self.settings.items():
            if not values:
                raise UsageError(f"--set {key}: no value; write it as KEY=V1,V2")
            _require_once(f"value of {key}", values)
        if len(self) > MAX_RUNS:
            raise UsageError(f"this sweep has {len(self)} runs; it must have at most {MAX_RUNS}")

    def __len__(self) -> int:
        """Return the number of runs."""
        count = len(self.seeds)
        for values in self.settings.values():
            count *= len(values)
        return count

    def cases(self) -> list[dict[str, Any]]:
        """Return key -> value for each combination of settings; one without keys if there are no settings."""
        return [dict(zip(self.settings, values, strict=True)) for values in itertools.product(*self.settings.values())]

    def too_few_seeds(self, robots: Sequence[str]) -> str | None:
        """Return a message if there are too few seeds to show any difference, with the number needed; else None.

        Args:
            robots: Those that estimate their pose: each is compared between the cases, or with the others in one case.
        """
        cases = len(self) // len(self.seeds)
        pairs = math.comb(cases, 2) * len(robots) if cases > 1 else math.comb(len(robots), 2)
        needed = fewest_pairs(shared_confidence(CONFIDENCE, pairs))
        if not pairs or len(self.seeds) >= needed:
            return None
        compared = f"{cases} cases" if cases > 1 else f"{len(robots)} robots"
        few = f"{len(self.seeds)} seeds are" if len(self.seeds) > 1 else "1 seed is"
        each = "" if pairs == 1 else f", since {pairs} pairs are compared"
        return f"{few} too few to show a difference between {compared}: use at least {needed}{each}"

    def jobs(self) -> Iterator[Job]:
        """Yield all runs, case by case."""
        for number, case in enumerate(self.cases()):
            for seed in self.seeds:
                yield Job(case=number, seed=seed, settings=setting_texts(case), seconds=self.seconds)


def parse_seeds(text: str) -> tuple[int, ...]:
    """Parse seeds such as '0:50' (0 to 49), '7' or '1,2,10:20'.

    Raises:
        UsageError: The text is invalid.
    """
    seeds: list[int] = []
    for part in text.split(","):
        match = _SEEDS.fullmatch(part.strip())
        if match is None:
            raise UsageError(f"--seeds {text}: '{part}' is not a seed; write 0:50 for 0 to 49, or 1,2,7")
        first = int(match[1])
        after = int(match[2]) if match[2] else first + 1
        if after <= first:
            raise UsageError(f"--seeds {text}: '{part}' contains no seed; the second number is the one after the last")
        if after - first > MAX_RUNS:
            raise UsageError(f"--seeds {text}: there are {after - first} seeds; at most {MAX_RUNS} can be run")
        seeds += range(first, after)
    return tuple(seeds)


def parse_settings(texts: Iterable[str]) -> dict[str, tuple[Any, ...]]:
    """Parse settings such as 'KEY=V1,V2' to key -> values; the values are YAML.

    Raises:
        UsageError: A setting is invalid, or a key occurs twice.
    """
    settings: dict[str, tuple[Any, ...]] = {}
    for text in texts:
        key, equals, values = text.partition("=")
        if not (key and equals and values.strip()):
            raise UsageError(f"--set {text}: write it as KEY=V1,V2, such as robots.scout.odometry.scale=1,1.05")
        if key in settings:
            raise UsageError(f"--set {text}: '{key}' is set twice; give all its values at once, with commas")
        try:
            settings[key] = tuple(read_value(f"[{values}]"))
            json.dumps(settings[key])
        except (ValueError, TypeError):
            raise UsageError(f"--set {text}: '{values}' are not YAML values separated by commas") from None
    return settings


def _require_once(label: str, values: Sequence[Any]) -> None:
    seen = set()
    for value in values:
        text = json.dumps(value)
        if text in seen:
            raise UsageError(f"{label} {text} is given twice; leave one out")
        seen.add(text)
