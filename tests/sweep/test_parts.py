"""What a sweep keeps and draws, and what its processes reset, without starting one."""

import importlib.util
import json

import numpy as np
import pytest
from scipy import stats

from mjsim.plan import GROUPS
from mjsim.sweep import SweepPlan
from mjsim.sweep.results import write_results
from mjsim.sweep.store import Store
from mjsim.sweep.sweep_plan import Job
from mjsim.sweep.sweep_plots import error_plot, nees_plot, plots, settings_plot
from mjsim.sweep.sweep_worker import empty_outcome

TURN = "robots.scout.odometry.noise.turn"
PLAN = SweepPlan(seeds=(4, 7), settings={TURN: (0.01, 0.04), "run.seconds": (5,)})
ROOM = """mjsim: 1
name: room
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
robots: [{name: scout, at: [1, 1], odometry: {noise: {turn: 0.02}}}]
run:
  seconds: 0.08
  drivers: {scout: {estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}, navigator: {use: NAVIGATOR}}}
"""
STAND = "mjsim.algorithms.constant:ConstantCommand"


def job(case=0, seed=4):
    return Job(case=case, seed=seed, settings=(), seconds=None)


def rows(values):
    return [
        {"case": case, "seed": seed, "robot": "scout", TURN: turn, "run.seconds": 5, "position_error_m.rmse": error,
         "odometry_error_m.rmse": 2 * error, "error": None}
        for case, (turn, errors) in enumerate(zip((0.01, 0.04), values, strict=True))
        for seed, error in zip((4, 7), errors, strict=False)
    ]  # fmt: skip


def series(scale, count=5):
    return {
        "time": [0.1 * k for k in range(count)], "position_error_m": [scale * k for k in range(count)],
        "odometry_error_m": [3 * scale * k for k in range(count)], "nees": [None, *[scale] * (count - 1)],
    }  # fmt: skip


def lines(axes):
    return {line.get_label(): np.column_stack(line.get_data()) for line in axes.lines}


def test_runs_of_each_value_are_dots_beside_their_mean_and_interval():
    above, below = settings_plot(PLAN, rows([(0.2, 0.4), (0.6,)])).axes
    for axes, factor in ((above, 1.0), (below, 2.0)):
        dots = [np.column_stack(line.get_data()) for line in axes.lines if line.get_alpha() == 0.35]
        np.testing.assert_allclose(dots[0], [[-0.05, 0.2 * factor], [0.05, 0.4 * factor]])
        np.testing.assert_allclose(dots[1], [[1.0, 0.6 * factor]])
        (bars,) = axes.containers
        np.testing.assert_allclose(
            np.column_stack(bars.lines[0].get_data()), [[0.0, 0.3 * factor], [1.0, 0.6 * factor]]
        )
        half = stats.t.ppf(0.975, 1) * stats.sem([0.2 * factor, 0.4 * factor])
        spans = [path[:, 1].tolist() for path in bars.lines[2][0].get_segments()]
        # An error is not negative; errorbar takes distances from the mean.
        assert spans[0] == pytest.approx([0.0, 0.3 * factor + half])
        assert spans[1] == pytest.approx([0.6 * factor, 0.6 * factor])
        assert bars.lines[0].get_linestyle() == "-"
        assert axes.get_ylim()[0] == 0.0
        assert axes.get_ylabel() == "position error, rmse [m]"
    assert above.get_title() == "the estimate of each run, means and 95 % intervals (2 runs a case)"
    assert (below.get_title(), below.get_xlabel()) == ("Odometry alone", TURN)
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["0.01", "0.04"]
    assert below.get_xlim() == pytest.approx((-0.6, 1.6))
    assert [each.get_text() for each in below.get_legend().get_texts()] == ["run.seconds 5"]


def test_values_that_are_no_numbers_are_not_joined_and_modules_go_by_their_class():
    key, more = "run.drivers.scout.estimator", {"use": "mjsim.algorithms.ekf_slam:EkfSlam", "gate": 3}
    plan = SweepPlan(seeds=(1,), settings={key: ("a.py:Own", more), "run.speed": (1, 2)})
    given = [
        {"robot": "scout", key: use, "run.speed": speed, "position_error_m.rmse": 0.1 * speed,
         "odometry_error_m.rmse": 1.0}
        for use in plan.settings[key]
        for speed in (1, 2)
    ]  # fmt: skip
    above, below = settings_plot(plan, given).axes
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["Own", "EkfSlam, gate=3"]
    assert [each.get_text() for each in below.get_legend().get_texts()] == ["run.speed 1", "run.speed 2"]
    assert [bars.lines[0].get_linestyle() for bars in above.containers] == ["None", "None"]
    # Two lanes stand beside each place.
    assert [bars.lines[0].get_xdata()[0] for bars in above.containers] == pytest.approx([-0.175, 0.175])
    assert [bars.lines[0].get_color() for bars in above.containers] == list(GROUPS[:2])
    assert "(1 run a case)" in above.get_title()
    alone = SweepPlan(seeds=(1, 2), settings={})
    above, below = settings_plot(alone, [{"position_error_m.rmse": 0.1, "odometry_error_m.rmse": 0.2}]).axes
    assert [tick.get_text() for tick in below.get_xticklabels()] == ["all runs"]
    assert below.get_legend() is None
    assert "(2 runs)" in above.get_title()


def test_errors_over_time_are_medians_with_the_range_of_most_runs():
    runs = [series(float(k), 5 + k) for k in range(1, 4)]
    (axes,) = error_plot(PLAN, [runs, []]).axes
    drawn = lines(axes)
    label = "noise.turn 0.01, run.seconds 5"
    # Two runs are left after 0.5 s, one after 0.6 s.
    np.testing.assert_allclose(drawn[label], [*([0.1 * k, 2.0 * k] for k in range(6)), [0.6, 15.0], [0.7, 21.0]])
    np.testing.assert_allclose(drawn["odometry"][:, 1], 3.0 * drawn[label][:, 1])
    shade = axes.collections[0].get_paths()[0].vertices
    assert shade[shade[:, 0] == 0.5][:, 1].max() == pytest.approx(5 * 2.8)
    assert shade[shade[:, 0] == 0.5][:, 1].min() == pytest.approx(5 * 1.2)
    assert axes.get_title() == "position error, median of the runs, 80 % of them in the shade (2 runs a case)"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [s]", "position error [m]")
    assert axes.get_xlim() == pytest.approx((0.0, 0.7))
    assert axes.get_ylim()[0] == 0.0
    (axes,) = error_plot(PLAN, [runs, runs]).axes
    assert "odometry" not in lines(axes)
    many = SweepPlan(seeds=(1,), settings={"run.speed": (1, 2, 3, 4)})
    (axes,) = error_plot(many, [runs] * 4).axes
    assert not axes.collections
    assert "shade" not in axes.get_title()
    (axes,) = error_plot(SweepPlan(seeds=(1,), settings={}), [runs]).axes
    assert "estimate" in lines(axes)
    assert axes.get_title().endswith("(1 run)")


def test_nees_over_time_is_the_mean_of_the_runs_that_have_one():
    (axes,) = nees_plot(PLAN, [[series(2.0), series(6.0), series(4.0)], [series(3.0)]]).axes
    drawn = lines(axes)
    first = drawn["noise.turn 0.01, run.seconds 5"]
    np.testing.assert_allclose(first, [[0.1 * k, 4.0] for k in range(1, 5)])
    assert drawn["noise.turn 0.04, run.seconds 5"][:, 1].tolist() == [3.0] * 4
    low, high = stats.chi2.ppf((0.025, 0.975), 9) / 3
    (band,) = axes.patches
    assert (band.get_y(), band.get_y() + band.get_height()) == pytest.approx((low, high))
    assert f"95 % band, {low:.2f} to {high:.2f}" in [each.get_text() for each in axes.get_legend().get_texts()]
    assert any(list(line.get_ydata()) == [3, 3] for line in axes.lines)
    assert (axes.get_ylabel(), axes.get_yscale()) == ("NEES of x, y, heading", "symlog")
    assert axes.get_yticks().tolist() == [0, 1, 3, 10]
    assert axes.get_title() == "consistency, the NEES averaged over the runs (2 runs a case)"
    assert axes.get_xlim() == pytest.approx((0.1, 0.4))
    (axes,) = nees_plot(SweepPlan(seeds=(1,), settings={}), [[series(2.0)]]).axes
    assert "mean of all runs" in lines(axes)


def test_a_robot_without_a_run_has_no_plots():
    assert plots(PLAN, [{"robot": "scout", "position_error_m.rmse": None}], [], ["scout", "other"], ("png",)) == {}


def outcome(case, seed, error):
    told = empty_outcome(job(case, seed), error=error)
    figures = {"position_error_m": {"rmse": 0.1 * seed}, "odometry_error_m": {"rmse": 0.5}}
    return told if error else told | {"robots": {"scout": figures}, "run": {"sim_seconds": 5.0}}


def test_results_are_tables_a_summary_and_the_failed_by_name(tmp_path, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)  # pyarrow takes seconds to import
    (tmp_path / "table.parquet").write_text("of an earlier sweep")
    outcomes = [
        outcome(case, seed, "it fell" if (case, seed) == (1, 4) else None) for case in (0, 1) for seed in (4, 7)
    ]
    found = write_results(Store(tmp_path, keep=False), PLAN, outcomes, ["other"], ("png",))
    assert found.failed == {"001-seed0004": "it fell"}
    assert json.loads((tmp_path / "summary.json").read_text()) == json.loads(json.dumps(found.summary))
    assert (tmp_path / "table.csv").exists()
    assert not (tmp_path / "table.parquet").exists()
    assert len((tmp_path / "clock.csv").read_text().splitlines()) == 5
    assert (found.folder, (tmp_path / "plots").exists()) == (tmp_path, False)
