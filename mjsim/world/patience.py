"""Python's collector of reference cycles waits while a world is made."""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """Keep the collector from looking for garbage; also a decorator of functions.

    A large world is a million objects that all stay; the collector would look through them again and again, for a
    fifth of the time that reading and compiling take.
    """
    ran = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if ran:
            gc.enable()
