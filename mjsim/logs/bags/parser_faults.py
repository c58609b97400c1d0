"""Wraps calls of the parsers of bags, whose exceptions have no common type."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from mjsim.errors import MAX_MESSAGE_LENGTH

ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of zstd data; CDR messages start with a zero."""


def unpacked(data: bytes) -> bytes:
    """Return decompressed zstd data."""
    # Part of Python from 3.14 on; before, it comes with rosbags, which reading bags requires anyway.
    if sys.version_info >= (3, 14):
        from compression import zstd
    else:
        from backports import zstd

    return zstd.decompress(data)


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
        raise BrokenBagError(reason[:MAX_MESSAGE_LENGTH]) from error
