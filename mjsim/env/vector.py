"""Many environments of one task in parallel, distributed over a few processes."""

import copy
import multiprocessing
import os
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from gymnasium.spaces import Space
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import (
    CloudpickleWrapper,
    batch_space,
    create_shared_memory,
    iterate,
    read_from_shared_memory,
    write_to_shared_memory,
)
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from mjsim.closing import THREAD_TIMEOUT
from mjsim.env.gym import GymEnvironment
from mjsim.env.task import Task
from mjsim.errors import MjsimError, UsageError

ANSWER_TIMEOUT = 600.0
"""Time limit for an answer of a process, which may have to compile the world [s]."""
StepResult = tuple[float, bool, bool, dict[str, Any]]
"""Reward, terminated, truncated, and info; observations go through shared memory."""
Make = Callable[[], GymEnvironment]
"""Creates an environment; it can be sent to a process."""


class VectorEnvironment(VectorEnv[Any, Any, Any]):
    """Environments that step in parallel; their actions, observations and rewards are stacked.

    `reset(seed=7)` seeds the first with 7, the next with 8 and so on. An episode that is over restarts at the next
    step, whose action is ignored and whose reward is 0 (Gymnasium's autoreset mode `NEXT_STEP`). It starts processes,
    so a script that creates one must keep its own code under `if __name__ == "__main__":`.
    """

    def __init__(self, task: Task, count: int, *, processes: int | None = None) -> None:
        """Start the processes, each of which compiles the world.

        Args:
            task: The learning task; its functions are sent to the processes.
            count: Number of environments.
            processes: Number of processes; by default one per processor.

        Raises:
            UsageError: A number is below 1.
            MjsimError: As `GymEnvironment`.
        """
        processes = (os.cpu_count() or 1) if processes is None else processes
        for label, number in (("count", count), ("processes", processes)):
            if number < 1:
                raise UsageError(f"{label} is {number}; it must be 1 or more")
        self.num_envs = count
        model = GymEnvironment(task)
        self.metadata = {**model.metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self.single_action_space, self.single_observation_space = model.action_space, model.observation_space
        model.close()
        self.action_space = batch_space(self.single_action_space, count)
        self.observation_space = batch_space(self.single_observation_space, count)
        context = multiprocessing.get_context("spawn")
        # Kept, because its locks would be deleted with it. A context has everything used here of the module.
        memory = create_shared_memory(self.single_observation_space, count, context)  # type: ignore[arg-type]
        self._memory = memory
        self._seen = read_from_shared_memory(self.single_observation_space, memory, count)
        self._shares = [share.tolist() for share in np.array_split(np.arange(count), min(processes, count))]
        self._pipes: list[Connection] = []
        self._workers = []
        make = CloudpickleWrapper(partial(GymEnvironment, task))
        for share in self._shares:
            ours, theirs = context.Pipe()
            sent = make, self.single_observation_space, memory, share, theirs
            worker = context.Process(target=_work, args=sent, daemon=True)
            worker.start()
            theirs.close()
            self._pipes.append(ours)
            self._workers.append(worker)

    @property
    def workers(self) -> list[int]:
        """Process ids."""
        return [worker.pid for worker in self._workers if worker.pid is not None]

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode in each; return their first observations, and their times and seeds."""
        if seed is None or isinstance(seed, int):
            seed = [None if seed is None else seed + number for number in range(self.num_envs)]
        if len(seed) != self.num_envs:
            raise UsageError(f"{len(seed)} seeds for {self.num_envs} environments; give one, or one for each")
        *_, infos = self._request("reset", list(seed))
        return copy.deepcopy(self._seen), infos

    def step(self, actions: Any) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], Any]:
        """Advance by one tick; return observations, rewards, terminated, truncated, and their times."""
        rewards, ended, cut, infos = self._request("step", list(iterate(self.action_space, actions)))
        return copy.deepcopy(self._seen), rewards, ended, cut, infos

    def close_extras(self, **kwargs: Any) -> None:
        """End the processes."""
        for pipe in self._pipes:
            pipe.close()
        for worker in self._workers:
            worker.join(THREAD_TIMEOUT)
            worker.kill()

    def _request(self, request: str, values: list[Any]) -> tuple[Any, Any, Any, dict[str, Any]]:
        """Send a request to all, each with its own value, and return their answers."""
        if len(values) != self.num_envs:
            raise UsageError(f"{len(values)} actions for {self.num_envs} environments; give one for each")
        try:
            for pipe, share in zip(self._pipes, self._shares, strict=True):
                pipe.send((request, [values[number] for number in share]))
            answers = [_answer(pipe) for pipe in self._pipes]
        except (EOFError, BrokenPipeError, OSError):
            raise MjsimError("a process of the environments has ended; create them again") from None
        for answer in answers:
            if isinstance(answer, MjsimError):
                raise answer
        results: list[StepResult] = [each for answer in answers for each in answer]
        infos: dict[str, Any] = {}
        for number, (*_, info) in enumerate(results):
            infos = self._add_info(infos, info, number)
        rewards, ended, cut, _ = zip(*results, strict=True)
        return np.array(rewards, dtype=float), np.array(ended, dtype=bool), np.array(cut, dtype=bool), infos


def vector_environment(task: Task, count: int, *, processes: int | None = None) -> VectorEnvironment:
    """Return environments that step in parallel; see `VectorEnvironment`."""
    return VectorEnvironment(task, count, processes=processes)


class _Share:
    """The environments of one process."""

    def __init__(self, make: Make, space: Space[Any], memory: Any, numbers: Sequence[int]) -> None:
        self._environments = [make() for _ in numbers]
        self._over = [False for _ in numbers]
        self._space, self._memory, self._numbers = space, memory, numbers

    def do(self, request: str, values: Sequence[Any]) -> list[StepResult]:
        """Reset or step all, each with its own value."""
        return [self._one(place, request, value) for place, value in enumerate(values)]

    def _one(self, place: int, request: str, value: Any) -> StepResult:
        environment = self._environments[place]
        seen: Any
        reward, ended, cut = 0.0, False, False
        if request == "reset":
            seen, info = environment.reset(seed=value)
        elif self._over[place]:
            seen, info = environment.reset()
        else:
            seen, reward, ended, cut, info = environment.step(value)
        self._over[place] = ended or cut
        write_to_shared_memory(self._space, self._numbers[place], seen, self._memory)
        return reward, ended, cut, info

    def close(self) -> None:
        """Close them."""
        for environment in self._environments:
            environment.close()


def _answer(pipe: Connection) -> Any:
    """Return the next answer of a process."""
    if not pipe.poll(ANSWER_TIMEOUT):
        raise MjsimError(
            f"a process of the environments did not answer within {ANSWER_TIMEOUT:g} s; end it with `close`"
        )
    return pipe.recv()


def _work(make: Make, space: Space[Any], memory: Any, numbers: Sequence[int], pipe: Connection) -> None:
    """Execute requests from the pipe until it closes."""
    share = None
    # One BLAS thread: the processes provide the parallelism.
    with threadpool_limits(1, user_api="blas"):
        while True:
            try:
                request, values = pipe.recv()
            except (EOFError, KeyboardInterrupt):
                break
            try:
                share = share or _Share(make, space, memory, numbers)
                pipe.send(share.do(request, values))
            except MjsimError as error:
                pipe.send(error)
            # Exceptions of a task's functions are reported in one line; this is the boundary to that code.
            except Exception as error:
                frame = traceback.extract_tb(error.__traceback__)[-1]
                place = f"{frame.filename.rpartition('/')[2]}:{frame.lineno}"
                pipe.send(MjsimError(f"an environment raised {type(error).__name__}: {error} ({place})"))
    if share is not None:
        share.close()
