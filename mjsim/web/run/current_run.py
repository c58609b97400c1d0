"""The run that all browsers watch: its state, its messages, and its viewers."""

import asyncio
import contextlib
import json
import threading
from collections.abc import Awaitable, Callable, Mapping
from pathlib import Path
from typing import Any, Protocol, TypeVar

from mjsim.record import Tick
from mjsim.session import Session, State, event_keys
from mjsim.web.run.feed import Feed
from mjsim.web.run.jointed import joints_json
from mjsim.web.run.painter import Painter
from mjsim.web.run.tick_json import drivers_json, mechanisms_json, noise_json, robots_json
from mjsim.world import World, noise_figures

Scene = Callable[[World], Mapping[str, Any]]
"""World -> the items of its plan and its bounds, in JSON form."""
Seen = TypeVar("Seen")
Encode = Callable[[str, Seen], Awaitable[tuple[float, bytes]]]
"""Name of a view, what is seen in it -> its time [s], and the data to send."""
POLL_SECONDS = 0.005
"""Minimum interval between checks of the viewers [s]."""
MAX_SPEED_VIEW_SHARE, BUSY_VIEW_SHARE = 0.3, 0.12
"""Fraction of time for external views while a run goes as fast as possible, and while it is late."""
REPORT_DELAY = 0.3
"""Maximum time until changes by a drag are reported [s]."""
FAREWELL_SECONDS = 1.0
"""A browser that has not received the last messages after this time misses them [s]."""
LATE_RATIO = 0.97
"""A run slower than this fraction of its speed is late."""


class Watching(Protocol):
    """A viewer of the run."""

    news: asyncio.Event
    """Set when there is something to send."""


class Stage:
    """One run at a time, for any number of browsers. The server's thread sends; any thread may report changes."""

    def __init__(self, scene: Scene) -> None:
        """Start without a run."""
        self._scene = scene
        self.feed = Feed(self.wake)
        self.viewers: set[Watching] = set()
        self.closing = False
        """Whether browsers must be sent the last messages and disconnected."""
        self.world: World | None = None
        self.session: Session | None = None
        self.painter: Painter | None = None
        self.show = 0
        """Number of the shown world, from 1."""
        self._path: str | None = None
        self._first: str | None = None
        self._initial: dict[str, float] = {}
        self._scene_text = ""
        self._lock, self._counting, self._left = threading.Lock(), threading.Lock(), threading.Event()
        self._news, self._published_news, self._woken = 0, 0, False
        self.version = 0
        """Changes with the run and its state."""
        self._root: Path | None = None
        self._made: dict[str, tuple[object, asyncio.Future[tuple[float, bytes]]]] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._later: asyncio.TimerHandle | None = None

    def put_on(
        self,
        world: World,
        session: Session | None,
        *,
        path: str | None = None,
        root: Path | None = None,
        first: str | None = None,
    ) -> None:
        """Show another run.

        Args:
            world: World of the run.
            session: Session that runs it; None if its ticks come from elsewhere.
            path: Path of the world file.
            root: Folder relative to which the page names recordings; by default none are named.
            first: Name of the robot shown first.
        """
        scene = {"kind": "scene", **self._scene(world)}
        with self._lock:
            self.world, self.session, self._path, self._first = world, session, path, first
            self._root = root
            self._initial = {figure.key: figure.value for figure in noise_figures(world)}
            self._scene_text = json.dumps(scene, allow_nan=False)
            painter, self.painter = self.painter, Painter(world, self._share)
            self.show += 1
        self.feed.begin(world)
        self.changed()
        if painter is not None:
            painter.close()

    def take(self, tick: Tick) -> None:
        """Take the next tick of the run; called in the thread of the run."""
        begins = self.session is None and self.feed.newest is None
        self.feed.take(tick)
        if begins:
            self.changed()

    def changed(self) -> None:
        """Report that the run or its state has changed; from any thread."""
        with self._counting:
            self.version += 1
        self.wake()

    def changed_later(self) -> None:
        """Report a change within `REPORT_DELAY` seconds, together with others; from the server's thread."""
        if self._later is None or self._later.when() < asyncio.get_running_loop().time():
            self._later = asyncio.get_running_loop().call_later(REPORT_DELAY, self.changed)

    async def once(self, name: str, seen: Seen, *, make: Encode[Seen]) -> tuple[float, bytes]:
        """Return the data of a view, made for the first browser that asks and shared with the others."""
        held = self._made.get(name)
        if held is None or held[0] is not seen:
            held = self._made[name] = seen, asyncio.ensure_future(make(name, seen))
        return await asyncio.shield(held[1])

    def scene_text(self) -> str:
        """Return the scene as JSON."""
        return self._scene_text

    def run_json(self) -> dict[str, Any]:
        """Return the run and its state, without its time."""
        with self._lock:
            world, session, number = self.world, self.session, self.show
        if world is None:
            return {"kind": "run", "number": number, "state": "idle", **_NOTHING}
        fault = None if session is None else session.error
        shown = world if session is None else session.world
        state = self._state_without_session() if session is None else session.shown
        return {
            "kind": "run",
            "number": number,
            "state": state,
            "error": None if fault is None else str(fault),
            "path": self._path,
            "name": world.name,
            "seconds": world.run.seconds if session is None else session.seconds,
            "dt": 1.0 / world.run.rate_hz,
            "seed": world.run.seed if session is None else session.seed,
            "speed": None if session is None else session.speed,
            "robots": robots_json(world, first=self._first),
            "mechanisms": mechanisms_json(world),
            "joints": joints_json(world),
            "controllable": session is not None,
            "recording": self._recording_of(session),
            "drivers": drivers_json(world),
            "noise": noise_json(shown, self._initial),
            "touched": [] if session is None else [event_keys(event) for event in session.touched],
        }

    def _recording_of(self, session: Session | None) -> str | None:
        """Return the path of the recording relative to the root; a restart writes another one."""
        if session is None or session.record is None or self._root is None:
            return None
        return session.record.relative_to(self._root).as_posix()

    def _state_without_session(self) -> State:
        """Return the state of a run whose ticks come from elsewhere."""
        if self.closing:
            return "ended"
        return "loading" if self.feed.newest is None else "running"

    def time(self) -> float:
        """Return the simulated time of the newest tick [s]."""
        newest = self.feed.newest
        return 0.0 if newest is None else newest.time

    def wake(self) -> None:
        """Serve the browsers soon; from any thread."""
        with self._counting:
            self._news += 1
        loop = self._loop
        if loop is not None and self.viewers and not self._woken:
            self._woken = True
            # The server may have ended meanwhile; then there are no browsers to serve.
            with contextlib.suppress(RuntimeError):
                loop.call_soon_threadsafe(self._publish)

    def join(self, viewer: Watching) -> None:
        """Add a viewer."""
        self._loop = asyncio.get_running_loop()
        self.viewers.add(viewer)
        self._left.clear()
        viewer.news.set()

    def leave(self, viewer: Watching) -> None:
        """Remove a viewer."""
        self.viewers.discard(viewer)
        if not self.viewers:
            self._left.set()

    def close(self) -> None:
        """End the run, and send viewers the last of it; not from the server's thread."""
        if self.session is not None:
            self.session.close()
        self.closing = True
        self.changed()
        if self.viewers:
            self._left.wait(FAREWELL_SECONDS)
        if self.painter is not None:
            self.painter.close()

    def _publish(self) -> None:
        self._published_news = self._news
        for viewer in self.viewers:
            viewer.news.set()
        if self._loop is not None:
            self._loop.call_later(POLL_SECONDS, self._rest)

    def _rest(self) -> None:
        self._woken = False
        if self._news != self._published_news:
            self.wake()

    def _share(self) -> float:
        """Return the fraction of time that may be spent on rendering beside the run."""
        session = self.session
        if session is None:
            return MAX_SPEED_VIEW_SHARE
        if session.state != "running":
            return 1.0
        if session.speed is None:
            return MAX_SPEED_VIEW_SHARE
        return 1.0 if self.feed.pace > LATE_RATIO * session.speed else BUSY_VIEW_SHARE


_NOTHING: Mapping[str, Any] = {
    "error": None,
    "path": None,
    "name": None,
    "seconds": None,
    "dt": 0.04,
    "seed": None,
    "speed": 1.0,
    "robots": [],
    "controllable": True,
    "recording": None,
}
