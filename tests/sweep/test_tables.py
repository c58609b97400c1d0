"""Tables and summaries of outcomes that are given: columns, means, reasons, lines for a terminal."""

import csv
import io
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy import stats

from mjsim.geometry import wrap_angle
from mjsim.report import mean_of, middle_of
from mjsim.sweep import SweepPlan
from mjsim.sweep.results import _clock, key_lines
from mjsim.sweep.seed_means import distribution, summary_of, summary_rows
from mjsim.sweep.sweep_plan import Job
from mjsim.sweep.sweep_plots import error_plot, nees_plot
from mjsim.sweep.sweep_table import csv_text, figure_names, no_nees, rows_of
from mjsim.sweep.sweep_worker import MAX_POINTS, _series, died, empty_outcome

PLAN = SweepPlan(seeds=(4, 7), settings={"run.speed": (1, 2)})


def outcome(case, seed, *, error=None, reason=None, rmse=0.5, touches=3):
    robot = {
        "position_error_m": {"rmse": rmse, "mean": rmse / 2},
        "nees": {"mean": None, "reason": reason} if reason else {"mean": 2.5, "in_band": 0.9},
        "landmark_error_m": {"rms": 0.1, "each": {"a": 0.3}},
        "bumps": touches,
        "estimator": "Ekf",
    }
    told = empty_outcome(Job(case=case, seed=seed, settings=(), seconds=None), error=error)
    if error is None:
        told |= {"run": {"sim_seconds": 12.5}, "robots": {"r": robot}}
    told["clock"] = {"total_seconds": 3.5}
    return told


OUTCOMES = [outcome(0, 4), outcome(0, 7, rmse=0.7), outcome(1, 4, error="it fell"), outcome(1, 7, rmse=0.9)]


def test_a_table_has_a_row_for_each_run_and_robot_with_the_settings_of_its_case():
    rows = rows_of(PLAN, OUTCOMES, ["r", "none"])
    assert [(row["case"], row["seed"], row["robot"], row["run.speed"]) for row in rows] == [
        (case, seed, robot, case + 1) for case in (0, 1) for seed in (4, 7) for robot in ("r", "none")
    ]
    first, failed = rows[0], rows[4]
    assert (first["sim_seconds"], first["position_error_m.rmse"], first["bumps"]) == (12.5, 0.5, 3)
    assert "landmark_error_m.rms" in first
    assert not any("each" in name or name == "estimator" for name in first)
    assert (failed["error"], failed["position_error_m.rmse"]) == ("it fell", None)
    assert rows[1]["position_error_m.rmse"] is None
    assert len({tuple(row) for row in rows}) == 1
    assert figure_names(PLAN, rows)[0] == "sim_seconds"
    assert not {"case", "seed", "robot", "error", "run.speed"} & set(figure_names(PLAN, rows))


def test_a_table_is_written_with_empty_fields():
    text = csv_text(rows_of(PLAN, OUTCOMES, ["r"])).decode()
    read = list(csv.DictReader(io.StringIO(text)))
    assert [row["position_error_m.rmse"] for row in read] == ["0.5", "0.7", "", "0.9"]
    assert "\r" not in text


def test_the_reason_why_there_is_no_nees_is_told_where_it_is_that_of_all_runs():
    both = [outcome(0, 4, reason="too short"), outcome(0, 7, reason="too short")]
    other = [outcome(1, 4, reason="too short"), outcome(1, 7)]
    odd = [outcome(2, 4, reason="too short"), outcome(2, 7, reason="singular")]
    assert no_nees([*both, *other, *odd]) == {(0, "r"): "too short"}
    assert no_nees([outcome(0, 4, error="it fell")]) == {}


def test_a_summary_has_the_spread_of_each_figure_and_counts_the_failed():
    summary = summary_of(PLAN, rows_of(PLAN, OUTCOMES, ["r"]), no_nees={(1, "r"): "too short"})
    first, second = summary["cases"]
    assert (first["settings"], first["runs"], first["failed"], second["failed"]) == ({"run.speed": 1}, 2, 0, 1)
    figure = first["robots"]["r"]["position_error_m.rmse"]
    assert (figure["count"], figure["min"], figure["max"], figure["median"]) == (2, 0.5, 0.7, 0.6)
    assert figure["mean"] == pytest.approx(0.6)
    assert figure["std"] == pytest.approx(np.std([0.5, 0.7], ddof=1))
    half = stats.t.ppf(0.975, 1) * stats.sem([0.5, 0.7])
    assert (figure["low"], figure["high"]) == (pytest.approx(max(0.6 - half, 0.0)), pytest.approx(0.6 + half))
    alone = second["robots"]["r"]["position_error_m.rmse"]
    assert (alone["count"], alone["low"], alone["high"], alone["std"]) == (1, None, None, 0.0)
    assert (first["no_nees"], second["no_nees"]) == ({}, {"r": "too short"})
    flat = summary_rows(summary)
    assert {(row["case"], row["run.speed"], row["robot"], row["failed"]) for row in flat} == {
        (0, 1, "r", 0),
        (1, 2, "r", 1),
    }
    assert len(flat) == sum(len(case["robots"]["r"]) for case in summary["cases"])
    lines = key_lines(summary)
    assert lines[0] == "run.speed 1: r, 2 of 2 runs"
    assert "run.speed 2: r, 1 of 2 runs" in lines
    assert any(line.split()[:3] == ["position", "error", "[m]"] and " 0.6 " in f"{line} " for line in lines)
    assert any("too short" in line for line in lines)
    assert json.dumps(summary)


def test_an_interval_of_a_share_ends_at_one():
    assert distribution(np.array([0.9, 1.0]), upper=1.0)["high"] == 1.0
    assert distribution(np.array([0.1, 0.2]))["low"] == 0.0


def test_what_died_has_no_results_and_the_clock_those_of_the_wall():
    job = Job(case=3, seed=12, settings=(), seconds=None)
    assert job.name == "003-seed0012"
    assert died(job, 2) == {**empty_outcome(job, error="its process died 2 times"), "died": True}
    assert _clock(OUTCOMES[0]) == {
        "case": 0,
        "seed": 4,
        "total_seconds": 3.5,
        "wall_seconds": None,
        "real_time_factor": None,
    }


def test_a_series_has_errors_and_nees_at_a_bounded_number_of_ticks():
    n = 2 * MAX_POINTS + 1
    rng = np.random.default_rng(0)
    truth, estimate, odometry = rng.normal(size=(3, n, 3))
    P = np.tile(np.diag([0.04, 0.09, 0.01]), (n, 1, 1))
    track = SimpleNamespace(time=np.arange(n) * 0.1, truth=truth, estimate=estimate, odometry=odometry, covariance=P)
    told = _series(track, estimated=True)
    assert len(told["time"]) == math.ceil(n / 3) <= MAX_POINTS
    assert told["time"][1] == pytest.approx(0.3)
    k = 3
    off = estimate[k] - truth[k]
    off[2] = wrap_angle(off[2])
    assert told["position_error_m"][1] == pytest.approx(math.hypot(*off[:2]))
    assert told["odometry_error_m"][1] == pytest.approx(math.hypot(*(odometry[k] - truth[k])[:2]))
    assert told["nees"][1] == pytest.approx(off[0] ** 2 / 0.04 + off[1] ** 2 / 0.09 + off[2] ** 2 / 0.01)
    assert (told["truth_x_m"][1], told["estimate_y_m"][1]) == (round(truth[k, 0], 4), round(estimate[k, 1], 4))
    assert set(_series(track, estimated=False)["nees"]) == {None}


@pytest.mark.parametrize("draw", [error_plot, nees_plot])
def test_runs_of_different_length_are_drawn_to_their_ends(draw):
    runs = [[series_of(40.0), series_of(60.0)], [series_of(10.0)]]
    (axes,) = draw(PLAN, runs).axes
    assert axes.get_xlim() == (0.0, 60.0)
    lines = {line.get_label(): line.get_xydata() for line in axes.get_lines()}
    np.testing.assert_allclose(lines["run.speed 1"][[0, -1]], [[0.0, 0.0], [60.0, 6.0]])
    np.testing.assert_allclose(lines["run.speed 2"][[0, -1]], [[0.0, 0.0], [10.0, 1.0]])


def test_of_runs_whose_error_is_not_known_there_is_no_median_and_no_mean():
    curves = [(np.arange(3.0), np.full(3, np.nan))] * 4
    assert [values.shape for values in (*middle_of(curves), *mean_of(curves))] == [(0,), (3, 0), (0,), (0,)]


def series_of(seconds):
    """Return errors of a tenth of the time, of which one is not known."""
    values = [0.1 * time for time in range(int(seconds) + 1)]
    values[5] = None
    time = [float(time) for time in range(len(values))]
    return {"time": time, **dict.fromkeys(("position_error_m", "odometry_error_m", "nees"), values)}
