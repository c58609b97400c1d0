"""What the page asks for while a world is edited."""

from collections.abc import Sequence
from typing import Any

from starlette.requests import Request
from starlette.routing import BaseRoute, Route

from mjsim.web.answers import asked
from mjsim.web.folder import Folder
from mjsim.web.trust import Trust
from mjsim.world import editor_schema


def routes(folder: Folder, trust: Trust, *, world: str | None) -> Sequence[BaseRoute]:
    """Return the routes of the Edit view."""

    def schema(_: Request) -> Any:
        return editor_schema()

    return [Route("/api/schema", asked(schema), methods=["GET"])]
