"""Many environments of one task at once, each in a process of its own."""

import os
from functools import partial

from gymnasium.vector import AsyncVectorEnv
from threadpoolctl import threadpool_limits

from mjsim.env.gym import GymEnvironment
from mjsim.env.task import Task
from mjsim.errors import UsageError


def vector_environment(task: Task, count: int) -> AsyncVectorEnv:
    """Return environments that step side by side; their actions and observations are stacked.

    Each is a process of its own, as many at work at a time as there are processors. `reset(seed=7)` seeds the first
    with 7, the next with 8 and so on. An episode that is over begins anew at the next step.

    Args:
        task: What is to be learned; its functions are sent to the processes.
        count: How many.

    Raises:
        UsageError: There is not one.
        MjsimError: As `GymEnvironment`.
    """
    if count < 1:
        raise UsageError(f"count is {count}; there is at least one environment")
    makers = [partial(_worker, task)] * count
    makers[0] = partial(GymEnvironment, task)
    return AsyncVectorEnv(makers, context="spawn", max_concurrency=os.cpu_count())


def _worker(task: Task) -> GymEnvironment:
    # For the life of the process: what is parallel are the processes.
    threadpool_limits(1, user_api="blas")
    return GymEnvironment(task)
