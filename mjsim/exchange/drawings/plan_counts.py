"""Lists what was made of a drawing, what was guessed and what was left out."""

import math
from collections import Counter
from collections.abc import Iterator, Sequence

from mjsim.exchange.drawings.drawing import Line
from mjsim.exchange.drawings.layer_roles import Role
from mjsim.inventory import Fate, FileItem
from mjsim.sentences import number_of
from mjsim.world import Wall

_LEFT: dict[Role | None, str] = {"note": "line of a note", "stairs": "line of stairs"}
"""Descriptions of roles that are not represented in the world."""
MIN_THICK, MAX_SHORT = 0.3, 3.0
"""Minimum thickness and maximum length of a wall that may be a piece of furniture if it touches no other wall [m]."""
ALONE = "lone thick wall"
"""These may be dark pieces of furniture."""
FINER = "line of a finer pen than walls"
UNEVEN = "piece of furniture that is no rectangle"
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
            counts["window" if opening.sill else "doorway"] += 1


def listed(counts: Counter[str], others: int = 0) -> Iterator[FileItem]:
    """Yield what was made of a drawing, what was guessed and what was left out.

    Args:
        counts: How many of each kind.
        others: How many lines are on layers of no known role, where other layers have the walls.
    """
    made = ("doorway", "window", "column", "piece of furniture", "wall drawn by one line")
    if had := [number_of(counts[kind], kind) for kind in made if counts[kind]]:
        yield FileItem(Fate.KEPT, ", ".join(had))
    yield FileItem(Fate.GUESSED, "heights", why="a drawing has none")
    if number := counts[UNEVEN]:
        shape = f"the shape of {number_of(number, 'piece of furniture')}, not rectangular"
        yield FileItem(Fate.GUESSED, shape, why="a box around it")
    if number := counts[ALONE]:
        what = number_of(number, "lone thick wall")
        yield FileItem(Fate.GUESSED, what, why="dark shapes are walls unless a name says 'furniture'")
    if others:
        lines = number_of(others, "line on layers without a known role")
        yield FileItem(Fate.GUESSED, lines, why="doors or furniture, never walls; --layer NAME makes walls of them")
    if left := [
        number_of(count, kind) for kind, count in counts.items() if count and kind not in (*made, ALONE, UNEVEN)
    ]:
        yield FileItem(Fate.LEFT_OUT, ", ".join(left))
