"""A server in a thread of its own, for pages that are opened from Python or from the command line."""

import asyncio
import contextlib
import secrets
import socket
import threading
from collections.abc import AsyncIterator, Callable, Sequence

import uvicorn
from starlette.applications import Starlette
from starlette.routing import BaseRoute

from mjsim.closing import Closes
from mjsim.errors import UsageError
from mjsim.web.local import LOOPBACK, SameOrigin, is_loopback, listen

LONGEST_MESSAGE = 8_000_000
"""Of a browser over a WebSocket [bytes]: it sends the text of a world."""
START = 20.0
"""The server must be there after this long [s]."""


class Server(Closes):
    """Serves routes until it is closed, guarded as `SameOrigin` does."""

    def __init__(
        self,
        routes: Sequence[BaseRoute],
        *,
        host: str = LOOPBACK,
        port: int = 0,
        token: str | None = None,
        closing: Sequence[Callable[[], None]] = (),
    ) -> None:
        """Begin to serve.

        Args:
            routes: Of HTTP and WebSocket.
            host: Address to listen at; another than this machine's own needs a token, which is made unless given.
            port: A free one unless given.
            token: That everybody must have.
            closing: Called when it ends, before browsers are let go.

        Raises:
            UsageError: The port is taken, or the address is none of this machine.
        """
        self._host, self._closing = host, closing
        self._token = token or (None if is_loopback(host) else secrets.token_urlsafe(16))
        listener = listen(port, host=host)
        self.port: int = listener.getsockname()[1]
        app = Starlette(routes=routes, lifespan=self._lifespan)
        self._server = uvicorn.Server(
            uvicorn.Config(
                SameOrigin(app, self.port, host=host, token=self._token),
                ws="websockets-sansio",
                # JPEG gains little from it, and it costs half as much as drawing, for each who watches.
                ws_per_message_deflate=False,
                ws_max_size=LONGEST_MESSAGE,
                log_config=None,
                access_log=False,
                server_header=False,
                timeout_graceful_shutdown=2,
            )
        )
        self._ready, self._closed = threading.Event(), False
        self._thread = threading.Thread(target=self._serve, args=[listener], name="page", daemon=True)
        self._thread.start()
        if not self._ready.wait(START):
            raise UsageError(f"the page did not come up within {START:g} s; the machine may be overloaded")

    @property
    def url(self) -> str:
        """Address of the page, with its token when it has one."""
        host = self._host if self._host not in ("0.0.0.0", "::") else socket.gethostname()
        shown = f"[{host}]" if ":" in host else host
        return f"http://{shown}:{self.port}/" + (f"?token={self._token}" if self._token else "")

    def wait(self) -> None:
        """Serve until it is closed from elsewhere, or Ctrl-C interrupts."""
        while self._thread.is_alive():
            self._thread.join(1.0)

    def close(self) -> None:
        """Stop serving; closing twice is no fault."""
        if not self._closed:
            self._closed = True
            for call in self._closing:
                call()
            self._loop.call_soon_threadsafe(self._cut_off)
        self._server.should_exit = True
        self._thread.join()

    def _serve(self, listener: socket.socket) -> None:
        asyncio.run(self._server.serve(sockets=[listener]))

    @contextlib.asynccontextmanager
    async def _lifespan(self, _: Starlette) -> AsyncIterator[None]:
        self._loop = asyncio.get_running_loop()
        self._ready.set()
        yield

    def _cut_off(self) -> None:
        """Drop who does not take what was sent: the server would wait for them, and complain."""
        for connection in self._server.server_state.connections:
            if connection.transport.get_write_buffer_size():
                connection.transport.abort()
