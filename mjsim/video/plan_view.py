"""A section of the world in a picture, to scale: converts metres to pixels and back."""

import math
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array


@dataclass(frozen=True, slots=True)
class PlanView:
    """The section of the plan in a picture; x east, y north, so y points up in the picture."""

    left: float
    """x of the left edge, world frame [m]."""
    top: float
    """y of the top edge, world frame [m]."""
    scale: float
    """[px/m]"""
    width: int
    """[px]"""
    height: int
    """[px]"""

    @classmethod
    def fit(cls, bounds: ArrayLike, width: int, height: int, *, margin: int = 0) -> Self:
        """Return the view that shows a box, minimum and maximum of (x, y), shape (2, 2) [m], centred."""
        (x0, y0), (x1, y1) = np.asarray(bounds, dtype=float).tolist()
        scale = min((width - 2 * margin) / max(x1 - x0, 1e-3), (height - 2 * margin) / max(y1 - y0, 1e-3))
        return cls.around((x0 + x1) / 2, (y0 + y1) / 2, scale, width, height)

    @classmethod
    def around(cls, x: float, y: float, scale: float, width: int, height: int) -> Self:
        """Return the view centred on a world point."""
        return cls(x - width / (2 * scale), y + height / (2 * scale), scale, width, height)

    def pixels(self, points: ArrayLike) -> Array:
        """Return the pixels of world points, shape (..., 2) [m]; pixel centres are at integers."""
        points = np.asarray(points, dtype=float)
        return np.asarray((points - (self.left, self.top)) * (self.scale, -self.scale) - 0.5)

    def world(self, pixels: ArrayLike) -> Array:
        """Return the world points [m] of pixels, shape (..., 2)."""
        return np.asarray((np.asarray(pixels, dtype=float) + 0.5) / (self.scale, -self.scale) + (self.left, self.top))

    def part(self, column: int, row: int, width: int, height: int) -> "PlanView":
        """Return the view of a part of the picture with top left corner (column, row)."""
        return PlanView(self.left + column / self.scale, self.top - row / self.scale, self.scale, width, height)

    @property
    def bottom(self) -> float:
        """The y of the bottom edge, world frame [m]."""
        return self.top - self.height / self.scale

    @property
    def right(self) -> float:
        """The x of the right edge, world frame [m]."""
        return self.left + self.width / self.scale


def round_step(least: float) -> float:
    """Return the smallest of 1, 2, 5 times a power of ten that is at least a positive number."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least * (1 - 1e-9))


def format_metres(value: float, step: float) -> str:
    """Return a number with as many decimals as its step needs, and a typographic minus sign."""
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    return f"{value + 0.0:.{decimals}f}".replace("-", "\N{MINUS SIGN}")
