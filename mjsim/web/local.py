"""What keeps a page to those it is for: the loopback address or a token, and answers for its own origin alone."""

import hmac
import ipaddress
import socket
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from mjsim.errors import UsageError

LOOPBACK = "127.0.0.1"
COOKIE = "mjsim-token-{port}"
"""Its name: machines have one set of cookies for all ports."""
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
"""A link on another page may lead here; there is nothing to be done by it."""


def is_loopback(host: str) -> bool:
    """Return whether an address is this machine's own, which no other can reach."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def listen(port: int, *, host: str = LOOPBACK) -> socket.socket:
    """Return a socket that listens; port 0 takes a free one.

    Raises:
        UsageError: The port is taken, or the address is none of this machine.
    """
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind((host, port))
        # Browsers that come before the server is ready wait in line.
        listener.listen()
    except (OSError, OverflowError) as error:
        listener.close()
        if isinstance(error, socket.gaierror) or "assign" in str(error):
            raise UsageError(f"cannot serve at '{host}': it is no address of this machine; try 0.0.0.0") from error
        reason = error.strerror if isinstance(error, OSError) else "there are ports 0 to 65535"
        raise UsageError(f"cannot serve at port {port}: {reason}; 0 takes a free one") from error
    return listener


class SameOrigin:
    """Refuses what another page asks for, a wrong Host (DNS rebinding), and who does not have the token."""

    def __init__(self, app: ASGIApp, port: int, *, host: str = LOOPBACK, token: str | None = None) -> None:
        """Guard an application.

        Args:
            app: What is guarded.
            port: That it is served at.
            host: The address that it is served at.
            token: Asked of everybody; without one only the loopback address is served.
        """
        assert token or is_loopback(host), "an address that others can reach needs a token"
        self._app, self._token, self._cookie = app, token, COOKIE.format(port=port)
        self._hosts: set[str] | None = None
        if is_loopback(host):
            shown = f"[{host}]" if ":" in host else host
            # Browsers leave out the port that all know.
            behind = ("", f":{port}") if port == 80 else (f":{port}",)
            self._hosts = {f"{name}{end}" for name in (shown, "localhost") for end in behind}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it: 403 for another page's, 401 without the token."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        if not self._is_own(scope, headers):
            answer: Response = _refusal(403, "this page is for its own address only; open the one that was printed")
        elif self._token is None or self._is_known(headers):
            await self._app(scope, receive, send)
            return
        elif _given_token(scope, self._token):
            answer = RedirectResponse(scope["path"], 303, headers=HEADERS)
            answer.set_cookie(self._cookie, self._token, httponly=True, samesite="strict")
        else:
            answer = _refusal(401, "this page needs its token; open the address that was printed, with '?token='")
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            await answer(scope, receive, send)

    def _is_own(self, scope: Scope, headers: Headers) -> bool:
        hosts = headers.getlist("host")
        if len(hosts) != 1 or (self._hosts is not None and hosts[0] not in self._hosts):
            return False
        # Where others may come from, the name of the machine may be any: the token is what they must have.
        origins = {f"http://{host}" for host in self._hosts or hosts}
        if not all(origin in origins for origin in headers.getlist("origin")):
            return False
        # Browsers say so of pictures and scripts too, for which they give no origin.
        site = headers.get("sec-fetch-site", "none")
        visit = headers.get("sec-fetch-mode") == "navigate" and scope["path"] in _ENTRANCES
        return site in ("same-origin", "none") or (visit and scope.get("method") == "GET")

    def _is_known(self, headers: Headers) -> bool:
        cookies: SimpleCookie = SimpleCookie()
        for line in headers.getlist("cookie"):
            try:
                cookies.load(line)
            except CookieError:
                return False
        return self._cookie in cookies and _equal(cookies[self._cookie].value, self._token or "")


def _given_token(scope: Scope, token: str) -> bool:
    """Return whether the address that is asked for carries the token."""
    given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
    return scope["type"] == "http" and len(given) == 1 and _equal(given[0], token)


def _equal(given: str, token: str) -> bool:
    """Compare in a time that tells nothing."""
    return hmac.compare_digest(given.encode(), token.encode())


def _refusal(status: int, message: str) -> Response:
    return JSONResponse({"error": f"refused: {message}"}, status, headers=HEADERS)
