"""Lines of text files, compressed or not, within bounds."""

import bz2
import codecs
import gzip
import io
import lzma
import os
import zlib
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any, cast

from mjsim.errors import UsageError
from mjsim.inventory import Fate, told

MAX_LINE_LENGTH = 1 << 20
"""Maximum length of a line [bytes]."""
MIN_UNPACKED_LIMIT, MAX_COMPRESSION = 16 << 20, 20
"""Maximum length of a text: absolute [bytes], and as a multiple of the size of its file if that is compressed."""
MAX_NUMBER = 1e30
"""Largest number in a log; products of larger ones overflow."""
_HEAD_BYTES = 1 << 16
"""Bytes at the beginning of a text that show its line ends and its compression."""
UNPACKERS: Mapping[str, tuple[bytes, Callable[[Path], Any]]] = {
    ".gz": (b"\x1f\x8b", gzip.open),
    ".xz": (b"\xfd7zXZ\x00", lzma.open),
    ".bz2": (b"BZh", bz2.open),
}
"""Suffixes of compressed files, their first bytes, and the decompressors."""


def lines_of(path: Path, notes: dict[str, str] | None = None) -> Iterator[str]:
    """Yield the lines of a text file; gzip, xz and bzip2 files are decompressed, whatever their names.

    Args:
        path: The file.
        notes: Metadata of the log. With it, a truncated compressed file is read up to its last whole line, which
            is noted.

    Raises:
        UsageError: It cannot be read, is not compressed as its name says, unpacks to too much, or is truncated.
    """
    is_first = True
    try:
        left = max(MIN_UNPACKED_LIMIT, MAX_COMPRESSION * path.stat().st_size)
        with _opened(path, notes) as packed:
            wide = packed.read(2) in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
            packed.seek(0)
            # The encoding that spreadsheets call Unicode text.
            file = codecs.EncodedFile(packed, "utf-8", "utf-16", errors="replace") if wide else _ended(packed)
            while line := file.readline(MAX_LINE_LENGTH):
                if (left := left - len(line)) < 0:
                    raise UsageError(
                        f"'{path}' unpacks to more than {MAX_COMPRESSION} times its size; unpack it yourself"
                    )
                # The byte order mark that editors on Windows write.
                line = line.removeprefix(codecs.BOM_UTF8) if is_first else line
                if notes and _broken(path) in notes and not line.endswith(b"\n"):
                    return
                is_first = False
                yield line.decode("utf-8", errors="replace")
    except (lzma.LZMAError, EOFError, gzip.BadGzipFile, zlib.error) as error:
        raise UsageError(f"cannot unpack '{path}': {error}") from None
    except OSError as error:
        raise UsageError(f"cannot read '{path}': {error.strerror or error}") from None


def lies_in(path: Path, folder: Path) -> bool:
    """Return whether a file, existing or not, is in a folder with links resolved; a loop of links stays as it is."""
    # No path has a null byte, but a damaged list may.
    return "\0" not in str(path) and Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def left_out_cut(path: Path, line: str, notes: dict[str, str] | None) -> bool:
    """Return whether an invalid line was truncated, as its end is missing, and note that it is left out."""
    if notes is None or line.endswith("\n"):
        return False
    notes[f"last line of {_called(path)}, cut short, left out"] = "1"
    return True


def _called(path: Path) -> str:
    """Return the name of a file in notes; all tables of EuRoC have the same."""
    return f"{path.parent.name}/{path.name}" if path.name == "data.csv" else path.name


def _broken(path: Path) -> str:
    """Return the key of the note about a truncated compressed file."""
    return f"{_called(path)} breaks off"


def _opened(path: Path, notes: dict[str, str] | None) -> IO[bytes]:
    # A pipe without a writer would block forever.
    if path.exists() and not path.is_file():
        raise UsageError(f"cannot read '{path}': it is not a file; copy its contents into one")
    with path.open("rb") as file:
        head = file.read(_HEAD_BYTES)
    for suffix, (magic, unpacker) in UNPACKERS.items():
        if head.startswith(magic) or path.suffix.lower() == suffix:
            unpacked = unpacker(path)
            return unpacked if notes is None else cast(IO[bytes], io.BufferedReader(_Whole(unpacked, path, notes)))
    return path.open("rb")


def _ended(file: Any) -> Any:
    """Return a text with line feeds; lines of old spreadsheets end with a carriage return only."""
    head = file.read(_HEAD_BYTES)
    file.seek(0)
    if b"\r" not in head or b"\n" in head:
        return file
    return io.BufferedReader(_Returns(file))


class _Whole(io.RawIOBase):
    """The readable part of a compressed text that may be truncated."""

    def __init__(self, unpacked: Any, path: Path, notes: dict[str, str]) -> None:
        """Wrap a decompressor."""
        self._unpacked, self._path, self._notes = unpacked, path, notes

    def readable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET, /) -> int:
        """Seek to a position; return it."""
        place: int = self._unpacked.seek(offset, whence)
        return place

    def readinto(self, into: Any) -> int:
        """Read the next bytes into a buffer; return their number."""
        try:
            data = self._unpacked.read1(len(into))
        except EOFError:
            self._notes[_broken(self._path)] = told(Fate.LEFT_OUT, "the compressed file was cut, and read up to there")
            return 0
        into[: len(data)] = data
        return len(data)

    def close(self) -> None:
        """Close the file."""
        self._unpacked.close()
        super().close()


class _Returns(io.RawIOBase):
    """A text with line feeds in place of carriage returns."""

    def __init__(self, file: Any) -> None:
        """Take a file that is open."""
        self._file = file

    def readable(self) -> bool:
        """Return True."""
        return True

    def readinto(self, into: Any) -> int:
        """Read the next bytes into a buffer; return their number."""
        data = self._file.read(len(into)).replace(b"\r", b"\n")
        into[: len(data)] = data
        return len(data)
