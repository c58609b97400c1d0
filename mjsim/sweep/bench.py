"""State that a process keeps between its runs, and state that it must reset."""

import functools
import os
import random
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import cv2
import numpy as np

from mjsim.modules import INSTALLED
from mjsim.sweep.sweep_plan import Job
from mjsim.world import load_world, with_settings

if TYPE_CHECKING:
    from mjsim.sim import Simulation

THREADS = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "LP_NUM_THREADS": "1"}
"""Environment variables that limit a worker to one core: for BLAS and software OpenGL."""


class KeptSimulation:
    """The simulation of the last run, reused for other seeds of the same case."""

    def __init__(self) -> None:
        self._case: tuple[Path, tuple[str, ...]] | None = None
        self._sim: Simulation | None = None

    @contextmanager
    def simulation(self, world_file: Path, job: Job) -> Iterator["Simulation"]:
        """Yield a simulation for a job; it is not reused after a failed run."""
        case = (world_file, job.settings)
        if self._sim is not None and case == self._case:
            self._sim.reset(job.seed)
        else:
            from mjsim.sim import Simulation

            self.clear()
            self._sim = Simulation(with_settings(load_world(world_file), job.settings), seed=job.seed)
            self._case = case
        try:
            yield self._sim
        except BaseException:
            self.clear()
            raise

    def clear(self) -> None:
        """Close the kept simulation."""
        sim, self._sim = self._sim, None
        if sim is not None:
            sim.close()


@functools.cache  # Constant in a process, like its single OpenGL library.
def bench() -> KeptSimulation:
    """Return the kept state of this process."""
    return KeptSimulation()


@functools.cache  # Constant in a process.
def settle() -> None:
    """Limit this process to one core, since other workers use the others."""
    os.environ |= THREADS
    cv2.setNumThreads(1)
    # The folder of a bundle contains only the files of the sweep.
    sys.dont_write_bytecode = True


def seed_the_rest(seed: int) -> None:
    """Seed the global random generators, which modules should not use but may, from the seed of the run."""
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002 - it is this one that such modules use
    cv2.setRNGSeed(seed % 2**31)


@contextmanager
def own_modules(folder: Path) -> Iterator[None]:
    """Allow imports of the user's modules in the block, and unload them afterwards for the next run."""
    folder = folder.resolve()
    path, known = list(sys.path), set(sys.modules)
    sys.path.append(str(folder / INSTALLED))
    try:
        yield
    finally:
        sys.path[:] = path
        # Another thread of a cluster may also be at the end of a run, and remove modules in the meantime.
        for name, module in sys.modules.copy().items():  # Listing the items is not atomic.
            file = None if name in known else getattr(module, "__file__", None)
            if file is not None and Path(file).is_relative_to(folder):
                sys.modules.pop(name, None)
