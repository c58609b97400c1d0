"""A run to watch in a browser on this machine while it goes on."""

import asyncio
import socket
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from types import TracebackType
from typing import Self

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from mjsim.errors import UsageError, did_you_mean
from mjsim.record import Tick
from mjsim.web.easel import Easel, Sheet
from mjsim.web.local import SameOrigin, listen, page_file
from mjsim.world import World

PERIOD = 1 / 12
"""Least time between two pictures [s]."""
FAREWELL = 1.0
"""A browser that has not asked for the last picture after this long misses it [s]."""
LONGEST_ASK = 1024
"""A browser has little to say [bytes]."""
START = 10.0
"""The server must be there after this long [s]."""


class LiveView:
    """A page on the loopback address that shows a run as its film will: `show` each tick while the block runs.

    A browser asks for the next picture when it has shown one, so a slow one misses pictures and holds up
    nobody. Pictures are drawn in the server's thread, and only when somebody waits for one.
    """

    def __init__(self, world: World, robot: str | None = None, *, port: int = 0) -> None:
        """Begin to serve the page.

        Args:
            world: Where the run is.
            robot: Whose run is shown; that of the first one that is driven unless given.
            port: Of the page; a free one unless given.

        Raises:
            UsageError: There is no such robot, or the port is taken.
        """
        names = [item.name for item in world.robots]
        if robot is not None and robot not in names:
            raise UsageError(f"no robot '{robot}' to show in this world{did_you_mean(robot, names)}")
        self._easel = Easel(world, robot)
        self._title = world.name
        listener = listen(port)
        self._port: int = listener.getsockname()[1]
        app = Starlette(
            routes=[
                Route("/", self._page),
                Route("/live.css", self._style),
                Route("/live.js", self._script),
                WebSocketRoute("/pictures", self._watch),
            ],
            lifespan=self._lifespan,
        )
        self._server = uvicorn.Server(
            uvicorn.Config(
                SameOrigin(app, self._port),
                ws="websockets-sansio",
                # JPEG gains little from it, and it costs half as much as drawing, for each who watches.
                ws_per_message_deflate=False,
                ws_max_size=LONGEST_ASK,
                log_config=None,
                access_log=False,
                server_header=False,
                timeout_graceful_shutdown=2,
            )
        )
        self._loop: asyncio.AbstractEventLoop | None = None
        self._ready = threading.Event()
        self._ended = False
        self._left = threading.Event()
        self._watchers = self._waiting = 0
        self._thread = threading.Thread(target=self._serve, args=[listener], name="live view", daemon=True)
        self._thread.start()
        if not self._ready.wait(START):
            raise UsageError(f"the page did not come up within {START:g} s; the machine may be overloaded")

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://127.0.0.1:{self._port}/"

    def show(self, tick: Tick) -> None:
        """Hand over a tick; the newest one is drawn when somebody waits for a picture."""
        if self._ended:
            return
        full = self._easel.take(tick)
        if self._waiting:
            self._call(self._wake)
        elif full:
            self._call(self._easel.catch_up)

    def close(self) -> None:
        """Show who watches the last tick, then stop serving; closing twice is no fault."""
        if self._call(self._end):
            self._left.wait(FAREWELL)
            self._call(self._cut_off)
        self._server.should_exit = True
        self._thread.join()

    def __enter__(self) -> Self:
        """Serve while the block runs."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop serving."""
        self.close()

    # What follows runs in the server's thread.

    def _serve(self, listener: socket.socket) -> None:
        asyncio.run(self._server.serve(sockets=[listener]))

    @asynccontextmanager
    async def _lifespan(self, _: Starlette) -> AsyncIterator[None]:
        self._news = asyncio.Event()
        self._drawing = asyncio.Lock()
        self._loop = asyncio.get_running_loop()
        self._ready.set()
        yield
        self._loop = None

    async def _page(self, _: Request) -> Response:
        return page_file("live.html", "text/html", title=self._title)

    async def _style(self, _: Request) -> Response:
        return page_file("live.css", "text/css")

    async def _script(self, _: Request) -> Response:
        return page_file("live.js", "text/javascript")

    async def _watch(self, socket: WebSocket) -> None:
        """Send a picture each time the browser asks, newer than the one it has."""
        await socket.accept()
        self._watchers += 1
        shown = 0
        try:
            while True:
                # Whatever it says is an ask.
                if (await socket.receive())["type"] == "websocket.disconnect":
                    return
                sheet = await self._newer(shown)
                if sheet is None:
                    await socket.close(1000, "ended")
                    return
                shown = sheet.number
                await socket.send_json({"time": sheet.time, "pace": sheet.pace})
                await socket.send_bytes(sheet.jpeg)
        except WebSocketDisconnect:
            return
        finally:
            self._watchers -= 1
            self._note_who_left()

    async def _newer(self, shown: int) -> Sheet | None:
        """Wait for a picture of a later tick; None when there will be none."""
        self._waiting += 1
        try:
            while self._easel.number <= shown and not self._ended:
                await self._news.wait()
        finally:
            self._waiting -= 1
        if self._easel.number <= shown:
            return None
        # Whoever comes first draws for all that ask within the period.
        async with self._drawing:
            sheet, rest = self._easel.sheet, 0.0 if self._ended else self._easel.age_left(PERIOD)
            if sheet is not None and sheet.number > shown and (rest or sheet.number == self._easel.number):
                return sheet
            await asyncio.sleep(rest)
            return self._easel.draw()

    def _wake(self) -> None:
        news, self._news = self._news, asyncio.Event()
        news.set()

    def _end(self) -> None:
        self._ended = True
        self._wake()
        self._note_who_left()

    def _cut_off(self) -> None:
        """Drop who does not take what was sent: the server would wait for them, and complain."""
        for connection in self._server.server_state.connections:
            if connection.transport.get_write_buffer_size():
                connection.transport.abort()

    def _note_who_left(self) -> None:
        if self._ended and not self._watchers:
            self._left.set()

    def _call(self, what: Callable[[], object]) -> bool:
        """Have the server's thread do something soon; false when it has ended."""
        loop = self._loop
        if loop is None or loop.is_closed():
            return False
        loop.call_soon_threadsafe(what)
        return True
