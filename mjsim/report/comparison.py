"""Compares statistics of many runs: groups runs by label, and computes differences paired by seed.

It reads no files: statistics from recordings and from sweeps can be compared.
"""

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from mjsim.errors import UsageError, one_line
from mjsim.geometry import Array
from mjsim.report.consistency import STATES, shared_errors
from mjsim.report.figures import FIGURES, ReportFigure, figure_value
from mjsim.report.paired import (
    CONFIDENCE,
    Difference,
    fewest_pairs,
    mean_interval,
    paired_difference,
    shared_confidence,
)
from mjsim.sentences import Sentence
from mjsim.views import Viewed
from mjsim.world import World


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Series:
    """Errors of one robot over one run, at N times."""

    time: Array
    """Shape (N,) [s]."""
    position_error_m: Array
    """Shape (N,)."""
    nees: Array
    """Shape (N,); NaN where the covariance is singular."""
    truth: Array | None = None
    """Positions, shape (N, 2) [m]; None if they were not kept."""
    estimate: Array | None = None
    """The same."""
    estimated: bool = True
    """Whether an estimator gave the estimate; else it is dead reckoning."""
    world: World | None = None
    """Where it drove; None if that is not known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RunFigures:
    """The statistics of one run, and its label."""

    label: str
    """Label of all runs that differ only in their seed."""
    seed: int
    robots: Mapping[str, Mapping[str, Any]]
    """As under 'robots' in `statistics.json`."""
    series: Mapping[str, Series] = field(default_factory=dict)
    """By robot; only plots need them."""
    failed: bool = False
    """Whether it ended early; it is counted as failed, and its statistics are left out."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Spread:
    """Distribution of a statistic over the runs of a group."""

    count: int
    """Number of runs that have the statistic."""
    mean: float
    median: float
    std: float
    """Sample standard deviation; 0 for one run."""
    low: float | None
    """Bounds of the mean with 95 % confidence; None for too few runs."""
    high: float | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """One robot in all runs of one label."""

    label: str
    robot: str
    values: Mapping[str, Mapping[int, float]]
    """Key of a statistic -> seed -> value."""
    spreads: Mapping[str, Spread]
    """Key of a statistic -> its spread."""
    failed: tuple[int, ...]
    """Seeds of runs that ended early."""
    series: Mapping[int, Series]
    """Seed -> errors over time."""
    no_nees: str = ""
    """Why no run has a NEES; empty if some have one."""
    pictures: float = 0.0
    """Mean share of sightings that come from pictures."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Compared:
    """One statistic of two groups."""

    figure: ReportFigure
    first: str
    """Label of a group."""
    second: str
    difference: Difference
    """Second minus first."""

    @property
    def sentence(self) -> str:
        """The result as a sentence."""
        figure, difference = self.figure, self.difference
        if not difference.verdict:
            return Sentence(
                "{first} and {second} in {title}: {reason}", self.first, self.second, figure.title, difference.reason
            )
        return Sentence(
            "{better} is better than {worse} in {title}: by {size}, {pairs} pairs",
            *(self.better, self.worse, figure.title, self.size, difference.pairs),
        )

    @property
    def better(self) -> str:
        """Label of the significantly better group, or empty."""
        return {"first": self.first, "second": self.second, "": ""}[self.difference.verdict]

    @property
    def worse(self) -> str:
        """Label of the significantly worse group, or empty."""
        return {"first": self.second, "second": self.first, "": ""}[self.difference.verdict]

    @property
    def size(self) -> str:
        """The difference with its interval and unit."""
        difference = self.difference
        low, high = sorted(abs(value) for value in (difference.low or 0.0, difference.high or 0.0))
        return f"{abs(difference.mean or 0.0):.3g} [{low:.3g}, {high:.3g}] {self.figure.unit}".rstrip()


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Comparison(Viewed):
    """The result of a comparison."""

    groups: tuple[Group, ...]
    differences: tuple[Compared, ...]
    """Every statistic of every pair of groups."""
    remarks: tuple[str, ...]
    """Notes for the interpretation of the results."""

    def __repr__(self) -> str:
        """Return its groups, and how many differences are significant."""
        labels = ", ".join(group.label for group in self.groups)
        return Sentence(
            "<Comparison of {labels}: {count} significant differences>", one_line(labels), len(self.verdicts)
        )

    @property
    def verdicts(self) -> tuple[str, ...]:
        """Significant differences, as sentences."""
        return tuple(item.sentence for item in self.differences if item.difference.verdict)

    @property
    def consistency(self) -> tuple[str, ...]:
        """Consistency of the estimators of the groups, as sentences."""
        return tuple(sentence for group in self.groups if (sentence := _consistency(group)))


@np.errstate(over="ignore", invalid="ignore")
def compare_tables(runs: Iterable[RunFigures], *, confidence: float = CONFIDENCE) -> Comparison:
    """Compare statistics of many runs.

    Args:
        runs: Runs with the same label must differ only in their seed.
        confidence: Confidence with which all intervals of one statistic hold simultaneously: with more than two groups
            each interval is wider (Bonferroni).

    Raises:
        UsageError: There are no runs, no robots in them, or a label has a seed twice.
    """
    runs_listed = tuple(runs)
    if not runs_listed:
        raise UsageError("nothing to compare; name at least one recording")
    if not 0.5 <= confidence < 1.0:
        raise UsageError(Sentence("confidence is {confidence:g}; it must be at least 0.5 and below 1", confidence))
    _require_once(runs_listed)
    groups = tuple(_group(label, robot, members) for label, robot, members in _members(runs_listed))
    if not groups:
        raise UsageError("no robot in these runs; only estimates of robots are compared")
    pairs = [pair for pair in itertools.combinations(groups, 2) if _comparable(groups, *pair)]
    each = shared_confidence(confidence, len(pairs))
    differences = [
        Compared(figure=figure, first=a.label, second=b.label, difference=_difference(a, b, figure, each))
        for a, b in pairs
        for figure in FIGURES
        if a.values[figure.key] and b.values[figure.key]
    ]
    return Comparison(
        groups=groups, differences=tuple(differences), remarks=tuple(_remarks(groups, pairs, differences, each))
    )


def _require_once(runs: Sequence[RunFigures]) -> None:
    seen = set()
    for run in runs:
        if (run.label, run.seed) in seen:
            raise UsageError(
                Sentence(
                    "'{label}' has seed {seed} twice; name each run once, and give different variants their own labels",
                    run.label,
                    run.seed,
                )
            )
        seen.add((run.label, run.seed))


def _members(runs: Sequence[RunFigures]) -> list[tuple[str, str, list[RunFigures]]]:
    """Return label, robot and runs of each group; the robot is part of the label if there are several."""
    labels = dict.fromkeys(run.label for run in runs)
    found = {label: _robots([run for run in runs if run.label == label]) for label in labels}
    names = {name for robots in found.values() for name in robots}
    members = []
    for label, robots in found.items():
        for robot in robots:
            shown = label if len(names) == 1 else robot if len(found) == 1 else f"{label}, {robot}"
            members.append((shown, robot, [run for run in runs if run.label == label]))
    return members


def _robots(runs: Sequence[RunFigures]) -> list[str]:
    """Return the robots with estimates; all if there are none."""
    names = dict.fromkeys(name for run in runs for name in run.robots)
    believing = [name for name in names if any(run.robots.get(name, {}).get("position_error_m") for run in runs)]
    return believing or list(names)


def _comparable(groups: Sequence[Group], a: Group, b: Group) -> bool:
    """Return whether two groups are of the same robot, or no robot is in several groups."""
    robots = [group.robot for group in groups]
    return a.robot == b.robot or len(set(robots)) == len(robots)


def _group(label: str, robot: str, runs: Sequence[RunFigures]) -> Group:
    sound = [run for run in runs if not run.failed and robot in run.robots]
    values = {
        figure.key: {
            run.seed: value for run in sound if (value := figure_value(run.robots[robot], figure.key)) is not None
        }
        for figure in FIGURES
    }
    return Group(
        label=label,
        robot=robot,
        values=values,
        spreads={key: _distribution(list(found.values())) for key, found in values.items() if found},
        failed=tuple(run.seed for run in runs if run.failed),
        series={run.seed: run.series[robot] for run in sound if robot in run.series},
        no_nees="" if values["nees.mean"] else _no_nees([run.robots[robot] for run in sound]),
        pictures=float(np.mean([figure_value(run.robots[robot], "nis.pictures") or 0.0 for run in sound] or [0.0])),
    )


def _no_nees(robots: Sequence[Mapping[str, Any]]) -> str:
    """Return why robots have no NEES; '' if all have one, or for several reasons."""
    reasons = {(robot.get("nees") or {}).get("reason") or "" for robot in robots}
    return str(reasons.pop()) if len(reasons) == 1 else ""


def _distribution(values: Sequence[float]) -> Spread:
    interval = mean_interval(values)
    return Spread(
        count=len(values),
        mean=float(np.mean(values)),
        median=float(np.median(values)),
        std=float(np.std(values, ddof=1)) if len(values) > 1 else 0.0,
        low=interval[0] if interval else None,
        high=interval[1] if interval else None,
    )


def _difference(a: Group, b: Group, figure: ReportFigure, confidence: float) -> Difference:
    """Return the difference of two groups; a group with more failures is never called better."""
    found = paired_difference(a.values[figure.key], b.values[figure.key], better=figure.better, confidence=confidence)
    worse = a if len(a.failed) > len(b.failed) else b if len(b.failed) > len(a.failed) else None
    if worse is not None and found.verdict == ("first" if worse is a else "second"):
        return replace(
            found,
            verdict="",
            reason=Sentence("{label} failed more often; its other runs are not a fair comparison", worse.label),
        )
    return found


def _consistency(group: Group) -> str:
    """Describe the consistency shown by the mean NEES of independent runs, or why there is none; '' for too few."""
    summary = group.spreads.get("nees.mean")
    if group.no_nees:
        return Sentence("{label} has no NEES: {no_nees}", group.label, group.no_nees)
    if summary is None or summary.low is None or summary.high is None:
        return ""
    nees = Sentence(
        "NEES {mean:.2f} [{low:.2f}, {high:.2f}], {states} expected", summary.mean, summary.low, summary.high, STATES
    )
    if summary.low > STATES:
        return Sentence("{label} is overconfident: {nees}", group.label, nees)
    if summary.high < STATES:
        return Sentence("{label} is conservative: {nees}", group.label, nees)
    return Sentence("{label} is not shown to be inconsistent: {nees}", group.label, nees)


def _remarks(
    groups: Sequence[Group],
    pairs: Sequence[tuple[Group, Group]],
    differences: Sequence[Compared],
    confidence: float,
) -> Iterable[str]:
    for group in groups:
        if group.failed:
            seeds = ", ".join(map(str, group.failed[:10])) + (", ..." if len(group.failed) > 10 else "")
            if len(group.failed) == 1:
                yield Sentence(
                    "{label}: 1 run ended before its time and is left out (seed {seeds})", group.label, seeds
                )
            else:
                count = len(group.failed)
                yield Sentence(
                    "{label}: {count} runs ended before their time and are left out (seed {seeds})",
                    *(group.label, count, seeds),
                )
    for group in groups:
        means = {key: group.spreads[key].mean for key in ("nees.mean", "nis.mean") if key in group.spreads}
        if shared := shared_errors(means.get("nees.mean"), means.get("nis.mean"), group.pictures):
            yield f"{group.label}: {shared}"
    if not pairs:
        yield "all runs have the same settings and differ only in their seed; there is nothing to compare"
    if len(pairs) > 1:
        yield Sentence(
            "{pairs} pairs are compared, so each interval holds with {confidence:.1%} (Bonferroni)",
            len(pairs),
            confidence,
        )
    if any(item.figure.better and item.difference.low is not None for item in differences):
        yield (
            "each statistic is tested on its own: of those without a true difference, one in twenty appears to differ;"
            " choose the one that decides before you look"
        )
    for a, b in pairs:
        seeds_a, seeds_b = ({seed for found in group.values.values() for seed in found} for group in (a, b))
        both = len(seeds_a & seeds_b)
        if both == 1:
            yield Sentence(
                "{first} and {second} have one seed in common; one pair is too few for a verdict",
                a.label,
                b.label,
            )
        elif 1 < both < fewest_pairs(confidence):
            yield Sentence(
                "{first} and {second} have {count} seeds in common; {needed} or more are needed",
                *(a.label, b.label, both, fewest_pairs(confidence)),
            )
        elif seeds_a != seeds_b:
            yield Sentence(
                "{first} and {second} have {count} seeds in common; the others are not compared", a.label, b.label, both
            )
