"""Tables, reports, comparisons and sweeps say why the NEES of dead reckoning is not shown: a huge number."""

import csv
import io
import json

import numpy as np
import pytest

import mjsim
from mjsim.report import write_report
from mjsim.report.statistics import statistics_file
from mjsim.report.tables import csv_table, key_table, latex_table
from mjsim.sweep.results import key_lines

WORLD = """\
mjsim: 1
name: plain
walls: [{points: [[0, 0], [6, 0], [6, 4], [0, 4]], closed: true}]
beacons: [{name: east, at: [5.9, 2], heading_deg: 180}]
robots:
  - name: scout
    at: [1, 2]
    odometry: {noise: {distance: 0.01, turn: 0.02}, scale: 1.05}
    sensors: [{beacons: ring, range: [0.3, 8], fov_deg: 360, rate_hz: 5, noise: {range: 0.05, bearing_deg: 1}}]
run:
  seconds: 0.6
  drivers: {scout: {navigator: {use: "mjsim.algorithms.waypoints:Waypoints", points: [[5, 2]]}}}
"""
KNOWING = WORLD.replace("{navigator", '{estimator: {use: "mjsim.algorithms.ekf_slam:EkfSlam"}, navigator')


def record(text, path, *, seed=1):
    """Run a world and return its recording."""
    with mjsim.Simulation(mjsim.parse_world(text), seed=seed) as sim:
        return mjsim.run(sim, record=path)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A run without an estimator."""
    return record(WORLD, tmp_path_factory.mktemp("runs") / "plain.mcap")


def test_statistics_have_the_nees_of_dead_reckoning_and_say_that_there_is_no_estimator(recording):
    figures = mjsim.statistics(recording)["scout"]
    assert figures["nees"]["reason"] == "no estimator"
    # By the distance of 5 % and the covariance of 0.01 m per root metre: far from the 3 of a filter, but finite.
    assert np.isfinite(figures["nees"]["mean"])
    assert 0.0 <= figures["nees"]["in_band"] <= 1.0
    assert figures["odometry_error_m"]["final"] > 0.0


def test_tables_say_so_in_words_and_are_empty_where_programs_read(recording):
    figures = statistics_file(recording)
    (line,) = [line for line in key_table(figures) if "NEES" in line]
    assert line.split(")")[-1].strip() == "no estimator"
    assert "no estimator" in latex_table(figures)
    rows = {row["figure"]: row["estimate"] for row in csv.DictReader(io.StringIO(csv_table(figures)))}
    assert rows["nees.mean"] == ""
    assert float(rows["position_error_m.rmse"]) > 0.0


@pytest.mark.slow
def test_a_report_draws_no_nees_and_its_page_says_why(recording, tmp_path):
    write_report(recording, tmp_path)
    assert not list(tmp_path.glob("*_nees.png"))
    assert list(tmp_path.glob("*_error.png"))
    assert "no estimator" in (tmp_path / "report.html").read_text()
    kept = json.loads((tmp_path / "statistics.json").read_text())
    assert kept["robots"]["scout"]["nees"]["reason"] == "no estimator"


def test_a_comparison_says_which_of_its_groups_has_none_and_does_not_compare_it(recording, tmp_path):
    other = record(KNOWING, tmp_path / "ekf.mcap")
    assert mjsim.statistics(other)["scout"]["nees"]["reason"] is None
    comparison = mjsim.compare({"wheels": recording, "ekf": other})
    assert "wheels has no NEES: no estimator" in comparison.consistency
    assert not any(each.figure.key.startswith("nees") for each in comparison.differences)
    assert any(each.figure.key == "position_error_m.mean" for each in comparison.differences)
    wheels = next(group for group in comparison.groups if group.label == "wheels")
    assert "nees.mean" not in wheels.spreads


@pytest.mark.slow
def test_a_sweep_says_so_in_its_summary_and_short_table(tmp_path):
    (tmp_path / "plain.yaml").write_text(WORLD)
    found = mjsim.sweep(tmp_path / "plain.yaml", seeds=[1, 2], folder=tmp_path / "out", workers=1)
    (case,) = found.summary["cases"]
    assert case["no_nees"] == {"scout": "no estimator"}
    assert "nees.mean" not in case["robots"]["scout"]
    assert any(line.split() == ["NEES", "no", "estimator"] for line in key_lines(found.summary))
    assert all(row.get("nees.mean") is None for row in found.rows)
    (group,) = mjsim.compare(tmp_path / "out").groups
    assert [series.estimated for series in group.series.values()] == [False, False]
