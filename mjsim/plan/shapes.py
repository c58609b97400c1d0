"""The display list of a plan: shapes and words in metres, each with a role whose look is that of `ROLES`."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan.look import ROLES, Paint, Theme, paint_of

ORIGIN = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PlanItem:
    """Outlines, lines or dots of one role."""

    role: str
    parts: Sequence[Array]
    """Corners of each part in the frame of the shape, shape (n, 2) [m], or [mm on paper] for a symbol."""
    kind: Literal["area", "line", "dots"] = "area"
    """Closed outlines, open lines, or dots at the corners."""
    symbol: bool = False
    """Whether it has the same size at each scale."""
    place: Pose = ORIGIN
    """world_from_shape."""
    of: str = ""
    """Name of the thing that it shows."""
    frame: str = ""
    """The frame that carries it, such as 'door/NAME', 'obstacle/NAME' or 'robot/NAME'; empty for the room."""
    frame_from_shape: Pose = ORIGIN
    tint: str = ""
    """Own colour of the thing, '#rrggbb'."""
    level: float = 1.0
    """Strength of its fill, from 0 to 1."""
    least: float = 0.0
    """Minimum distance of its farthest corner from its origin [mm on paper]; smaller shapes are enlarged."""
    ahead: float = 0.0
    """Distance by which it is shifted along its x axis [mm on paper]."""

    @property
    def group(self) -> str:
        """Group of a drawing that contains it, such as 'walls'."""
        return ROLES[self.role].group

    def placed(self, metres: float) -> list[Array]:
        """Return the corners of all parts in the world frame, shape (n, 2) each [m].

        Args:
            metres: Length in the world of a millimetre on paper [m].
        """
        scale = metres if self.symbol else 1.0
        if self.least:
            reach = max(float(np.hypot(*np.transpose(part)).max()) for part in self.parts)
            scale *= max(1.0, self.least * metres / max(scale * reach, 1e-9))
        if scale == 1.0 and not self.ahead and self.place is ORIGIN:
            return list(self.parts)
        shift = np.array([self.ahead * metres, 0.0])
        return [self.place.transform(np.multiply(part, scale) + shift) for part in self.parts]

    def paint(self, theme: Theme = "light") -> Paint:
        """Return its colours and the width of its lines; symbols in one colour have no edge."""
        paint = paint_of(self.role, tint=self.tint, level=self.level, theme=theme)
        is_plain = self.symbol and self.kind == "area" and paint.fill == paint.line
        return replace(paint, line=None) if is_plain else paint


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Words:
    """A name to write beside its object."""

    text: str
    at: Array
    """The named point, world frame, shape (2,) [m]."""
    side: Array
    """Preferred side, a unit vector in the world frame; zeros for centred on the point."""
    reach: tuple[float, float] = (0.0, 0.0)
    """Half extent of the named thing in x and y around the point [m]."""
    gap: float = 0.0
    """Half extent of its symbol [mm on paper]."""
    inside: bool = False
    """Whether it is centred on the thing where that is large enough."""
    ink: str = "muted"
    """Its colour, one of `INKS`, darkened."""
    size: float = 2.3
    """Height of the font [mm on paper]."""
    of: Literal["thing", "wall", "other"] = "other"
    """What it names: an obstacle, a wall, or something else."""
    moves: bool = False
    """Whether the named thing may move."""


def placed_at(shapes: Iterable[PlanItem], frames: Mapping[str, Pose]) -> list[PlanItem]:
    """Return shapes where their frames are; world_from_frame by name, others stay where they are."""
    return [
        shape if (pose := frames.get(shape.frame)) is None else replace(shape, place=pose @ shape.frame_from_shape)
        for shape in shapes
    ]


def bounds_of(shapes: Iterable[PlanItem]) -> Array:
    """Return minimum and maximum of (x, y) of shapes, shape (2, 2) [m], at least 1 m wide; 10 x 10 m without any."""
    points = [np.reshape(part, (-1, 2)) for shape in shapes for part in shape.placed(0.0)]
    if not points:
        return np.array([[-5.0, -5.0], [5.0, 5.0]])
    found = np.concatenate(points)
    low, high = found.min(axis=0), found.max(axis=0)
    short = np.maximum(1.0 - (high - low), 0.0) / 2
    return np.stack([low - short, high + short])
