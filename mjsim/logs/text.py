"""Lines of text files, compressed or not, within bounds."""

import bz2
import codecs
import gzip
import lzma
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any

from mjsim.errors import UsageError

MOST_BYTES = 4 << 30
"""Maximum size of text in a log [bytes]."""
LONGEST_LINE = 1 << 20
"""Maximum length of a line [bytes]."""
UNPACKERS: Mapping[str, tuple[bytes, Callable[[Path], Any]]] = {
    ".gz": (b"\x1f\x8b", gzip.open),
    ".xz": (b"\xfd7zXZ\x00", lzma.open),
    ".bz2": (b"BZh", bz2.open),
}
"""Suffixes of compressed files, their first bytes, and the decompressors."""


def lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a text file; gzip, xz and bzip2 files are decompressed, whatever their names.

    Raises:
        UsageError: It cannot be read, is not compressed as its name says, or is too large.
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
    except (lzma.LZMAError, EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise UsageError(f"cannot unpack '{path}': {error}") from None
    except OSError as error:
        raise UsageError(f"cannot read '{path}': {error.strerror or error}") from None


def _opened(path: Path) -> IO[bytes]:
    with path.open("rb") as file:
        head = file.read(6)
    for suffix, (magic, unpacker) in UNPACKERS.items():
        if head.startswith(magic) or path.suffix.lower() == suffix:
            unpacked: IO[bytes] = unpacker(path)
            return unpacked
    return path.open("rb")
