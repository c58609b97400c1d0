"""Programs end with who started them, and their last answer counts."""

import signal
import sys
import time
from pathlib import Path

import pytest

from mjsim.modules.foreign import ON_STANDARD, Ended, Process, ShownOutput
from tests.children import child
from tests.modules.processes import gone, left_running
from tests.modules.test_programs import room, script

DAEMON = """
import os, sys
for _ in range(3):
    if os.fork() == 0:
        os.setsid()
        if os.fork() == 0:
            os.execv("/bin/sh", ["sh", "-c", "sleep 60079 </dev/null >/dev/null 2>&1; : " + sys.argv[1]])
        os._exit(0)
for line in sys.stdin:
    print('{"pictures": false}' if '"start"' in line else ANSWER, flush=True)
"""


@pytest.mark.skipif(not Path("/proc/self/environ").exists(), reason="daemons are found where /proc has environments")
@pytest.mark.parametrize(
    "answer",
    ["'{\"forward\": 1}'", "'no JSON'", pytest.param("__import__('time').sleep(60078)", marks=pytest.mark.slow)],
)
def test_a_program_and_its_daemons_end_with_who_started_it_even_when_that_is_killed(tmp_path, answer):
    script(tmp_path, "bad", DAEMON.replace("ANSWER", answer))
    room(tmp_path, f"navigator: {{use: 'exec:./bad {tmp_path}', patience: 60}}")
    words = [sys.executable, "-m", "mjsim.cli", "run", str(tmp_path / "room.yaml"), "-o", str(tmp_path / "run.mcap")]
    with child(words) as parent:
        until = time.monotonic() + 30
        while "sleep" in answer and len(left_running("sleep 60079")) < 3 and time.monotonic() < until:
            time.sleep(0.05)
        if "sleep" in answer:
            parent.kill()
    assert gone(f": {tmp_path}")
    assert gone(f"bad {tmp_path}")


class Preempted(Process):
    """A process that has ended by the time it is found that it says nothing: a busy machine ran it in between."""

    def _has_ended(self) -> bool:
        time.sleep(0.5)
        return super()._has_ended()


def test_an_answer_that_comes_with_the_end_of_a_program_counts(tmp_path):
    with Preempted(
        ["sh", "-c", "sleep 0.2; echo done"], tmp_path, shell=ON_STANDARD, output=ShownOutput("x")
    ) as program:
        assert program.exchange(b"{}\n", lambda got: got.find(b"\n") + 1, patience=20) == b"done\n"
        with pytest.raises(Ended, match="ended with exit code 0 before it answered"):
            program.exchange(b"{}\n", lambda got: got.find(b"\n") + 1, patience=20)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="asks a system that shows which signals are ignored")
def test_a_program_begins_with_signals_at_their_defaults_whatever_this_process_ignores(tmp_path):
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # as in jobs that a script starts with '&'
    words = ["sh", "-c", "read -r _; exec grep SigIgn /proc/self/status"]
    try:
        with Process(words, tmp_path, shell=ON_STANDARD, output=ShownOutput("x")) as program:
            shown = program.exchange(b"{}\n", lambda got: got.find(b"\n") + 1, patience=20)
    finally:
        signal.signal(signal.SIGINT, before)
    assert int(shown.split()[1], 16) & 0x7FFFFFFF == 0  # the others are of the C library itself
