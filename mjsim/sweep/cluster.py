"""Runs jobs on a Dask cluster: files are sent there, results and recordings are sent back."""

import tempfile
import warnings
from collections.abc import Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from mjsim.errors import MjsimError, UsageError, how_to_install
from mjsim.sweep.bundle import Bundle
from mjsim.sweep.store import Store, versions
from mjsim.sweep.sweep_plan import Job
from mjsim.sweep.sweep_worker import Outcome, died, run_job

if TYPE_CHECKING:
    from distributed import Client

ANSWERS_WITHIN = 20.0
"""Maximum time for a scheduler to answer [s]."""
COMES_WITHIN = 300.0
"""Maximum time until the first worker is available [s]; workers may wait in the queue of a cluster."""


def run_on_cluster(
    address: str, bundle: Bundle, jobs: Iterable[Job], store: Store
) -> Generator[tuple[Job, Outcome], None, None]:
    """Yield each job with its outcome on completion. If a worker dies, Dask gives its job to another.

    Args:
        address: Address of the scheduler, such as tcp://10.0.0.5:8786.
        bundle: Files for the runs.
        jobs: Jobs to run.
        store: Destination of recordings.

    Raises:
        UsageError: The cluster does not exist, or its workers are unsuitable.
        MjsimError: The cluster disappeared, or a worker has a problem that would fail every run.
    """
    with _client(address) as client:
        from distributed import KilledWorker, as_completed

        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", message="Sending large graph")
            # A task like any other: if all workers with the files die, the next ones receive them again.
            files = client.submit(_hand_on, bundle, pure=False)
        futures = {client.submit(_work, files, job, store.keep, versions(), pure=False): job for job in jobs}
        for future in as_completed(futures, loop=client.loop):
            job = futures[future]
            try:
                outcome, made = future.result()
            except KilledWorker as error:
                outcome, made = died(job, int(error.allowed_failures) + 1), {}
            except CancelledError as error:
                raise MjsimError(
                    f"the Dask cluster at {address} is no longer reachable; repeat the command to resume"
                ) from error
            finally:
                future.release()
            for name, content in made.items():
                store.write(f"runs/{name}", content)
            yield job, outcome


@contextmanager
def _client(address: str) -> Iterator["Client"]:
    try:
        from distributed import Client
        from distributed.comm.addressing import parse_address, parse_host_port
    except ModuleNotFoundError as error:
        raise UsageError(f"Dask is not installed here; type: {how_to_install('distributed')}") from error
    try:
        parse_host_port(parse_address(address)[1])  # A client would leave threads behind before it notices the error.
    except ValueError as error:
        raise UsageError(
            f"'{address}' is not the address of a Dask scheduler; write it as tcp://10.0.0.5:8786"
        ) from error
    try:
        client = Client(address, timeout=ANSWERS_WITHIN, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(f"no Dask scheduler answers at '{address}'; start one with: dask scheduler") from error
    with client:
        try:
            client.wait_for_workers(1, timeout=COMES_WITHIN)
        except TimeoutError as error:
            line = f"dask worker {address} --nworkers 2 --nthreads 1"
            raise UsageError(f"no worker at '{address}'; start some with: {line}") from error
        yield client


def _hand_on(bundle: Bundle) -> Bundle:
    return bundle


def _work(bundle: Bundle, job: Job, keep: bool, expected: dict[str, str]) -> tuple[Outcome, dict[str, bytes]]:
    """Run a job on a worker; return its outcome, and by name its figures and, if requested, its recording."""
    from distributed import get_worker

    worker = get_worker()
    if worker.state.nthreads != 1:
        threads = worker.state.nthreads
        raise UsageError(f"Dask worker {worker.address} has {threads} threads; start it with --nthreads 1")
    for name, installed in versions().items():
        if installed != expected[name]:
            raise UsageError(f"Dask worker {worker.address} has {name} {installed}; the sweep needs {expected[name]}")
    world_file = Path(_unpacked(bundle, worker.local_directory).name) / bundle.main
    with tempfile.TemporaryDirectory(dir=worker.local_directory) as folder:
        record = Path(folder) / "run.mcap"
        outcome = run_job(world_file, job, record=record, pictures=keep)
        made = {f"{job.name}-figures/{file.name}": file.read_bytes() for file in Path(folder).glob("*-figures/*")}
        return outcome, made | ({f"{job.name}.mcap": record.read_bytes()} if keep and record.is_file() else {})


@lru_cache(maxsize=1)  # A worker keeps the bundle of one sweep, and runs of another sweep rarely come in between.
def _unpacked(bundle: Bundle, folder: str) -> "tempfile.TemporaryDirectory[str]":
    place = tempfile.TemporaryDirectory(dir=folder, prefix="mjsim-world-")
    bundle.unpack(Path(place.name))
    return place
