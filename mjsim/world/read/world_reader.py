"""Reads text as `World`; all errors of the text are reported together, each with line and column."""

import dataclasses
import os
import stat
from collections.abc import Iterator, Mapping
from functools import cache, partial
from itertools import islice
from pathlib import Path as FilePath

from pydantic import ValidationError

from mjsim.errors import Problem, UsageError, WorldError
from mjsim.models import one_trial_child
from mjsim.sentences import Sentence
from mjsim.world.files import Source
from mjsim.world.ground import KEY, Model, Path, gc_paused, meant_key, misspelt_kind, path_of, sentence
from mjsim.world.items import World, misfits
from mjsim.world.language import Value, expand, needs_expansion
from mjsim.world.yaml import MAX_BYTES, Fault, Node, line_and_column, problems_at, read_text, too_large

MAX_REPORTED = 100
"""Maximum number of errors such as unknown names; each is compared with all known names."""


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
        file: Name in messages.
        source: Origin of the text, where its pictures are looked up; replaces `file`.
        variables: Values that take precedence over the variables in the text.
        read: Result of `read_text` for this text, if already known.

    Raises:
        WorldError: The text is invalid; every error is reported.
    """
    source = source or Source(file=file)
    node, problems = read or read_text(text, file=source.file)
    problems = list(problems)
    if node is None:
        raise WorldError(problems)
    if not isinstance(node.value, dict):
        found = "a list" if isinstance(node.value, list) else "one value"
        line = Problem(
            source.file,
            node.line,
            node.column,
            Sentence("the file holds {found}; a world begins with 'mjsim: 1'", found),
        )
        raise WorldError([*problems, line])
    source, amiss = dataclasses.replace(source, text=text, included={}, variables={}), False
    if variables or needs_expansion(text):
        expansion = expand(node, source, variables=variables)
        source = dataclasses.replace(source, included=expansion.included, variables=expansion.variables)
        node, amiss = expansion.node, bool(expansion.problems)
        problems += expansion.problems
    source = dataclasses.replace(source, written=node)
    try:
        with one_trial_child():
            world = World.model_validate(node.value, context={"source": source})
    except ValidationError as error:
        faults = list(faults_of(error, World, whole=not amiss))
        if not amiss:  # inconsistencies may vanish once the rest is valid
            faults += [(path, partial(str, message)) for message, path in islice(misfits(node.value), MAX_REPORTED)]
        reported = {(problem.file, problem.line, problem.column) for problem in problems}
        more = set(problems_at(node, source.file, faults))
        problems += [problem for problem in more if (problem.file, problem.line, problem.column) not in reported]
        raise WorldError(problems) from None
    if problems:
        raise WorldError(problems)
    world._source = source
    return world


def read_file(path: FilePath, *, what: str = "a world file") -> str:
    """Return the text of a file.

    Args:
        path: The file.
        what: What the user should name if it is not a file.

    Raises:
        UsageError: The file does not exist.
        WorldError: It is not text, or too large.
    """
    try:
        # A pipe without a writer must not block.
        with os.fdopen(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                raise _refused(path, Sentence("this is not a file; name {what}", what))
            if status.st_size > MAX_BYTES:
                raise _refused(path, too_large(status.st_size))
            data = file.read(MAX_BYTES + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise UsageError(Sentence("no file '{path}'; name {what}", path, what)) from None
    except IsADirectoryError:
        raise _refused(path, Sentence("this is a folder; name {what}", what)) from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise _refused(path, Sentence("the file cannot be read: {reason}", reason)) from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = data[: error.start].decode("utf-8", "replace")
        line, column = line_and_column(before, len(before))
        byte = data[error.start]
        message = Sentence("byte 0x{byte:02x} is not UTF-8 text; write the file as UTF-8 text", byte)
        raise WorldError([Problem(str(path), line, column, message)]) from None


def _refused(path: FilePath, message: str) -> WorldError:
    return WorldError([Problem(str(path), 1, 1, message)])


def faults_of(error: ValidationError, model: type[Model], *, whole: bool = True) -> Iterator[Fault]:
    """Yield the errors that a model found; `whole`: whether the text is complete and its parts must fit."""
    faults = [(path_of(details), details) for details in error.errors(include_url=False)]
    unknown = {path for path, details in faults if details["type"] == "extra_forbidden"}
    # Finding a similar word takes long, and the items of a list have the same keys.
    suggest = cache(lambda keys: meant_key(keys, model))
    meant = {(*path[:-1], suggest(_keys_in(path))) for path in unknown}
    suggest_kind = cache(lambda keys, given: misspelt_kind(given, keys, model))
    for path, details in faults:
        if not (whole or details["loc"]):
            continue
        if details["type"] == "missing" and path in meant:
            continue  # it exists, but is misspelt
        if details["type"] == "too_short" and len(details["input"]) >= details["ctx"]["min_length"]:
            continue  # pydantic counts only valid items; the invalid one is reported
        given = tuple(details["input"]) if details["type"] == "kind" and isinstance(details["input"], Mapping) else ()
        if misspelt := suggest_kind(_keys_in(path), given):
            yield (*path, misspelt[0], KEY), partial(str, misspelt[1])
        else:
            yield (*path, KEY) if path in unknown else path, partial(sentence, details, path, model)


def _keys_in(path: Path) -> Path:
    return tuple(step for step in path if isinstance(step, str))
