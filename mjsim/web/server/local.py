"""Listening sockets, and a guard that answers only requests of the page's own origin."""

import ipaddress
import socket

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from mjsim.errors import UsageError

LOOPBACK = "127.0.0.1"
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; "
    "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""The page loads nothing from elsewhere, and no other page may frame or read it."""
_ENTRANCES = ("/", "/favicon.ico")
"""Links on other pages may lead here; a visit changes nothing."""


def is_loopback(host: str) -> bool:
    """Return whether an address is a loopback address, which no other machine can reach."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def listen(port: int, *, host: str = LOOPBACK) -> socket.socket:
    """Return a listening socket; port 0 selects a free one.

    Raises:
        UsageError: The port is taken, or the address does not belong to this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        # Browsers that connect before the server is ready are queued.
        listener.listen()
    except (OSError, OverflowError) as error:
        listener.close()
        if isinstance(error, socket.gaierror) or "assign" in str(error):
            raise UsageError(f"cannot serve at '{host}': it is not an address of this machine; try 0.0.0.0") from error
        reason = error.strerror if isinstance(error, OSError) else "there are ports 0 to 65535"
        raise UsageError(f"cannot serve on port {port}: {reason}; 0 selects a free one") from error
    return listener


class SameOrigin:
    """Rejects requests of other pages, and a wrong Host header (DNS rebinding)."""

    def __init__(self, app: ASGIApp, port: int, *, host: str = LOOPBACK) -> None:
        """Protect an application that is served at an address and a port."""
        self._app = app
        self._hosts: set[str] | None = None
        if is_loopback(host):
            shown = f"[{host}]" if ":" in host else host
            # Browsers omit the default port.
            ends = ("", f":{port}") if port == 80 else (f":{port}",)
            self._hosts = {f"{name}{end}" for name in (shown, "localhost") for end in ends}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer 403."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif self._is_own(scope, Headers(scope=scope)):
            await self._app(scope, receive, _with_headers(send))
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            message = "refused: this page is for its own address only; open the one that was printed"
            await JSONResponse({"error": message}, 403, headers={**HEADERS, "Connection": "close"})(
                scope, receive, send
            )

    def _is_own(self, scope: Scope, headers: Headers) -> bool:
        hosts = headers.getlist("host")
        if len(hosts) != 1 or (self._hosts is not None and hosts[0] not in self._hosts):
            return False
        # At other addresses the machine may have any name; there the session identifies the client.
        origins = {f"http://{host}" for host in self._hosts or hosts}
        if not all(origin in origins for origin in headers.getlist("origin")):
            return False
        # Browsers send this also with pictures and scripts, for which they send no origin.
        site = headers.get("sec-fetch-site", "none")
        visit = headers.get("sec-fetch-mode") == "navigate" and scope["path"] in _ENTRANCES
        return site in ("same-origin", "none") or (visit and scope.get("method") == "GET")


def _with_headers(send: Send) -> Send:
    """Return `send` with missing headers added to responses, such as those of the framework for unknown addresses."""

    async def sent(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return sent
