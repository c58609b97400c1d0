"""Figures that modules in .m files draw: in sweeps, and in sessions such as those of the studio."""

import shutil
import sys
from functools import partial

import pytest

import mjsim
from mjsim.session import Session
from mjsim.toolbox import figures_told
from tests.children import completed

pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(300),
    pytest.mark.skipif(shutil.which("octave-cli") is None, reason="no Octave here"),
]
WORLD = """mjsim: 1
robots: [{name: scout, preset: pioneer3dx, at: [0, 0]}]
run: {seconds: 0.4, drivers: {scout: {navigator: {use: turn.m}}}}
"""
TURN = """function [cmd, state] = turn(obs, est, robot, state)
cmd.forward = 0.1; cmd.turn = 0.2;
state(end + 1) = obs.time;
if numel(state) == 5, figure(3); plot(state, 2 * state); xlabel('time [s]'); end
end
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "w.yaml").write_text(WORLD)
    (tmp_path / "turn.m").write_text(TURN)
    return tmp_path


def test_each_run_of_a_sweep_keeps_the_figures_of_its_modules(folder):
    command = [sys.executable, "-m", "mjsim.cli", "sweep", "w.yaml", "--seeds", "0:2", "--workers", "1", "-o", "s"]
    done = completed(command, cwd=folder, check=False)
    assert done.returncode == 0, done.stderr
    found = sorted(str(file.relative_to(folder / "s" / "runs")) for file in (folder / "s").rglob("turn-figure-3.*"))
    runs = sorted({name.partition("/")[0] for name in found})
    assert len(runs) == 2
    assert all(name.endswith("-figures") for name in runs)
    assert [name.rpartition(".")[2] for name in found] == ["pdf", "png"] * 2
    assert list(folder.glob("s/runs/*.mcap")) == []


def test_a_session_keeps_the_figures_of_each_run_that_it_records(folder):
    world, told = mjsim.load_world(folder / "w.yaml"), []
    around = partial(figures_told, world.run, overwrite=False, tell=told.append)
    with Session(world, record=folder / "r.mcap", around=around) as session:
        session.wait(timeout=60.0)
        session.restart()
        assert session.wait("running", "ended") in ("running", "ended")
        session.wait(timeout=60.0)
    names = sorted(str(file.relative_to(folder)) for file in folder.rglob("turn-figure-3.png"))
    assert names == ["r-2-figures/turn-figure-3.png", "r-figures/turn-figure-3.png"]
    assert sorted(line for line in told if line.endswith("png")) == [str(folder / name) for name in names]
