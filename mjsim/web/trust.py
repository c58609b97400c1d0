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
        self._known: dict[str, set[str]] = {}

    def asks_for(self, world: World) -> list[str]:
        """Return what of a world's code nobody has allowed yet: files, and modules with what they are given.

        It is asked at each change of a text; files are looked through for others that they import only when their
        names are new, and when it matters, by `check` and `allow`.
        """
        uses = _foreign(world)
        key = f"{world.source.folder} {json.dumps(uses, default=str)}"
        if key not in self._known:
            self._known = {key: _code(world)}
        return sorted(self._known[key] - self._allowed)

    def allow(self, world: World) -> None:
        """Let all code run that a world names now."""
        self._known = {}
        self._allowed |= _code(world)

    def check(self, world: World) -> None:
        """Raise RefusedError when code that a world names may not run yet."""
        self._known = {}
        if names := self.asks_for(world):
            message = f"this world runs code that you have not allowed yet: {', '.join(names)}"
            raise RefusedError(403, message, needs_trust=names)


def _code(world: World) -> set[str]:
    uses = _foreign(world)
    if not uses:
        return set()
    named = {use["use"].rpartition(":")[0] for use in uses}
    installed = {_shown(use) for use in uses if not use["use"].rpartition(":")[0].endswith(".py")}
    try:
        files = set(user_files(world))
    except UsageError:
        files = set()  # Whoever runs it is told that one of them cannot be read.
    return installed | {name for name in files | named if name.endswith(".py")}


def _foreign(world: World) -> list[Mapping[str, Any]]:
    """Return what a world names with `use:` that does not come with mjsim."""
    driven = {"robots": world.model_dump(include={"robots"})["robots"], "run": world.run.model_dump()}
    return [use for use in _uses(driven) if not use["use"].startswith(_OURS)]


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
