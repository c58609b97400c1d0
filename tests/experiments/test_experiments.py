"""The classic experiments: each is made anew, and what its page says is compared with the recording."""

import json

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.cli import main
from mjsim.experiments import EXPERIMENTS, run_experiments
from mjsim.experiments.classic import classic_world, odometry
from mjsim.experiments.offline import triangulated


@pytest.fixture(scope="module")
def bumped(tmp_path_factory):
    folder = tmp_path_factory.mktemp("experiments")
    (result,) = run_experiments(folder, only=["bump"])
    return folder, result


@pytest.mark.slow
def test_into_the_wall_the_robot_bumps_stops_and_wriggles(bumped):
    folder, result = bumped
    assert result.holds
    track = mjsim.read_recording(folder / "bump" / "run.mcap").robots["scout"]
    # Seen another way: no corner of a many-sided body is beyond the inner faces of the walls, and the end is at one.
    body = shapely.Point(track.truth[-1, :2]).buffer(0.22)
    assert shapely.box(0.05, 0.05, 5.95, 3.95).buffer(1e-3).contains(body)
    assert 5.95 - body.bounds[2] < 0.01


@pytest.mark.slow
def test_its_page_shows_every_figure_and_every_picture(bumped):
    folder, result = bumped
    page = (folder / "index.html").read_text()
    assert all(finding.what in page for finding in result.findings)
    for picture in result.pictures:
        assert f'src="bump/{picture.name}.png"' in page
        assert (folder / "bump" / f"{picture.name}.png").read_bytes().startswith(b"\x89PNG")
    assert json.loads((folder / "results.json").read_text())["bump"]["holds"] is True


def test_every_experiment_is_a_shipped_world():
    for name in EXPERIMENTS:
        with classic_world(name) as world:
            assert world.name == f"classic-{name}"


def test_a_wrong_name_is_an_error(capsys, tmp_path):
    with pytest.raises(SystemExit) as caught:
        main(["experiments", "slum", "-o", str(tmp_path)])
    assert caught.value.code == 2
    assert capsys.readouterr().err == "no experiment 'slum'; did you mean 'slam'?\n"


@pytest.mark.slow
def test_a_covariance_half_as_large_as_the_error_is_found_out(bumped):
    folder, _ = bumped
    recording = mjsim.read_recording(folder / "bump" / "run.mcap")
    rng = np.random.default_rng(1)
    # Random walks of known covariance stand for twenty runs.
    rows = len(recording.time)
    steps = rng.normal(size=(20, rows, 3)) * 0.01
    truth, estimate = np.zeros((20, rows, 3)), np.cumsum(steps, axis=1)
    honest = 1e-4 * np.arange(1, rows + 1)[None, :, None, None] * np.eye(3) * np.ones((20, 1, 1, 1))
    assert odometry(recording, (truth, estimate, honest)).findings[-1].holds
    assert not odometry(recording, (truth, estimate, honest / 2.0)).findings[-1].holds


@pytest.mark.slow
def test_recorded_pictures_tell_where_they_were_taken(tmp_path):
    with classic_world("triangulation") as world, mjsim.Simulation(world) as sim:
        recording = mjsim.run(sim, seconds=4.5, record=tmp_path / "run.mcap")
    fixes = triangulated(recording, "scout", "front")
    errors = np.hypot(*(fixes.position - fixes.truth).T)
    assert len(errors) >= 9
    assert errors.mean() <= 0.10
    assert fixes.wrong == 0
