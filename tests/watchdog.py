"""Ends a process of tests that its own limits do not reach, and names the test; a program of its own.

    python watchdog.py PID

Reads lines `SECONDS WHAT` on standard input: what PID does from now on, and how long that may take; 0 is for ever.
"""

import os
import select
import signal
import sys
from pathlib import Path


def main(pid: int) -> None:
    """Watch a process until the pipe from it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the tests: this ends with them.
    rest, limit, what = b"", 0.0, ""
    while select.select([0], [], [], limit or None)[0]:
        if not (came := os.read(0, 65536)):
            return
        *lines, rest = (rest + came).split(b"\n")
        if lines:
            limit, what = float(lines[-1].split(b" ", 1)[0]), lines[-1].partition(b" ")[2].decode()
    told = f"\nwatchdog: {what} took more than {limit:g} s, and no limit within its process ended it; killed {pid}\n"
    os.write(2, told.encode())
    for each in [pid, *_offspring(pid)]:
        try:
            os.kill(each, signal.SIGKILL)
        except OSError:
            continue  # It has ended.


def _offspring(pid: int) -> list[int]:
    """Return all that a process started, and what these started, where the system tells."""
    parents = {}
    for place in Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(place.parent.name)] = int(place.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue  # It has ended.
    found = [pid]
    for one in found:
        found += [each for each, parent in parents.items() if parent == one]
    return found[1:]


if __name__ == "__main__":
    main(int(sys.argv[1]))
