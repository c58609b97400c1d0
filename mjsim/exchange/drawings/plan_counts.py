"""Lists what was made of a drawing, what was guessed and what was left out."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.layer_roles import Role
from mjsim.inventory import Fate, FileItem
from mjsim.world import Wall

_LEFT: dict[Role | None, str] = {"note": "lines of notes", "stairs": "lines of stairs"}
"""Descriptions of roles that are not represented in the world."""
MIN_THICK, MAX_SHORT = 0.3, 3.0
"""Thickness and length of a wall that may be a piece of furniture if it touches no other wall [m]."""
ALONE = "thick walls that stand alone"
"""These may be dark pieces of furniture."""
UNEVEN = "pieces of furniture that are no rectangles"
"""These become boxes around them."""


def left_out(lines: Sequence[Line]) -> Counter[str]:
    """Return how many lines have roles that are not represented in the world, by description."""
    return Counter(_LEFT[line.role] for line in lines if line.role in _LEFT)


def count_walls(walls: Sequence[Wall], counts: Counter[str]) -> None:
    """Count doorways and windows, and short, thick walls that touch no other."""
    import shapely

    lines = [shapely.LineString(wall.points).buffer(wall.thickness / 2, cap_style="flat") for wall in walls]
    tree = shapely.STRtree(lines)
    for wall, line in zip(walls, lines, strict=True):
        thick = wall.thickness >= MIN_THICK and len(wall.points) == 2
        if thick and math.dist(*wall.points) <= MAX_SHORT and len(tree.query(line, "dwithin", distance=0.05)) == 1:
            counts[ALONE] += 1
        for opening in wall.openings:
            counts["windows" if opening.sill else "doorways"] += 1


def listed(counts: Counter[str], others: int = 0) -> Iterator[FileItem]:
    """Yield what was made of a drawing, what was guessed and what was left out.

    Args:
        counts: How many of each kind.
        others: How many lines are on layers of no known role, where other layers have the walls.
    """
    made = {
        "doorways": "doorway",
        "windows": "window",
        "columns": "column",
        "pieces of furniture": "piece of furniture",
        "walls drawn by one line": "wall drawn by one line",
    }
    had = [f"{counts[many]} {one if counts[many] == 1 else many}" for many, one in made.items() if counts[many]]
    if had:
        yield FileItem(Fate.KEPT, ", ".join(had))
    yield FileItem(Fate.GUESSED, "heights", why="a drawing has none")
    if number := counts[UNEVEN]:
        pieces = "a piece of furniture that is" if number == 1 else f"{number} pieces of furniture that are"
        yield FileItem(Fate.GUESSED, f"the shape of {pieces} not rectangular", why="a box around it")
    if number := counts[ALONE]:
        what = "a thick wall that stands" if number == 1 else f"{number} thick walls that stand"
        yield FileItem(Fate.GUESSED, f"{what} alone", why="dark shapes are walls unless a name says 'furniture'")
    if others:
        lines = f"{others} {'line' if others == 1 else 'lines'} on layers without a known role"
        yield FileItem(Fate.GUESSED, lines, why="doors or furniture, never walls; --layer NAME makes walls of them")
    if left := [f"{count} {kind}" for kind, count in counts.items() if count and kind not in (*made, ALONE, UNEVEN)]:
        yield FileItem(Fate.LEFT_OUT, ", ".join(left))
