"""A server in a separate thread, for pages opened from Python or the command line."""

import asyncio
import contextlib
import socket
import threading
import time
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.routing import BaseRoute, Route
from starlette.types import ASGIApp

from mjsim.closing import Closes, join
from mjsim.errors import UsageError
from mjsim.progress import say
from mjsim.sentences import Sentence
from mjsim.web.server.answers import answer_get
from mjsim.web.server.browser import BrowserOpener
from mjsim.web.server.connections import Connections, HttpConnection, Limits, WebSocketConnection
from mjsim.web.server.entrance import PARAMETER, Entrance
from mjsim.web.server.local import LOOPBACK, SameOrigin, is_loopback, listen
from mjsim.web.server.session_keys import LIFETIME_SECONDS, Keys, Pass

MAX_MESSAGE_LENGTH = 8_000_000
"""Maximum size of a WebSocket message from a browser [bytes]: the text of a world."""
MAX_HEADERS = 65_536
"""Maximum size of a request's headers [bytes]; browsers send the cookies of all ports."""
START_TIMEOUT = 20.0
"""Time limit for the start of the server [s]."""
STOP_TIMEOUT = 60.0
"""Time limit for the end of the server: of requests that are still being answered [s]."""
AT_ONCE = 40
"""Maximum number of requests that are answered at the same time."""
MAX_QUEUED = 1024
"""Maximum number of connections waiting to be accepted."""
MIN_REPORT_INTERVAL = 60.0
"""Minimum interval between reports of a lack of file descriptors [s]."""


class Server(Closes):
    """Serves routes until it is closed, to authenticated browsers and the page's own origin only."""

    def __init__(
        self,
        routes: Sequence[BaseRoute],
        *,
        host: str = LOOPBACK,
        port: int = 0,
        token: str | None = None,
        without_token: bool = False,
        closing: Sequence[Callable[[], None]] = (),
        limits: Limits | None = None,
    ) -> None:
        """Start serving.

        Args:
            routes: Routes of HTTP and WebSocket.
            host: Address on which to listen.
            port: Port; by default a free one.
            token: Admits every client that knows it, in addition to the one-time addresses from `url`.
            without_token: Admit every program and user of this machine; for loopback addresses only.
            closing: Called on closing, before browsers are disconnected.
            limits: Limits of connections.

        Raises:
            UsageError: The port is taken, the address does not belong to this machine, or the token is not acceptable.
        """
        if without_token and (token is not None or not is_loopback(host)):
            raise UsageError("serving without a token works only on the loopback address, and excludes a token")
        self._host, self._closing = host, closing
        self._keys = None if without_token else Keys(token)
        limits = limits or Limits()
        self._connections, self._opening = Connections(limits), BrowserOpener()
        listener = listen(port, host=host)
        self.port: int = listener.getsockname()[1]
        invite = Route("/api/invite", answer_get(self._invite), methods=["POST"])
        # Late routes take all that is left.
        app = Starlette(routes=[invite, *routes], lifespan=self._lifespan)
        guarded = app if self._keys is None else Entrance(app, self._keys, port=self.port)
        self._ready, self._closed = threading.Event(), False
        self._server = _Uvicorn(
            _settings(SameOrigin(guarded, self.port, host=host), limits),
            self._connections,
            started=self._ready,
        )
        self._thread = threading.Thread(target=self._serve, args=[listener], name="page", daemon=True)
        self._thread.start()
        if not self._ready.wait(START_TIMEOUT):
            raise UsageError(
                Sentence(
                    "the server did not start within {start_timeout:g} s; the machine may be overloaded", START_TIMEOUT
                )
            )

    @property
    def address(self) -> str:
        """Address of the page; unauthenticated browsers are asked for the token there."""
        host = self._host if self._host not in ("0.0.0.0", "::") else socket.gethostname()
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self.port}/"

    @property
    def url(self) -> str:
        """A new address that admits one browser, once, within five minutes; `address` if no token is required."""
        return self.address if self._keys is None else self._address_with(self._keys.new_pass())

    def open(self, *, failed: Callable[[], None]) -> None:
        """Open the page in the browser of this machine, authenticated; the secret appears on no command line.

        Args:
            failed: Called from another thread if there is no browser.
        """
        if self._keys is None:
            self._opening.open(self.address, failed=failed)
        else:
            given = self._keys.new_pass()
            self._opening.open_privately(self._address_with(given), given.over, failed=failed)

    def wait(self) -> None:
        """Serve until it is closed from elsewhere, or Ctrl-C interrupts."""
        while self._thread.is_alive():
            self._thread.join(1.0)

    def close(self) -> None:
        """Stop serving; a second call does nothing."""
        if not self._closed:
            self._closed = True
            for call in self._closing:
                call()
            self._loop.call_soon_threadsafe(self._connections.close_all)
        self._server.should_exit = True
        join(self._thread, within=STOP_TIMEOUT)
        self._opening.close()

    def _address_with(self, given: Pass) -> str:
        return f"{self.address}?{PARAMETER}={given.word}"

    def _invite(self, _: Request) -> Mapping[str, Any]:
        """Return an address for another browser, to an authenticated one."""
        return {"url": self.url, "minutes": None if self._keys is None else LIFETIME_SECONDS / 60.0}

    def _serve(self, listener: socket.socket) -> None:
        asyncio.run(self._server.serve(sockets=[listener]))

    @contextlib.asynccontextmanager
    async def _lifespan(self, _: Starlette) -> AsyncIterator[Mapping[str, Any]]:
        self._loop = asyncio.get_running_loop()
        self._loop.set_default_executor(ThreadPoolExecutor(AT_ONCE, thread_name_prefix="mjsim-answers"))
        async with self._connections.sweeping():
            yield {"connections": self._connections}


def _settings(app: ASGIApp, limits: Limits) -> uvicorn.Config:
    """Return the configuration of a server whose clients may be unauthenticated."""
    return uvicorn.Config(
        app,
        http=HttpConnection,
        ws=WebSocketConnection,
        # Compression gains little for JPEG, and costs half as much as rendering, for each viewer.
        ws_per_message_deflate=False,
        ws_max_size=MAX_MESSAGE_LENGTH,
        ws_ping_interval=limits.ping,
        ws_ping_timeout=limits.ping,
        h11_max_incomplete_event_size=MAX_HEADERS,
        backlog=limits.batch,
        # Anybody could claim another address in headers.
        proxy_headers=False,
        log_config=None,
        # Invalid requests are rejected; unauthenticated clients must not fill the terminal with messages.
        log_level="error",
        access_log=False,
        server_header=False,
        timeout_graceful_shutdown=2,
    )


class _Uvicorn(uvicorn.Server):
    """Accepts connections in small batches from a long queue, and survives a lack of file descriptors."""

    def __init__(self, config: uvicorn.Config, connections: Connections, *, started: threading.Event) -> None:
        super().__init__(config)
        self._connections, self._started, self._complained = connections, started, -MIN_REPORT_INTERVAL

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start serving."""
        asyncio.get_running_loop().set_exception_handler(self._complain)
        await super().startup(sockets=sockets)
        for listener in sockets or ():
            # The server's own setting, `backlog`, is also the size of a batch.
            listener.listen(MAX_QUEUED)
        self._started.set()

    def _complain(self, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        """Report a lack of file descriptors on one line, and make room; the event loop tries again after a second."""
        if "out of system resource" not in context.get("message", ""):
            loop.default_exception_handler(context)
            return
        self._connections.make_room()
        if time.monotonic() - self._complained >= MIN_REPORT_INTERVAL:
            self._complained = time.monotonic()
            say("this process has no file descriptors left for connections; some were closed, and the page continues")
