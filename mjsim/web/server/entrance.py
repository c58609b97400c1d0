"""Authentication of requests: browsers with a session pass; others exchange a one-time address or the token for one."""

from collections.abc import Iterator
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

from mjsim.web.server.answers import RefusedError, read_body
from mjsim.web.server.connections import COOKIE, Visitor
from mjsim.web.server.entrance_pages import LOGIN_HEADERS, WELCOME_HEADERS, login_page, welcome_page
from mjsim.web.server.local import HEADERS
from mjsim.web.server.peer import peer_of
from mjsim.web.server.session_keys import Keys
from mjsim.web.server.token_penalty import Penalty

PARAMETER = "token"
"""Query parameter with the one-time word."""
LOGIN = "/login"
_MAX_BODY = 4096
_REFUSAL = "this page needs a session; open the address that mjsim printed, or log in at '/'"


class Entrance:
    """Passes requests of authenticated browsers to an application, and no others."""

    def __init__(self, app: ASGIApp, keys: Keys, *, port: int) -> None:
        """Protect an application that is served at a port."""
        self._app, self._keys = app, keys
        self._cookie = f"{COOKIE}{port}"
        self._penalty = Penalty()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or answer it: 401 without a session, 429 after too many wrong tokens."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif self._is_known(scope):
            await self._serve(scope, receive, send)
        elif scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008})
        else:
            response = await self._answer(Request(scope, receive))
            # Connections of unauthenticated clients are closed.
            response.headers["Connection"] = "close"
            await response(scope, receive, send)

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> None:
        visitor: Visitor = scope["state"]["visitor"]
        if not visitor.let_in():
            response = JSONResponse({"error": "the studio has too many connections; close some pages"}, 503, HEADERS)
            await (response(scope, receive, send) if scope["type"] == "http" else _close(send))
        elif scope["path"] == LOGIN or (scope["path"] == "/" and _words(scope)):
            await RedirectResponse("/", 303, headers=HEADERS)(scope, receive, send)
        else:
            await self._app(scope, receive, send)

    async def _answer(self, request: Request) -> Response:
        """Answer an unauthenticated client."""
        peer = _peer(request.scope)
        if request.url.path == LOGIN and request.method == "POST":
            return await self._log_in(request, peer)
        if request.url.path != "/" or request.method != "GET":
            return JSONResponse({"error": f"refused: {_REFUSAL}"}, 401, headers=HEADERS)
        words = _words(request.scope)
        # Browsers that preload a page must not use up a pass.
        if not words or "prefetch" in request.headers.get("sec-purpose", ""):
            return self._login_page(request)
        session = self._keys.exchange(words[0], peer=peer) if len(words) == 1 else None
        if session is None:
            return await self._refuse(peer, "this address was used before, or is too old")
        # Such a cookie is not sent if the navigation began on another page; it is sent from here on.
        return self._with_cookie(HTMLResponse(welcome_page(), headers=WELCOME_HEADERS), session)

    async def _log_in(self, request: Request, peer: str) -> Response:
        if self._penalty.is_full(peer):
            return _page(429, "too many wrong tokens at once; try again in a few seconds, or open a one-time address")
        try:
            form = parse_qs((await read_body(request, limit=_MAX_BODY)).decode("latin-1"))
        except RefusedError as refused:
            return _page(refused.status, refused.message)
        # The pasted text may be the whole address.
        given = form.get(PARAMETER, [""])[0].strip().rpartition(f"?{PARAMETER}=")[2]
        session = self._keys.log_in(given, peer=peer)
        if session is None:
            return await self._refuse(peer, "this is neither the token nor an address that still works")
        self._penalty.forgive(peer)
        return self._with_cookie(RedirectResponse("/", 303, headers=HEADERS), session)

    async def _refuse(self, peer: str, message: str) -> Response:
        """Answer a wrong token after a delay; at once if too many requests of the same peer are already waiting."""
        if self._penalty.is_full(peer):
            return _page(429, "too many wrong tokens at once; try again in a few seconds, or open a one-time address")
        await self._penalty.wait(peer)
        return _page(401, message)

    def _login_page(self, request: Request) -> Response:
        """Ask for the token; a link from another page arrives without its cookie, and is repeated from here with it."""
        from_link = request.headers.get("sec-fetch-site") == "cross-site"
        return HTMLResponse(login_page("", again=from_link), 401, LOGIN_HEADERS)

    def _with_cookie(self, response: Response, session: str) -> Response:
        response.headers["Set-Cookie"] = f"{self._cookie}={session}; HttpOnly; SameSite=Strict; Path=/"
        return response

    def _is_known(self, scope: Scope) -> bool:
        return self._keys.know(_cookies(Headers(scope=scope), self._cookie), peer=lambda: _peer(scope))


async def _close(send: Send) -> None:
    await send({"type": "websocket.close", "code": 1013})


def _page(status: int, message: str) -> Response:
    return HTMLResponse(login_page(message), status, LOGIN_HEADERS)


def _words(scope: Scope) -> list[str]:
    """Return the one-time words in an address."""
    return parse_qs(scope["query_string"].decode("latin-1")).get(PARAMETER, [])


def _peer(scope: Scope) -> str:
    """Return the identity of the client, determined once per connection."""
    visitor: Visitor = scope["state"]["visitor"]
    if visitor.peer is None:
        visitor.peer = peer_of(scope["client"], scope["server"])
    return visitor.peer


def _cookies(headers: Headers, name: str) -> Iterator[str]:
    """Yield all values of a cookie: another port may have set one of the same name to shadow ours."""
    for line in headers.getlist("cookie"):
        for pair in line.split(";"):
            key, _, value = pair.strip().partition("=")
            if key == name:
                yield value
