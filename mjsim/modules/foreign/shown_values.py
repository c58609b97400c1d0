"""Converts items shown by modules in other languages: objects with `points`, `lines`, `grid` or `text`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from mjsim.errors import did_you_mean
from mjsim.geometry import Pose
from mjsim.interface import MAX_ITEMS, Shown, ShownGrid, ShownLines, ShownPoints, ShownText
from mjsim.modules.covariances import Unfit
from mjsim.sentences import Sentence

_HEAD = ("name", "frame", "color")
_KEYS: Mapping[str, tuple[str, ...]] = {
    "points": ("size",),
    "lines": ("joined", "width"),
    "grid": ("resolution", "origin"),
    "text": ("at",),
}
"""Key that identifies a kind -> its further keys."""


def shown_of(answer: Any, of: str = "est") -> tuple[Shown, ...]:
    """Return the shown items of an answer; a single item needs no list.

    Args:
        answer: From JSON: an object, or a list of them; None for nothing.
        of: Name of the enclosing value in the language.
    """
    items = [] if answer is None else answer if isinstance(answer, list) else [answer]
    if len(items) > MAX_ITEMS:
        raise Unfit(
            Sentence("returned a show of {count} items; there must be at most {max_items}", len(items), MAX_ITEMS)
        )
    return tuple(_item(item, number, of) for number, item in enumerate(items, start=1))


def _item(item: Any, number: int, of: str) -> Shown:
    label = f"item {number} of {of}.show"
    if not isinstance(item, Mapping):
        raise Unfit(Sentence("returned {label} that is not an object; it must have points, lines, grid or text", label))
    kinds = [kind for kind in _KEYS if kind in item]
    if len(kinds) != 1:
        raise Unfit(
            Sentence(
                "returned {label} with {value} of {names}; it must have one",
                label,
                " and ".join(kinds) or "none",
                ", ".join(_KEYS),
            )
        )
    known = (kinds[0], *_HEAD, *_KEYS[kinds[0]])
    for key in item:
        if key not in known:
            raise Unfit(
                Sentence("returned {label} with the key '{key}'{did_you_mean}", label, key, did_you_mean(key, known))
            )
    try:
        return _made(kinds[0], {"name": kinds[0], **item})
    except (KeyError, TypeError, ValueError) as error:
        problem = f"lacks the key {error}" if isinstance(error, KeyError) else str(error)
        raise Unfit(Sentence("returned {label} that is not valid: {problem}", label, problem)) from None


def _made(kind: str, item: Mapping[str, Any]) -> Shown:
    head = {key: item[key] for key in _HEAD if key in item}
    rest = {key: item[key] for key in _KEYS[kind] if key in item}
    if kind == "text":
        return ShownText(**head, text=item["text"], at=item["at"])
    if kind == "grid":
        x, y, heading = np.append(np.array(rest.get("origin", (0.0, 0.0)), dtype=float), 0.0)[:3].tolist()
        cells = np.atleast_2d(np.array(item["grid"], dtype=float))
        return ShownGrid(**head, cells=cells, resolution=item["resolution"], origin=Pose(x, y, heading))
    points = np.array(item[kind], dtype=float)
    # Octave writes a single row as a plain list.
    places = points[None] if points.ndim == 1 and points.size else points
    return ShownPoints(**head, points=places, **rest) if kind == "points" else ShownLines(**head, points=places, **rest)
