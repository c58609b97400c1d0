"""What modules do to the process that hosts them: a command puts it back, or says in a line what it cannot."""

import locale
import os
import signal
import sys
from contextlib import ExitStack, suppress

import numpy as np
import pytest

import mjsim
from mjsim.modules import hosting
from tests.children import child, completed

CODE = """
import mjsim, os, subprocess, sys, time
class M:
    ticks = 0
    def start(self, *told): pass
    def command(self, seen, belief):
        self.ticks += 1
        if self.ticks == 3:
            DO
        return mjsim.Command(0.1)
"""
WORLD = """
mjsim: 1
name: room
robots: [{name: r, preset: pioneer3dx, at: [1, 1], odometry: {noise: {distance: 0, turn: 0}}}]
run: {seconds: 0.4, drivers: {r: {navigator: {use: "m.py:M"}}}}
"""
SLEEP = "subprocess.Popen(['sleep', '600'])"


def ran(folder, do):
    """Return exit code, standard output and error, and the recorded ticks, of a run whose module does something."""
    (folder / "m.py").write_text(CODE.replace("DO", do))
    (folder / "room.yaml").write_text(WORLD)
    words = [sys.executable, "-m", "mjsim.cli", "run", "room.yaml"]
    made = completed(words, check=False, cwd=folder)
    recording = folder / "out" / "room" / "run.mcap"
    return made, len(mjsim.read_recording(recording).time) if recording.exists() else 0


GOES_ON = {
    "another working directory, no standard output, and copies that return and exit": (
        "os.chdir('/'); os.close(1); sys.stdout = 'text'; os.fork(); os.fork() or sys.exit(0)"
    ),
    "a working directory that is gone": "os.mkdir('gone'); os.chdir('gone'); os.rmdir('../gone'); sys.stdout.close()",
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", GOES_ON)
def test_the_run_goes_on_and_its_recording_is_told(tmp_path, kind):
    made, ticks = ran(tmp_path, GOES_ON[kind])
    assert (made.returncode, made.stdout, ticks) == (0, "out/room/run.mcap\n", 10)
    assert "Traceback" not in made.stderr


@pytest.mark.slow
def test_no_process_of_a_module_outlives_the_run(tmp_path):
    daemon = f"os.fork() or (os.setsid(), {SLEEP}, os._exit(0))"
    # It returns when nobody holds its standard output any more.
    made, ticks = ran(tmp_path, f"{SLEEP}; os.fork() or time.sleep(600); {daemon}")
    assert (made.returncode, ticks) == (0, 10)
    line = "mjsim: ended what modules left running: "
    assert made.stderr.splitlines()[-1].startswith(line)
    assert "sleep (2)" in made.stderr


@pytest.mark.slow
def test_a_module_that_closes_the_recording_is_named_with_its_robot_and_time(tmp_path):
    made, _ = ran(tmp_path, "os.closerange(3, 1000)")
    assert made.returncode == 1
    line = "navigator M of robot 'r' at 0.08 s closed files of the simulator; close only your own (m.py:6)"
    assert made.stderr.splitlines() == [line]


def test_what_would_end_the_process_as_if_the_run_were_complete_is_an_error_and_copies_end_by_it():
    usual = os._exit
    with hosting():
        for ends, name in [
            (lambda: os._exit(0), "_exit"),
            (lambda: os.execv("/bin/true", ["true"]), "execv"),
            (lambda: os.execlp("true", "true"), "execv"),
            (lambda: os.execle("/bin/true", "true", {}), "execve"),
        ]:
            with pytest.raises(RuntimeError, match=rf"^os.{name} ends the whole program; return, or raise an error$"):
                ends()
        copy = os.fork() or os._exit(3)
        assert os.waitstatus_to_exitcode(os.waitpid(copy, 0)[1]) == 3
    assert os._exit is usual


def test_what_a_block_changes_is_put_back(tmp_path):
    def state():
        mask = os.umask(0o022)
        os.umask(mask)
        handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
        return [
            os.getcwd(),
            np.geterr(),
            sys.getrecursionlimit(),
            mask,
            handlers,
            sys.stdout,
            locale.setlocale(locale.LC_ALL),
        ]

    before = state()
    with hosting():
        os.chdir(tmp_path)
        np.seterr(all="raise")
        sys.setrecursionlimit(5000)
        os.umask(0o777)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        sys.stdout = None
        locale.setlocale(locale.LC_ALL, "C")
        assert state() != before
    assert state() == before


def test_processes_that_a_block_leaves_are_ended_and_those_before_it_stay(capsys):
    with ExitStack() as owned:
        before = owned.enter_context(child(["sleep", "600"]))
        with hosting():
            left = owned.enter_context(child(["sh", "-c", "sleep 600 & setsid sleep 600 & wait"]))
        left.process.returncode = -signal.SIGKILL
        assert before.runs()
    assert "mjsim: ended what modules left running: " in capsys.readouterr().err
    with suppress(ProcessLookupError):
        os.kill(left.pid, 0)
        pytest.fail("it is still there")
