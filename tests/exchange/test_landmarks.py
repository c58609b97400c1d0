"""Landmark maps of MATLAB's SLAM simulators become worlds, and recordings go back to MATLAB."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

import mjsim
from mjsim.cli import main
from mjsim.modules import load_runnable
from tests.children import completed

OCTAVE = shutil.which("octave-cli") or shutil.which("octave")
needs_octave = pytest.mark.skipif(
    OCTAVE is None, reason="no Octave here; type: sudo apt-get install --no-install-recommends octave"
)
LM = np.array([[10.0, 50.0, 90.0, 90.0, 50.0, 10.0], [0.0, -10.0, 0.0, 60.0, 70.0, 60.0]])
WP = np.array([[0.0, 100.0, 100.0, 0.0], [30.0, 10.0, 50.0, 50.0]])


def octave(code: str, folder: Path) -> str:
    """Return what Octave prints."""
    words = [OCTAVE, "--norc", "--no-gui", "--quiet", "--eval", code]
    return completed(words, cwd=folder).stdout


def new(folder: Path, *words: str) -> int:
    """Return the exit code of `mjsim new --from map.mat`."""
    with pytest.raises(SystemExit) as left:
        main(["new", "--from", str(folder / "map.mat"), "-o", str(folder / "room.yaml"), *words])
    return left.value.code


@pytest.mark.slow
@pytest.mark.parametrize("writer", ["scipy", pytest.param("octave", marks=needs_octave)])
def test_landmarks_are_reflectors_and_waypoints_the_way(tmp_path, capsys, writer):
    if writer == "scipy":
        savemat(tmp_path / "map.mat", {"lm": LM, "wp": WP})
    else:
        octave(f"lm = {matrix(LM)}; wp = {matrix(WP)}; save('-v7', 'map.mat', 'lm', 'wp')", tmp_path)
    assert new(tmp_path, "--scale", "0.1") == 0
    assert "6 landmarks, 4 waypoints, 10.0 x 8.0 m" in capsys.readouterr().err
    world = load_runnable(tmp_path / "room.yaml")
    np.testing.assert_allclose([beacon.at for beacon in world.beacons], 0.1 * LM.T)
    (robot,) = world.robots
    assert robot.at == (0.0, 3.0)
    assert robot.heading_deg == pytest.approx(np.degrees(np.arctan2(-2.0, 10.0)), abs=0.05)
    np.testing.assert_allclose(world.run.drivers["scout"].navigator.arguments()["points"], 0.1 * WP.T[1:])


def matrix(values: np.ndarray) -> str:
    return "[" + "; ".join(" ".join(map(str, row)) for row in values.tolist()) + "]"


@pytest.mark.slow
def test_the_robot_drives_the_way_and_maps_the_landmarks(tmp_path):
    savemat(tmp_path / "map.mat", {"lm": LM, "wp": WP})
    assert new(tmp_path, "--scale", "0.05") == 0
    with mjsim.Simulation(load_runnable(tmp_path / "room.yaml")) as sim:
        track = mjsim.run(sim, seconds=26.0).robots["scout"]
    assert np.hypot(*(track.truth[-1, :2] - 0.05 * WP[:, -1])) < 0.25
    assert len(track.landmarks.names) >= 4


@pytest.mark.parametrize(
    ("content", "says"),
    [
        ({"wp": WP}, "holds no landmarks: lm, 2 x n; it holds wp"),
        ({"lm": np.zeros((6, 5))}, "has lm of 6 x 5; it must be 2 x n numbers, x above y"),
        ({"lm": "text"}, "has lm of 1; it must be 2 x n numbers, x above y"),
        ({"lm": LM * np.nan}, "has lm that is not finite"),
        ({"lm": LM * 1000.0}, "extends to 90000 m; the limit is 5000 m, give a smaller --scale"),
        ({"lm": np.zeros((2, 0))}, "has an empty lm; a map has at least one landmark"),
        ({"lm": np.zeros((2, 2001))}, "has 2001 columns in lm; at most 2000 can be read"),
    ],
)
def test_what_is_no_landmark_map_is_one_line(tmp_path, capsys, content, says):
    savemat(tmp_path / "map.mat", content)
    assert new(tmp_path) == 2
    assert capsys.readouterr().err == f"'{tmp_path / 'map.mat'}' {says}\n"


def test_another_file_is_told_how_to_save_one(tmp_path, capsys):
    (tmp_path / "map.mat").write_text("# Created by Octave\n# name: lm\n")
    assert new(tmp_path) == 2
    assert "; write a MAT-file of version 5 to 7 with: save('-v7', " in capsys.readouterr().err


@pytest.mark.parametrize("before", [b"", b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b"\0")])
def test_a_mat_file_of_version_7_3_is_refused_with_how_to_save_it(tmp_path, capsys, before):
    (tmp_path / "map.mat").write_bytes(before + b"\x89HDF\r\n\x1a\n" + bytes(800))
    assert new(tmp_path) == 2
    said = capsys.readouterr().err
    assert "is a MAT-file of version 7.3 (HDF5), which mjsim cannot read; write one of version 5 to 7" in said
    assert said.count("\n") == 1


@pytest.mark.slow
@needs_octave
def test_octave_opens_an_export_under_names_that_are_expected(tmp_path):
    text = "robots: [{name: 2-nd, at: [1, 2]}]\nbeacons: [{name: lion, at: [3, 2]}]\n"
    with mjsim.Simulation(mjsim.parse_world(text)) as sim:
        driver = mjsim.Driver(navigator=Ahead())
        recording = mjsim.run(sim, drivers={"2-nd": driver}, seconds=0.4, record=tmp_path / "run.mcap")
    with pytest.raises(SystemExit) as left:
        main(["export", str(tmp_path / "run.mcap"), "--mat", str(tmp_path / "run.mat")])
    assert left.value.code == 0
    code = """load('run.mat');
    r = robots.x2_nd;
    assert(strcmp(r.name, '2-nd') && isequal(size(time), [10 1]) && isequal(size(r.truth), [10 3]))
    assert(isequal(size(r.estimate), [10 3]) && isequal(size(r.covariance), [10 3 3]))
    error_of = sqrt(sum((r.estimate(:, 1:2) - r.truth(:, 1:2)).^2, 2));
    printf('%.17g %.17g\\n', r.truth(end, 1), error_of(end))"""
    x, apart = map(float, octave(code, tmp_path).split())
    track = recording.robots["2-nd"]
    assert x == track.truth[-1, 0]
    assert apart == pytest.approx(np.hypot(*(track.estimate - track.truth)[-1, :2]), rel=1e-12)


class Ahead:
    """Goes straight on."""

    def start(self, robot, map, rng):
        pass

    def command(self, seen, belief):
        return mjsim.Command(0.3)
