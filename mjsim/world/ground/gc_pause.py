"""Pauses garbage collection while a world is built."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def gc_paused() -> Iterator[None]:
    """Disable cyclic garbage collection; also usable as a decorator.

    A large world has a million long-lived objects; scanning them repeatedly would take a fifth of the time for reading
    and compiling.
    """
    ran = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if ran:
            gc.enable()
