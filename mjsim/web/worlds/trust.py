"""Trust in code: the user must allow code of a world before it first runs, and again when it changes."""

import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.modules import MAX_BYTES, foreign_code, modules_of
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.world import Source, Use, World, read_regular

Code = tuple[str, str]
"""A file and the SHA-256 of its content; or the name of an installed class, and ''."""


class Trust:
    """Stores which code the user allowed while the studio is open; no other code of a world runs.

    A file is allowed with its current content, and a class of an installed package by its name. Decisive is `admit`,
    which sees the bytes that run; everything else serves to ask the user in time.
    """

    def __init__(self) -> None:
        self._allowed: set[Code] = set()
        self._known: dict[str, dict[str, Code]] = {}
        self._refused: set[Path] = set()

    def guarded(self, source: Source) -> Source:
        """Return a world's source that runs only allowed code."""
        return replace(source, admit=self.admit)

    def admit(self, path: Path, data: bytes) -> None:
        """Raise UsageError unless a file beside a world may run with this content."""
        if (str(path), _digest(data)) not in self._allowed:
            # Its name may not appear in the text that imports it; now it is known.
            self._refused.add(path)
            self._known = {}
            raise UsageError(
                Sentence(
                    "'{name}' is code that you have not allowed in its present form; start again to be asked", path.name
                )
            )

    def asks_for(self, world: World) -> dict[str, str]:
        """Return the code of a world that has not been allowed yet.

        Called at each change of a text; files are read again only when their names are new, and by `check` and `allow`,
        where it matters.

        Returns:
            Files beside the world with the SHA-256 of their content, installed classes with an empty text.
        """
        key = f"{world.source.folder} {json.dumps([_shown(named.use) for named in modules_of(world)])}"
        if key not in self._known:
            self._known = {key: self.code_of(world)}
        return _texts_of({name: code for name, code in self._known[key].items() if code not in self._allowed})

    def allow(self, world: World, shown: Mapping[str, str]) -> None:
        """Allow the code of a world in the version that the user was shown.

        Args:
            world: The world.
            shown: What `asks_for` returned then.

        Raises:
            RefusedError: The world's code has changed since.
        """
        self._known = {}
        needed = {name: code for name, code in self.code_of(world).items() if code not in self._allowed}
        if changed := sorted(name for name, (_, digest) in needed.items() if shown.get(name) != digest):
            message = Sentence(
                "this code has changed since you were asked: {changed}; look at it again", ", ".join(changed)
            )
            raise RefusedError(409, message, needs_trust=_texts_of(needed))
        self._allowed |= set(needed.values())

    def check(self, world: World) -> Mapping[str, Code]:
        """Return the current code of a world.

        Raises:
            RefusedError: It may not run.
        """
        self._known = {}
        code = self.code_of(world)
        if needed := _texts_of({name: each for name, each in code.items() if each not in self._allowed}):
            message = Sentence(
                "this world runs code that you have not allowed yet, or that has changed: {needed}", ", ".join(needed)
            )
            raise RefusedError(403, message, needs_trust=needed)
        return code

    def code_of(self, world: World) -> dict[str, Code]:
        """Return the code of a world that is not shipped with mjsim, by the names shown to the user."""
        code, folder = foreign_code(world), (world.source.folder or Path.cwd()).resolve()
        files = {name: (str(folder / name), _digest(data)) for name, data in code.files.items()}
        for path in [path for path in self._refused.copy() if path.is_relative_to(folder)]:
            with suppress(OSError):
                files[path.relative_to(folder).as_posix()] = str(path), _digest(read_regular(path, limit=MAX_BYTES))
        return {**files, **{use.use: (use.use, "") for use in code.installed}}


def _texts_of(code: Mapping[str, Code]) -> dict[str, str]:
    return {name: code[name][1] for name in sorted(code)}


def _digest(data: bytes) -> str:
    return sha256(data).hexdigest()


def _shown(use: Use) -> str:
    given = use.arguments()
    return f"{use.use} {json.dumps(given, default=str)}" if given else use.use
