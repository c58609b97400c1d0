"""Runs jobs in processes on this machine; those that die are replaced, and none outlives its parent."""

import os
import signal
import threading
from collections import Counter, deque
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Self

from mjsim.sweep.bench import THREADS
from mjsim.sweep.store import Store
from mjsim.sweep.sweep_plan import Job
from mjsim.sweep.sweep_worker import Outcome, died, run_job

MAX_DEATHS = 3
"""Maximum number of attempts at a run whose process dies."""


def usable_cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run_on_processes(
    world_file: Path, jobs: Iterable[Job], store: Store, *, workers: int
) -> Generator[tuple[Job, Outcome], None, None]:
    """Yield each job with its outcome on completion.

    Args:
        world_file: World of the unpacked bundle.
        jobs: Jobs to run.
        store: Destination of recordings.
        workers: Number of processes.

    Raises:
        MjsimError: A problem would fail every run on this machine.
    """
    waiting, deaths = deque(jobs), Counter[Job]()
    with _environment(THREADS), ExitStack() as undo:
        free = [undo.enter_context(_Worker()) for _ in range(min(workers, len(waiting)))]
        busy: dict[Future[Outcome], tuple[_Worker, Job]] = {}
        while waiting or busy:
            while waiting and free:
                worker, job = free.pop(), waiting.popleft()
                busy[worker.submit(world_file, job, store)] = worker, job
            for future in wait(busy, return_when=FIRST_COMPLETED).done:
                worker, job = busy.pop(future)
                try:
                    outcome: Outcome | None = future.result()
                except BrokenProcessPool:
                    worker.close()
                    worker = undo.enter_context(_Worker())
                    deaths[job] += 1
                    if deaths[job] < MAX_DEATHS:
                        waiting.append(job)
                        outcome = None
                    else:
                        outcome = died(job, MAX_DEATHS)
                free.append(worker)
                if outcome is not None:
                    yield job, outcome


class _Worker:
    """A process that runs one job at a time. It ends when this object is closed, or when its parent ends."""

    def __init__(self) -> None:
        # Nothing is ever sent: the other side wakes when this side closes, for whatever reason.
        self._listening, self._lifeline = Pipe(duplex=False)
        self._executor = ProcessPoolExecutor(
            1, mp_context=get_context("spawn"), initializer=_begin, initargs=(self._listening,)
        )

    def submit(self, world_file: Path, job: Job, store: Store) -> Future[Outcome]:
        """Start a job, and the process with the first."""
        with _uninterrupted():
            return self._executor.submit(_work, world_file, job, store)

    def close(self) -> None:
        """End the process at once; a second call does nothing."""
        self._lifeline.close()
        self._executor.shutdown()
        self._listening.close()

    def __enter__(self) -> Self:
        """Return itself; the end of the block ends the process."""
        return self

    def __exit__(self, *error: object) -> None:
        """End the process."""
        self.close()


@contextmanager
def _uninterrupted() -> Iterator[None]:
    """Start processes in the block that ignore Ctrl-C, which reaches every process of a terminal; handle it afterwards.

    A process inherits which signals are blocked, not their handlers; `_begin` ignores this one.
    """
    if not hasattr(signal, "pthread_sigmask"):  # as on Windows
        yield
        return
    came: list[int] = []
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
    ours = threading.current_thread() is threading.main_thread()  # Python runs handlers there despite blocks.
    handler = signal.signal(signal.SIGINT, lambda number, _: came.append(number)) if ours else None
    try:
        yield
    finally:
        if ours:
            signal.signal(signal.SIGINT, handler)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    if came:
        raise KeyboardInterrupt


def _begin(listening: Connection) -> None:
    """Turn a new process into a worker."""
    # The parent process tells this one when to end.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))
    threading.Thread(target=_end_with, args=(listening,), daemon=True).start()


def _end_with(listening: Connection) -> None:
    with suppress(EOFError, OSError):
        listening.recv_bytes()
    os._exit(1)


def _work(world_file: Path, job: Job, store: Store) -> Outcome:
    with store.recording(job) as record:
        return run_job(world_file, job, record=record, pictures=store.keep)


@contextmanager
def _environment(variables: dict[str, str]) -> Iterator[None]:
    """Set environment variables in the block, so that processes started in it have them before they load anything."""
    before = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
