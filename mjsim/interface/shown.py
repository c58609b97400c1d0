"""Visualisation of modules: points, lines, grids and texts, for the studio and Foxglove."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, Pose

MAX_ITEMS = 64
"""Maximum number of items in one estimate."""
MAX_POINTS = 20_000
"""Maximum number of points in all items of an estimate together."""
MAX_CELLS = 1 << 20
"""Maximum number of grid cells in all items of an estimate together."""
MAX_TEXT_LENGTH = 200
"""Maximum length of a text or a name [characters]."""
_ORIGIN: Final = Pose(0.0, 0.0, 0.0)
_COLOR = re.compile(r"#[0-9a-fA-F]{6}")

ShownFrame = Literal["world", "estimate", "base"]
"""world: the frame of the estimate's own pose; estimate: the frame of the robot at its estimated pose; base: the frame
of the robot at its true pose, such as for what a sensor has just measured."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shown:
    """Base class of items to display; a value is checked and copied on creation and immutable."""

    name: str
    """Name; the studio has a switch for all items of the same name."""
    frame: ShownFrame = "world"
    """Frame of its coordinates."""
    color: str = "#e8590c"
    """'#rrggbb'"""

    def __post_init__(self) -> None:
        """Check the values; raises ValueError."""
        _require_text("name", self.name)
        if self.frame not in get_args(ShownFrame):
            raise ValueError(f"frame is {self.frame!r:.40}; it must be one of {', '.join(get_args(ShownFrame))}")
        if not isinstance(self.color, str) or not _COLOR.fullmatch(self.color):
            raise ValueError(f"color is {self.color!r:.40}; it must be a text such as '#e8590c'")

    @property
    def points_count(self) -> int:
        """Number of its points."""
        return 0

    @property
    def cells_count(self) -> int:
        """Number of its cells."""
        return 0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShownPoints(Shown):
    """Points, such as particles or scan points."""

    points: Array
    """Shape (n, 2) on the floor, or (n, 3) [m]; kept as (n, 3)."""
    size: float = 0.05
    """Diameter of each point [m]."""

    def __post_init__(self) -> None:
        """Check the values; raises ValueError."""
        Shown.__post_init__(self)
        object.__setattr__(self, "points", _places("points", self.points))
        object.__setattr__(self, "size", _length("size", self.size))

    @property
    def points_count(self) -> int:
        """Number of its points."""
        return len(self.points)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShownLines(Shown):
    """A polyline, such as a planned path; or many line segments, such as matches."""

    points: Array
    """Shape (n, 2) on the floor, or (n, 3) [m]; kept as (n, 3)."""
    joined: bool = True
    """Whether each point is joined to the next; otherwise each pair is a line."""
    width: float = 0.02
    """[m]"""

    def __post_init__(self) -> None:
        """Check the values; raises ValueError."""
        Shown.__post_init__(self)
        object.__setattr__(self, "points", _places("points", self.points))
        object.__setattr__(self, "width", _length("width", self.width))
        if not self.joined and len(self.points) % 2:
            raise ValueError(f"{len(self.points)} points of lines that are not joined; there must be two for each")

    @property
    def points_count(self) -> int:
        """Number of its points."""
        return len(self.points)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShownGrid(Shown):
    """A grid of cells on the floor, such as an occupancy map."""

    cells: Array
    """Occupancy from 0 for free to 1 for occupied, NaN for unknown, shape (rows, columns): columns along x, rows along
    y."""
    resolution: float
    """Side of a cell [m]."""
    origin: Pose = _ORIGIN
    """Pose of the outer corner of cell (0, 0), x along its row."""

    def __post_init__(self) -> None:
        """Check the values; raises ValueError."""
        Shown.__post_init__(self)
        cells = _numbers("cells", self.cells)
        if cells.ndim != 2 or not cells.size:
            raise ValueError(f"cells have shape {cells.shape}; it must be (rows, columns), each at least 1")
        known = cells[~np.isnan(cells)]
        if len(known) and not (known.min() >= 0.0 and known.max() <= 1.0):
            raise ValueError(f"cells are from {known.min():g} to {known.max():g}; they must be from 0 to 1, or NaN")
        if not isinstance(self.origin, Pose) or not np.isfinite(self.origin.as_array()).all():
            raise ValueError(f"origin is {self.origin!r:.80}; it must be a Pose with finite numbers")
        object.__setattr__(self, "cells", _sealed(cells))
        object.__setattr__(self, "resolution", _length("resolution", self.resolution))

    @property
    def cells_count(self) -> int:
        """Number of its cells."""
        return int(self.cells.size)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShownText(Shown):
    """A text at a position."""

    text: str
    """At most 200 characters, on one line."""
    at: Array
    """Start of the text, shape (2,) on the floor, or (3,) [m]; kept as (3,)."""

    def __post_init__(self) -> None:
        """Check the values; raises ValueError."""
        Shown.__post_init__(self)
        _require_text("text", self.text)
        object.__setattr__(self, "at", _places("at", np.reshape(_numbers("at", self.at), (1, -1)))[0])

    @property
    def points_count(self) -> int:
        """A text counts as a point."""
        return 1


def require_bounds(items: Sequence[Shown]) -> None:
    """Check that the items displayed together are within limits.

    Raises:
        ValueError: They exceed a limit; the message says by how much.
    """
    counts = (
        ("items", len(items), MAX_ITEMS),
        ("points", sum(item.points_count for item in items), MAX_POINTS),
        ("cells", sum(item.cells_count for item in items), MAX_CELLS),
    )
    for kind, count, limit in counts:
        if count > limit:
            raise ValueError(f"{count} {kind} are shown at once; there must be at most {limit}")


def _require_text(label: str, text: object) -> None:
    if not isinstance(text, str) or not text.isprintable() or not 0 < len(text) <= MAX_TEXT_LENGTH:
        raise ValueError(f"{label} is {text!r:.60}; it must be 1 to {MAX_TEXT_LENGTH} printable characters")


def _numbers(label: str, values: ArrayLike) -> Array:
    """Return a copy as doubles."""
    try:
        array: Array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise ValueError(f"{label} hold something other than numbers, or rows that differ") from None
    return array


def _places(label: str, values: ArrayLike) -> Array:
    """Return points in stored form, shape (n, 3) [m]; points on the floor have z = 0."""
    array = _numbers(label, values)
    if not array.size:
        return _sealed(np.zeros((0, 3)))
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ValueError(f"{label} have shape {array.shape}; it must be (n, 2) or (n, 3)")
    if not np.isfinite(array).all():
        raise ValueError(f"{label} hold numbers that are not finite; leave those points out")
    return _sealed(np.pad(array, ((0, 0), (0, 3 - array.shape[1]))))


def _length(label: str, value: Any) -> float:
    array = _numbers(label, value)
    if array.ndim or not 0.0 < array < np.inf:
        raise ValueError(f"{label} is {value!r:.40}; it must be above 0 m")
    return float(array)


def _sealed(array: Array) -> Array:
    array.flags.writeable = False
    return array
