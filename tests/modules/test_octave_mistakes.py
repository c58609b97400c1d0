"""Everything that a function in a .m file can do wrong is one line, and what was recorded stays readable."""

import re

import pytest

import mjsim
from tests.modules.octave_room import HEADS, fault_of, needs_octave, world_of, written
from tests.modules.processes import gone

MISTAKES = [
    # What a function does at 0.20 s, in its line 5, and what the line says after that.
    ("estimator", "x = rnad(3);", "raised an error: 'rnad' undefined (mine.m:5 in mine)"),
    ("estimator", "error('lost: %d\\nat sea', 3);", "raised an error: lost: 3 at sea (mine.m:5 in mine)"),
    ("estimator", "helper(3);\nend\nend\nfunction helper(x)\nif 1\n  [1 2 3](x + 9);", "raised an error: index (12)"),
    (
        "estimator",
        "x = [1 2] * [3 4];",
        "raised an error: operator *: nonconformant arguments (op1 is 1x2, op2 is 1x2)",
    ),
    ("estimator", "est = rmfield(est, 'pose');", "returned no est.pose (mine.m:1)"),
    ("estimator", "est.pose = [1 2];", "returned est.pose of 1 x 2; it must be 3 numbers (mine.m:1)"),
    ("estimator", "est.pose = [1 NaN 3];", "returned a pose that is not finite: [1.0, nan, 3.0] (mine.m:1)"),
    ("estimator", "est.pose = {1, 2, 3};", "returned est.pose that is of cell; it must hold real numbers (mine.m:1)"),
    ("estimator", "est.pose = [1i 2 3];", "returned est.pose that is complex; it must hold real numbers (mine.m:1)"),
    ("estimator", "est = 7;", "returned est that is of double; it must be a struct (mine.m:1)"),
    ("estimator", "est.covariance = eye(2);", "returned the covariance of the pose of shape (2, 2); it must be (3, 3)"),
    ("estimator", "est.covariance = -eye(3);", "returned the covariance of the pose with the eigenvalue -1;"),
    ("estimator", "est.landmarks = ones(3, 4);", "returned est.landmarks of 3 x 4; it must be 2 x n (mine.m:1)"),
    ("estimator", "est.landmarks = ones(2, 4);", "returned 4 landmarks with 0 covariances; each needs one (mine.m:1)"),
    (
        "estimator",
        "est.landmarks = ones(2, 2); est.landmark_covariance = repmat(eye(2), [1 1 2]); est.ids = [2 2];",
        "returned two landmarks called 'bear-2'; each id stands for one (mine.m:1)",
    ),
    ("estimator", "clear state;", "raised an error: "),
    ("estimator", "exit(0);", "ended with exit code 0 before it answered (mine.m:5 in mine)"),
    ("estimator", "quit", "ended with exit code 0 before it answered (mine.m:5 in mine)"),
    ("estimator", "x = input('how far? ');", "raised an error: input: reading user-input failed! (mine.m:5 in mine)"),
    ("estimator", "x = zeros(1e6, 1e7);", "raised an error: out of memory or dimension too large"),
    ("estimator", "while true, end", "did not answer within 1 s and was ended (mine.m:1 in mine)"),
    ("estimator", "keyboard", "did not answer within 1 s and was ended (mine.m:1 in mine)"),
    ("estimator", "system('sleep 88088');", "did not answer within 1 s and was ended (mine.m:1 in mine)"),
    ("estimator", "kill(getpid(), 9);", "was ended by SIGKILL before it answered (mine.m:1 in mine)"),
    (
        "navigator",
        "cmd.forward = 'fast';",
        "returned cmd.forward that is of char; it must hold real numbers (mine.m:1)",
    ),
    (
        "navigator",
        "cmd = struct('speed', 1);",
        "returned a cmd without forward, left, turn, wheels or joints; it must",
    ),
    (
        "navigator",
        "cmd.wheels = [1 2 3];",
        "returned 3 wheel speeds; the wheels are wheel_left, wheel_right (mine.m:1)",
    ),
    ("navigator", "cmd.forward = Inf;", "returned a command that is not finite: [inf, 0.0, 0.0] (mine.m:1)"),
    (
        "observer",
        "z.id = 9; z.range = 1; z.bearing = 0; z.R = eye(2);",
        "returned the id 9; the catalogue has 2 beacons",
    ),
    ("observer", "z.id = 1;", "returned z with 1 id, 0 range, 0 bearing, 0 R; it must have as many of each (mine.m:1)"),
    ("avoidance", "cmd.turn = [1 2];", "returned cmd.turn of 1 x 2; it must be one number (mine.m:1)"),
]


@needs_octave
@pytest.mark.slow
@pytest.mark.parametrize(("role", "body", "says"), MISTAKES)
def test_a_mistake_is_one_line_and_what_was_recorded_is_readable(tmp_path, role, body, says):
    world = world_of(tmp_path, f"{role}: {{use: mine.m, patience: 1}}", written(role, body))
    line = fault_of(world, tmp_path / "run.mcap")
    assert line.startswith(f"{role} mine.m of robot 'scout' at 0.20 s {says}"), line
    assert re.search(r"\(mine\.m:\d+", line)
    recording = mjsim.read_recording(tmp_path / "run.mcap")
    assert len(recording.time) == 5
    assert [event.text for event in recording.robots["scout"].events if event.kind == "fault"] == [line]
    assert gone(str(tmp_path))
    assert gone("sleep 88088")


EARLY = [
    # A file that Octave cannot read, or that answers too little, and what the line says at 0.00 s.
    (
        f"function {HEADS['estimator']}\nest.pose = (1;\nend\n",
        "raised a parse error: syntax error near 'est.pose = (1;' (mine.m:2)",
    ),
    (f"function {HEADS['estimator']}\nif 1\nest.pose = 1;\n", "raised a parse error: syntax error (mine.m:4)"),
    (f"function {HEADS['estimator']}\nest.pose = robot.prior;\nend\n", "returned no est.covariance (mine.m:1)"),
    ("function [est, state] = mine(obs, robot)\nend\n", "raised an error: mine: function called with too many inputs"),
    (
        "function est = mine(obs, robot, state)\nest = 1;\nend\n",
        "raised an error: mine: function called with too many outputs",
    ),
    ("function [est, state] = mine(obs, robot, state)\nend\n", "raised an error: "),
]


@needs_octave
@pytest.mark.slow
@pytest.mark.parametrize(("text", "says"), EARLY)
def test_what_cannot_be_read_is_one_line_too(tmp_path, text, says):
    line = fault_of(world_of(tmp_path, "estimator: {use: mine.m}", text), tmp_path / "run.mcap")
    assert line.startswith(f"estimator mine.m of robot 'scout' at 0.00 s {says}"), line
    assert re.search(r"\(mine\.m:\d+", line)
    assert gone(str(tmp_path))
