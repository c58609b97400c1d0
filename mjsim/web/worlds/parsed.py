"""A text in JSON for the page: its problems, and the items that it describes."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from pydantic import ValidationError

from mjsim.errors import Problem, WorldError
from mjsim.modules import check_modules, check_pictures, unfed_modules
from mjsim.record import named_files
from mjsim.web.worlds.items import LISTS, Json, Path, scene_of, world_values
from mjsim.web.worlds.watch import named_in
from mjsim.world import (
    MAX_REPORTED,
    Node,
    Source,
    World,
    check_world,
    expand,
    gc_paused,
    misfits,
    needs_expansion,
    parse_world,
    read_text,
)

_MAX_ATTEMPTS = 3
"""Number of attempts at omitting invalid items until the rest is a valid world."""

Read = tuple[Node | None, list[Problem]]


@dataclass(frozen=True, slots=True)
class Parsed:
    """The result of parsing a text."""

    world: World | None
    """None if something in it is invalid."""
    content: Json
    """For the page: problems, items, bounds, name, run, world, and the files that the text names."""


@gc_paused()
def parsed(text: str, source: Source, *, read: Read | None = None) -> Parsed:
    """Return the result of parsing a text; for a partly invalid one, its valid part.

    Args:
        text: Text of a world.
        source: Origin of the text.
        read: Result of `read_text`, if already known.
    """
    read = read or read_text(text, file=source.file)
    raw = read[0] if needs_expansion(text) else None
    try:
        world = parse_world(text, source=source, read=read)
    except WorldError as error:
        return Parsed(None, _json_of_part(text, source, read=read, problems=error.problems))
    problems = sorted([*check_world(world), *check_modules(world), *check_pictures(world), *unfed_modules(world)])
    node = world.source.written
    warnings = (
        [_problem(problem, source, paths=_Paths(node), kind="warning") for problem in problems] if problems else []
    )
    return Parsed(
        world, {"problems": warnings, **_world_json(world, raw or node), "files": _files(read[0], node, world=world)}
    )


def _world_json(world: World, raw: Node | None) -> Json:
    whole = world_values(world, raw)
    return {**scene_of(world, raw), "name": world.name, "run": whole["values"]["run"], "world": whole}


def _files(*nodes: Node | None, world: World | None = None, included: Iterable[str] = ()) -> list[str]:
    """Return the files that a text names, existing or not, by their paths relative to its folder.

    Args:
        nodes: The text as written, and its expansion.
        world: The world that it describes.
        included: Files that it includes.
    """
    named = (name for node in nodes if node is not None for name in named_in(node.value))
    return sorted({*named, *included, *(named_files(world) if world is not None else ())})


_NOTHING: Json = {"items": None, "bounds": [-5.0, -5.0, 5.0, 5.0], "name": "", "run": {}, "world": None}


def _json_of_part(text: str, source: Source, *, read: Read, problems: Sequence[Problem]) -> Json:
    """Return the problems of a text, and its valid items."""
    node, _ = read
    if node is None or not isinstance(node.value, dict):
        found = [_problem(problem, source, paths=None) for problem in problems]
        return {"problems": found, **_NOTHING, "files": _files(node)}
    source = replace(source, text=text, included={}, variables={})
    expansion = expand(node, source) if needs_expansion(text) else None
    written = node if expansion is None else expansion.node
    files = _files(node, written, included=() if expansion is None else expansion.included)
    paths = _Paths(written)
    reported = [_problem(problem, source, paths=paths) for problem in problems]
    wrong = {path for problem in problems if problem.file == source.file for path in paths.at(problem)}
    right = _right_part(written, source, wrong=wrong)
    if right is None:
        return {"problems": reported, **_NOTHING, "files": files}
    world, indices = right
    seen = _world_json(world, node if needs_expansion(text) else None)
    for item in seen["items"]:
        if item["path"][0] in indices:
            item["path"][1] = indices[item["path"][0]][item["path"][1]]
    return {"problems": reported, **seen, "files": files}


def _right_part(node: Node, source: Source, *, wrong: set[Path]) -> tuple[World, Mapping[str, list[int]]] | None:
    """Return the world of the valid part of a text, and the indices of its items by list; None if there is none."""
    for _ in range(_MAX_ATTEMPTS):
        part, indices = _without(node, wrong)
        try:
            world = World.model_validate(part.value, context={"source": source})
        except ValidationError as error:
            more = {_original(details["loc"], indices) for details in error.errors(include_url=False) if details["loc"]}
            # Inconsistencies are reported one at a time.
            more |= {_original(path, indices) for _, path in islice(misfits(part.value), MAX_REPORTED)}
            if more <= wrong:
                return None
            wrong = wrong | more
            continue
        world._source = replace(source, written=part)
        return world, indices
    return None


def _original(path: tuple[int | str, ...], indices: Mapping[str, list[int]]) -> Path:
    if len(path) > 1 and path[0] in indices and isinstance(path[1], int):
        return (path[0], indices[str(path[0])][path[1]])
    return tuple(path[:1])


def _without(node: Node, wrong: set[Path]) -> tuple[Node, dict[str, list[int]]]:
    """Return the text's node without the invalid items or keys, and the indices of the remaining items."""
    items: dict[str | int, Node] = {}
    indices: dict[str, list[int]] = {}
    for key, child in node.items.items():
        invalid = {path[1] for path in wrong if path[:1] == (key,) and len(path) > 1}
        if key in LISTS and isinstance(child.value, list) and (key,) not in wrong:
            left = [index for index in range(len(child.value)) if index not in invalid]
            indices[str(key)] = left
            nodes: dict[str | int, Node] = {place: child.items[index] for place, index in enumerate(left)}
            items[key] = replace(child, items=nodes, value=[item.value for item in nodes.values()])
        elif not invalid and (key,) not in wrong:
            items[key] = child
    return replace(node, items=items, value={key: item.value for key, item in items.items()}), indices


class _Paths:
    """Finds the path of a value from its position in a text."""

    def __init__(self, node: Node) -> None:
        self._paths: dict[tuple[int, int], list[Path]] = defaultdict(list)
        for path, place in _places(node, ()):
            self._paths[place].append(path)

    def at(self, problem: Problem) -> list[Path]:
        """Return the paths to which a problem refers: several if an item is repeated."""
        return self._paths.get((problem.line, problem.column), [])


def _places(node: Node, path: Path) -> Iterator[tuple[Path, tuple[int, int]]]:
    if node.origin is not None and node.origin.file is not None:
        return
    yield path, (node.line, node.column)
    for key, place in node.keys.items():
        yield (*path, key), place
    for step, item in node.items.items():
        yield from _places(item, (*path, step))


def _problem(problem: Problem, source: Source, *, paths: _Paths | None, kind: str = "error") -> Json:
    own = problem.file == source.file
    found = paths.at(problem) if paths is not None and own else []
    message = problem.message if own else str(problem)
    return {
        "line": problem.line if own else 1,
        "column": problem.column if own else 1,
        "message": message,
        "path": next((list(path) for path in found if path), None),
        "kind": kind,
    }
