"""Converts lines of a drawing to walls: scales them to metres and joins them where they meet."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.drawings.layer_roles import Role
from mjsim.exchange.maps import DIGITS, WALL_HEIGHT, distinct
from mjsim.geometry import Array
from mjsim.inventory import FileItem
from mjsim.world import Wall

MAX_CORNERS = 20_000
"""Maximum number of corners in a drawing."""
MAX_BYTES = 20_000_000
"""Maximum size of a drawing's file [bytes]."""
MAX_COORDINATE = 1e12
"""Maximum coordinate of a corner; maps of countries in millimetres have 1e10 [units of the drawing]."""
MIN_FLOOR, MAX_FLOOR = 0.5, 2000.0
"""Smallest and largest size of a floor [m]."""
HAIRLINE_THICKNESS = 0.1
"""Thickness of a wall drawn as a thin line [m]."""
MIN_PEN, MAX_PEN = 0.03, 1.0
"""A line width between these is taken as the thickness of the wall [m]."""
MAX_END_GAP = 0.02
"""Line ends closer than this are joined [m]."""
MAX_STRAY = 0.005
"""A corner closer than this to the line between its neighbours is removed [m]."""
MIN_LINE = 0.01
"""Shorter lines are left out [m]."""
MAX_BOW = 0.002
"""Maximum deviation of the straight segments of a curve, as a fraction of the curve's size."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """A polyline as drawn; y points up."""

    points: Array
    """Corners, shape (n, 2) [units of the drawing]."""
    closed: bool = False
    width: float = 0.0
    """Line width as drawn; 0 for a hairline [units of the drawing]."""
    role: Role | None = None
    """Role derived from the names of its layer and block."""
    block: str = ""
    """Name of its block; empty if it is not in a block."""
    part: int = 0
    """Number of the item or block instance that it belongs to; 0 for none."""
    path: int = 0
    """Number of the drawn shape; one shape may have several outlines."""
    dark: float | None = None
    """Darkness of the fill, 0 to 1; None if it is not filled."""
    blank: bool = False
    """Whether it has the background colour and hides what was drawn before it."""
    parts: tuple[int, ...] = ()
    """Numbers of the block instances that contain it, innermost last."""


@dataclass(frozen=True, slots=True, eq=False)
class Drawing:
    """The lines of a drawing file that may be walls, furniture or symbols."""

    name: str
    """Name of the file."""
    lines: Sequence[Line]
    unit: float | None = None
    """Metres per unit of the drawing, if the file states it."""
    named: bool = False
    """Whether the user named the layers that contain walls."""
    items: Sequence[FileItem] = ()
    """Contents of the file that are not among its lines."""

    def __post_init__(self) -> None:
        """Check the corners before geometry is computed with them.

        Raises:
            UsageError: A coordinate is not finite, or too large.
        """
        require_near([line.points for line in self.lines], self.name)


def require_near(outlines: Sequence[Array], name: str) -> None:
    """Check that corners can be computed with; libraries of geometry do not return from some huge coordinates.

    Args:
        outlines: Corners, shape (n, 2) each [units of the drawing].
        name: Name of the file, for the message.

    Raises:
        UsageError: A coordinate is not finite, or too large.
    """
    points = np.concatenate([np.zeros((1, 2)), *outlines])
    if not np.isfinite(points).all():
        raise UsageError(f"'{name}' has corners without finite coordinates; correct the drawing")
    farthest = float(np.abs(points).max())
    if farthest > MAX_COORDINATE:
        raise UsageError(f"'{name}' has a corner at {farthest:.3g}; coordinates are at most {MAX_COORDINATE:g} units")


def joined(lines: Sequence[Line]) -> list[Line]:
    """Return lines in metres without duplicates; lines that meet end to end are joined, straightest joints first."""
    once = {_ends_and_corners(line): line for line in lines}
    chains = [line.points for line in once.values() if not line.closed]
    whole = [line for line in once.values() if line.closed]
    links = _links(chains)
    waiting = dict.fromkeys(range(len(chains)))
    while waiting:
        first = next(iter(waiting))
        back, ring = _walk((first, 0), links, waiting)
        ahead = [] if ring else _walk((first, 1), links, waiting)[0]
        order = [(chain, 1 - end) for chain, end in reversed(back)] + [(first, 1)] + ahead
        parts = [chains[chain][:: 1 if end else -1] for chain, end in order]
        corners = np.concatenate([parts[0], *(part[1:] for part in parts[1:])])
        waiting.pop(first, None)
        whole.append(Line(corners[:-1] if ring else corners, ring))
    return whole


def _walk(
    start: tuple[int, int], links: dict[tuple[int, int], tuple[int, int]], waiting: dict[int, None]
) -> tuple[list[tuple[int, int]], bool]:
    """Return the chains that follow from an end, each with the end at which it is left, and whether they close."""
    found: list[tuple[int, int]] = []
    current = start
    while (entered := links.get(current)) is not None:
        if entered[0] == start[0]:
            return found, True
        current = (entered[0], 1 - entered[1])
        found.append(current)
        waiting.pop(entered[0], None)
    return found, False


def _links(chains: Sequence[Array]) -> dict[tuple[int, int], tuple[int, int]]:
    """Return which ends meet, as (chain, 0 for its first corner or 1 for its last), the straightest joints first."""
    from scipy.spatial import cKDTree

    ends = [(index, end) for index in range(len(chains)) for end in (0, 1)]
    if not ends:
        return {}
    places = np.array([chains[index][-end] for index, end in ends])
    meetings = []
    for one, other in cKDTree(places).query_pairs(MAX_END_GAP):
        if ends[one][0] != ends[other][0] or len(chains[ends[one][0]]) > 3:
            bend = float(_outward(chains, ends[one]) @ _outward(chains, ends[other]))
            meetings.append((bend, ends[one], ends[other]))
    links: dict[tuple[int, int], tuple[int, int]] = {}
    for _, begin, target in sorted(meetings):
        if begin not in links and target not in links:
            links[begin], links[target] = target, begin
    return links


def _outward(chains: Sequence[Array], end: tuple[int, int]) -> Array:
    """Return the outward direction of a line at one of its ends, unit vector, shape (2,)."""
    points = chains[end[0]] if end[1] else chains[end[0]][::-1]
    along = points[-1] - points[-2]
    return np.asarray(along / max(1e-12, math.hypot(*along)), dtype=float)


def _ends_and_corners(line: Line) -> tuple[bool, tuple[tuple[float, ...], ...]]:
    corners = tuple(map(tuple, (np.round(line.points, DIGITS) + 0.0).tolist()))
    return line.closed, min(corners, corners[::-1])


def corner_and_scale(drawing: Drawing, lines: Sequence[Line], scale: float | None) -> tuple[Array, float]:
    """Return the lower left corner of lines [units of the drawing], and metres per unit.

    Raises:
        UsageError: The drawing does not state its unit, or its size is not that of a floor.
    """
    points = np.concatenate([line.points for line in lines])
    low, high = points.min(axis=0), points.max(axis=0)
    size = (high - low).tolist()
    scale = drawing.unit if scale is None else scale
    if scale is None:
        raise UsageError(
            f"'{drawing.name}' does not state its unit, and measures {size[0]:.7g} x {size[1]:.7g} units;"
            f" give --scale METRES, the metres per unit{_guessed(max(size))}"
        )
    if not MIN_FLOOR <= max(size) * scale <= MAX_FLOOR:
        raise UsageError(
            f"'{drawing.name}' is {size[0] * scale:.7g} x {size[1] * scale:.7g} m at {scale:g}m per unit;"
            f" a floor measures {MIN_FLOOR:g} to {MAX_FLOOR:g} m, give another --scale{_guessed(max(size))}"
        )
    return low, scale


def _guessed(size: float) -> str:
    """Return a message that suggests the scale at which a drawing of this size would be a building."""
    if 3000.0 <= size <= 100_000.0:
        return ", 0.001 for millimetres"
    return ", 1 for metres" if 5.0 <= size <= 60.0 else ""


def drawn_thickness(width: float) -> float:
    """Return the thickness of a wall that is drawn as one line of the given width [m]."""
    return round(width, DIGITS) if MIN_PEN <= width <= MAX_PEN else HAIRLINE_THICKNESS


def wall_along(line: Line, thickness: float) -> Wall | None:
    """Return the wall along a line in metres; None if nothing of it remains."""
    import shapely

    points = np.concatenate([line.points, line.points[:1]]) if line.closed else line.points
    straight = shapely.get_coordinates(shapely.simplify(shapely.linestrings(points), MAX_STRAY))
    corners = distinct(straight, closed=line.closed)
    if line.closed and len(corners) > 2:
        corners = tuple(_without_straight(corners))
    if len(corners) < 2 or sum(math.dist(*pair) for pair in itertools.pairwise(corners)) < MIN_LINE:
        return None
    return Wall(points=corners, closed=line.closed and len(corners) > 2, thickness=thickness, height=WALL_HEIGHT)


def _without_straight(corners: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """Yield the corners of a ring, without the first if the ring is straight there."""
    (x0, y0), (x1, y1), (x2, y2) = corners[-1], corners[0], corners[1]
    bow = abs((x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0)) / max(1e-12, math.hypot(x2 - x0, y2 - y0))
    yield from corners if bow > MAX_STRAY or len(corners) < 4 else corners[1:]
