"""Points of mechanisms: a body, a named point of it, or coordinates on it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator, Discriminator, Field, Tag

from mjsim.errors import did_you_mean
from mjsim.sentences import Sentence
from mjsim.world.ground import JOINT_PATTERN, POINT_PATTERN, Legible, Name, Point3

GROUND = "ground"
"""Name of the fixed ground."""


def _pointing(axis: tuple[float, ...]) -> tuple[float, ...]:
    if math.hypot(*axis) < 1e-9:
        raise ValueError("it is [0, 0, 0], which has no direction; give one number that is not 0")
    return axis


PartName = Annotated[str, Field(pattern=JOINT_PATTERN, max_length=64), Legible]
"""Name of a body or a joint: letters, digits, `_` and `-`; a dot precedes the name of a point or value."""
Axis = Annotated[Point3, AfterValidator(_pointing)]
"""A direction, of any length."""
Named = Annotated[str, Field(pattern=POINT_PATTERN, max_length=130), Legible]
"""'BODY' or 'BODY.POINT'."""


def _kind(value: object) -> str:
    return "<point>" if isinstance(value, Mapping) else "<name>"


End = Annotated[
    Annotated[Named, Tag("<name>")]
    | Annotated[Mapping[Name, Point3], Field(strict=False, min_length=1, max_length=1), Tag("<point>")],
    Discriminator(_kind),
]
"""Where something is attached: `BODY` (its origin), `BODY.end`, `BODY.center`, or {BODY: [x, y, z]} [m];
the body may be `ground`."""


@dataclass(frozen=True, slots=True)
class Place:
    """A point of a body, found by its name."""

    body: str
    """Or 'ground'."""
    at: tuple[float, ...]
    """Position in the frame of the body, [x, y, z] [m]."""


def place_of(
    end: str | Mapping[str, tuple[float, ...]], points: Mapping[str, Mapping[str, tuple[float, ...]]]
) -> Place:
    """Return the point that an end refers to.

    Args:
        end: End as written.
        points: Named points by body.

    Raises:
        ValueError: The body or its point does not exist.
    """
    if isinstance(end, Mapping):
        name, at = next(iter(end.items()))
        _require(name, points)
        return Place(name, tuple(at))
    name, _, point = end.partition(".")
    _require(name, points)
    if not point:
        return Place(name, (0.0, 0.0, 0.0))
    if point not in points[name]:
        known = points[name]
        has = Sentence("it has {known}", ", ".join(known)) if known else "it has none"
        raise ValueError(
            Sentence("body '{name}' has no point '{point}'; {has}, or give {{{name}: [x, y, z]}}", name, point, has)
        )
    return Place(name, points[name][point])


def _require(name: str, points: Mapping[str, object]) -> None:
    if name not in points:
        raise ValueError(Sentence("no body '{name}' in this mechanism{meant}", name, did_you_mean(name, points)))
