"""The work of ray casting, divided among processes: each part of the work is one call of a function here."""

import contextlib
import os
import pickle
import struct
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from queue import SimpleQueue
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from mjsim.light.charts import Charts
from mjsim.light.rays import Light, Numbers, Points, Rectangle, Room, behind_share, hemisphere, light_of, starts_of

PART = 8192
"""Points in one part of the work, for any number of processes."""
MOST_PROCESSES = 4
"""Largest number of processes, to bound their memory."""
FEW = 8 * PART
"""Number of points up to which this process does all work itself."""
ALONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment variables that give a process one thread."""
_LENGTH = struct.Struct("<q")


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """A room, and which cell of its surfaces rays hit."""

    room: Room
    names: Numbers
    """Triangle of the charts of each triangle of the room; `PORTAL` for windows, shape (n,)."""
    charts: Charts
    cells: NDArray[np.int32]
    """Cell of each texel of the atlas; row after row."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """What the rays of some points hit."""

    hits: NDArray[np.int32]
    """Cell of each ray, `count` where it brings nothing, shape (rays, n)."""
    sky: Light
    """Share of rays that reach the sky, shape (n,)."""
    behind: Light
    """Share of rays that hit a surface from behind, shape (n,)."""


def behind(around: Surroundings, at: Points, side: int) -> Light:
    """Return the share of rays that hit a surface from behind, shape (n,)."""
    return behind_share(around.room, at, side)


def lit(around: Surroundings, at: Points, rectangles: Sequence[Rectangle], colors: Light) -> Light:
    """Return the light of rectangles.

    Args:
        around: The room.
        at: Points on its surfaces.
        rectangles: Lamps and windows.
        colors: How much each adds to each of some sums, shape (rectangles, k).

    Returns:
        The sums, shape (n, k).
    """
    total = np.zeros((len(at.points), colors.shape[1]), np.float32)
    for rectangle, color in zip(rectangles, colors, strict=True):
        total += light_of(around.room, at, rectangle)[:, None] * color
    return total


def gathered(around: Surroundings, at: Points, side: int, count: int) -> Gathered:
    """Return what side x side rays of each point hit; `count` is the number of cells."""
    starts = starts_of(at)
    hits = np.full((side * side, len(starts)), count, np.int32)
    sky, back = np.zeros(len(starts), np.float32), np.zeros(len(starts), np.float32)
    for row, directions in zip(hits, hemisphere(at, side), strict=True):
        triangles, distances, behind = around.room.first(starts, directions)
        found = np.flatnonzero(triangles >= 0)
        names = around.names[triangles[found]]
        lit = (names >= 0) & ~behind[found]
        lit[lit] = around.charts.of[names[lit]] >= 0
        found, names = found[lit], names[lit]
        texels = around.charts.texel(
            starts[found] + distances[found, None] * directions[found], around.charts.of[names]
        )
        row[found] = around.cells[texels]
        sky += (triangles < 0) & (directions[:, 2] > 0.0)
        back += behind
    share = np.float32(1.0 / len(hits))
    return Gathered(hits, sky * share, back * share)


class Crew:
    """Processes that share the work; this process alone if there are no others."""

    def __init__(self, workers: Sequence["_Worker"]) -> None:
        """Use processes that are running."""
        self._free: SimpleQueue[_Worker] = SimpleQueue()
        for worker in workers:
            self._free.put(worker)
        self._pool = ThreadPoolExecutor(len(workers)) if workers else None

    def run(
        self,
        function: Callable[..., Any],
        around: Surroundings,
        at: Points,
        *arguments: Any,
        done: Callable[[int], None] = lambda count: None,
    ) -> list[Any]:
        """Return the results of a function for all parts of some points, in their order.

        Args:
            function: A function of this module.
            around: Its first argument.
            at: Its second, which is divided.
            arguments: The rest.
            done: Called with the number of points after each part.
        """
        parts = [at.some(slice(first, first + PART)) for first in range(0, len(at.points), PART)]

        def one(part: Points) -> Any:
            if self._pool is None:
                return function(around, part, *arguments)
            worker = self._free.get()
            try:
                return worker.call(function.__name__, around, part, arguments)
            finally:
                self._free.put(worker)

        results = []
        for part, result in zip(
            parts, map(one, parts) if self._pool is None else self._pool.map(one, parts), strict=True
        ):
            results.append(result)
            done(len(part.points))
        return results

    def close(self) -> None:
        """End the threads; the processes end by themselves."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)


@contextmanager
def crew_of(processes: int) -> Iterator[Crew]:
    """Start processes for the duration of a block."""
    with contextlib.ExitStack() as stack:
        workers = [stack.enter_context(_worker()) for _ in range(processes if processes > 1 else 0)]
        crew = Crew(workers)
        stack.callback(crew.close)
        yield crew


def processors() -> int:
    """Return how many processes are worth while on this machine."""
    # Windows and macOS do not tell which processors a process may use.
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(usable, MOST_PROCESSES)


class _Worker:
    """A process that waits for work."""

    def __init__(self, requests: IO[bytes], answers: IO[bytes]) -> None:
        self._requests, self._answers = requests, answers
        self._known: Surroundings | None = None

    def call(self, function: str, around: Surroundings, at: Points, arguments: tuple[Any, ...]) -> Any:
        """Return the result of a function of this module; surroundings are sent when they change."""
        _send(self._requests, (function, None if around is self._known else around, at, arguments))
        self._known = around
        return _received(self._answers)


@contextmanager
def _worker() -> Iterator[_Worker]:
    # Not `multiprocessing`: it would import the user's script once more.
    process = subprocess.Popen(
        [sys.executable, "-m", "mjsim.light.worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **ALONE},
        # The terminal's Ctrl-C reaches the parent alone, which then ends the child.
        start_new_session=sys.platform != "win32",
    )
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        yield _Worker(process.stdin, process.stdout)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
        with contextlib.suppress(OSError):
            process.stdin.close()


def serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Do the work of a parent process until it closes the pipe."""
    functions: dict[str, Callable[..., Any]] = {each.__name__: each for each in (behind, lit, gathered)}
    around: Surroundings | None = None
    while True:
        try:
            function, sent, at, arguments = _received(requests)
        except EOFError:
            return
        around = sent or around
        _send(answers, functions[function](around, at, *arguments))


def _send(pipe: IO[bytes], value: Any) -> None:
    data = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.write(_LENGTH.pack(len(data)))
    pipe.write(data)
    pipe.flush()


def _received(pipe: IO[bytes]) -> Any:
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        raise EOFError
    return pickle.loads(pipe.read(*_LENGTH.unpack(head)))  # from a process of our own
