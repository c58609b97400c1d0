"""Renders recordings as H.264 films, with 25 frames per simulated second."""

import queue
import threading
from collections.abc import Callable, Iterable
from itertools import chain
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError, how_to_install
from mjsim.interface import Picture
from mjsim.output import new_file, require_free
from mjsim.record import Recording
from mjsim.sentences import Sentence
from mjsim.video.views import DIAGRAMS, composed_pictures, diagram_pictures, plan_pictures, scene_pictures
from mjsim.world import View

RATE = 25
"""Frames per second."""
MAX_WAITING_FRAMES = 8
"""Maximum number of rendered frames waiting for the encoder."""
OPTIONS = {"preset": "veryfast", "crf": "20", "movflags": "+faststart"}
"""Options of x264: fast, and sharp enough for small text; the index comes first, for browsers."""


def make_video(
    recording: Recording,
    path: str | Path,
    *,
    view: str | None = None,
    follow: str | None = None,
    sightings: bool | None = None,
    ellipses: bool | None = None,
    trails: bool | None = None,
    begin: float | None = None,
    end: float | None = None,
    progress: Callable[[float], None] | None = None,
    overwrite: bool = False,
) -> None:
    """Write the film of a recording as H.264 in an MP4 file.

    Args:
        recording: The recording.
        path: Output file; it appears only when the film is complete.
        view: 'plan', 'chase', 'overview', 'diagrams' of mechanisms, or 'ROBOT/CAMERA'; by default the composed view, in
            which stationary arms are seen from the side; without robots diagrams, or the overview.
        follow: What the close-up follows, 'truth', 'estimate' or 'nothing'; by default as in the world.
        sightings: Whether to draw lines to sighted beacons; by default as in the world, like the following ones.
        ellipses: Whether to draw 95 % ellipses.
        trails: Whether to draw the paths of the robot.
        begin: Start time [s]; by default that of the recording.
        end: End time [s]; by default that of the recording.
        progress: Called with the number of frames that are done.
        overwrite: Whether an existing file may be replaced, once the film is complete.

    Raises:
        UsageError: The view does not exist, there is no tick between these times, or the file exists or cannot be
            written.
    """
    path = Path(path)
    require_film_name(path)
    require_free(path, overwrite=overwrite)
    rows = frames_between(recording, begin, end)
    view = usual_view(recording) if view is None else view
    if view == DIAGRAMS and recording.world.mechanisms:
        pictures = diagram_pictures(recording, rows)
    elif view is None or view == "plan":
        display = display_of(recording.world.run.view, follow, sightings, ellipses, trails)
        pictures = (composed_pictures if view is None else plan_pictures)(recording, rows, display)
    else:
        pictures = scene_pictures(recording, rows, view)
    # The first frame reveals what is impossible before a file is created.
    first = next(pictures)
    with new_file(path, overwrite=overwrite) as part:
        write_film(chain((first,), pictures), part, progress=progress)


def usual_view(recording: Recording) -> str | None:
    """Return the view of a recording that fits what its world has; None for the composed view of robots."""
    if recording.robots:
        return None
    return DIAGRAMS if recording.world.mechanisms else "overview"


def require_film_name(path: Path) -> None:
    """Raise UsageError if a file name does not have the suffix of a film, or PyAV is not installed."""
    if path.suffix.lower() not in (".mp4", ".m4v", ".mov"):
        raise UsageError(Sentence("cannot write a video as '{name}'; name it .mp4", path.name))
    _av()


def _av() -> Any:
    """Return PyAV, which only videos need."""
    try:
        import av
    except ImportError:
        raise UsageError(
            Sentence("videos need PyAV, which is not installed; type: {how_to_install}", how_to_install("av"))
        ) from None
    return av


def display_of(
    view: View, follow: str | None, sightings: bool | None, ellipses: bool | None, trails: bool | None
) -> View:
    """Return the display settings of a world, overridden by the given ones."""
    if follow is not None and follow not in ("truth", "estimate", "nothing"):
        raise UsageError(Sentence("follow is '{follow}'; it must be truth, estimate or nothing", follow))
    given = {"follow": follow, "sightings": sightings, "ellipses": ellipses, "trails": trails}
    return view.model_copy(update={name: value for name, value in given.items() if value is not None})


def frames_between(recording: Recording, begin: float | None = None, end: float | None = None) -> list[int]:
    """Return the row of each frame of a recording's film, or of its section between two times [s].

    Raises:
        UsageError: There is no tick between these times.
    """
    part = recording.between(begin, end).time
    first = int(np.searchsorted(recording.time, part[0]))
    return [first + row for row in frame_rows(part)]


def frame_rows(times: NDArray[np.float64]) -> list[int]:
    """Return the last row not after each frame's time; times ascend, shape (N,) [s]."""
    count = int((times[-1] - times[0]) * RATE + 1e-6) + 1
    instants = times[0] + np.arange(count) / RATE
    rows: list[int] = (np.searchsorted(times, instants + 1e-6, side="right") - 1).tolist()
    return rows


def write_film(pictures: Iterable[Picture], path: Path, *, progress: Callable[[float], None] | None = None) -> None:
    """Encode RGB pictures of one even size into a file; they are rendered in a separate thread."""
    frames = _Ahead(pictures)
    try:
        _encode(frames, path, progress)
    finally:
        frames.stop()


def _encode(frames: "_Ahead", path: Path, progress: Callable[[float], None] | None) -> None:
    stream: Any = None
    av = _av()
    with av.open(str(path), "w", format="mp4", options={"movflags": OPTIONS["movflags"]}) as container:
        for count, yuv in enumerate(frames):
            if stream is None:
                stream = container.add_stream("libx264", rate=RATE, options=OPTIONS)
                stream.width, stream.height, stream.pix_fmt = yuv.shape[1], yuv.shape[0] * 2 // 3, "yuv420p"
                # As OpenCV converts; players would assume BT.709 for pictures of this size.
                stream.codec_context.color_range = av.video.reformatter.ColorRange.MPEG
                stream.codec_context.colorspace = av.video.reformatter.Colorspace.ITU601
            frame = av.VideoFrame.from_ndarray(yuv, format="yuv420p")
            frame.pts = count
            container.mux(stream.encode(frame))
            if progress is not None:
                progress(count + 1)
        container.mux(stream.encode())


class _Ahead:
    """Renders and converts pictures in a separate thread, a few ahead of the consumer."""

    def __init__(self, pictures: Iterable[Picture]) -> None:
        self._pictures = pictures
        self._ready: queue.Queue[NDArray[np.uint8] | BaseException | None] = queue.Queue(MAX_WAITING_FRAMES)
        self._stopped = threading.Event()
        self._thread = threading.Thread(target=self._work, name="film", daemon=True)
        self._thread.start()

    def __iter__(self) -> "_Ahead":
        return self

    def __next__(self) -> NDArray[np.uint8]:
        taken = self._ready.get()
        if taken is None:
            raise StopIteration
        if isinstance(taken, BaseException):
            raise taken
        return taken

    def stop(self) -> None:
        """Stop rendering, and wait until the thread has ended."""
        self._stopped.set()
        while self._thread.is_alive():
            # The thread may be waiting for space.
            with self._ready.mutex:
                self._ready.queue.clear()
                self._ready.not_full.notify()
            self._thread.join(0.05)

    def _work(self) -> None:
        try:
            for picture in self._pictures:
                # H.264 halves the resolution of colours, so both sides must be even.
                even = picture[: picture.shape[0] // 2 * 2, : picture.shape[1] // 2 * 2]
                self._ready.put(np.asarray(cv2.cvtColor(even, cv2.COLOR_RGB2YUV_I420), dtype=np.uint8))
                if self._stopped.is_set():
                    return
            self._ready.put(None)
        # Passed to the thread that waits for pictures, and raised there.
        except BaseException as error:
            self._ready.put(error)
