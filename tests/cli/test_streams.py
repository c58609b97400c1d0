"""Standard output that is full, closed, or read no more; a terminal that is gone; names that are no UTF-8."""

import os
import shlex
import signal
import subprocess
import sys
import time

import pytest

import mjsim
from mjsim.progress import say
from tests.children import child

pytestmark = pytest.mark.slow  # Each starts a process.

MJSIM = f"{shlex.quote(sys.executable)} -m mjsim.cli"
ROOM = "mjsim: 1\nname: room\nrobots: [{name: r, preset: pioneer3dx, at: [1, 1]}]\nrun: {seconds: 0.1}\n"


def typed(line, folder):
    """Return exit code, and standard error, of a line of bash."""
    made = subprocess.run(
        ["bash", "-o", "pipefail", "-c", line], cwd=folder, capture_output=True, timeout=100, check=False
    )
    return made.returncode, made.stderr.decode(errors="replace")


FULL = "mjsim: cannot write to standard output: No space left on device\n"


@pytest.mark.parametrize("command", ["schema", "worlds", "--help", "--version"])
def test_a_full_standard_output_is_one_line(tmp_path, command):
    assert typed(f"{MJSIM} {command} > /dev/full", tmp_path) == (2, FULL)


def test_an_output_that_nobody_reads_ends_the_command_quietly(tmp_path):
    assert typed(f"{MJSIM} worlds | true", tmp_path) == (141, "")


def test_a_closed_standard_output_is_refused_before_anything_is_opened(tmp_path):
    line = "mjsim: standard output is closed; redirect it to a file, or to /dev/null\n"
    assert typed(f"{MJSIM} schema >&-", tmp_path) == (2, line)


def test_a_run_without_standard_error_is_recorded(tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    assert typed(f"{MJSIM} run room.yaml -o run.mcap 2>&-", tmp_path) == (0, "")
    assert mjsim.read_recording(tmp_path / "run.mcap").whole


def test_errors_that_cannot_be_told_still_have_their_exit_code(tmp_path):
    assert typed(f"{MJSIM} check none.yaml 2>/dev/full", tmp_path) == (2, "")


def test_a_world_whose_name_is_no_utf_8_is_checked_and_run(tmp_path):
    name = os.fsdecode(b"room\xff.yaml")
    (tmp_path / name).write_text(ROOM)
    (tmp_path / os.fsdecode(b"bad\xff.yaml")).write_text("mjsim: 1\nwals: []\n")
    recording = os.fsdecode(b"run\xff.mcap")
    assert typed(f"LC_ALL=C.UTF-8 {MJSIM} run $'room\\xff.yaml' -o $'run\\xff.mcap'", tmp_path)[0] == 0
    assert r"room\udcff.yaml" in mjsim.read_recording(tmp_path / recording).metadata["command"]
    code, err = typed(f"{MJSIM} check $'bad\\xff.yaml'", tmp_path)
    assert (code, len(err.splitlines()), "unknown key 'wals'" in err) == (2, 1, True)


def test_under_nohup_a_hang_up_is_ignored_and_a_termination_is_not(tmp_path):
    (tmp_path / "room.yaml").write_text(ROOM)
    words = [*shlex.split(MJSIM), "run", "room.yaml", "--seconds", "600", "--realtime", "-o", "run.mcap"]
    with child(words, cwd=tmp_path, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) as process:
        while not any(tmp_path.glob("*.mcap")) and process.runs():
            process.send(signal.SIGHUP)
            time.sleep(0.1)
        process.send(signal.SIGTERM)
        assert process.ended() == 143
    assert mjsim.read_recording(tmp_path / "run.mcap").whole


def test_a_message_without_a_place_to_go_is_lost(monkeypatch):
    monkeypatch.setattr(sys, "stderr", None)
    say("lost")
    full = open("/dev/full", "w")  # noqa: SIM115  # closing it fails
    monkeypatch.setattr(sys, "stderr", full)
    say("lost")
    with pytest.raises(OSError, match="No space left"):
        full.close()
