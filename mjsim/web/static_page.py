"""The page itself, which is built from mjsim/web/page by scripts/make/page."""

from collections.abc import Sequence
from importlib import resources

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from mjsim.web.local import HEADERS

_FILES = {"/": ("index.html", "text/html"), "/studio.js": ("studio.js", "text/javascript")}
_FILES["/studio.css"] = ("studio.css", "text/css")
_UNBUILT = "<!doctype html><title>mjsim</title><p>The page is not built; run scripts/make/page."


def page_routes() -> Sequence[BaseRoute]:
    """Return the routes of the page, its program and its style."""
    return [Route(path, _file) for path in _FILES]


async def _file(request: Request) -> Response:
    name, kind = _FILES[request.url.path]
    file = resources.files(__package__) / "static" / name
    text = file.read_text(encoding="utf-8") if file.is_file() else (_UNBUILT if request.url.path == "/" else "")
    return Response(text, media_type=kind, headers=HEADERS)
