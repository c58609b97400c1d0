"""The command line as a person types it: exit codes, one line a mistake, results on stdout."""

import json
import os
import signal
import sys
from pathlib import Path

import cv2
import mujoco
import numpy as np
import pytest

import mjsim
from tests.children import completed
from tests.cli.shell import FORWARD, shell, typed, wait_for_ticks


def test_check_says_nothing_of_a_world_that_is_right(room, capsys):
    assert typed("check", "room.yaml", capsys=capsys) == (0, "", "")


def test_check_tells_of_every_file_all_that_is_wrong(room, capsys):
    Path("bad.yaml").write_text("mjsim: 1\nwals: []\nrobots: [{name: a, at: [0, x]}]\n")
    code, out, err = typed("check", "bad.yaml", "room.yaml", "none.yaml", capsys=capsys)
    lines = err.splitlines()
    assert (code, out) == (2, "")
    assert lines[0] == "bad.yaml:2:1: unknown key 'wals'; did you mean 'walls'?"
    assert lines[1].startswith("bad.yaml:3:")
    assert "none.yaml" in lines[2]
    assert len(lines) == 3


@pytest.mark.slow
def test_a_run_is_recorded_reported_and_exported(room, capsys):
    code, out, err = typed("run", "room.yaml", capsys=capsys)
    assert (code, out) == (0, "out/room/run.mcap\n")
    assert "run room" in err
    recording = mjsim.read_recording("out/room/run.mcap")
    assert len(recording.time) == 25

    code, out, _ = typed("report", "out/room/run.mcap", "-o", "report", capsys=capsys)
    assert code == 0
    assert "position error, mean [m]" in out
    figures = json.loads(Path("report/statistics.json").read_text())
    assert figures["robots"]["scout"] == mjsim.statistics(recording)["scout"]
    for plot in ("path", "error", "bounds"):
        assert cv2.imread(f"report/scout_{plot}.png") is not None
    page = Path("report/report.html").read_text()
    assert "http" not in page.replace("http://www.w3.org", "")
    assert page.count("data:image/png;base64,") == 3

    code, out, _ = typed("export", "out/room/run.mcap", "--tum", "tum", "--npz", "run.npz", capsys=capsys)
    assert (code, out) == (0, "tum\nrun.npz\n")
    assert len(np.loadtxt("tum/scout_truth.tum")) == 25


@pytest.mark.slow
def test_options_of_a_run_go_before_the_world_file(room, capsys):
    words = ("run", "room.yaml", "-o", "a.mcap", "--seconds", "0.4", "--seed", "7", "--set", "run.rate_hz=12.5")
    assert typed(*words, capsys=capsys)[0] == 0
    recording = mjsim.read_recording("a.mcap")
    assert recording.seed == 7
    np.testing.assert_allclose(recording.time, np.arange(5) * 0.08)


@pytest.mark.parametrize(
    ("setting", "complaint"),
    [
        ("robots.scot.at=[1, 1]", "--set robots.scot.at=[1, 1]: no item 'scot'; did you mean 'scout'?"),
        ("run.secnds=3", "--set run.secnds=3: no key 'secnds'; did you mean 'seconds'?"),
        ("run.seconds", "--set run.seconds: write it as KEY=VALUE, such as run.seconds=20"),
    ],
)
def test_a_setting_that_cannot_be_is_one_line(room, capsys, setting, complaint):
    code, _, err = typed("run", "room.yaml", "--set", setting, capsys=capsys)
    assert (code, err) == (2, complaint + "\n")
    assert not Path("out").exists()


def test_compile_gives_a_folder_that_plain_mujoco_loads(room, capsys):
    code, out, _ = typed("compile", "room.yaml", "-o", "scene", capsys=capsys)
    assert (code, out) == (0, "scene/scene.xml\n")
    model = mujoco.MjModel.from_xml_path("scene/scene.xml")
    assert model.body("scout/base").id > 0


@pytest.mark.slow
def test_an_invalid_choice_is_a_plain_error(room, capsys):
    code, _, err = typed("show", "room.yaml", "-o", "x.png", "--labels", "some", capsys=capsys)
    assert code == 2
    assert err == "mjsim: Invalid value for '--labels': 'some' is not one of 'none', 'walls', 'all'.\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ("new", "room.yaml"),
            "Got unexpected extra argument(s) (room.yaml); name the output with -o WORLD.yaml",
        ),
        (("compile", "gallery"), "Missing option '-o'; name the output with -o DIR"),
        (("doctor", "x"), "Got unexpected extra argument(s) (x); mjsim doctor --help shows how to type it"),
        (("check",), "Missing argument 'WORLD...'; mjsim check --help shows how to type it"),
        (("exprot",), "No such command 'exprot'. Did you mean 'export'?"),
        (("frob",), "No such command 'frob'; mjsim --help lists the commands"),
        (("run", "room.yaml", "--seed", "-1"), "Invalid value for '--seed': it must be greater than or equal to 0"),
    ],
)
def test_wrong_arguments_are_told_with_what_to_type(capsys, words, says):
    code, _, err = typed(*words, capsys=capsys)
    assert (code, err) == (2, f"mjsim: {says}\n")


def test_show_draws_the_plan_and_what_a_camera_sees(room, capsys):
    assert typed("show", "room.yaml", "-o", "plan.png", capsys=capsys)[0] == 0
    assert min(cv2.imread("plan.png").shape[:2]) > 200
    assert typed("show", "room.yaml", "-o", "seen.png", "--camera", "scout/front", capsys=capsys)[0] == 0
    assert cv2.imread("seen.png").shape == (120, 160, 3)
    code, _, err = typed("show", "room.yaml", "-o", "x.png", "--camera", "scout/frnt", capsys=capsys)
    assert (code, err) == (2, "no camera 'scout/frnt' in this world; did you mean 'scout/front'?\n")


@pytest.mark.slow
def test_a_module_that_fails_ends_the_run_with_one_line_and_a_readable_file(room, capsys):
    Path("forward.py").write_text(FORWARD.replace("return mjsim", "assert seen.time < 0.5\n        return mjsim"))
    code, _, err = typed("run", "room.yaml", "-o", "run.mcap", capsys=capsys)
    assert code == 1
    last = err.splitlines()[-1]
    assert last.startswith("navigator Forward of robot 'scout' at 0.52 s raised AssertionError")
    assert len(mjsim.read_recording("run.mcap").time) == 13


@pytest.mark.slow
def test_a_module_may_import_a_file_beside_it(room, capsys, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    Path("my_speeds.py").write_text("SLOW = 0.1\n")
    Path("forward.py").write_text(FORWARD.replace("import mjsim", "import mjsim\nfrom my_speeds import SLOW"))
    assert typed("run", "room.yaml", "-o", "run.mcap", capsys=capsys)[0] == 0
    assert len(mjsim.read_recording("run.mcap").time) == 25


def test_a_module_that_cannot_be_made_is_the_users_mistake(room, capsys):
    Path("forward.py").write_text(FORWARD.replace("speed)", "pace)"))
    code, _, err = typed("run", "room.yaml", capsys=capsys)
    assert code == 2
    assert err == "room.yaml:11:67: Forward takes no 'speed'; there are pace\n"
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("--seconds", "0.01"), "seconds is 0.01; a run has at least one tick of 0.04 s"),
        (("--seconds", "inf"), "seconds is inf; a run has at least one tick of 0.04 s, and at most 1e+08 s"),
        (("-o", "/proc/none/run.mcap"), "cannot write '/proc/none/run.mcap': No such file or directory"),
        (("--video", "film.avi"), "cannot write a video as 'film.avi'; name it .mp4"),
    ],
)
def test_an_impossible_run_is_an_error_before_it_starts(room, capsys, words, complaint):
    code, out, err = typed("run", "room.yaml", *words, capsys=capsys)
    assert (code, out, err.splitlines()[-1]) == (2, "", complaint)
    assert not Path("out").exists()


@pytest.mark.slow
def test_a_report_that_cannot_be_written_is_one_line(room, capsys):
    assert typed("run", "room.yaml", "-o", "run.mcap", capsys=capsys)[0] == 0
    code, _, err = typed("report", "run.mcap", "-o", "/proc/none", capsys=capsys)
    assert (code, err) == (2, "cannot write '/proc/none': No such file or directory\n")


def test_what_is_no_recording_is_told_in_one_line(room, capsys):
    for words in (
        ("report", "room.yaml", "-o", "r"),
        ("report", "none.mcap", "-o", "r"),
        ("video", "x.mcap", "-o", "v"),
    ):
        code, _, err = typed(*words, capsys=capsys)
        assert code == 2
        assert len(err.splitlines()) == 1


@pytest.mark.slow
def test_the_schema_is_json_that_names_the_walls(capsys):
    code, out, _ = typed("schema", capsys=capsys)
    assert code == 0
    assert "walls" in json.loads(out)["properties"]


@pytest.mark.slow
@pytest.mark.parametrize(("sent", "code"), [(signal.SIGINT, 130), (signal.SIGHUP, 129)])
def test_ctrl_c_and_kill_close_the_recording_and_give_what_shells_expect(room, sent, code):
    with shell("run", "room.yaml", "-o", "run.mcap", "--seconds", "600", "--realtime") as process:
        wait_for_ticks("run.mcap")
        process.send(sent)
        assert process.ended() == code
        err = process.rest("stderr")
    assert "Traceback" not in err
    assert err.splitlines()[-1] == "mjsim: interrupted; anything recorded so far is closed and readable"
    recording = mjsim.read_recording("run.mcap")
    assert recording.whole
    assert "run room.yaml -o run.mcap" in recording.metadata["command"]


def test_ctrl_c_while_the_command_line_is_imported_is_one_line():
    starts = """
import os, signal, sys
class Press:
    def find_spec(self, name, *rest):
        if name == "typer":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Press())
from mjsim.cli import main
main(["--version"])
"""
    done = completed([sys.executable, "-c", starts], check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "mjsim: interrupted\n")


@pytest.mark.slow
def test_a_killed_run_leaves_a_recording_that_can_be_reported(room, capsys):
    with shell("run", "room.yaml", "-o", "run.mcap", "--seconds", "600", "--realtime"):
        wait_for_ticks("run.mcap")
    assert not mjsim.read_recording("run.mcap").whole
    code, _, err = typed("report", "run.mcap", "-o", "report", capsys=capsys)
    line = "mjsim: run.mcap: the recording is incomplete: the run was killed, or the file was cut\n"
    assert (code, err) == (0, line)
    assert typed("export", "run.mcap", "--tum", "tum", capsys=capsys)[2] == line


@pytest.mark.slow
def test_a_run_that_cannot_draw_says_so_before_it_bakes_light(room):
    Path("lit.yaml").write_text(f"shading: baked{Path('room.yaml').read_text()}")
    more = {"MUJOCO_GL": "disabled", "XDG_CACHE_HOME": str(Path("cache").resolve())}
    done = completed([sys.executable, "-m", "mjsim.cli", "run", "lit.yaml"], check=False, env={**os.environ, **more})
    assert done.returncode != 0
    assert done.stderr.splitlines()[-1].startswith("MUJOCO_GL is 'disabled'; mjsim draws with")
    assert "light of" not in done.stderr
