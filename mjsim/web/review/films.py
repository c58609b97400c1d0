"""Renders films in the background, one after another."""

import secrets
import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from mjsim.errors import MjsimError
from mjsim.record import Recording
from mjsim.sentences import Sentence
from mjsim.video import frames_between, make_video
from mjsim.web.server import RefusedError

MAX_JOBS = 100
"""Number of films that are remembered."""


@dataclass(frozen=True, slots=True)
class FilmProgress:
    """Progress of a film."""

    done: int
    """Number of finished frames."""
    total: int
    """Number of frames."""
    path: str | None = None
    """Path of the finished film; None before."""
    error: str | None = None
    """Error message; None if there was no error."""


class Films:
    """Renders films in a separate thread."""

    def __init__(self) -> None:
        """Start idle."""
        self._lock = threading.Lock()
        self._progress: dict[str, FilmProgress] = {}
        self._files: dict[str, Path] = {}
        self._closed = False
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mjsim-films")

    def begin(self, recording: Recording, file: Path, *, shown: str, view: str | None, begin: float, end: float) -> str:
        """Start a film and return its id.

        Args:
            recording: The recording.
            file: Output file.
            shown: Path of that file on the page.
            view: The view, as for `make_video`.
            begin: Start time [s].
            end: End time [s].

        Raises:
            UsageError: There is no tick between these times.
        """
        total = len(frames_between(recording, begin, end))
        name = secrets.token_hex(8)
        with self._lock:
            if len(self._progress) >= MAX_JOBS:
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
                # A bug of mjsim; the page is informed as well.
                self._finish(name, error=Sentence("the video failed: {error}", type(error).__name__))
                raise
            else:
                self._finish(name, path=shown)

        self._thread.submit(make)
        return name

    def progress(self, name: str) -> FilmProgress:
        """Return the progress of a film.

        Raises:
            RefusedError: The film does not exist.
        """
        with self._lock:
            if name not in self._progress:
                raise RefusedError(404, "no video of that name is being made; start it again")
            return self._progress[name]

    def files(self) -> set[Path]:
        """Return the output files of unfinished films."""
        with self._lock:
            return set(self._files.values())

    def close(self) -> None:
        """Abort the current film, and start no more."""
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
    """The studio was closed during a film."""
