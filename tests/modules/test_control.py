"""What a controller answers is checked: a finite torque for each motor, or one line that says what is wrong."""

import re
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.cli import main
from mjsim.modules import CheckedController

NONE = np.zeros(0)
READ = mjsim.FastReading(0.5, 0.004, {}, mjsim.JointState(0.5, NONE, NONE, NONE))
MISTAKES = [
    (lambda sensed: 1 / 0, r"raised ZeroDivisionError: division by zero \(test_control.py:\d+\)"),
    (lambda sensed: None, r"returned torques that are None; the motors are left, right \(test_control.py:\d+\)"),
    (lambda sensed: 3.0, r"returned torques that are a value of type float; the motors are left, right"),
    (lambda sensed: [0.0], r"returned 1 torques; the motors are left, right"),
    (lambda sensed: [0.0, np.nan], r"returned a list of torques that is not finite: \[0.0, nan\]"),
    (lambda sensed: np.zeros((2, 2)), r"returned a list of torques that holds an array of shape \(2,\)"),
    (lambda sensed: ["1", 2.0], r"returned a list of torques that holds something other than numbers: '1'"),
    (lambda sensed: [1j, 2.0], r"returned a list of torques that is complex; it must be real"),
    (lambda sensed: sensed.wheels.positions.fill(1.0), r"raised ValueError: .* read-only; .* copy them first"),
]


class Answers:
    def __init__(self, answer):
        self.answer = answer

    def start(self, robot, part, rng):
        pass

    def torques(self, sensed, wanted):
        return self.answer(sensed)


def checked(controller: object) -> CheckedController:
    return CheckedController(controller, robot="joe", part="drive", motors=("left", "right"), clock=lambda: 0.5)


@pytest.mark.parametrize(("answer", "says"), MISTAKES)
def test_a_mistake_is_one_line_with_robot_and_time(answer, says):
    with pytest.raises(mjsim.ModuleFault, match=rf"^controller Answers of robot 'joe' at 0\.50 s {says}") as caught:
        checked(Answers(answer)).torques(READ, mjsim.Command())
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("answer", [(1, -2), [1.0, -2.0], np.array([1.0, -2.0], np.float32)])
def test_numbers_of_any_kind_become_floats(answer):
    torques = checked(Answers(lambda sensed: answer)).torques(READ, mjsim.Command())
    assert torques == (1.0, -2.0)
    assert set(map(type, torques)) == {float}


def test_what_has_no_torques_is_no_controller():
    with pytest.raises(mjsim.ModuleFault, match=r"has no method torques\(\); a controller needs start\(\) and torques"):
        checked(type("Odd", (), {"start": print})())


ROOM = """
mjsim: 1
name: room
robots: [{name: joe, preset: balancer, at: [0, 0], odometry: {noise: {}}}]
run: {seconds: 0.6, drivers: {joe: {controllers: {drive: {use: "bad.py:Bad"}}}}}
"""
BAD = """
import numpy as np
class Bad:
    def start(self, robot, part, rng):
        START
    def torques(self, sensed, wanted):
        if sensed.time < 0.178:
            return 0.0, 0.0
        BODY
"""
RUNS = [
    ("pass", "1 / 0", r"at 0\.18 s raised ZeroDivisionError: division by zero \(bad\.py:9\)"),
    ("pass", "raise SystemExit(3)", r"at 0\.18 s raised SystemExit: 3 \(bad\.py:9\)"),
    ("pass", "return [np.nan, 0.0]", r"at 0\.18 s returned a list of torques that is not finite: \[nan, 0\.0\]"),
    ("pass", "return [1.0]", r"at 0\.18 s returned 1 torques; the motors are wheel_left, wheel_right \(bad\.py:6\)"),
    ("pass", "sensed.imu[0].turn[:] = 0", r"at 0\.18 s raised ValueError: .* copy them first \(bad\.py:9\)"),
    ("robot.sensors.clear()", "pass", r"at 0\.00 s raised TypeError: .* copy them first \(bad\.py:5\)"),
    ("1 / 0", "pass", r"at 0\.00 s raised ZeroDivisionError: division by zero \(bad\.py:5\)"),
]


@pytest.mark.parametrize(("start", "body", "says"), RUNS)
def test_in_a_run_it_is_one_line_and_exit_code_1_and_what_was_recorded_stays(
    tmp_path, capsys, monkeypatch, start, body, says
):
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM)
    Path("bad.py").write_text(BAD.replace("START", start).replace("BODY", body))
    with pytest.raises(SystemExit) as left:
        main(["run", "room.yaml", "-o", "run.mcap"])
    assert left.value.code == 1
    (line,) = (line for line in capsys.readouterr().err.splitlines() if not line.startswith("mjsim: run room"))
    assert re.match(rf"controller Bad of robot 'joe' {says}", line), line
    if "at 0.00 s" in line:
        assert not Path("run.mcap").exists()
        return
    recording = mjsim.read_recording("run.mcap")
    assert len(recording.time) == 5
    assert [event.text for event in recording.robots["joe"].events if event.kind == "fault"] == [line]


def test_check_finds_what_is_wrong_without_running_it(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM)
    Path("bad.py").write_text("class Bad:\n    def start(self, robot, part, rng): 1 / 0\n")
    with pytest.raises(SystemExit):
        main(["check", "room.yaml"])
    assert "room.yaml:5:64: Bad in bad.py has no method torques(); a controller needs start() and torques()" in "".join(
        capsys.readouterr()
    )
