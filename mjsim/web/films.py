"""Films that are made while the page waits, one after the other."""

import secrets
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from mjsim.errors import MjsimError
from mjsim.record import Recording
from mjsim.video import frames_between, make_video
from mjsim.web.answers import RefusedError

MOST = 100
"""So many films are remembered."""


@dataclass(frozen=True, slots=True)
class FilmProgress:
    """How far a film is."""

    done: int
    """Frames."""
    total: int
    """Frames."""
    path: str | None = None
    """Where it is, once it is whole."""
    error: str | None = None
    """Why there is none."""


class Films:
    """Makes films in a thread of its own."""

    def __init__(self) -> None:
        """Be idle."""
        self._lock = threading.Lock()
        self._progress: dict[str, FilmProgress] = {}
        self._files: dict[str, Path] = {}
        self._closed = False
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mjsim-films")

    def begin(self, recording: Recording, file: Path, *, shown: str, view: str | None, begin: float, end: float) -> str:
        """Begin a film and return what it is asked for by.

        Args:
            recording: Which is shown.
            file: Where the film goes.
            shown: That place as the page names it.
            view: As `make_video` has it.
            begin: Of the part that is shown [s].
            end: Of that part [s].

        Raises:
            UsageError: No tick is between these times.
        """
        total = len(frames_between(recording, begin, end))
        name = secrets.token_hex(8)
        with self._lock:
            if len(self._progress) >= MOST:
                self._progress.pop(next(iter(self._progress)))
            self._progress[name] = FilmProgress(0, total)
            self._files[name] = file

        def note(done: float) -> None:
            self._note(name, int(done))

        def make() -> None:
            try:
                make_video(recording, file, view=view, begin=begin, end=end, progress=note)
            except MjsimError as error:
                self._finish(name, error=str(error).partition("\n")[0])
            except _ClosedError:
                self._finish(name, error="the studio was closed")
            except BaseException as error:
                # A bug of ours; the page is told as well.
                self._finish(name, error=f"the film failed: {type(error).__name__}")
                raise
            else:
                self._finish(name, path=shown)

        self._thread.submit(make)
        return name

    def progress(self, name: str) -> FilmProgress:
        """Return how far a film is.

        Raises:
            RefusedError: The film does not exist.
        """
        with self._lock:
            if name not in self._progress:
                raise RefusedError(404, "no film of that name is being made; begin it again")
            return self._progress[name]

    def files(self) -> set[Path]:
        """Return where films go that are not done yet."""
        with self._lock:
            return set(self._files.values())

    def close(self) -> None:
        """Make no more, and give up the current one."""
        self._closed = True
        self._thread.shutdown(cancel_futures=True)

    def _note(self, name: str, done: int) -> None:
        if self._closed:
            raise _ClosedError
        with self._lock:
            if name in self._progress:
                self._progress[name] = replace(self._progress[name], done=done)

    def _finish(self, name: str, *, path: str | None = None, error: str | None = None) -> None:
        with self._lock:
            self._files.pop(name, None)
            if name in self._progress:
                self._progress[name] = replace(self._progress[name], path=path, error=error)


class _ClosedError(Exception):
    """The studio is closed while a film is made."""
