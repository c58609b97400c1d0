"""Runs functions that decode untrusted files in a child process with limits."""

import contextlib
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from mjsim.closing import Closes
from mjsim.errors import MjsimError
from mjsim.guarded.guarded_process import About, Child, ShortOfMemoryError
from mjsim.guarded.limits import Allowance, limits_for
from mjsim.guarded.request import Call

DAMAGED = "the file may be damaged"
"""Default end of the message on a file that cannot be read."""

_SHARED: ContextVar["Reader | None"] = ContextVar("_SHARED", default=None)
"""The child of `one_reader`, which serves all calls."""


def guarded(
    function: str,
    *arguments: Any,
    about: str | Path,
    size: int | None = None,
    folders: Sequence[str | Path] | None = None,
    advice: str = DAMAGED,
    **keywords: Any,
) -> Any:
    """Return the value of a function that decodes a file, called in a child process of its own.

    Args:
        function: The function, as 'module:name'.
        arguments: Its arguments; they are pickled.
        about: Path of the file, or another name for it, for messages.
        size: Size of the data to decode, with which the limits grow [bytes]; by default that of the file.
        folders: Folders and files that may be read; by default the folder of the file.
        advice: End of the message if the file cannot be read: what may be wrong, or what to do.
        keywords: Further arguments of the function.

    Returns:
        Its value, which must be None, a number, text, bytes, an array of numbers, or made of these; see `Plain`.

    Raises:
        MjsimError: What the function raised, if it is an error of mjsim.
        UsageError: It raised something else, crashed, or needed too much time or memory.
    """
    with reader_for(function, folders=_around(about) if folders is None else folders) as reader:
        return reader.call(function, *arguments, about=about, size=size, advice=advice, **keywords)


def guarded_parts(
    function: str,
    *arguments: Any,
    about: str | Path,
    size: int | None = None,
    folders: Sequence[str | Path] | None = None,
    scratch: bool = False,
    advice: str = DAMAGED,
    **keywords: Any,
) -> Iterator[Any]:
    """Yield the values of a generator function as they are made, in a child process of its own; see `guarded`.

    The child runs ahead by the capacity of the pipe, about 64 kB. One message costs about 50 microseconds: yield
    batches. The time limit covers the waits of the caller, for all parts together.

    Args:
        function: The generator function, as 'module:name'.
        arguments: Its arguments; they are pickled.
        about: Path of the file, or another name for it, for messages.
        size: Size of the data to decode [bytes]; by default that of the file.
        folders: Folders and files that may be read; by default the folder of the file.
        scratch: Whether it may make temporary files, in a private folder that is deleted afterwards.
        advice: End of the message if the file cannot be read.
        keywords: Further arguments of the function.

    Raises:
        MjsimError: As from `guarded`, once the iteration reaches the fault.
    """
    with Reader(function, folders=_around(about) if folders is None else folders, scratch=scratch) as reader:
        yield from reader.parts(function, *arguments, about=about, size=size, advice=advice, **keywords)


class Reader(Closes):
    """A child process with limits that decodes files, one after another; it is started with the first call.

    If a file crashes the child, the next file gets a new child. Not thread-safe.
    """

    def __init__(
        self,
        function: str,
        *,
        folders: Sequence[str | Path] = (),
        scratch: bool = False,
        limits: Allowance | None = None,
    ) -> None:
        """Describe the child.

        Args:
            function: One of its functions, 'module:name'; its module is imported before the limits hold.
            folders: Folders and files that may be read; content passed as bytes needs none.
            scratch: Whether it may make temporary files, in a private folder that is deleted afterwards.
            limits: Limits of temporary files; each call has its own limits of memory and time.
        """
        self._function, self._limits = function, limits or Allowance()
        self._folders = tuple(Path(folder).absolute() for folder in folders)
        self._scratch = tempfile.TemporaryDirectory(prefix="mjsim-") if scratch else None
        self._child: Child | None = None

    def call(
        self,
        function: str,
        /,
        *arguments: Any,
        about: str | Path,
        size: int | None = None,
        advice: str = DAMAGED,
        **keywords: Any,
    ) -> Any:
        """Return the value of a function; see `guarded`."""
        answers = self._answers(
            _call(function, arguments, keywords), About(str(about), advice), limits_for(_size(about, size))
        )
        # If the function yields parts, they are dropped.
        return next((answer["value"] for answer in answers if "value" in answer), None)

    def parts(
        self,
        function: str,
        /,
        *arguments: Any,
        about: str | Path,
        size: int | None = None,
        limits: Allowance | None = None,
        advice: str = DAMAGED,
        **keywords: Any,
    ) -> Iterator[Any]:
        """Yield the values of a generator function; see `guarded_parts`. Stopping early ends the child."""
        limits = limits or limits_for(_size(about, size))
        for answer in self._answers(_call(function, arguments, keywords), About(str(about), advice), limits):
            if "part" in answer:
                yield answer["part"]

    def start(self) -> None:
        """Start the child, unless it runs: it imports its libraries while the caller does something else."""
        if self._child is not None and not self._child.running:
            self._end()
        if self._child is None:
            scratch = None if self._scratch is None else Path(self._scratch.name)
            self._child = Child(self._function, self._limits, folders=self._folders, scratch=scratch)

    def close(self) -> None:
        """End the child, and delete its temporary files."""
        self._end()
        if self._scratch is not None:
            self._scratch.cleanup()

    def _end(self) -> None:
        child, self._child = self._child, None
        if child is not None:
            child.kill()

    def _answers(self, call: Call, about: About, limits: Allowance) -> Iterator[Mapping[str, Any]]:
        """Yield the answers to a call up to its value; if a used child lacks memory, a new one repeats the call."""
        child, begun = self._started(), False
        was_used, child.used = child.used, True
        try:
            for answer in self._answers_of(child, call, about, limits):
                begun = True
                yield answer
        except ShortOfMemoryError:
            if begun or not was_used:
                raise
            self._end()
            yield from self._answers(call, about, limits)

    def _started(self) -> Child:
        self.start()
        assert self._child is not None, "it was started"
        return self._child

    def _answers_of(self, child: Child, call: Call, about: About, limits: Allowance) -> Iterator[Mapping[str, Any]]:
        """Yield the answers of a child, which ends if it failed, or if the caller stops early."""
        whole = False
        try:
            for answer in child.answers(call, limits, about):
                whole = "value" in answer
                yield answer
        except MjsimError:
            whole = child.running
            raise
        finally:
            if not whole:
                self._end()


@contextmanager
def reader_for(function: str, *, folders: Sequence[str | Path] = ()) -> Iterator[Reader]:
    """Yield the child that all calls of this thread share, or else a new one; see `Reader` for the arguments."""
    if (shared := _SHARED.get()) is not None:
        yield shared
        return
    with Reader(function, folders=folders) as reader:
        yield reader


@contextmanager
def one_reader(function: str, *, folders: Sequence[str | Path] = ()) -> Iterator[Reader]:
    """Let all calls of `guarded` in a block run in one child, in this thread; it starts with the first of them.

    Args:
        function: One of the functions, 'module:name'; its module is imported before the limits hold.
        folders: Folders and files that all calls may read, instead of those that they name.
    """
    with Reader(function, folders=folders) as reader:
        if (shared := _SHARED.get()) is not None:
            yield shared
            return
        token = _SHARED.set(reader)
        try:
            yield reader
        finally:
            _SHARED.reset(token)


def _call(function: str, arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> Call:
    """Return a call in the working folder of this process, unless that is deleted."""
    try:
        folder = os.getcwd()
    except OSError:
        folder = None
    return Call(function, arguments, keywords, folder)


def _around(about: str | Path) -> Sequence[Path]:
    """Return the folder of a file, and that of its target if it is a link."""
    return [about.absolute().parent, Path(os.path.realpath(about)).parent] if isinstance(about, Path) else []


def _size(about: str | Path, size: int | None) -> int:
    """Return a size, or that of the file; 0 if there is none, which its reader reports."""
    if size is None and isinstance(about, Path):
        with contextlib.suppress(OSError):
            return about.stat().st_size
    return size or 0
