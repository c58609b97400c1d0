"""The recordings of a folder as the page lists them: date, length, world, robots, and a small plan."""

import threading
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import MjsimError
from mjsim.plan import SvgPlan, Theme, bounds_of, world_shapes
from mjsim.record import recorded_world, recording_summary
from mjsim.web.worlds import Folder, recordings_below

MAX_DETAILED = 500
"""Maximum number of recordings with details: the newest."""


MARGIN = 0.3
"""Margin around the plan [m]."""


class Recorded:
    """The worlds and robots of the recordings of a folder; each file is read again only after it has changed."""

    def __init__(self, folder: Folder) -> None:
        """Store the folder."""
        self._folder, self._lock = folder, threading.Lock()
        self._known: dict[Path, tuple[tuple[int, int], dict[str, Any]]] = {}

    def cards(self) -> list[dict[str, Any]]:
        """Return path, `when` it was written [s since 1970], `bytes`, world, robots and seconds, the newest first.

        A file that is not a recording of mjsim has no world, no robots and no length.
        """
        found = []
        for path in recordings_below(self._folder.root):
            try:
                stat = path.stat()
            except OSError:  # removed meanwhile
                continue
            found.append((stat.st_mtime_ns, stat.st_size, path))
        with self._lock:
            newest = sorted(found, reverse=True)[:MAX_DETAILED]
            self._known = {path: self._card(path, (when, size)) for when, size, path in newest}
            return [card for _, card in self._known.values()]

    def _card(self, path: Path, stamp: tuple[int, int]) -> tuple[tuple[int, int], dict[str, Any]]:
        held = self._known.get(path)
        if held is not None and held[0] == stamp:
            return held
        card = {"path": self._folder.name(path), "when": stamp[0] / 1e9, "bytes": stamp[1]}
        return stamp, {**card, **_content(path)}


def _content(path: Path) -> dict[str, Any]:
    try:
        summary = recording_summary(path)
    except MjsimError:
        return {"world": "", "robots": [], "seconds": None}
    return {"world": summary.world, "robots": list(summary.robots), "seconds": summary.seconds}


def plan_of(path: Path, theme: Theme) -> bytes:
    """Return the plan of a recording's world as SVG.

    Raises:
        UsageError: The file cannot be read.
        RecordingError: It is not a recording, or its world cannot be read.
    """
    shapes = world_shapes(recorded_world(path))
    bounds = bounds_of(shapes) if shapes else np.array([[0.0, 0.0], [1.0, 1.0]])
    plan = SvgPlan(bounds + np.array([[-MARGIN], [MARGIN]]), ratio=100.0, theme=theme)
    plan.draw(shapes)
    return plan.data()
