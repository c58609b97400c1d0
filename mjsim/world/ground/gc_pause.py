"""Pauses garbage collection while a world is built."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def gc_paused() -> Iterator[None]:
    """Pause the collector of reference cycles; also a decorator of functions.

    A large world is a million objects that all stay; scanning them again and again would take a fifth of the time of
    reading and compiling.
    """
    ran = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if ran:
            gc.enable()
