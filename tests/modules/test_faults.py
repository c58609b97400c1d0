"""Whatever a module does wrong is one line that names it, its robot and the time; what was recorded stays readable."""

import re
import warnings
from pathlib import Path

import pytest

import mjsim
from mjsim.cli import main
from tests.modules.faulty import ASKED, ROOM, TICKS, made
from tests.modules.mistakes import cases


@pytest.fixture(scope="module")
def sim():
    world = mjsim.parse_world(ROOM.replace('ROLE: {use: "bad.py:Bad"}', ""))
    with mjsim.Simulation(world) as sim:
        yield sim


def ended(sim, driver: mjsim.Driver, path: Path) -> str:
    """Return the fault that ends a run, once what was recorded is looked at."""
    sim.reset(1)
    with pytest.raises(mjsim.ModuleFault) as caught:
        mjsim.run(sim, drivers={"scout": driver}, record=path)
    assert caught.value.robot == "scout"
    line = str(caught.value)
    assert_recorded(path, line)
    return line


def assert_recorded(path: Path, line: str) -> None:
    """Look for what was recorded until a fault, and the fault."""
    if "at 0.00 s" in line:
        assert not path.exists()
        return
    recording = mjsim.read_recording(path)
    assert len(recording.time) == TICKS
    assert [event.text for event in recording.robots["scout"].events if event.kind == "fault"] == [line]


def test_the_table_has_more_than_forty_mistakes_of_all_roles():
    table = [case.values for case in cases()]
    assert len({text for _, text, _ in table}) > 40
    assert {role for role, *_ in table} == set(ASKED)


@pytest.mark.parametrize(("role", "module", "says"), cases())
def test_a_mistake_is_one_line_and_what_was_recorded_is_readable(sim, tmp_path, role, module, says):
    with warnings.catch_warnings():
        line = ended(sim, mjsim.Driver(**{role: made(module)}), tmp_path / "run.mcap")
    assert re.match(rf"{role} Bad of robot 'scout' {says}", line), line
    assert line.isprintable()


@pytest.mark.slow
@pytest.mark.parametrize(("role", "module", "says"), {case.values[0]: case for case in cases()}.values())
def test_on_the_command_line_it_is_that_line_and_exit_code_1(tmp_path, capsys, monkeypatch, role, module, says):
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM.replace("ROLE", role))
    Path("bad.py").write_text(module)
    with warnings.catch_warnings(), pytest.raises(SystemExit) as left:
        main(["run", "room.yaml", "-o", "run.mcap"])
    assert left.value.code == 1
    (line,) = (line for line in capsys.readouterr().err.splitlines() if not line.startswith("mjsim: run room"))
    assert re.match(rf"{role} Bad of robot 'scout' {says}", line), line
    assert_recorded(Path("run.mcap"), line)
