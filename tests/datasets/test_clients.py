"""Programs of others compute from exports what mjsim computes."""

import shutil
from pathlib import Path

import pytest

import mjsim
from mjsim.record import export_csv, export_mat
from tests.children import completed

WORLD = """mjsim: 1
name: clients
robots:
  - {name: scout, preset: create3, at: [2, 2.5], odometry: {noise: {distance: 0.05, turn: 0.1}}}
run:
  rate_hz: 25
  drivers: {scout: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.3, turn: 0.4}}}
"""
pytestmark = pytest.mark.slow  # Each starts a large program.


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> mjsim.Recording:
    with mjsim.Simulation(mjsim.parse_world(WORLD), seed=3) as sim:
        return mjsim.run(sim, seconds=1.0, record=tmp_path_factory.mktemp("clients") / "run.mcap")


def error_of(run: mjsim.Recording) -> float:
    return float(mjsim.statistics(run)["scout"]["position_error_m"]["rmse"])


def test_pandas_finds_the_error_of_the_estimate_in_a_table(run: mjsim.Recording, tmp_path: Path):
    pandas = pytest.importorskip("pandas")
    export_csv(run, tmp_path)
    table = pandas.read_csv(tmp_path / "scout_track.csv")
    off = (table.estimate_x - table.truth_x) ** 2 + (table.estimate_y - table.truth_y) ** 2
    assert off.mean() ** 0.5 == pytest.approx(error_of(run), abs=1e-9)
    assert error_of(run) > 1e-3


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="GNU Octave is not installed")
def test_octave_finds_the_same_error_in_arrays(run: mjsim.Recording, tmp_path: Path):
    export_mat(run, tmp_path / "run.mat")
    code = "load run.mat; d = robots.scout.estimate(:, 1:2) - robots.scout.truth(:, 1:2);"
    code += "printf('%.12f', sqrt(mean(sum(d.^2, 2))))"
    told = completed(["octave-cli", "--eval", code], cwd=tmp_path)
    assert float(told.stdout) == pytest.approx(error_of(run), abs=1e-9)
