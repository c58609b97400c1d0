"""`mjsim run --live`: the page steers the run of a shell, which ends, fails and is interrupted as any other."""

import re
import signal
import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

import mjsim
from mjsim.record import same_run
from tests.browser import browser
from tests.children import child
from tests.cli.shell import typed

pytestmark = pytest.mark.slow
ROOM = """
mjsim: 1
name: room
walls: [{points: [[0, 0], [4, 0], [4, 3], [0, 3]], closed: true}]
robots: [{name: scout, preset: pioneer3dx, at: [1, 1.5], odometry: {noise: {distance: 0.01}}}]
run:
  seconds: 600
  drivers: {scout: {navigator: {use: "forward.py:Forward"}, avoidance: true}}
"""
FORWARD = """
import mjsim

class Forward:
    def start(self, robot, map, rng):
        pass
    def command(self, seen, belief):
        assert seen.time < 1.0, "far enough"
        return mjsim.Command(0.3)
"""


@pytest.fixture
def room(tmp_path, monkeypatch):
    """A folder with a world and its navigator, which is the working one."""
    monkeypatch.chdir(tmp_path)
    Path("room.yaml").write_text(ROOM)
    Path("forward.py").write_text(FORWARD)


@contextmanager
def shell(*words):
    """Start a live run in a shell; yield it and the address of its page."""
    with child([sys.executable, "-m", "mjsim.cli", "run", "room.yaml", "--live", *words]) as process:
        yield process, re.search(r"http://127\.0\.0\.1:\S+", process.line("stderr"))[0]


def test_the_page_steers_the_run_and_its_recording_is_that_of_a_plain_one(room):
    with shell("-o", "live.mcap", "--realtime") as (process, url), browser(url) as seen:
        assert seen.until("run", state="running")["controllable"]
        seen.until("tick")
        seen.say("pause")
        seen.until("run", state="paused")
        for _ in range(3):
            seen.say("tick")
        seen.say("stop")
        seen.until("run", state="ended")
        assert process.ended() == 0, process.rest("stderr")
    live = mjsim.read_recording("live.mcap")
    assert live.whole
    with mjsim.Simulation(mjsim.load_world("room.yaml")) as sim:
        mjsim.run(sim, seconds=len(live.time) * sim.dt, record="plain.mcap")
    assert same_run(Path("live.mcap"), Path("plain.mcap"))


def test_ctrl_c_ends_a_live_run_as_any_other_even_when_it_is_paused(room):
    with shell("-o", "run.mcap", "--realtime") as (process, url), browser(url) as seen:
        seen.until("tick")
        seen.say("pause")
        seen.until("run", state="paused")
        process.send(signal.SIGINT)
        assert process.ended() == 130
        err = process.rest("stderr")
    assert "Traceback" not in err
    assert err.splitlines()[-1] == "mjsim: interrupted; anything recorded so far is closed and readable"
    assert mjsim.read_recording("run.mcap").whole


def test_a_module_that_fails_ends_a_live_run_with_its_one_line(room, capsys):
    code, _, err = typed("run", "room.yaml", "--live", "-o", "run.mcap", capsys=capsys)
    assert code == 1
    assert err.splitlines()[-1].startswith("navigator Forward of robot 'scout' at 1.00 s raised AssertionError")
    assert len(mjsim.read_recording("run.mcap").time) == 25
