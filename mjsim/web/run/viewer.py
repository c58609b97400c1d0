"""A browser that watches a run: its views, the pictures in transit, and its next messages."""

import asyncio
import json
import time
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from mjsim.errors import MjsimError
from mjsim.record import Tick
from mjsim.sentences import with_sentences
from mjsim.web.run.current_run import Stage
from mjsim.web.run.feed import Shot
from mjsim.web.run.requests import FrameShown, Outside, Watch
from mjsim.web.run.scene_3d import Scene3dShelf
from mjsim.web.run.shots import FAR, NEAR, depth_shown, jpeg, segmentation_shown
from mjsim.web.run.tick_json import recognised_json

Make = Callable[[], Awaitable[tuple[float, bytes]]]
"""Makes a picture: its time [s], and JPEG data or poses of bodies."""
Source = tuple[dict[str, Any], Make]
"""The header of a picture, and what makes it."""
MIN_TICK_INTERVAL = 1 / 30
"""Minimum interval between two ticks [s]."""
MAX_PENDING = 2
"""Maximum number of pictures per view that a browser has not displayed yet."""
OUTSIDE, BODIES = "outside", "bodies"
OUTSIDE_EVERY = 1 / 25
"""Minimum interval between two external views [s]."""


@dataclass(slots=True)
class _View:
    """What a browser has received of one view."""

    pending: set[int] = field(default_factory=set)
    drawing: bool = False
    last: Any = None
    """Subject of the last picture."""
    at: float = 0.0
    """When it was sent, on the clock [s]."""


class Viewer:
    """A browser. Data for which it is too slow are dropped, never queued, and do not block others."""

    def __init__(self, socket: WebSocket, stage: Stage, *, solids: Scene3dShelf) -> None:
        """Serve an authenticated browser; `solids` contains the 3-D scene that it requested."""
        self._socket, self._stage, self._solids = socket, stage, solids
        self.news = asyncio.Event()
        """Set when there is something to send."""
        self._sending = asyncio.Lock()
        self._watch = Watch(do="watch")
        self._views: dict[str, _View] = {}
        self._tasks: set[asyncio.Task[None]] = set()
        self._frame = self._tick = self._events = 0
        self._run = self._show = 0
        self._version = -1
        self._tick_at = 0.0

    def watch(self, watch: Watch) -> None:
        """Send these views from now on."""
        self._watch = watch
        names = _views_of(watch)
        self._views = {name: self._views.get(name, _View()) for name in names}
        self.news.set()

    def shown(self, shown: FrameShown) -> None:
        """Record that a picture was displayed; another may be sent."""
        for view in self._views.values():
            view.pending.discard(shown.number)
        self.news.set()

    async def send(self, news: Mapping[str, Any]) -> None:
        """Send a message to this browser only."""
        await self._send(json.dumps(with_sentences(news), allow_nan=False))

    async def serve(self) -> None:
        """Send news until the browser disconnects, or the end."""
        try:
            while not self._stage.closing:
                await self.news.wait()
                self.news.clear()
                await self._send_news()
                self._begin_pictures()
            await self._send_news()
            await self._socket.close(1000, "ended")
        finally:
            for task in self._tasks:
                task.cancel()

    async def _send_news(self) -> None:
        stage, feed = self._stage, self._stage.feed
        version, show = stage.version, stage.show
        # A world comes after its run: a page that does not know the run ignores it.
        if (self._version, self._show) != (version, show):
            self._version = version
            await self.send({**stage.run_json(), "time": stage.time()})
        if self._show != show:
            self._show = show
            await self._send(stage.scene_text())
        if self._run != feed.run:
            self._run = feed.run
            self._events, past = await asyncio.to_thread(feed.past)
            await self.send(past)
        self._events, events = feed.events(self._events)
        for event in events:
            await self.send(event)
        await self._send_tick()

    async def _send_tick(self) -> None:
        """Send the newest tick, later if one was sent just now."""
        if self._stage.feed.number == self._tick:
            return
        rest = self._tick_at + MIN_TICK_INTERVAL - time.perf_counter()
        if rest > 0.0 and not self._stage.closing:
            asyncio.get_running_loop().call_later(rest, self.news.set)
        elif (told := self._stage.feed.tick()) is not None:
            self._tick, text = told
            self._tick_at = time.perf_counter()
            await self._send(text)

    def _begin_pictures(self) -> None:
        """Start sending what is new in each view."""
        for name, view in self._views.items():
            if view.drawing or len(view.pending) >= MAX_PENDING:
                continue
            source = self._source(name, view)
            if source is not None:
                view.drawing = True
                task = asyncio.create_task(self._send_picture(name, view, source=source))
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)

    def _source(self, name: str, view: _View) -> Source | None:
        """Return a function that makes the next picture of a view, if there is anything new in it."""
        if name == OUTSIDE:
            return self._outside(view)
        return self._bodies(view) if name == BODIES else self._onboard(name, view)

    def _bodies(self, view: _View) -> Source | None:
        """Return a function that returns the poses of bodies, if the time has changed and the scene is ready."""
        tick, solids = self._stage.feed.newest, self._solids.held(self._stage.feed.world)
        if tick is None or solids is None or view.last is tick:
            return None
        view.last = tick

        async def where(_: str, at: Tick) -> tuple[float, bytes]:
            return at.time, await asyncio.to_thread(solids.poses, at.time, at.qpos, at.looks)

        return {"recognised": []}, partial(self._stage.once, BODIES, tick, make=where)

    def _outside(self, view: _View) -> Source | None:
        """Return a function that renders the external view, if there is anything new in it."""
        tick, painter, outside = self._stage.feed.newest, self._stage.painter, self._watch.outside
        if tick is None or painter is None or outside is None or view.last == (tick, outside):
            return None
        rest = view.at + OUTSIDE_EVERY - time.perf_counter()
        if rest > 0.0:
            asyncio.get_running_loop().call_later(rest, self.news.set)
            return None
        view.at = time.perf_counter()

        def newest() -> tuple[Tick, Outside]:
            now = self._stage.feed.newest or tick, self._watch.outside or outside
            view.last = now
            return now

        return {"recognised": []}, partial(painter.outside, newest)

    def _onboard(self, name: str, view: _View) -> Source | None:
        """Return a function that makes a picture of an onboard camera, if there is a new one."""
        camera, _, kind = name.partition(":")
        shot = self._stage.feed.shots.get(camera)
        if shot is None or view.last is shot:
            return None
        view.last = shot
        head: dict[str, Any] = {"recognised": []}
        if kind == "depth":
            head["scale"] = [NEAR, FAR]
        if not kind:
            head["recognised"] = recognised_json(shot.sightings)
        return head, partial(self._stage.once, name, shot, make=self._encode)

    async def _encode(self, name: str, shot: Shot) -> tuple[float, bytes]:
        """Return time and JPEG of an onboard camera's picture, or of its depth or segmentation."""
        camera, _, kind = name.partition(":")
        frame, feed, painter, tick = shot.frame, self._stage.feed, self._stage.painter, self._stage.feed.newest
        if kind == "depth" and frame.depth is not None:
            depth = frame.depth
            return frame.stamp, await asyncio.to_thread(lambda: jpeg(depth_shown(depth)))
        if kind == "segmentation" and frame.segmentation is not None:
            return frame.stamp, await asyncio.to_thread(lambda: jpeg(segmentation_shown(frame)))
        if kind and painter is not None and tick is not None:
            return await painter.onboard(lambda: feed.newest or tick, camera, kind=kind)
        return frame.stamp, await asyncio.to_thread(jpeg, frame.image)

    async def _send_picture(self, name: str, view: _View, *, source: Source) -> None:
        head, make = source
        try:
            taken, data = await make()
            self._frame += 1
            number = self._frame
            view.pending.add(number)
            told = {"number": number, "view": name, "time": taken, **head}
            header = json.dumps(told, allow_nan=False).encode()
            await self._send(len(header).to_bytes(4, "little") + header + data)
        except MjsimError as error:
            await self.send({"kind": "refused", "do": "watch", "error": str(error)})
        except (WebSocketDisconnect, RuntimeError):
            return
        finally:
            view.drawing = False
            self.news.set()

    async def _send(self, message: str | bytes) -> None:
        async with self._sending:
            if isinstance(message, str):
                await self._socket.send_text(message)
            else:
                await self._socket.send_bytes(message)


def _views_of(watch: Watch) -> list[str]:
    """Return the names of the watched views."""
    kinds = ["", *([":depth"] if watch.depth else []), *([":segmentation"] if watch.segmentation else [])]
    names = [f"{camera}{kind}" for camera in watch.cameras for kind in kinds]
    return [*names, *([OUTSIDE] if watch.outside is not None else []), *([BODIES] if watch.bodies else [])]
