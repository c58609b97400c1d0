"""Ends a process of tests that its own limits do not reach, and names the test; a program of its own.

    python watchdog.py PID FILE

FILE is the number of an open file: when PID must be done with what it does, by the clock that all processes share, 0
for never; how long that may take at most [s]; what it is.
"""

import mmap
import os
import select
import signal
import struct
import sys
import time
from pathlib import Path

LOOKING = 0.5
"""[s]"""


def main(pid: int, file: int) -> None:
    """Watch a process until the pipe from it closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the tests: this ends with them.
    told = mmap.mmap(file, mmap.PAGESIZE, prot=mmap.PROT_READ)
    ends = 0.0
    while not ends or time.monotonic() < ends:
        if select.select([0], [], [], LOOKING)[0]:
            return
        (ends,) = struct.unpack_from("d", told)
    limit, what = struct.unpack_from("d256p", told, 8)
    _end(pid, what.decode(errors="replace"), limit)


def _end(pid: int, what: str, limit: float) -> None:
    """Kill a process and all that it started, and say why."""
    told = f"\nwatchdog: {what} took more than {limit:g} s, and no limit within its process ended it; killed {pid}\n"
    os.write(2, told.encode())
    for each in [pid, *offspring(pid)]:
        try:
            os.kill(each, signal.SIGKILL)
        except OSError:
            continue  # It has ended.


def offspring(pid: int) -> list[int]:
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
    main(int(sys.argv[1]), int(sys.argv[2]))
