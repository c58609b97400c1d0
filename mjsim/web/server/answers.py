"""Requests and responses of the page: JSON in, JSON out, one line per error."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response

from mjsim.errors import MjsimError
from mjsim.sentences import Sentence, with_sentences
from mjsim.web.server.local import HEADERS
from mjsim.web.server.request_bodies import Bodies

MAX_JSON = 12_000_000
"""Maximum size of a request [bytes]: the text of a world and the requested changes."""

MAX_DIGITS = 18
"""Maximum length of the stated size of a body."""


class RefusedError(Exception):
    """A refused request; holds the HTTP status, a message, and further data for the page."""

    def __init__(self, status: int, message: str, **more: Any) -> None:
        super().__init__(message)
        self.status, self.message, self.more = status, message, more


class Ask(BaseModel):
    """Base of the requests sent by the page."""

    model_config = ConfigDict(frozen=True, extra="forbid")


Asked = TypeVar("Asked", bound=Ask)
Endpoint = Callable[[Request], Awaitable[Response]]


def posted(kind: type[Asked], work: Callable[[Asked], Any]) -> Endpoint:
    """Return an endpoint that answers a POST of JSON with the result of `work`: JSON, or a response that it made."""

    async def endpoint(request: Request) -> Response:
        if request.headers.get("content-type", "").partition(";")[0].strip() != "application/json":
            return refusal(RefusedError(415, "send this as application/json"))
        try:
            async with body_of(request, limit=MAX_JSON) as data:
                return await answered(lambda: work(_read(kind, data)))
        except RefusedError as refused:
            return refusal(refused)

    return endpoint


def answer_get(work: Callable[[Request], Any]) -> Endpoint:
    """Return an endpoint that answers a GET with the result of `work`: JSON, or a response that it made itself."""

    async def endpoint(request: Request) -> Response:
        return await answered(lambda: work(request))

    return endpoint


async def answered(work: Callable[[], Any]) -> Response:
    """Return the response to a request, computed outside the server's own thread."""
    try:
        # The end of the loop waits for these threads: one that draws while Python ends would crash it.
        made = await asyncio.to_thread(_made, work)
    except RefusedError as refused:
        return refusal(refused)
    except MjsimError as error:
        return refusal(RefusedError(400, str(error)))
    return made if isinstance(made, Response) else JSONResponse(made, headers=HEADERS)


def _made(work: Callable[[], Any]) -> Any:
    made = work()
    return with_sentences(made) if isinstance(made, dict) else made


def refusal(refused: RefusedError) -> Response:
    """Return the response that says why a request is refused."""
    return JSONResponse(with_sentences({"error": refused.message, **refused.more}), refused.status, headers=HEADERS)


@asynccontextmanager
async def body_of(request: Request, *, limit: int) -> AsyncIterator[bytes]:
    """Give the body of a request to the block; large ones wait until there is room for them in memory.

    Raises:
        RefusedError: It has more than `limit` bytes; the rest is not read.
    """
    stated = request.headers.get("content-length", "")
    size = int(stated) if stated.isdecimal() and len(stated) < MAX_DIGITS else limit
    bodies: Bodies = request.state.connections.bodies
    async with bodies.room(min(size, limit)):
        yield await read_body(request, limit=limit)


async def read_body(request: Request, *, limit: int) -> bytes:
    """Return the body of a request; see `body_of` for large ones.

    Raises:
        RefusedError: It has more than `limit` bytes; the rest is not read.
    """
    parts, size = [], 0
    try:
        async for part in request.stream():
            size += len(part)
            if size > limit:
                raise RefusedError(413, Sentence("this is larger than {limit:.0f} MB; send less", limit / 1e6))
            parts.append(part)
    except ClientDisconnect:
        raise RefusedError(400, "the request arrived incomplete; send it again") from None
    return b"".join(parts)


def _read(kind: type[Asked], data: bytes) -> Asked:
    try:
        return kind.model_validate_json(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        location = ".".join(map(str, first["loc"])) or "the request"
        raise RefusedError(400, f"{location}: {first['msg'][0].lower()}{first['msg'][1:]}") from None
