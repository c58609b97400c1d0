"""Paired differences and their bootstrap intervals, against known distributions; tables of groups, against counting."""

import csv
import io
import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from mjsim.errors import UsageError
from mjsim.report import RunFigures, compare_tables, comparison_lines, fewest_pairs, mean_interval
from mjsim.report.comparison_tables import _counted, comparison_csv, comparison_json, comparison_latex
from mjsim.report.paired import paired_difference
from mjsim.report.tables import latex_text, shared_errors_of


def by_seed(values):
    return dict(enumerate(np.asarray(values, dtype=float).tolist()))


def coverage_of(draw, mean, count, *, trials=150):
    """Return how often the 95 % interval of a sample holds the mean that it was drawn with."""
    intervals = [mean_interval(draw(count)) for _ in range(trials)]
    return np.mean([low <= mean <= high for low, high in intervals])


@pytest.mark.slow
def test_intervals_hold_the_mean_nearly_as_often_as_they_say():
    # Scipy's BCa alone holds it in 81 to 89 % of such small samples; 150 trials have a standard deviation of 2 %.
    rng = np.random.default_rng(3)
    assert coverage_of(lambda n: rng.normal(2.0, 1.0, n), 2.0, 10) > 0.88
    assert coverage_of(lambda n: rng.exponential(1.0, n), 1.0, 10) > 0.85
    assert coverage_of(lambda n: rng.normal(size=n), 0.0, 40) > 0.9


def test_of_many_normal_values_the_interval_is_that_of_student():
    values = np.random.default_rng(1).normal(5.0, 2.0, 400)
    low, high = mean_interval(values)
    half = 1.966 * values.std(ddof=1) / 20.0
    assert low == pytest.approx(values.mean() - half, abs=0.02)
    assert high == pytest.approx(values.mean() + half, abs=0.02)


def test_the_same_values_have_the_same_interval():
    values = np.random.default_rng(2).normal(size=12)
    assert mean_interval(values) == mean_interval(values)


def test_a_verdict_needs_as_many_pairs_as_chance_cannot_agree_in():
    # Signs of n pairs agree with probability 2^(1 - n): 1 in 32 for 6.
    assert [fewest_pairs(c) for c in (0.9, 0.95, 0.99)] == [5, 6, 8]
    for pairs in range(1, 6):
        told = paired_difference(by_seed(np.arange(pairs) + 5.0), by_seed(np.arange(pairs) * 0.5))
        assert (told.verdict, told.low) == ("", None)
        assert told.pairs == pairs
    assert "one pair is too few" in paired_difference({1: 1.0}, {1: 2.0}).reason
    assert paired_difference(by_seed(np.arange(6) + 5.0), by_seed(np.arange(6) * 0.5)).verdict == "second"


def test_equal_runs_differ_by_exactly_0_and_nothing_is_said():
    values = by_seed(np.random.default_rng(0).normal(size=10))
    told = paired_difference(values, dict(values))
    assert (told.mean, told.low, told.high, told.verdict) == (0.0, 0.0, 0.0, "")
    assert told.reason == "no difference at all"


def test_pairing_shows_a_difference_hidden_by_the_variation_of_runs():
    rng = np.random.default_rng(4)
    hard = rng.uniform(1.0, 10.0, 12)  # Some seeds are hard for both.
    first, second = by_seed(hard), by_seed(hard + rng.normal(0.3, 0.1, 12))
    told = paired_difference(first, second)
    assert told.verdict == "first"
    assert told.low < 0.3 < told.high
    assert paired_difference(first, second, better="higher").verdict == "second"
    assert paired_difference(first, second, better="").verdict == ""


def test_only_seeds_that_both_have_are_paired():
    told = paired_difference({1: 1.0, 2: 2.0, 9: 50.0}, {2: 2.5, 1: 1.5, 7: -50.0})
    assert (told.pairs, told.mean) == (2, 0.5)
    assert paired_difference({1: 1.0}, {2: 1.0}).mean is None


@pytest.mark.slow
def test_between_equals_a_verdict_is_as_rare_as_the_confidence_says():
    rng = np.random.default_rng(8)
    said = [
        bool(paired_difference(by_seed(rng.normal(size=12)), by_seed(rng.normal(size=12))).verdict) for _ in range(300)
    ]
    assert np.mean(said) < 0.09  # 5 % and two standard deviations of 200 trials, and what small samples cost.


def runs(label, values, *, robot="scout", failed=(), nees=3.0):
    """Return a run for each value of the mean position error, seeds from 1."""
    return [
        RunFigures(
            label=label,
            seed=seed,
            robots={robot: {"position_error_m": {"mean": float(value)}, "nees": {"mean": nees + 0.1 * (seed % 3)}}},
            failed=seed in failed,
        )
        for seed, value in enumerate(values, start=1)
    ]


ERRORS = np.random.default_rng(6).uniform(0.1, 0.5, 10)


def test_what_is_certain_is_said_with_its_size_and_the_number_of_pairs():
    found = compare_tables([*runs("old", ERRORS), *runs("new", ERRORS * 0.5)])
    (verdict,) = found.verdicts
    assert verdict.startswith("new is better than old in position error, mean: by ")
    assert verdict.endswith("m, 10 pairs")
    assert found.differences[0].difference.mean == pytest.approx(-0.5 * ERRORS.mean())
    assert found.groups[0].spreads["position_error_m.mean"].median == pytest.approx(np.median(ERRORS))


def test_two_single_runs_cannot_decide_and_that_is_said():
    found = compare_tables([*runs("a", [0.1]), *runs("b", [0.5])])
    assert found.verdicts == ()
    assert any("one pair is too few" in remark for remark in found.remarks)
    assert "No difference is significant." in "\n".join(comparison_lines(found))


def test_few_pairs_cannot_decide_and_how_many_can_is_said():
    found = compare_tables([*runs("a", ERRORS[:3]), *runs("b", ERRORS[:3] * 0.5)])
    assert "a and b have 3 seeds in common; 6 or more are needed" in found.remarks


def test_brackets_are_called_what_they_are():
    for count, told in ((1, "mean"), (3, "mean (min to max)"), (8, "mean [95 % interval]")):
        head = comparison_lines(compare_tables(runs("it", ERRORS[:count])))[1]
        assert head.partition("   ")[0] == told


def test_intervals_are_wider_where_more_groups_are_compared():
    two = compare_tables([*runs("a", ERRORS), *runs("b", ERRORS**2)])
    four = compare_tables([run for k in range(4) for run in runs("abcd"[k], ERRORS ** (k + 1))])
    assert len(four.differences) == 6 * 2
    assert four.differences[0].difference.confidence == pytest.approx(1.0 - 0.05 / 6)
    assert four.differences[0].difference.low < two.differences[0].difference.low
    assert any("Bonferroni" in remark for remark in four.remarks)


def test_runs_that_failed_are_left_out_and_who_failed_more_often_is_not_called_better():
    found = compare_tables([*runs("sound", ERRORS), *runs("brittle", ERRORS * 0.5, failed=(3, 4))])
    assert found.groups[1].failed == (3, 4)
    assert found.differences[0].difference.pairs == 8
    assert found.verdicts == ()
    assert "failed more often" in found.differences[0].difference.reason


def test_overconfident_estimators_are_distinguished_from_those_of_which_nothing_is_shown():
    sure, sound = (compare_tables(runs("it", ERRORS, nees=nees)).consistency[0] for nees in (9.0, 2.9))
    assert "is overconfident" in sure
    assert "it is not shown to be inconsistent" in sound


def test_a_wide_interval_of_the_nees_is_no_praise():
    wide = [
        replace(run, robots={"scout": {"nees": {"mean": nees}}})
        for run, nees in zip(runs("it", ERRORS[:8]), [1.0, 2.0, 1.5, 2.5, 30.0, 1.0, 2.0, 25.0], strict=False)
    ]
    (told,) = compare_tables(wide).consistency
    assert told.startswith("it is not shown to be inconsistent: NEES ")


@pytest.mark.parametrize(
    ("nees", "nis", "pictures", "told"),
    [(107.0, 2.0, 1.0, True), (107.0, 2.0, 0.0, False), (107.0, 9.0, 1.0, False), (4.0, 2.0, 1.0, False)],
)
def test_errors_that_pictures_share_are_named_where_only_the_nees_shows_them(nees, nis, pictures, told):
    found = [
        replace(run, robots={"scout": {"nees": {"mean": nees}, "nis": {"mean": nis, "pictures": pictures}}})
        for run in runs("it", ERRORS[:2])
    ]
    line = f"it: NEES {nees:.1f} with NIS {nis:.1f}: the sightings come from pictures, whose errors are shared"
    assert any(remark.startswith(line) for remark in compare_tables(found).remarks) == told
    assert shared_errors_of(found[0].robots["scout"]).startswith(line.removeprefix("it: ")) == told


def test_robots_of_the_same_runs_are_compared_with_each_other():
    pairs = zip(runs("", ERRORS, robot="left"), runs("", ERRORS * 2.0, robot="right"), strict=True)
    both = [RunFigures(label="hall", seed=a.seed, robots={**a.robots, **b.robots}) for a, b in pairs]
    found = compare_tables(both)
    assert [group.label for group in found.groups] == ["left", "right"]
    assert found.verdicts[0].startswith("left is better than right")


def test_with_several_robots_each_is_compared_with_itself():
    both = [
        RunFigures(label=label, seed=seed, robots={**run.robots, "other": run.robots["scout"]})
        for label in ("a", "b")
        for seed, run in enumerate(runs("", ERRORS), start=1)
    ]
    found = compare_tables(both)
    compared = {(item.first, item.second) for item in found.differences}
    assert compared == {("a, scout", "b, scout"), ("a, other", "b, other")}


def test_a_label_with_a_seed_twice_and_no_runs_are_refused_in_a_line():
    with pytest.raises(
        UsageError, match=r"^'a' has seed 1 twice; name each run once, and give different variants their own labels$"
    ):
        compare_tables([*runs("a", [1.0]), *runs("a", [2.0])])
    with pytest.raises(UsageError, match="nothing to compare"):
        compare_tables([])
    with pytest.raises(UsageError, match="no robot in these runs"):
        compare_tables([RunFigures(label="gate", seed=1, robots={})])


def test_runs_that_differ_only_in_their_seed_have_means_and_no_differences():
    found = compare_tables(runs("it", ERRORS))
    assert found.differences == ()
    assert any("nothing to compare" in remark for remark in found.remarks)


def test_tables_hold_what_the_comparison_holds():
    found = compare_tables([*runs("a_1", ERRORS), *runs("b & c", ERRORS * 0.5)])
    rows = list(csv.DictReader(io.StringIO(comparison_csv(found))))
    first = next(row for row in rows if row["kind"] == "mean")
    assert float(first["mean"]) == found.groups[0].spreads["position_error_m.mean"].mean
    assert next(row for row in rows if row["kind"] == "difference")["label"] == "b & c - a_1"
    held = json.loads(json.dumps(comparison_json(found), allow_nan=False))
    assert held["verdicts"] == list(found.verdicts)
    assert held["groups"][0]["figures"]["position_error_m.mean"]["values"]["1"] == ERRORS[0]
    latex = comparison_latex(found)
    assert r"a\_1 & b \& c \\" in latex
    assert "\\caption{Mean [95 \\% interval]; 10 runs each.}" in latex
    assert f"% {latex_text(found.verdicts[0])}.\n" in latex
    assert latex.count("\\begin{") == latex.count("\\end{")
    assert all(len(row.split(" & ")) >= 3 for row in latex.splitlines() if row.startswith("position"))


def test_runs_of_a_group_are_counted_even_if_there_is_none():
    def group(*counts):
        return SimpleNamespace(spreads={str(k): SimpleNamespace(count=count) for k, count in enumerate(counts)})

    assert [str(_counted(each)) for each in (group(), group(1), group(0, 3, 2))] == ["0 runs", "1 run", "3 runs"]
