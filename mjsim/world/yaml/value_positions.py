"""Finds the position of a value in a text by its path, and reports problems there."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence

from mjsim.errors import Problem
from mjsim.sentences import Sentence
from mjsim.world.ground import KEY
from mjsim.world.yaml.yaml_text import Node, Origin

Path = tuple[str | int, ...]
Fault = tuple[Path, Callable[[], str]]
"""A path, and a function that returns the message about its value."""


def place_of(node: Node | None, path: Sequence[str | int]) -> tuple[int, int]:
    """Return line and column of the value at a path, or of the nearest enclosing value that is written.

    Steps in angle brackets, the tags of kinds, are not in the text; a last step `[key]` refers to the key itself. A
    world built in Python has no text: the result is (1, 1).
    """
    if node is None:
        return 1, 1
    nodes, steps = _walk(node, path)
    # A key of an included file has its position in that file.
    if steps[-1:] == [KEY] and len(nodes) == len(steps) and steps[:-1] and steps[-2] in nodes[-2].keys:
        return nodes[-2].keys[str(steps[-2])]
    return nodes[-1].line, nodes[-1].column


def problems_at(node: Node | None, file: str, faults: Iterable[Fault]) -> Iterator[Problem]:
    """Yield the problems at paths of a text, each with its position.

    The same problem in several repetitions of an item is reported once, naming the repetitions unless it affects all.

    Args:
        node: Value of the text; None if there is none.
        file: Name in messages.
        faults: The problems.
    """
    repeated: dict[tuple[object, ...], list[tuple[Origin, Fault]]] = {}
    for path, message in faults:
        nodes, steps = ([], []) if node is None else _walk(node, path)
        origins = [(index, item.origin) for index, item in enumerate(nodes) if item.origin is not None]
        copies = [(index, origin) for index, origin in origins if origin.repetition]
        if not copies:
            origin = origins[-1][1] if origins else Origin()
            yield _problem(node, file, (path, message), origin)
            continue
        depth, copy = copies[-1]
        outer = next((origin for _, origin in reversed(origins) if origin.file is not None), Origin())
        all_of_them = math.prod(origin.copies for _, origin in copies)
        origin = Origin(outer.file, outer.how, copy.repetition, all_of_them)
        place = (origin.file, *place_of(node, path), *steps[depth:])
        repeated.setdefault(place, []).append((origin, (path, message)))
    for found in repeated.values():
        origin, fault = found[0]
        number = ", ".join(str(index + 1) for index in origin.repetition)
        repetition = Sentence("in repetition {number}", number) if len(found) < origin.copies else ""
        yield _problem(node, file, fault, origin, repetition)


def _problem(node: Node | None, file: str, fault: Fault, origin: Origin, repetition: str = "") -> Problem:
    path, message = fault
    details = repetition or origin.how
    if repetition and origin.how:
        details = Sentence("{first}, {then}", repetition, origin.how)
    said = Sentence("{problem} ({details})", message(), details) if details else message()
    return Problem(origin.file or file, *place_of(node, path), said)


def _walk(node: Node, path: Sequence[str | int]) -> tuple[list[Node], list[str | int]]:
    """Return the values along a path as far as they are written, starting with the whole, and the steps of the path."""
    steps = [step for step in path if isinstance(step, int) or not step.startswith("<")]
    nodes = [node]
    for step in steps:
        if step not in nodes[-1].items:
            break
        nodes.append(nodes[-1].items[step])
    return nodes, steps
