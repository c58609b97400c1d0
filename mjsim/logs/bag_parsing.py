"""Wraps calls of the parsers of bags, whose exceptions have no common type."""

from collections.abc import Iterator
from contextlib import contextmanager

from mjsim.errors import LONGEST_MESSAGE


class BrokenBagError(Exception):
    """A bag, or a message in it, is invalid; the reason has one line."""


@contextmanager
def parsing() -> Iterator[None]:
    """Convert any exception of a parser into a `BrokenBagError`."""
    try:
        yield
    except BrokenBagError:
        raise
    # rosbags and its decompressors may raise any exception for damaged files.
    except Exception as error:
        reason = " ".join(f"{error}".split()) or type(error).__name__
        raise BrokenBagError(reason[:LONGEST_MESSAGE]) from error
