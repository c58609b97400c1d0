"""Processes that share the work of ray casting."""

import contextlib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from queue import SimpleQueue
from typing import IO, Any

from mjsim.errors import MjsimError
from mjsim.light.light_rays import Points
from mjsim.light.work import Surroundings, received, send

POINTS_PER_PART = 8192
"""Points in one part of the work, for any number of processes."""
MAX_PROCESSES = 4
"""Largest number of processes, to bound their memory."""
MAX_LONE_POINTS = 8 * POINTS_PER_PART
"""Number of points up to which this process does all work itself."""
ALONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment variables that give a process one thread."""
ENDED = "a process that bakes light has ended before its work was done; free some memory, or set shading: plain"


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
            function: A function of `work`.
            around: First argument of the function.
            at: Second argument, which is divided.
            arguments: Further arguments.
            done: Called with the number of points after each part.
        """
        parts = [at.some(slice(first, first + POINTS_PER_PART)) for first in range(0, len(at.points), POINTS_PER_PART)]

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
    """Return the number of processes that is worthwhile on this machine."""
    # On Windows and macOS a process cannot ask which processors it may use.
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(usable, MAX_PROCESSES)


class _Worker:
    """A process that waits for work."""

    def __init__(self, requests: IO[bytes], answers: IO[bytes]) -> None:
        self._requests, self._answers = requests, answers
        self._known: Surroundings | None = None

    def call(self, function: str, around: Surroundings, at: Points, arguments: tuple[Any, ...]) -> Any:
        """Return the result of a function of `work`; surroundings are sent when they change.

        Raises:
            MjsimError: The process has ended.
        """
        try:
            send(self._requests, (function, None if around is self._known else around, at, arguments))
            self._known = around
            return received(self._answers)
        except (EOFError, OSError) as error:
            raise MjsimError(ENDED) from error


@contextmanager
def _worker() -> Iterator[_Worker]:
    # Not `multiprocessing`: it would import the user's script once more. -P: files of the current folder do not
    # take the place of modules.
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "mjsim.light.ray_worker"],
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
