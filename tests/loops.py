"""Coroutines in tests: Playwright holds the event loop of the thread in which the tests run."""

import asyncio
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")


def in_a_loop(work: Callable[[], Awaitable[T]], *, within: float = 30.0) -> T:
    """Run a coroutine in a thread with a loop of its own, which ends it after a time [s]."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, asyncio.wait_for(work(), within)).result(within + 10.0)
