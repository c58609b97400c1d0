"""How far a command is: a bar on a terminal, plain lines elsewhere."""

import os
import pty
import sys
from contextlib import suppress

import pytest

from tests.children import child, completed

pytestmark = pytest.mark.slow  # Each starts a process.

PROGRAM = """
from mjsim.progress import tracked
with tracked("run room", total=4.0, unit="s") as advance:
    for done in (1.0, 2.0, 3.0, 4.0):
        advance(done)
"""

COUNTED = """
from mjsim.progress import counted
with counted("sweep room", total=4, unit="runs") as advance:
    for done in (1, 2, 3, 4):
        advance(done)
"""


def test_where_nobody_watches_one_plain_line_says_how_it_ended():
    done = completed([sys.executable, "-c", PROGRAM])
    assert done.stdout == ""
    assert done.stderr.startswith("mjsim: run room: 4 of 4 s in ")
    assert done.stderr.count("\n") == 1
    done = completed([sys.executable, "-c", PROGRAM.replace("4.0", "0.25")])
    assert done.stderr.startswith("mjsim: run room: 0.25 of 0.25 s in ")


def test_what_takes_long_is_counted_in_one_line_where_nobody_watches():
    done = completed([sys.executable, "-c", COUNTED])
    assert done.stderr == "mjsim: sweep room: 4 of 4 runs in 0 s\n"


def test_on_a_terminal_what_is_counted_has_a_bar_and_a_time_left():
    shown = on_a_terminal(COUNTED)
    assert "━" in shown
    assert "3 of 4 runs, 0 s left" in shown or "4 of 4 runs" in shown


def test_on_a_terminal_there_is_a_bar():
    shown = on_a_terminal(PROGRAM)
    assert "━" in shown
    assert "4/4 s" in shown


def on_a_terminal(program):
    """Run a program whose stderr is a terminal; return what that shows."""
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    with (
        child([sys.executable, "-c", program], stderr=theirs, env=environment) as process,
        os.fdopen(ours, "rb") as shown,
    ):
        os.close(theirs)
        said = b""
        with suppress(OSError):  # the other end has closed: all is read
            while chunk := shown.read1():
                said += chunk
        assert process.ended() == 0
    return said.decode()
