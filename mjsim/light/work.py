"""The work of ray casting: each part is one call of a function in this module, in this process or one of `crew`."""

import pickle
import struct
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from mjsim.light.charts import Charts
from mjsim.light.light_rays import (
    Light,
    Numbers,
    Points,
    Rectangle,
    Room,
    buried_share,
    hemisphere,
    light_of,
    starts_of,
)

_LENGTH = struct.Struct("<q")


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """A room, and the cells of its surfaces."""

    room: Room
    names: Numbers
    """Triangle of the charts of each triangle of the room; `PORTAL` for windows, shape (n,)."""
    charts: Charts
    cells: NDArray[np.int32]
    """Cell of each texel of the atlas; row after row."""


@dataclass(frozen=True, slots=True, eq=False)
class Gathered:
    """What the rays of some points hit."""

    hits: NDArray[np.int32]
    """Cell of each ray, `count` where it adds no light, shape (rays, n)."""
    sky: Light
    """Share of rays that reach the sky, shape (n,)."""
    behind: Light
    """Share of rays that hit a surface from behind, shape (n,)."""


def buried(around: Surroundings, at: Points, side: int) -> Light:
    """Return the share of rays that hit a surface from behind or very near, shape (n,)."""
    return buried_share(around.room, at, side)


def lit(around: Surroundings, at: Points, rectangles: Sequence[Rectangle], colors: Light) -> Light:
    """Return the light of rectangles.

    Args:
        around: The room.
        at: Points on its surfaces.
        rectangles: Lamps and windows.
        colors: Weight of each in each of k sums, shape (rectangles, k).

    Returns:
        The sums, shape (n, k).
    """
    total = np.zeros((len(at.points), colors.shape[1]), np.float32)
    for rectangle, color in zip(rectangles, colors, strict=True):
        total += light_of(around.room, at, rectangle)[:, None] * color
    return total


def gathered(around: Surroundings, at: Points, side: int, count: int) -> Gathered:
    """Return the hits of side x side rays of each point; `count` is the number of cells."""
    starts = starts_of(at)
    hits = np.full((side * side, len(starts)), count, np.int32)
    sky, back = np.zeros(len(starts), np.float32), np.zeros(len(starts), np.float32)
    for row, directions in zip(hits, hemisphere(at, side), strict=True):
        triangles, distances, behind = around.room.first(starts, directions)
        found = np.flatnonzero(triangles >= 0)
        names = around.names[triangles[found]]
        lit = (names >= 0) & ~behind[found]
        lit[lit] = around.charts.of[names[lit]] >= 0
        found, names = found[lit], names[lit]
        texels = around.charts.texel(
            starts[found] + distances[found, None] * directions[found], around.charts.of[names]
        )
        row[found] = around.cells[texels]
        sky += (triangles < 0) & (directions[:, 2] > 0.0)
        back += behind
    share = np.float32(1.0 / len(hits))
    return Gathered(hits, sky * share, back * share)


def serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Do the work of a parent process until it closes the pipe."""
    functions: dict[str, Callable[..., Any]] = {each.__name__: each for each in (buried, lit, gathered)}
    around: Surroundings | None = None
    while True:
        try:
            function, sent, at, arguments = received(requests)
        except EOFError:
            return
        around = sent or around
        send(answers, functions[function](around, at, *arguments))


def send(pipe: IO[bytes], value: Any) -> None:
    """Write a value to another process of ours."""
    data = pickle.dumps(value, protocol=pickle.HIGHEST_PROTOCOL)
    pipe.write(_LENGTH.pack(len(data)))
    pipe.write(data)
    pipe.flush()


def received(pipe: IO[bytes]) -> Any:
    """Return the next value of another process of ours; raises EOFError at the end, also within a value."""
    (length,) = _LENGTH.unpack(_read(pipe, _LENGTH.size))
    return pickle.loads(_read(pipe, length))  # from a process of our own


def _read(pipe: IO[bytes], length: int) -> bytes:
    data = pipe.read(length)
    if len(data) < length:
        raise EOFError
    return data
