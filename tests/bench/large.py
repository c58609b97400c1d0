"""Large worlds: how long they take to be read, checked and compiled, and how much memory that needs."""

import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from mjsim.bench.figure import Once, Prepare
from mjsim.compile import compile_world
from mjsim.world import load_checked

ROOM = """\
  - name: room{n}
    points: [[{x}, {y}], [{x6}, {y}], [{x6}, {y5}], [{x}, {y5}]]
    closed: true
    thickness: 0.12
    openings: [{{at: 1, width: 0.9}}, {{segment: 2, at: 1, width: 1.2, sill: 0.9, head: 2}}]
  - points: [[{x3}, {y}], [{x3}, {y5}]]
    color: "#b8c4c8"
    openings: [{{at: 2, width: 0.9}}]
"""
"""Five segments: a room with a door and a window, and a wall across it with a door."""


def large_floor(segments: int) -> str:
    """Return the text of a world of so many wall segments: rooms of 6 m x 5 m in a square, 5 segments each."""
    count = segments // 5
    across = max(1, round(count**0.5))
    rooms = []
    for n in range(count):
        x, y = 7 * (n % across), 6 * (n // across)
        rooms.append(ROOM.format(n=n, x=x, y=y, x3=x + 3, x6=x + 6, y5=y + 5))
    return f"mjsim: 1\nname: floor\nwalls:\n{''.join(rooms)}robots: [{{name: scout, at: [1.5, 1.5]}}]\n"


def made_ready(path: Path) -> float:
    """Return how long a world takes until MuJoCo can run it, processor time [s]."""
    began = time.process_time()
    compile_world(load_checked(path)).compile()
    return time.process_time() - began


def peak_memory() -> float:
    """Return the most memory that this process has had [MB]."""
    status = Path("/proc/self/status")
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    # What getrusage tells on Linux is at least what the process that started this one had.
    (line,) = (line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
    return float(line.split()[1]) / 1024


def in_its_own_process(path: Path) -> tuple[float, float]:
    """Return how long a world takes in a new process [s], and the most memory that it has had there [MB]."""
    code = (
        "import sys, pathlib; from mjsim.bench.large import made_ready, peak_memory;"
        "print(made_ready(pathlib.Path(sys.argv[1])), peak_memory())"
    )
    said = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True, timeout=600
    ).stdout
    seconds, megabytes = map(float, said.split())
    return seconds, megabytes


def large(segments: int, *, memory: bool) -> Prepare:
    """Measure a world of so many wall segments: the processor time that it takes, or the memory."""

    @contextmanager
    def prepare() -> Iterator[Once]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "floor.yaml"
            path.write_text(large_floor(segments), encoding="utf-8")
            yield lambda _: in_its_own_process(path)[memory]

    return prepare
