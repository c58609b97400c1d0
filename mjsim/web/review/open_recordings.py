"""Recordings under review: read once, and rendered by threads of their own."""

import threading
from collections import OrderedDict
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from mjsim.closing import awaited
from mjsim.record import Recording, read_recording
from mjsim.sentences import Sentence
from mjsim.sim import LedPeople, Onlooker, Orbit
from mjsim.web.edit import PICTURE_TIMEOUT
from mjsim.web.review.reviewing import People, row_at
from mjsim.web.run import Scene3d, Scene3dShelf, SensorPast, depth_shown, jpeg, segmentation_shown
from mjsim.web.server import RefusedError

MAX_OPEN = 3
"""Number of recordings kept in memory."""
SIZE = (960, 600)
"""Size of external views [px]."""


class Opened:
    """A recording, and its renderer."""

    def __init__(self, recording: Recording) -> None:
        """Prepare; nothing is compiled before the first picture."""
        self.recording = recording
        self._onlooker, self._solids = Onlooker(recording.world), Scene3dShelf()
        self.measured = SensorPast(recording)
        self._people, self._posing = LedPeople(recording.world), threading.Lock()
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="mjsim-review")

    def people(self, row: int) -> People:
        """Return the outlines from above, at a row, of people whose hands were moved."""
        with self._posing:
            return self._people.outlines(self.recording.looks(row))

    def picture(self, time: float, view: str, *, orbit: Orbit | None = None) -> bytes:
        """Return a picture at a time, rendered again from the recorded state, as JPEG; blocks until it is ready.

        Args:
            time: The last tick not after this time is shown [s].
            view: 'ROBOT/CAMERA', the same with ':depth' or ':segmentation'; 'overview', 'ROBOT/chase', 'outside'.
            orbit: Viewpoint of 'outside'; by default that of the overview.

        Raises:
            RefusedError: The recording has no states, as for real robots.
            UsageError: The view does not exist.
        """
        self._require_states()
        return awaited(self._thread.submit(self._draw, time, view, orbit=orbit), "a picture", within=PICTURE_TIMEOUT)

    def solids(self) -> Scene3d:
        """Return the 3-D scene of its world.

        Raises:
            RefusedError: The recording has no states, as for real robots.
        """
        self._require_states()
        return self._solids.of(self.recording.world)

    def poses(self, time: float) -> bytes:
        """Return the poses of the bodies at the last tick not after a time [s], in the format of `Scene3d`.

        Raises:
            RefusedError: The recording has no states, as for real robots.
        """
        row = row_at(self.recording, time)
        return self.solids().poses(float(self.recording.time[row]), self.recording.qpos[row], self.recording.looks(row))

    def close(self) -> None:
        """Release the renderer, and stop reading."""
        self.measured.close()
        self._thread.submit(self._onlooker.close)
        self._thread.shutdown()

    def _require_states(self) -> None:
        if not self.recording.qpos.shape[1]:
            raise RefusedError(409, "this recording contains no states to render; it is of a real robot")

    def _draw(self, time: float, view: str, *, orbit: Orbit | None) -> bytes:
        recording, row = self.recording, row_at(self.recording, time)
        self._onlooker.show(recording.qpos[row], recording.looks(row))
        if view == "chase":
            view = f"{next(iter(recording.robots), '')}/chase"
        if view in ("outside", "overview") or view.endswith("/chase"):
            outside = orbit if view == "outside" and orbit is not None else "overview" if view == "outside" else view
            return jpeg(self._onlooker.outside(outside, width=SIZE[0], height=SIZE[1]))
        camera, _, kind = view.partition(":")
        robot, _, name = camera.partition("/")
        stamp = float(recording.time[row])
        frame = self._onlooker.onboard(
            robot, name, stamp=stamp, depth=kind == "depth", segmentation=kind == "segmentation"
        )
        if kind == "segmentation":
            return jpeg(segmentation_shown(frame))
        if kind == "depth" and frame.depth is not None:
            return jpeg(depth_shown(frame.depth))
        return jpeg(frame.image)


class Shelf:
    """The most recently used recordings; one that has changed on disk is read again."""

    def __init__(self) -> None:
        """Start empty."""
        self._lock = threading.Lock()
        self._opened: OrderedDict[Path, tuple[tuple[int, int], Opened]] = OrderedDict()

    def open(self, path: Path) -> Opened:
        """Return a recording, read if necessary.

        Raises:
            RefusedError: The file does not exist.
            RecordingError: It is not a recording.
        """
        try:
            found = path.stat()
        except OSError:
            raise RefusedError(
                404, Sentence("no file '{name}'; it may have been moved or removed", path.name)
            ) from None
        stamp = found.st_mtime_ns, found.st_size
        with self._lock:
            held = self._opened.get(path)
            if held is None or held[0] != stamp:
                opened = Opened(read_recording(path))
                if held is not None:
                    held[1].close()
                held = self._opened[path] = stamp, opened
            self._opened.move_to_end(path)
            while len(self._opened) > MAX_OPEN:
                self._opened.popitem(last=False)[1][1].close()
            return held[1]

    def close(self) -> None:
        """Release everything."""
        with self._lock:
            while self._opened:
                self._opened.popitem()[1][1].close()
