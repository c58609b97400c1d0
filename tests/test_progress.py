"""How far a command is: a bar on a terminal, plain lines elsewhere."""

import os
import pty
import subprocess
import sys

PROGRAM = """
from mjsim.progress import tracked
with tracked("run room", total=4.0, unit="s") as advance:
    for done in (1.0, 2.0, 3.0, 4.0):
        advance(done)
"""


def test_where_nobody_watches_one_plain_line_says_how_it_ended():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert done.stdout == ""
    assert done.stderr.startswith("mjsim: run room: 4 of 4 s in ")
    assert done.stderr.count("\n") == 1


def test_on_a_terminal_there_is_a_bar():
    ours, theirs = pty.openpty()
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "100"}
    process = subprocess.Popen([sys.executable, "-c", PROGRAM], stderr=theirs, env=environment)
    os.close(theirs)
    shown = b""
    try:
        while chunk := os.read(ours, 4096):
            shown += chunk
    except OSError:
        pass  # the other end has closed: all is read
    assert process.wait(timeout=30) == 0
    os.close(ours)
    assert "━" in shown.decode()
    assert "4/4 s" in shown.decode()
