"""Where the parsers of bags are called, whose faults have no type in common."""

from collections.abc import Iterator
from contextlib import contextmanager

from mjsim.errors import LONGEST_MESSAGE


class BrokenBagError(Exception):
    """A bag, or a message in it, is not as it must be; it says why in one line."""


@contextmanager
def parsing() -> Iterator[None]:
    """Turn whatever a parser raises into a `BrokenBagError`."""
    try:
        yield
    except BrokenBagError:
        raise
    # rosbags and what it decompresses with meet broken files by any kind of exception.
    except Exception as error:
        reason = " ".join(f"{error}".split()) or type(error).__name__
        raise BrokenBagError(reason[:LONGEST_MESSAGE]) from error
