"""Lines of text files, compressed or not, within bounds."""

import bz2
import codecs
import gzip
import lzma
from collections.abc import Iterator
from pathlib import Path
from typing import IO, cast

from mjsim.errors import UsageError

MOST_BYTES = 4 << 30
"""Of text in a log."""
LONGEST_LINE = 1 << 20
"""Bytes; what is longer is no line of numbers."""


def lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a text file; one that ends in .gz, .xz or .bz2 is unpacked as it is read.

    Raises:
        UsageError: It cannot be read, is not packed as its name says, or is too large.
    """
    taken = 0
    try:
        with _opened(path) as packed:
            wide = packed.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
            packed.seek(0)
            # What spreadsheets call Unicode text.
            file = codecs.EncodedFile(packed, "utf-8", "utf-16", errors="replace") if wide else packed
            while line := file.readline(LONGEST_LINE):
                # What editors of Windows put before a text.
                line = line if taken else line.removeprefix(codecs.BOM_UTF8)
                taken += len(line)
                if taken > MOST_BYTES:
                    raise UsageError(f"'{path}' holds more than {MOST_BYTES >> 30} GB of text; take a part of it")
                yield line.decode("utf-8", errors="replace")
    except (lzma.LZMAError, EOFError, gzip.BadGzipFile) as error:
        raise UsageError(f"cannot unpack '{path}': {error}") from None
    except OSError as error:
        raise UsageError(f"cannot read '{path}': {error.strerror or error}") from None


def _opened(path: Path) -> IO[bytes]:
    match path.suffix.lower():
        case ".gz":
            return cast(IO[bytes], gzip.open(path, "rb"))
        case ".xz":
            return lzma.open(path, "rb")
        case ".bz2":
            return bz2.open(path, "rb")
        case _:
            return path.open("rb")
