"""Axes of a figure, and arms that move in them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Arm
from mjsim.toolbox.calls import FigureCall

ORDER = ("#0072bd", "#d95319", "#edb120", "#7e2f8e", "#77ac30", "#4dbeee", "#a2142f")
"""Colours of successive lines, as in MATLAB."""
SHOWN_POSTURES = 6
"""Postures of an arm that a picture shows."""


@dataclass(slots=True, eq=False)
class AxesPane:
    """One pair or triple of axes."""

    axes: Any
    spec: Any
    hold: bool = False
    first: int = 0
    """Number of the colour of the first line."""
    lines: int = 0
    """Number of lines drawn, which determines the colour of the next."""
    labelled: list[Any] = field(default_factory=list)
    """Artists that a legend names, in order."""
    settings: list[FigureCall] = field(default_factory=list)
    """Calls about limits, scales and labels."""


@dataclass(slots=True, eq=False)
class ArmMotion:
    """An arm that a figure shows, with its postures in order."""

    arm: Arm
    fields: Mapping[str, Any]
    q: list[Array] = field(default_factory=list)
    pane: AxesPane | None = None

    def postures(self) -> Array:
        """Return all postures, shape (k, n)."""
        return np.vstack(self.q)


def overlap(one: tuple[int, ...], other: tuple[int, ...]) -> bool:
    """Return whether two different places of grids, (rows, columns, places ...), overlap in the figure."""
    if one == other or not all(isinstance(each, tuple) for each in (one, other)):
        return False
    (a, b, c, d), (e, f, g, h) = _sides_of(one), _sides_of(other)
    return min(b, f) - max(a, e) > 1e-9 and min(d, h) - max(c, g) > 1e-9


def _sides_of(place: tuple[int, ...]) -> tuple[float, float, float, float]:
    """Return the left and right, upper and lower side of a place, as fractions of the figure."""
    if len(place) < 3:
        return 0.0, 1.0, 0.0, 1.0
    rows, columns, *cells = place
    down, across = np.divmod(cells, columns)
    return across.min() / columns, (across.max() + 1) / columns, down.min() / rows, (down.max() + 1) / rows


def draw_motion(motion: ArmMotion, q: Array) -> None:
    """Draw an arm at some of its postures, and the path of its tool."""
    assert motion.pane is not None
    chosen = np.unique(np.linspace(0, len(q) - 1, min(len(q), SHOWN_POSTURES)).round().astype(int))
    points = motion.arm.extent(q[:: max(1, len(q) // 50)])
    motion.arm.draw(motion.pane.axes, q[chosen], bounds=points)
    if len(q) > 2:
        motion.pane.axes.plot(*motion.arm.fkine(q)[:, :3, 3].T, color=ORDER[0], lw=1.4)
    if not motion.pane.axes.get_title():
        motion.pane.axes.set_title(motion.arm.name)
