"""What keeps a page to this machine: the loopback address, and answers for its own origin alone."""

import html
import socket
from importlib import resources

from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from mjsim.errors import UsageError

LOOPBACK = "127.0.0.1"
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}
"""The page loads nothing from elsewhere, and no other page may frame or read it."""


def listen(port: int) -> socket.socket:
    """Return a socket that listens on the loopback address; port 0 takes a free one.

    Raises:
        UsageError: The port is taken.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((LOOPBACK, port))
        # Browsers that come before the server is ready wait in line.
        listener.listen()
    except (OSError, OverflowError) as error:
        listener.close()
        reason = error.strerror if isinstance(error, OSError) else "there are ports 0 to 65535"
        raise UsageError(f"cannot serve at port {port}: {reason}; 0 takes a free one") from error
    return listener


def page_file(name: str, kind: str, *, title: str = "") -> Response:
    """Return a file of the page, its title filled in."""
    text = resources.files("mjsim.web").joinpath(name).read_text(encoding="utf-8")
    return Response(text.replace("{{title}}", html.escape(title)), media_type=kind, headers=HEADERS)


class SameOrigin:
    """Refuses what another page asks for: a wrong Host (DNS rebinding) or a wrong Origin."""

    def __init__(self, app: ASGIApp, port: int) -> None:
        """Guard an application that is served at a port of the loopback address."""
        self._app = app
        self._hosts = {f"{name}:{port}".encode() for name in (LOOPBACK, "localhost")}
        self._origins = {b"http://" + host for host in self._hosts}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it with 403."""
        if scope["type"] == "lifespan" or self._is_own(scope):
            await self._app(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            await PlainTextResponse("refused: this page is for its own address only\n", 403)(scope, receive, send)

    def _is_own(self, scope: Scope) -> bool:
        hosts = [value for name, value in scope["headers"] if name == b"host"]
        origins = [value for name, value in scope["headers"] if name == b"origin"]
        return len(hosts) == 1 and hosts[0] in self._hosts and all(origin in self._origins for origin in origins)
