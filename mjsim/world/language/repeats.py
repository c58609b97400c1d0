"""`repeat`: several copies of an item, each translated, or rotated about a point."""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Self

from pydantic import Discriminator, Field, Tag, model_validator

from mjsim.sentences import Sentence
from mjsim.world.ground import Degrees, Metres, Model, Point, fault
from mjsim.world.items import SENSOR_KINDS

MAX_TIMES = 100_000
MAX_REPEATS = 3
"""Maximum number of nested repeats, with the indices i, j and k."""
NAMES = ("name", *SENSOR_KINDS)
"""Keys that contain the name of an item."""
_HEADINGS = {
    **dict.fromkeys(("obstacles", "beacons", "robots", "patches"), "heading_deg"),
    **dict.fromkeys(("sensors", "look"), "yaw_deg"),
}
"""The key that holds an item's heading, by the list that contains the item."""
_DECIMALS = 9
"""Decimals to which translated coordinates are rounded, so that 0.1 three times is 0.3."""

_NUMBERS = (int, float)

Numbers = Annotated[tuple[Metres, ...], Field(strict=False, min_length=2, max_length=3)]


class Repeat(Model):
    """Several copies of an item; the first is at the written position."""

    times: Annotated[int, Field(ge=0, le=MAX_TIMES)]
    """Number of copies, including the first."""
    offset: (
        Annotated[
            Annotated[Metres, Tag("<number>")] | Annotated[Numbers, Tag("<list>")],
            Discriminator(lambda value: "<list>" if isinstance(value, (list, tuple)) else "<number>"),
        ]
        | None
    ) = None
    """Translation [x, y] from each copy to the next [m]; a single number if `at` is a single number."""
    turn_deg: Degrees = 0.0
    """Rotation from each copy to the next about the point `about`, counter-clockwise."""
    about: Point | None = None
    """Centre of the rotation, [x, y] [m]."""

    @model_validator(mode="after")
    def _turns_about_something(self) -> Self:
        if self.turn_deg and self.about is None:
            raise fault("turn_deg needs the middle of the ring; add about: [x, y]", "turn_deg")
        return self


Keys = dict[str, Any]
Move = Callable[[Any], Any]
Place = Callable[[Keys, Sequence[int]], None]
"""Moves the keys of an item to their place in a repetition, given its indices from 0."""


def placing(keys: Mapping[str, Any], steps: Sequence[Repeat], *, within: str) -> Place:
    """Return a function that moves the keys of an item to their place in a repetition.

    Args:
        keys: Keys of the item as written.
        steps: Nested repeats, outermost first.
        within: The list that contains the item, such as 'walls'.

    Raises:
        ValueError: The item has no position that can be translated or rotated like this; the message says why.
    """
    moving = [(index, step) for index, step in enumerate(steps) if step.offset is not None or step.turn_deg]
    for _, step in moving:
        _check_place(keys, step)
    moving.reverse()  # a grid is a repeated row

    def place(changed: Keys, index: Sequence[int]) -> None:
        for number, step in moving:
            if index[number]:
                _move(changed, step, index[number], within)

    return place


def indices(steps: Sequence[Repeat]) -> Iterator[tuple[int, ...]]:
    """Yield the indices of all repetitions; the last index varies fastest."""
    return itertools.product(*(range(step.times) for step in steps))


def _check_place(keys: Mapping[str, Any], step: Repeat) -> None:
    at = keys.get("at", keys.get("to"))
    if at is None and "points" not in keys:
        raise ValueError("this item has no 'at' or 'points' that can be shifted; leave out 'offset', or use ${i}")
    single = _is_number(at)
    if single and step.turn_deg:
        raise ValueError("this item has one number as 'at'; it cannot be turned about a point")
    if step.offset is None or not (single or isinstance(at, list) or "points" in keys):
        return
    if single != _is_number(step.offset):
        expected = "one number as 'at' has" if single else "[x, y] as 'at' has"
        raise ValueError(Sentence("offset is {offset}; it must be {expected}", _shown(step.offset), expected))


def _move(keys: Keys, step: Repeat, number: int, within: str) -> None:
    if _is_number(keys.get("at")):
        if isinstance(step.offset, float):
            keys["at"] = round(keys["at"] + number * step.offset, _DECIMALS)
        return
    move = _turning(step, number) if step.turn_deg else _shifting(step, number)
    for key in ("at", "to"):
        if key in keys:
            keys[key] = move(keys[key])
    if isinstance(keys.get("points"), list):
        keys["points"] = [move(point) for point in keys["points"]]
    path = keys.get("path")
    if isinstance(path, dict) and isinstance(path.get("points"), list):
        keys["path"] = {**path, "points": [move(point) for point in path["points"]]}
    heading = "heading_deg" if "heading_deg" in keys else _HEADINGS.get(within)
    if step.turn_deg and heading is not None and _is_number(keys.get(heading, 0)):
        turned = (keys.get(heading, 0) + number * step.turn_deg) % 360.0
        keys[heading] = round(turned - 360.0 if turned > 180.0 else turned, _DECIMALS)


def _shifting(step: Repeat, number: int) -> Move:
    """Return a function that translates a point; other values are left unchanged for the models to reject."""
    offset = step.offset if isinstance(step.offset, tuple) else ()
    shift = [number * value for value in offset]

    def move(point: Any) -> Any:
        if not _is_point(point):
            return point
        return [round(value + by, _DECIMALS) for value, by in zip(point, shift, strict=False)] + point[len(shift) :]

    return move


def _turning(step: Repeat, number: int) -> Move:
    """Return a function that rotates a point and then translates it."""
    shift = _shifting(step, number)
    x0, y0 = step.about or (0.0, 0.0)
    turn = math.radians(number * step.turn_deg)
    c, s = round(math.cos(turn), 15), round(math.sin(turn), 15)

    def move(point: Any) -> Any:
        if not _is_point(point):
            return point
        x, y = point[0] - x0, point[1] - y0
        turned = (x0 + c * x - s * y, y0 + s * x + c * y)
        # Adding 0 turns -0.0 into 0.0.
        return shift([*(round(value, _DECIMALS) + 0 for value in turned), *point[2:]])

    return move


def _is_point(value: Any) -> bool:
    return isinstance(value, list) and len(value) >= 2 and all(type(number) in _NUMBERS for number in value)


def _is_number(value: Any) -> bool:
    return type(value) in _NUMBERS


def _shown(value: Any) -> str:
    return f"[{', '.join(f'{number:g}' for number in value)}]" if isinstance(value, tuple) else f"{value:g}"
