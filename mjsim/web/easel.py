"""Ticks to pictures for who watches: taking a tick is cheap, drawing is for another thread."""

import threading
import time
from collections import deque
from dataclasses import dataclass, replace

import cv2

from mjsim.record import Tick
from mjsim.video.frame import Frame
from mjsim.video.moment import Moment, moment_of
from mjsim.video.scans import mounts_of
from mjsim.world import World

BACKLOG = 500
"""Trails and errors are drawn on at the latest when so many ticks wait, so that memory stays bounded."""
QUALITY = 85
"""Of the JPEG, of 100: small letters stay clean."""


@dataclass(frozen=True, slots=True, eq=False)
class Sheet:
    """A picture to be sent."""

    number: int
    """Which tick it shows, counted from 1."""
    time: float
    """Simulated [s]."""
    pace: float
    """Simulated seconds a second, over the last pictures."""
    jpeg: bytes


class Easel:
    """Takes ticks in the loop's thread and draws the newest in another; the two never wait for each other's work."""

    def __init__(self, world: World, robot: str | None) -> None:
        """Show a robot's run; that of the first one that is driven unless given."""
        self._world = world
        self._robot = robot
        self._lock = threading.Lock()
        self._newest: Moment | None = None
        self._backlog: deque[Moment] = deque()
        self._frame: Frame | None = None
        self._began: tuple[float, float] | None = None
        self._pace = 0.0
        self._drawn_at = 0.0
        self.number = 0
        """How many ticks were taken."""
        self.sheet: Sheet | None = None
        """The newest picture."""

    def take(self, tick: Tick) -> bool:
        """Take note of a tick; true when it is time to `catch_up` although nobody watches."""
        robot = self._robot or next(iter(tick.orders), None)
        if robot is None or robot not in tick.orders:
            return False
        moment = moment_of(tick, robot, before=self._newest, lidars=mounts_of(self._world, robot))
        with self._lock:
            self._robot, self._newest = robot, moment
            # Pictures are large; only the newest one is ever shown.
            self._backlog.append(replace(moment, picture=None))
            self.number += 1
            return len(self._backlog) % BACKLOG == 0

    def catch_up(self) -> tuple[Frame, Moment, int]:
        """Let trails and errors go on to the newest tick; return what draws it, it, and its number."""
        with self._lock:
            moment, number, robot = self._newest, self.number, self._robot
            backlog, self._backlog = self._backlog, deque()
        assert moment is not None, "there is a tick before anything is drawn"
        if self._frame is None:
            self._frame = Frame(self._world, robot)
        for each in backlog:
            self._frame.add(each)
        return self._frame, moment, number

    def draw(self) -> Sheet:
        """Return the picture of the newest tick."""
        self._drawn_at = time.perf_counter()
        frame, moment, number = self.catch_up()
        picture = cv2.cvtColor(frame.draw(moment), cv2.COLOR_RGB2BGR)
        done, data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
        assert done, "a picture of ours can always be encoded"
        self.sheet = Sheet(number, moment.time, self._measured_pace(moment.time), data.tobytes())
        return self.sheet

    def age_left(self, period: float) -> float:
        """Return how long to wait until drawing the newest picture began a period ago [s]."""
        return max(0.0, self._drawn_at + period - time.perf_counter())

    def _measured_pace(self, simulated: float) -> float:
        """Return simulated seconds a second, measured over at least one second."""
        now = time.perf_counter()
        if self._began is None:
            self._began = now, simulated
        elapsed = now - self._began[0]
        if elapsed >= 1.0:
            self._pace = (simulated - self._began[1]) / elapsed
            self._began = now, simulated
        return self._pace
