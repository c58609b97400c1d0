"""Bounds connections in number and duration, so that unauthenticated clients never lock out authenticated ones.

The classes extend uvicorn's protocols, which its settings `http` and `ws` take: its own `limit_concurrency` counts all
connections alike, so that one unauthenticated client could fill it, and it closes no peer that does not read.
"""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable, Iterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.exceptions import HeaderLineTooLong, RequestLineTooLong, TooManyHeaders
from websockets.frames import CloseCode, Frame

from mjsim.web.server.request_bodies import Bodies

SWEEP_SECONDS = 0.5
"""Interval between checks of the connections [s]."""
COOKIE = "mjsim-session-"
"""Prefix of the name of a server's cookie, before its port; all ports of an address share one cookie jar."""
MAX_COOKIE, MAX_COOKIES = 200, 50
"""Maximum length of our cookies [characters], and how many are checked; another port may have set more."""
MAX_FRAGMENTS = 10_000
"""Maximum number of fragments of a WebSocket message; browsers use fragments of 64 kB and more."""
_OF_UPGRADES = (b"host", b"origin", b"upgrade", b"connection")
_PONG = 0x8A
"""First byte of a pong frame."""


def _open_files() -> int:
    """Return the maximum number of open files of this process."""
    try:
        import resource
    except ImportError:  # Windows
        return 2048
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return 2048 if soft == resource.RLIM_INFINITY else soft


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """Limits on the number and duration of connections."""

    strangers: int = field(default_factory=lambda: max(40, min(_open_files() // 6, 200)))
    """Maximum number of connections without a session; a new one replaces the oldest."""
    known: int = field(default_factory=lambda: max(60, min(_open_files() // 4, 300)))
    """Maximum number of connections with a session."""
    stranger: float = 10.0
    """An unauthenticated connection is closed after this time in any case [s]."""
    idle: float = 60.0
    """A connection that stalls during a request, or does not read its response, is closed after this time [s]."""
    ping: float = 20.0
    """Interval of pings on a WebSocket, and the time allowed for each reply [s]."""

    @property
    def batch(self) -> int:
        """Maximum number of connections accepted at once.

        The first request of a connection is read after a few turns of the event loop. This number times these turns
        stays well below `strangers`, so that a flood cannot displace a request that is sent at once.
        """
        return max(2, self.strangers // 10)


class Visitor:
    """One connection."""

    def __init__(self, connections: "Connections", transport: asyncio.Transport) -> None:
        """Register a new connection."""
        self._connections, self._now = connections, asyncio.get_running_loop().time
        self.transport = transport
        self.since = self.received = self.moved = self._now()
        """Time of connection; of the last data received; of the last decrease of pending output [s]."""
        self.waiting = 0
        """Pending output at the last check [bytes]."""
        self.peer: str | None = None
        """Identity of the peer, once determined."""
        self.is_owed: Callable[[], bool] = lambda: False
        """Returns whether the server has to act next."""

    def note_data(self) -> None:
        """Record that data arrived."""
        self.received = self._now()

    def let_in(self) -> bool:
        """Count it as authenticated; return False if there are too many of those."""
        return self._connections.let_in(self)

    def leave(self) -> None:
        """Unregister it."""
        self._connections.leave(self)

    def is_stuck(self, patience: float) -> bool:
        """Return whether it has stalled for longer than `patience` [s]."""
        now, before = self._now(), self.waiting
        self.waiting = self.transport.get_write_buffer_size()
        if not self.waiting or self.waiting < before:
            self.moved = now
        silent = now - self.received > patience and not self.waiting and not self.is_owed()
        return silent or now - self.moved > patience


class Connections:
    """All connections of a server; for use in its event loop only."""

    def __init__(self, limits: Limits) -> None:
        """Start without connections."""
        self.limits, self.bodies = limits, Bodies()
        self._max_strangers = limits.strangers
        self._strangers: dict[Visitor, None] = {}
        self._known: set[Visitor] = set()

    def arrive(self, transport: asyncio.Transport) -> Visitor:
        """Register a connection; if there are too many unauthenticated ones, the oldest is closed."""
        while len(self._strangers) >= self._max_strangers:
            self._drop(next(iter(self._strangers)))
        visitor = Visitor(self, transport)
        self._strangers[visitor] = None
        return visitor

    def let_in(self, visitor: Visitor) -> bool:
        """Count a connection as authenticated; return False if there are too many of those."""
        if visitor in self._strangers:
            if len(self._known) >= self.limits.known:
                return False
            del self._strangers[visitor]
            self._known.add(visitor)
        return True

    def leave(self, visitor: Visitor) -> None:
        """Unregister a closed connection."""
        self._strangers.pop(visitor, None)
        self._known.discard(visitor)

    def make_room(self) -> None:
        """Close all unauthenticated connections and lower their limit: file descriptors have run out."""
        self._max_strangers = max(3 * self.limits.batch, min(self._max_strangers, len(self._strangers)) // 2)
        for visitor in list(self._strangers):
            self._drop(visitor)

    def close_all(self) -> None:
        """Close the connections whose peers do not read: a closing server would wait for them."""
        for visitor in [*self._strangers, *self._known]:
            if visitor.transport.get_write_buffer_size():
                self._drop(visitor)

    @asynccontextmanager
    async def sweeping(self) -> AsyncIterator[None]:
        """Close connections that take too long, while the block runs."""
        task = asyncio.create_task(self._sweep())
        try:
            yield
        finally:
            task.cancel()
            with suppress(asyncio.CancelledError):
                await task

    async def _sweep(self) -> None:
        now = asyncio.get_running_loop().time
        while True:
            await asyncio.sleep(min(SWEEP_SECONDS, self.limits.stranger / 2, self.limits.idle / 2))
            late = [each for each in self._strangers if now() - each.since > self.limits.stranger]
            for visitor in late + [each for each in self._known if each.is_stuck(self.limits.idle)]:
                self._drop(visitor)

    def _drop(self, visitor: Visitor) -> None:
        self.leave(visitor)
        visitor.transport.abort()


class HttpConnection(H11Protocol):
    """An HTTP connection counted by the server; requests carry it in their state as `visitor`."""

    visitor: Visitor

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Register it."""
        connections: Connections = self.app_state["connections"]
        self.visitor = connections.arrive(transport)
        self.visitor.is_owed = self._is_owed
        self.app_state = {**self.app_state, "visitor": self.visitor}
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Record that data arrived, and process it."""
        self.visitor.note_data()
        super().data_received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        """Unregister it."""
        self.visitor.leave()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Pass on only the headers that a WebSocket needs: its parser accepts only few and short ones."""
        self.headers = list(_upgrade_headers(self.headers))
        super().handle_websocket_upgrade(event)

    def _is_owed(self) -> bool:
        """Return whether a complete request was received and not yet answered."""
        return self.conn.their_state not in (h11.IDLE, h11.SEND_BODY)


class WebSocketConnection(WebSocketsSansIOProtocol):
    """A WebSocket counted by the server; what it stores for its peer is bounded."""

    def connection_made(self, transport: Any) -> None:
        """Take over from the connection that requested the upgrade."""
        self._visitor: Visitor = self.app_state["visitor"]
        # Silent peers are pinged.
        self._visitor.is_owed = lambda: True
        self._pong = b""
        super().connection_made(transport)

    def data_received(self, data: bytes) -> None:
        """Process data, and answer a request that cannot be parsed."""
        super().data_received(data)
        if self.conn.handshake_exc is not None and not self.handshake_initiated:
            self.handshake_initiated = True
            self.transport.write(_unread(self.conn.handshake_exc))
            self.transport.close()

    def handle_cont(self, event: Frame) -> None:
        """Receive a fragment of a message; empty ones take memory but do not add to its size."""
        if len(self.frames) < MAX_FRAGMENTS:
            super().handle_cont(event)
        else:
            self._fail(CloseCode.MESSAGE_TOO_BIG)

    def handle_ping(self) -> None:
        """Answer pings; for a peer that does not read, only the newest one (RFC 6455, section 5.5.3)."""
        for frame in self.conn.data_to_send():
            if self.writable.is_set() or frame[:1] != bytes([_PONG]):
                self.transport.write(frame)
            else:
                self._pong = frame

    def resume_writing(self) -> None:
        """Continue: the peer reads again."""
        super().resume_writing()
        if self._pong:
            self.transport.write(self._pong)
            self._pong = b""

    def send_receive_event_to_app(self) -> None:
        """Pass on a message; invalid UTF-8 ends the connection without a traceback on the terminal."""
        if self.curr_msg_data_type == "text":
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError:
                self._fail(CloseCode.INVALID_DATA)
                return
        super().send_receive_event_to_app()

    async def receive(self) -> Any:
        """Return the next message; a flood of small ones blocks nothing, and a closed connection is noticed at once."""
        await asyncio.sleep(0)
        return await super().receive()

    def _fail(self, code: CloseCode) -> None:
        self.frames = []
        if not self.close_sent and not self.transport.is_closing():
            self.conn.fail(code)
            self.handle_parser_exception()
            self.transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        """Unregister it."""
        self._visitor.leave()
        super().connection_lost(exc)


def _upgrade_headers(headers: Iterable[tuple[bytes, bytes]]) -> Iterator[tuple[bytes, bytes]]:
    """Yield the headers that a WebSocket needs, and our cookies, each as a separate header."""
    cookies = 0
    for name, value in headers:
        if name == b"cookie":
            for pair in value.split(b";"):
                ours = pair.strip().startswith(COOKIE.encode()) and len(pair) <= MAX_COOKIE
                if ours and cookies < MAX_COOKIES:
                    cookies += 1
                    yield name, pair.strip()
        elif name in _OF_UPGRADES or name.startswith((b"sec-websocket-", b"sec-fetch-")):
            yield name, value


def _unread(error: Exception) -> bytes:
    """Return the response to a WebSocket request that its parser rejected."""
    long = isinstance(error, (RequestLineTooLong, HeaderLineTooLong, TooManyHeaders))
    status = "431 Request Header Fields Too Large" if long else "400 Bad Request"
    return f"HTTP/1.1 {status}\r\nConnection: close\r\nContent-Length: 0\r\n\r\n".encode()
