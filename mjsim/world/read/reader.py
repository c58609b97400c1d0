"""Text to `World`; every fault of the text is told with its line and column, all at once."""

import dataclasses
import os
import stat
from collections.abc import Iterator, Mapping
from functools import cache, partial
from itertools import islice
from pathlib import Path as FilePath

from pydantic import ValidationError

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.world.check import check_world
from mjsim.world.files import Source, world_path
from mjsim.world.ground import KEY, Model, Path, gc_paused, meant_key, misspelt_kind, path_of, sentence
from mjsim.world.items import World, misfits
from mjsim.world.language import Value, expand, needs_expansion
from mjsim.world.yaml import MOST_BYTES, Fault, Node, line_and_column, problems_at, read_text, too_large

MOST = 100
"""Names that fit nothing, and the like, are told so often; each is looked for among all others."""


@gc_paused()
def parse_world(
    text: str,
    *,
    file: str = "world.yaml",
    source: Source | None = None,
    variables: Mapping[str, Value] | None = None,
    read: tuple[Node | None, list[Problem]] | None = None,
) -> World:
    """Return the world that a text describes.

    Args:
        text: YAML 1.2.
        file: How errors name it.
        source: Where it comes from, and so where the pictures are that it names; instead of `file`.
        variables: Values that go before those that the text gives its variables.
        read: What `read_text` says of the text, when it was asked before.

    Raises:
        WorldError: Something in it is wrong; every fault is told.
    """
    source = source or Source(file=file)
    node, problems = read or read_text(text, file=source.file)
    problems = list(problems)
    if node is None:
        raise WorldError(problems)
    if not isinstance(node.value, dict):
        found = "a list" if isinstance(node.value, list) else "one value"
        line = Problem(source.file, node.line, node.column, f"the file holds {found}; a world begins with 'mjsim: 1'")
        raise WorldError([*problems, line])
    source, amiss = dataclasses.replace(source, text=text, included={}, variables={}), False
    if variables or needs_expansion(text):
        expansion = expand(node, source, variables=variables)
        source = dataclasses.replace(source, included=expansion.included, variables=expansion.variables)
        node, amiss = expansion.node, bool(expansion.problems)
        problems += expansion.problems
    source = dataclasses.replace(source, written=node)
    try:
        world = World.model_validate(node.value, context={"source": source})
    except ValidationError as error:
        faults = list(faults_of(error, World, whole=not amiss))
        if not amiss:  # what does not fit may do so once the rest is right
            faults += [(path, partial(str, message)) for message, path in islice(misfits(node.value), MOST)]
        told = {(problem.file, problem.line, problem.column) for problem in problems}
        more = set(problems_at(node, source.file, faults))
        problems += [problem for problem in more if (problem.file, problem.line, problem.column) not in told]
        raise WorldError(problems) from None
    if problems:
        raise WorldError(problems)
    world._source = source
    return world


def load_world(path: str | FilePath) -> World:
    """Return the world of a file; pictures and modules are looked for beside it.

    Args:
        path: The file, or a bare word: the name of a shipped world.

    Raises:
        UsageError: The file does not exist, or is not such a world.
        WorldError: Something in it is wrong; every fault is told.
    """
    path = world_path(path)
    return parse_world(read_file(path), source=Source(file=str(path), folder=path.parent))


def load_checked(path: str | FilePath) -> World:
    """Return the world of a file, named as for `load_world`, that also passes `check_world`.

    Raises:
        UsageError: The file does not exist, or is not such a world.
        WorldError: Something in it is wrong; every fault is told.
    """
    world = load_world(path)
    if problems := check_world(world):
        raise WorldError(problems)
    return world


def read_file(path: FilePath) -> str:
    """Return the text of a world file.

    Raises:
        UsageError: The file does not exist.
        WorldError: It is no text, or too large.
    """
    try:
        # A pipe that nobody writes to must not keep us waiting.
        with os.fdopen(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise _refused(path, "this is not a file; name a world file")
            if status.st_size > MOST_BYTES:
                raise _refused(path, too_large(status.st_size))
            data = file.read(MOST_BYTES + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError(f"no file '{path}'; name a world file") from None
    except IsADirectoryError:
        raise _refused(path, "this is a folder; name a world file") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise _refused(path, f"the file cannot be read: {reason}") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8", "replace")
        line, column = line_and_column(before, len(before))
        byte = data[error.start]
        message = f"byte 0x{byte:02x} is not UTF-8 text; write the file as UTF-8 text"
        raise WorldError([Problem(str(path), line, column, message)]) from None


def _refused(path: FilePath, message: str) -> WorldError:
    return WorldError([Problem(str(path), 1, 1, message)])


def faults_of(error: ValidationError, model: type[Model], *, whole: bool = True) -> Iterator[Fault]:
    """Yield what a model found; `whole` tells whether all of its text is there, so that its parts should fit."""
    faults = [(path_of(details), details) for details in error.errors(include_url=False)]
    unknown = {path for path, details in faults if details["type"] == "extra_forbidden"}
    # Looking for a near word takes long, and the items of a list have the same keys.
    near = cache(lambda keys: meant_key(keys, model))
    meant = {(*path[:-1], near(_keys_in(path))) for path in unknown}
    near_kind = cache(lambda keys, given: misspelt_kind(given, keys, model))
    for path, details in faults:
        if not (whole or details["loc"]):
            continue
        if details["type"] == "missing" and path in meant:
            continue  # it is there, misspelt
        if details["type"] == "too_short" and len(details["input"]) >= details["ctx"]["min_length"]:
            continue  # pydantic counts good items only; the bad one is told
        given = tuple(details["input"]) if details["type"] == "kind" and isinstance(details["input"], Mapping) else ()
        if misspelt := near_kind(_keys_in(path), given):
            yield (*path, misspelt[0], KEY), partial(str, misspelt[1])
        else:
            yield (*path, KEY) if path in unknown else path, partial(sentence, details, path, model)


def _keys_in(path: Path) -> Path:
    return tuple(step for step in path if isinstance(step, str))
