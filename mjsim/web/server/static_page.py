"""The static files of the page, built from mjsim/web/page by scripts/make/page."""

import gzip
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from mjsim.web.server.local import HEADERS

_FILES = {"/": ("index.html", "text/html"), "/studio.js": ("studio.js", "text/javascript")}
_FILES |= {"/languages.js": ("languages.js", "text/javascript")}
_FILES |= {"/studio.css": ("studio.css", "text/css"), "/scene.js": ("scene.js", "text/javascript")}
_UNBUILT = "<!doctype html><title>mjsim</title><p>The page is not built; run scripts/make/page."


def page_routes(*, preload: Sequence[str] = ()) -> Sequence[BaseRoute]:
    """Return the routes of the page, its scripts and its style sheet.

    Args:
        preload: Addresses that the browser fetches while it loads the script that requests them first.
    """
    links = ", ".join(f"<{address}>; rel=preload; as=fetch; crossorigin" for address in preload)
    files = [Route(path, _file) for path in _FILES if path != "/"]
    return [Route("/", partial(_file, more={"Link": links} if links else {})), *files]


def pack_files() -> None:
    """Compress all files once, so that no request waits for it."""
    for name, _ in _FILES.values():
        pack(_contents(name))


def packed_response(
    request: Request, data: bytes, kind: str, *, more: Mapping[str, str] = MappingProxyType({})
) -> Response:
    """Return the response with static data, compressed once, for clients that accept that."""
    if "gzip" in request.headers.get("accept-encoding", ""):
        headers = {**HEADERS, **more, "Content-Encoding": "gzip", "Vary": "Accept-Encoding"}
        return Response(pack(data), media_type=kind, headers=headers)
    return Response(data, media_type=kind, headers={**HEADERS, **more, "Vary": "Accept-Encoding"})


async def _file(request: Request, *, more: Mapping[str, str] = MappingProxyType({})) -> Response:
    name, kind = _FILES[request.url.path]
    return packed_response(request, _contents(name), kind, more=more)


def _contents(name: str) -> bytes:
    """Return a file of the page."""
    file = Path(__file__).parents[1] / "static" / name
    return file.read_bytes() if file.is_file() else (_UNBUILT if name == "index.html" else "").encode()


@cache
def pack(data: bytes) -> bytes:
    """Compress static data."""
    # Without a time stamp, so that the same file gives the same bytes.
    return gzip.compress(data, mtime=0)
