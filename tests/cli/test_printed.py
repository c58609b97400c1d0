"""What commands print of their results, word by word, and the small decisions that they make for a shell."""

import os
import signal
import time

import pytest

from mjsim.cli import arguments, ergonomics, logs, page_access, program
from mjsim.cli.new import _estimator
from mjsim.errors import UsageError
from mjsim.logs.calibration import Calibration, MotionCalibration, SightingCalibration
from tests.cli.shell import typed

SEATED = {
    "contacts": {
        "hip": {"error_mm": 1.25},
        "left_hand": {"error_mm": 31.46},
        "gaze": {"error_deg": 99.0},
    },
    "missed": ["left_hand"],
    "collisions": [{"segment": "left_thigh", "thing": "desk", "distance_m": -0.0123}],
    "reach": {
        "desk.key": {"short_m": 0.0, "short_leaning_m": 0.0},
        "desk.far": {"short_m": 0.1001, "short_leaning_m": 0.0},
        "shelf.top": {"short_m": 0.5, "short_leaning_m": 0.25},
    },
    "displays": {
        "screen": {"visible": {"either": 0.875}, "hidden_by": {"lamp": 0.1, "arm": 0.025}},
        "clock": {"visible": {"either": 1.0}, "hidden_by": {}},
    },
}


def test_a_seated_person_is_told_with_what_is_missed_hit_and_hidden():
    assert list(ergonomics._lines("ann", SEATED)) == [
        "ann: 3 contacts, the largest error 31.46 mm",
        "  left_hand is out of reach by 31.5 mm",
        "  left_thigh goes 12 mm into desk",
        "  desk.far is 101 mm out of reach; leaning reaches it",
        "  shelf.top is 500 mm out of reach; leaning does not reach it",
        "  screen: 87.5 % visible; hidden: lamp 10.0 %, arm 2.5 %",
        "  clock: 100.0 % visible",
    ]
    empty = {key: {} for key in SEATED} | {"missed": [], "collisions": []}
    assert list(ergonomics._lines("ann", empty)) == ["ann: 0 contacts, the largest error 0 mm"]


def test_a_calibration_is_told_in_percent_degrees_and_metres():
    motion = MotionCalibration(scale=0.987, distance=0.0123, turn_bias=0.01, turn=0.05, delay=-0.12, windows=40)
    sightings = SightingCalibration(range_bias=-0.02, range=0.1, bearing_bias=0.02, bearing=0.01, count=300, outliers=7)
    odometry, seen = logs._lines("r", Calibration(motion=motion, sightings=sightings))
    assert odometry == (
        "r odometry: distance -1.3 %, noise 0.012 m/sqrt(m); turn +0.573 deg/s, noise 0.050 rad/sqrt(rad);"
        " delay -0.12 s; 40 windows"
    )
    assert seen == (
        "r sightings: range -0.020 m, noise 0.100 m; bearing +1.15 deg, noise 0.57 deg; 300 sightings, 7 outliers"
    )
    assert list(logs._lines("r", Calibration(motion=None, sightings=None))) == []


MJCF = """<mujoco><worldbody><body name="base"><geom size="0.1" mass="1"/>
  <body name="upper" pos="0 0 0.5"><joint name="turn" axis="0 0 1" range="-90 45"/><geom size="0.1" mass="2"/>
    <body name="slider" pos="0.25 0 0"><joint name="slide" type="slide" axis="1 0 0"/><geom size="0.1" mass="0.5"/>
</body></body></body></worldbody></mujoco>"""


def test_an_arm_of_a_file_is_told_by_its_axes(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.xml").write_text(MJCF)
    code, out, _ = typed("arm", "two.xml", "--joints", "90,0.5", capsys=capsys)
    assert code == 0
    head, _, _, first, second, *rest = out.splitlines()
    assert head == "two.xml: 2 joints, flange on link2"
    assert first.split()[:9] == ["1", "turns", "turn", "base", "0,", "0,", "0.5", "0,", "0,"]
    assert "-90 .. 45" in first
    assert second.split()[:7] == ["2", "slides", "slide", "link1", "0.25,", "0,", "0.5"]
    assert rest[-1].startswith("at 90 deg, 0.5 m: tool at 0.0000, 0.7500, 0.5000 m; roll, pitch, yaw 0.00, 0.00, 90.00")
    for joints in ("1", "1,2,3", "a,b", "nan,1"):
        code, _, err = typed("arm", "two.xml", "--joints", joints, capsys=capsys)
        assert code == 2
        assert f"--joints is '{joints}'; give 2 numbers" in err


def test_a_shell_completes_shipped_worlds_folders_and_yaml(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "office").mkdir()
    (tmp_path / "office" / "one.yaml").write_text("")
    (tmp_path / "office" / "notes.txt").write_text("")
    found = arguments.complete_world("offi")
    assert found == sorted(found)
    assert {"office", "office/"} <= set(found)
    assert arguments.complete_world("office/o") == ["office/one.yaml"]
    assert arguments.complete_world("office/") == ["office/one.yaml"]
    assert arguments.complete_world("no/such/folder") == []
    assert "gallery" in arguments.complete_world("")


def test_an_estimator_beside_a_new_world_is_named_from_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "worlds").mkdir()
    source = "class Mine:\n    def start(self, robot, map, rng): ...\n    def update(self, seen): ...\n"
    for place in ("own.py", "worlds/own.py"):
        (tmp_path / place).write_text(source)
    inside = _estimator("worlds/own.py:Mine", tmp_path / "worlds" / "new.yaml")
    assert inside.use == "own.py:Mine"
    with pytest.raises(UsageError, match="must be in the folder of the new world"):
        _estimator("own.py:Mine", tmp_path / "worlds" / "new.yaml")
    for unknown in ("nothing", "nothing{a: 1}"):
        with pytest.raises(UsageError, match="no estimator 'nothing'"):
            _estimator(unknown, None)


@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY", None])
def test_a_screen_is_one_of_two_variables(monkeypatch, name):
    monkeypatch.setattr("sys.platform", "linux")
    for each in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(each, raising=False)
    if name is not None:
        monkeypatch.setenv(name, ":0")
    assert page_access.has_screen() == (name is not None)
    monkeypatch.setattr("sys.platform", "darwin")
    assert page_access.has_screen()


@pytest.mark.skipif(not hasattr(signal, "SIGUSR1"), reason="a signal of Unix")
def test_a_signal_prints_another_address_only_while_a_page_is_served(capsys):
    before = signal.getsignal(signal.SIGUSR1)
    with page_access.addresses_on_signal(lambda: "http://here"):
        os.kill(os.getpid(), signal.SIGUSR1)
        err, until = "", time.monotonic() + 5.0
        while not err and time.monotonic() < until:
            time.sleep(0.01)
            err = capsys.readouterr().err
    assert "address for another browser, works once: http://here" in err
    assert signal.getsignal(signal.SIGUSR1) is before
    assert f"kill -USR1 {os.getpid()}" in page_access.how_to_get_another()


def test_other_errors_of_the_system_than_those_of_the_output_are_bugs():
    with pytest.raises(OSError, match="disk"):
        program._unwritten(OSError("disk"))


def test_a_second_signal_ends_a_program_that_hangs_and_ignored_ones_stay_ignored(monkeypatch):
    held = {number: signal.getsignal(number) for number in program.TERMINATING}
    try:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        came = program._interrupt_when_terminated()
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGTERM)
        assert came == [signal.SIGTERM]
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
