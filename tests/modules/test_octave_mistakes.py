"""Everything that a function in a .m file can do wrong is one line, and what was recorded stays readable."""

import os
import re
import shutil

import pytest

import mjsim
from tests.modules.mistakes import mistakes_in
from tests.modules.octave_room import HEADS, fault_of, needs_octave, world_of, written
from tests.modules.processes import gone


@needs_octave
@pytest.mark.slow
@pytest.mark.parametrize("case", mistakes_in("octave.yaml"), ids=lambda case: case["says"][:60])
def test_a_mistake_is_one_line_and_what_was_recorded_is_readable(tmp_path, case):
    role, body, says = case["role"], case["body"], case["says"]
    # Whatever does answer, or end, may take as long as a busy machine needs for it.
    patience = "patience: 1" if says.startswith("did not answer") else "patience: 30"
    world = world_of(tmp_path, f"{role}: {{use: mine.m, {patience}}}", written(role, body))
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
    ("function [est, state] = mine(obs, robot)\nend\n", "raised an error: mine: function called with too many inputs"),
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


@needs_octave
@pytest.mark.slow
def test_patience_is_for_calls_not_for_the_start_of_octave(tmp_path, monkeypatch):
    octave = shutil.which("octave-cli") or shutil.which("octave")
    late = tmp_path / "bin" / "octave-cli"
    late.parent.mkdir()
    late.write_text(f'#!/bin/sh\nsleep 1.2\nexec {octave} "$@"\n')
    late.chmod(0o755)
    monkeypatch.setenv("PATH", f"{late.parent}:{os.environ['PATH']}")
    world = world_of(tmp_path, "estimator: {use: mine.m, patience: 1}", written("estimator", ""))
    with mjsim.Simulation(world) as sim:
        assert len(mjsim.run(sim, seconds=0.2).time) == 5
