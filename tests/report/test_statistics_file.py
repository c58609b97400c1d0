"""What `statistics.json` says of a run as a whole, from a recording of a few ticks, and its tables."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

import mjsim
from mjsim.report.comparison_tables import comparison_csv, comparison_lines, interval_text, mean_rows
from mjsim.report.figures import FIGURES
from mjsim.report.statistics import statistics_file
from mjsim.report.tables import csv_table
from tests.record_ticks import hand_made_ticks, record
from tests.report.test_compare_values import ERRORS, compare_tables, runs

TICKS = 12


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return mjsim.read_recording(record(tmp_path_factory.mktemp("run") / "run.mcap", [*hand_made_ticks(TICKS)]))


def test_a_run_lasts_from_its_first_tick_to_the_end_of_its_last(recording):
    run = statistics_file(recording)["run"]
    assert run["sim_seconds"] == pytest.approx(TICKS * 0.04)
    assert (run["world"], run["seed"], run["whole"]) == (recording.world.name, recording.seed, True)
    assert run["wall_seconds"] == recording.wall_seconds == pytest.approx(np.diff(recording.clock).sum())
    assert run["real_time_factor"] == pytest.approx(run["sim_seconds"] / recording.wall_seconds)
    metadata = {**recording.metadata, "seconds": "12.5"}
    asked = replace(recording, metadata=metadata, clock=np.zeros(TICKS), whole=False)
    run = statistics_file(asked)["run"]
    assert (run["asked_seconds"], run["real_time_factor"], run["whole"]) == (12.5, None, False)


def test_times_of_modules_are_in_milliseconds_and_those_of_a_tick_their_sum(recording):
    rng = np.random.default_rng(4)
    estimator, rest = rng.uniform(0.001, 0.01, (2, TICKS))
    estimator[3] = np.nan
    times = {"a/estimator": estimator, "physics": rest, "b/navigator": np.full(TICKS, np.nan)}
    found = statistics_file(replace(recording, module_seconds=times))["run"]["milliseconds"]
    assert set(found) == {"a/estimator", "physics", "tick"}
    for name, values in (("a/estimator", np.delete(estimator, 3)), ("physics", rest)):
        assert found[name] == pytest.approx({"mean": 1e3 * values.mean(), "p99": 1e3 * np.quantile(values, 0.99)})
    assert found["tick"]["mean"] == pytest.approx(1e3 * (np.nansum(estimator) + rest.sum()) / TICKS)
    assert statistics_file(replace(recording, module_seconds={}))["run"]["milliseconds"] == {}


def test_figures_are_those_of_the_part_that_is_asked_for(recording):
    part = mjsim.statistics(recording, begin=0.12, end=0.24)
    assert part["run"]["sim_seconds"] == pytest.approx(4 * 0.04)
    assert (
        json.loads(json.dumps(statistics_file(recording)["robots"], allow_nan=False))
        == statistics_file(recording)["robots"]
    )


def test_the_table_has_a_row_for_each_robot_and_figure_with_all_digits(recording):
    figures = statistics_file(recording)
    rows = [*csv.DictReader(csv_table(figures).splitlines())]
    assert len(rows) == len(figures["robots"]) * len(FIGURES)
    for row in rows:
        robot, figure = figures["robots"][row["robot"]], next(each for each in FIGURES if each.key == row["figure"])
        for column, key in (("estimate", figure.key), ("odometry", figure.odometry)):
            value = None if "nees" in (key or "") else robot  # there is no estimator
            for part in key.split(".") if key else ():
                value = (value or {}).get(part)
            assert row[column] == ("" if value is None or not key else str(float(value))), (row, column)


def test_cells_of_a_comparison_have_an_interval_a_range_or_one_value():
    error = next(figure for figure in FIGURES if figure.key == "position_error_m.mean")
    for count in (1, 3, 8):
        (group,) = compare_tables(runs("it", ERRORS[:count])).groups
        text, mean = interval_text(error, group), f"{ERRORS[:count].mean():.3f}"
        assert text.startswith(mean)
        if count == 1:
            assert text == mean
        elif count == 3:
            assert text == f"{mean} ({min(ERRORS[:3]):.3f} to {max(ERRORS[:3]):.3f})"
        else:
            spread = group.spreads[error.key]
            assert text == f"{mean} [{spread.low:.3f}, {spread.high:.3f}]"
    unknown = next(figure for figure in FIGURES if figure.key == "bumps")
    assert interval_text(unknown, group) == "-"


def test_tables_of_a_comparison_have_its_means_and_differences_with_their_signs():
    found = compare_tables([*runs("old", ERRORS), *runs("new", ERRORS * 0.5)])
    rows = [*csv.DictReader(comparison_csv(found).splitlines())]
    means = {row["label"]: row for row in rows if row["kind"] == "mean" and row["figure"] == "position_error_m.mean"}
    assert float(means["new"]["mean"]) == pytest.approx(ERRORS.mean() / 2)
    (row,) = (row for row in rows if row["kind"] == "difference" and row["figure"] == "position_error_m.mean")
    assert (row["label"], row["count"]) == ("new - old", "10")
    assert float(row["mean"]) == pytest.approx(-ERRORS.mean() / 2)
    assert float(row["low"]) < float(row["mean"]) < float(row["high"]) < 0.0
    assert row["verdict"] == found.verdicts[0]
    lines = comparison_lines(found)
    start = lines.index("new is better than old (10 pairs), by:")
    assert lines[start + 1].startswith(f"  {'position error, mean':<30}")
    assert "No difference is significant." not in lines
    assert ["position error, mean [m]", *(interval_text(FIGURES[0], group) for group in found.groups)] in [
        [row[0], *row[1:]] for row in mean_rows(found)
    ] or FIGURES[0].key != "position_error_m.mean"
