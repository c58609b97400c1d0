#!/usr/bin/env python3
"""Measure how long Python takes to start mjsim, in multiples of what it takes to start and import NumPy.

    .venv/bin/python scripts/measure/start.py [--runs 15] [--cpu]

Whole processes from their start to their end, in turns, after one run of each that writes the bytecode; medians. The
last column is the limit that the project sets. The last case is what the studio loads before it prints its address.
"""

import argparse
import os
import statistics
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
MJSIM = str(Path(sys.executable).with_name("mjsim"))
CASES = {
    "import numpy": (sys.executable, "-c", "import numpy"),
    "import mjsim": (sys.executable, "-c", "import mjsim"),
    "mjsim --help": (MJSIM, "--help"),
    "mjsim check gallery": (MJSIM, "check", str(ROOT / "worlds" / "gallery.yaml")),
    "address of the studio": (
        sys.executable,
        "-c",
        "import mjsim.cli.studio_command as s, mjsim.web.studio; s.opened('gallery')",
    ),
}
MOST = {"import mjsim": 3.0, "mjsim --help": 3.5, "mjsim check gallery": 3.5, "address of the studio": 5.5}
"""Times the first case."""


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=15)
    parser.add_argument("--cpu", action="store_true", help="processor time, for a busy machine")
    given = parser.parse_args()
    seconds: dict[str, list[float]] = {name: [] for name in CASES}
    for run in range(given.runs + 1):
        for name, command in CASES.items():
            took = once(command, cpu=given.cpu)
            if run:
                seconds[name].append(took)
    numpy = statistics.median(seconds["import numpy"])
    for name, values in seconds.items():
        median = statistics.median(values)
        asked = f"  at most {MOST[name]}" if name in MOST else ""
        print(f"{name:<22}{1e3 * median:7.0f} ms{median / numpy:7.2f}{asked}")


def once(command: tuple[str, ...], *, cpu: bool) -> float:
    """Return how long a process takes [s]: on the clock, or of the processors."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    start = time.perf_counter()
    process = os.posix_spawn(command[0], command, environment, file_actions=quiet)
    _, status, used = os.wait4(process, 0)
    took = time.perf_counter() - start
    if status:
        raise SystemExit(f"{' '.join(command)} failed")
    return used.ru_utime + used.ru_stime if cpu else took


if __name__ == "__main__":
    main()
