"""Whose code may run: what came with a world is asked for once, before it first runs."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from mjsim.errors import UsageError
from mjsim.sweep.modules import user_files
from mjsim.web.answers import RefusedError
from mjsim.world import World

_OURS = "mjsim.algorithms."


class Trust:
    """Remembers what code somebody said may run while the studio is open; nothing else of it runs.

    A file that was allowed stays so while it is worked on; a module that is installed may be any of thousands, so
    what it is given is asked for too.
    """

    def __init__(self) -> None:
        self._allowed: set[str] = set()

    def asks_for(self, world: World) -> list[str]:
        """Return what of a world's code nobody has allowed yet: files, and modules with what they are given."""
        return sorted(_code(world) - self._allowed)

    def allow(self, world: World) -> None:
        """Let all code run that a world names now."""
        self._allowed |= _code(world)

    def check(self, world: World) -> None:
        """Raise RefusedError when code that a world names may not run yet."""
        if names := self.asks_for(world):
            message = f"this world runs code that you have not allowed yet: {', '.join(names)}"
            raise RefusedError(403, message, needs_trust=names)


def _code(world: World) -> set[str]:
    uses = [use for use in _uses(world.model_dump()) if not use["use"].startswith(_OURS)]
    if not uses:
        return set()
    installed = {_shown(use) for use in uses if not use["use"].rpartition(":")[0].endswith(".py")}
    try:
        files = user_files(world)
    except UsageError as error:
        raise RefusedError(400, str(error)) from error
    return installed | {name for name in files if name.endswith(".py")}


def _shown(use: Mapping[str, Any]) -> str:
    given = {key: value for key, value in use.items() if key != "use"}
    return f"{use['use']} {json.dumps(given, default=str)}" if given else str(use["use"])


def _uses(value: Any) -> Iterator[Mapping[str, Any]]:
    """Yield all mappings with the key `use`, wherever they stand."""
    if isinstance(value, Mapping):
        if isinstance(value.get("use"), str):
            yield value
        value = tuple(value.values())
    if isinstance(value, (list, tuple)):
        for item in value:
            yield from _uses(item)
