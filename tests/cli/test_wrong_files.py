"""A wrong file is one line that says what to name instead, before anything is computed."""

from pathlib import Path

import pytest

from tests.cli.shell import typed

EKF = "mjsim.algorithms.ekf_slam:EkfSlam"


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A folder with a world, an empty file, a folder, and a file that is not text."""
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text("mjsim: 1\nrobots: [{name: scout, at: [0, 0]}]\n")
    Path("nothing.yaml").write_text("")
    Path("folder").mkdir()
    Path("some.bin").write_bytes(b"\x89\x00\x01")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ("check folder", "no shipped world 'folder'; for a world in the folder, type 'folder/WORLD.yaml'"),
        ("run room.yaml -o room.yaml/run.mcap", "'room.yaml' exists and is not a folder; name another one"),
        ("run room.yaml --video room.yaml/a.mp4", "'room.yaml' exists and is not a folder; name another one"),
        ("compile room.yaml -o room.yaml", "'room.yaml' exists and is not a folder; name another one"),
        ("export-world room.yaml --map room.yaml", "'room.yaml' exists and is not a folder; name another one"),
        pytest.param(
            "lab lab-1-step -o room.yaml",
            "'room.yaml' exists and is not a folder; name another one",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "ergonomics control_desk -o room.yaml/a",
            "'room.yaml' exists and is not a folder; name another one",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "experiments bump -o room.yaml",
            "'room.yaml' exists and is not a folder; name another one",
            marks=pytest.mark.slow,
        ),
        ("sweep room.yaml --seeds 0:2 -o room.yaml", "'room.yaml' exists and is not a folder; name another one"),
        ("new --template empty -o room.yaml/a.yaml", "'room.yaml' exists and is not a folder; name another one"),
        ("report none.mcap -o out", "no file 'none.mcap'; name a recording"),
        ("video room.yaml/a.mcap -o a.mp4", "no file 'room.yaml/a.mcap'; name a recording"),
        ("compare none.mcap", "no file 'none.mcap'; name a recording"),
        ("export folder --tum out", "'folder' is a folder; name a recording"),
        (f"replay folder --robot scout --estimator {EKF} -o a.mcap", "'folder' is a folder; name a recording"),
        (
            "import-log some.bin --noise none.yaml -o a.mcap",
            "no file 'none.yaml'; name a file written by `mjsim calibrate -o`",
        ),
        ("arm none.yaml", "no file 'none.yaml'; name a YAML file with `dh`, MJCF or URDF"),
        ("arm nothing.yaml", "nothing.yaml:1:1: the file is empty; an arm has the key 'dh'"),
        (
            "studio some.bin --no-browser",
            "'some.bin' is not a world file (.yaml); for a recording, open its folder and choose Review",
        ),
    ],
)
def test_a_wrong_file_is_one_line_that_says_what_to_name(place, capsys, words, complaint):
    before = sorted(place.rglob("*"))
    assert typed(*words.split(), capsys=capsys) == (2, "", f"{complaint}\n")
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (f"{EKF}{{jacobian: standard}}", "EkfSlam takes no 'jacobian'; did you mean 'jacobians'?"),
        ("mjsim.algorithms.ekf_slm:EkfSlam", "no module 'mjsim.algorithms.ekf_slm'; install it or correct the name"),
    ],
)
def test_a_wrong_estimator_of_a_replay_is_one_line(place, capsys, spec, complaint):
    assert typed("run", "room.yaml", "--seconds", "0.2", "-o", "run.mcap", capsys=capsys)[0] == 0
    words = ("replay", "run.mcap", "--robot", "scout", "--estimator", spec, "-o", "mine.mcap")
    assert typed(*words, capsys=capsys) == (2, "", f"{complaint}\n")
