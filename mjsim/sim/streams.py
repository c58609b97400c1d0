"""Random streams: one for each purpose of each sensor of each robot."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from mjsim.errors import UsageError
from mjsim.sentences import Sentence

MAX_SEED = 2**63 - 1
"""Largest seed that a recording can store."""
Streams = Callable[[str], Generator]
"""Purpose -> random stream."""


def checked_seed(seed: int) -> int:
    """Return a seed.

    Raises:
        UsageError: It is not a whole number, negative, or larger than a recording can store.
    """
    if not isinstance(seed, int | np.integer) or not 0 <= seed <= MAX_SEED:
        raise UsageError(Sentence("seed is {seed!r}; it must be a whole number from 0 to {max_seed}", seed, MAX_SEED))
    return int(seed)


def stream(seed: int, robot: str, purpose: str) -> Generator:
    """Return the random stream of a purpose, such as 'scan/range'; streams are independent of each other."""
    return np.random.default_rng([seed, *f"{robot}/{purpose}".encode()])


def streams_of(seed: int, robot: str, sensor: str) -> Streams:
    """Return a function for the random streams of one sensor."""
    return lambda purpose: stream(seed, robot, f"{sensor}/{purpose}")


def cached(streams: Streams) -> Streams:
    """Return a function that returns the same stream for the same purpose, so that its sequence continues."""
    made: dict[str, Generator] = {}

    def source(purpose: str) -> Generator:
        if purpose not in made:
            made[purpose] = streams(purpose)
        return made[purpose]

    return source
