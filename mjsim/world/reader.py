"""Text to `World`; every fault of the text is told with its line and column, all at once."""

import dataclasses
import os
import stat
from collections.abc import Iterable, Iterator
from pathlib import Path

from pydantic import ValidationError

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.world.base import KEY
from mjsim.world.check import check_world
from mjsim.world.fit import misfits
from mjsim.world.model import World
from mjsim.world.places import place_of
from mjsim.world.source import Source
from mjsim.world.text import MOST_BYTES, Node, line_and_column, read_text, too_large
from mjsim.world.words import meant_key, misspelt_kind, path_of, sentence


def parse_world(text: str, *, file: str = "world.yaml", source: Source | None = None) -> World:
    """Return the world that a text describes.

    Args:
        text: YAML 1.2.
        file: How errors name it.
        source: Where it comes from, and so where the pictures are that it names; instead of `file`.

    Raises:
        WorldError: Something in it is wrong; every fault is told.
    """
    source = source or Source(file=file)
    node, problems = read_text(text, file=source.file)
    if node is None:
        raise WorldError(problems)
    if not isinstance(node.value, dict):
        found = "a list" if isinstance(node.value, list) else "one value"
        line = Problem(source.file, node.line, node.column, f"the file holds {found}; a world begins with 'mjsim: 1'")
        raise WorldError([*problems, line])
    source = dataclasses.replace(source, text=text, written=node)
    try:
        world = World.model_validate(node.value, context={"source": source})
    except ValidationError as error:
        told = {(problem.line, problem.column) for problem in problems}
        more = {*_faults(error, node, source.file), *_misfits(node, source.file)}
        raise WorldError([*problems, *(fault for fault in more if (fault.line, fault.column) not in told)]) from None
    if problems:
        raise WorldError(problems)
    world._source = source
    return world


def load_world(path: str | Path) -> World:
    """Return the world of a file; pictures and modules are looked for beside it.

    Raises:
        UsageError: There is no such file.
        WorldError: Something in it is wrong; every fault is told.
    """
    path = Path(path)
    return parse_world(_read_file(path), source=Source(file=str(path), folder=path.parent))


def load_checked(path: str | Path) -> World:
    """Return the world of a file that is well written and can be meant, as `check_world` sees it.

    Raises:
        UsageError: There is no such file.
        WorldError: Something in it is wrong; every fault is told.
    """
    world = load_world(path)
    if problems := check_world(world):
        raise WorldError(problems)
    return world


def _read_file(path: Path) -> str:
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


def _refused(path: Path, message: str) -> WorldError:
    return WorldError([Problem(str(path), 1, 1, message)])


def _faults(error: ValidationError, node: Node, file: str) -> Iterator[Problem]:
    faults = [(path_of(details), details) for details in error.errors(include_url=False)]
    unknown = [path for path, details in faults if details["type"] == "extra_forbidden"]
    meant = {(*path[:-1], meant_key(path, World)) for path in unknown}
    for path, details in faults:
        if details["type"] == "missing" and path in meant:
            continue  # it is there, misspelt
        if details["type"] == "too_short" and len(details["input"]) >= details["ctx"]["min_length"]:
            continue  # pydantic counts good items only; the bad one is told
        misspelt = misspelt_kind(details, path, World)
        if misspelt:
            path, message = misspelt
        else:
            message = sentence(details, path, World)
        place = place_of(node, (*path, KEY) if path in unknown or misspelt else path)
        yield Problem(file, *place, message)


def _misfits(node: Node, file: str) -> Iterable[Problem]:
    return (Problem(file, *place_of(node, path), message) for message, path in misfits(node.value))
