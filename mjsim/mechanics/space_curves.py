"""Smooth 3-D curves parametrised by arc length: positions, tangents and curvature.

References:
    do Carmo, Differential Geometry of Curves and Surfaces (1976), section 1.3; de Boor, A Practical Guide to Splines
    (2001), chapter 4.
"""

import math
from bisect import bisect_right
from itertools import pairwise
from typing import Self

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.special import roots_legendre

from mjsim.geometry import Array
from mjsim.mechanics.transforms import cross

PIECES_PER_SPAN = 40
"""Number of pieces between two given points for measuring and drawing."""
PIECES_PER_CIRCLE = 1440
"""Number of pieces of a circle or an ellipse."""
STRAIGHT_TOLERANCE = 1e-9
"""Maximum width of a straight curve, relative to its length."""
MAX_NEWTON_STEPS = 30
"""Maximum number of steps of Newton's method towards the nearest point."""
STEP_TOLERANCE = 1e-8
"""A step towards the nearest point shorter than this, relative to the curve, is the last: its error is the square."""


class SpaceCurve:
    """A smooth curve parametrised by arc length; an open one continues in straight lines beyond its ends."""

    def __init__(self, points: Array, *, closed: bool, axis: Array, pieces: int = PIECES_PER_SPAN) -> None:
        """Fit a cubic spline through points, and measure it.

        Args:
            points: Points on it, shape (n, 3) [m]; a closed curve returns to the first, which is not repeated.
            closed: Whether it is closed.
            axis: Normal for a straight curve, which has no unique plane, shape (3,).
            pieces: Number of pieces between two points for measuring.
        """
        points = np.concatenate([points, points[:1]]) if closed else points
        marks = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        rough = CubicSpline(marks, points, bc_type="periodic" if closed else "not-a-knot")
        fine = np.concatenate([np.linspace(a, b, pieces, endpoint=False) for a, b in pairwise(marks)])
        fine = np.append(fine, marks[-1])
        nodes, weights = roots_legendre(5)
        half = np.diff(fine)[:, None] / 2.0
        speeds = np.linalg.norm(rough((fine[:-1, None] + half) + half * nodes, 1), axis=-1)
        along = np.concatenate([[0.0], np.cumsum((speeds * weights * half).sum(axis=1))])
        self.closed, self.length = closed, float(along[-1])
        """Whether it is closed, and its length [m]."""
        knots = rough(fine)
        if closed:
            knots[-1] = knots[0]
        self._spline = CubicSpline(along, knots, bc_type="periodic" if closed else "not-a-knot")
        self._marks: list[float] = along.tolist()
        self._cubes = list(np.moveaxis(self._spline.c, 1, 0))
        sizes, directions = np.linalg.svd(knots - knots.mean(axis=0), full_matrices=False)[1:]
        self.axis: Array = axis / np.linalg.norm(axis) if sizes[1] < STRAIGHT_TOLERANCE * sizes[0] else directions[-1]
        """The direction in which it is flattest, shape (3,): the normal of its plane if it is planar."""

    @classmethod
    def ellipse(cls, across: float, up: float, axis: Array) -> Self:
        """Return an ellipse about the origin.

        Args:
            across: Semi-axis along the first direction in its plane [m].
            up: Semi-axis along the second [m].
            axis: Normal of its plane, shape (3,); both directions follow from it as for a planar joint.
        """
        turns = np.arange(PIECES_PER_CIRCLE) * 2.0 * math.pi / PIECES_PER_CIRCLE
        first, second = plane(axis)
        points = across * np.outer(np.cos(turns), first) + up * np.outer(np.sin(turns), second)
        return cls(points, closed=True, axis=axis, pieces=1)

    def at(self, along: float) -> tuple[Array, Array, Array]:
        """Return position, tangent and derivative of the tangent at an arc length.

        Args:
            along: The length [m].

        Returns:
            place: Shape (3,) [m].
            slope: Tangent, of length 1 up to the error of the spline, shape (3,).
            bend: Derivative of the tangent, 0 beyond the ends, shape (3,) [1/m].
        """
        inner = along % self.length if self.closed else min(max(along, 0.0), self.length)
        piece = min(max(bisect_right(self._marks, inner) - 1, 0), len(self._cubes) - 1)
        u = inner - self._marks[piece]
        a, b, c, d = self._cubes[piece]
        slope = (3.0 * u * a + 2.0 * b) * u + c
        place = ((u * a + b) * u + c) * u + d
        beyond = 0.0 if self.closed else along - inner
        return place + beyond * slope, slope, np.zeros(3) if beyond else 6.0 * u * a + 2.0 * b

    def place(self, along: float) -> Array:
        """Return the position at an arc length [m], shape (3,) [m]."""
        return self.at(along)[0]

    def normals(self, along: float) -> Array:
        """Return two normals at an arc length, shape (2, 3): in its plane and along its axis if it is planar."""
        return self.across(self.at(along)[1])

    def across(self, tangent: Array) -> Array:
        """Return the same two normals for its tangent there, shape (3,)."""
        across = cross(self.axis, tangent)
        size = math.sqrt(float(across @ across))
        first = across / size if size > 1e-6 else plane(tangent)[0]
        second = cross(tangent, first)
        return np.array([first, second / math.sqrt(float(second @ second))])

    def sampled(self, count: int) -> Array:
        """Return points along it, shape (count + 1, 3) [m]; the last of a closed one is the first."""
        return np.asarray(self._spline(np.linspace(0.0, self.length, count + 1)))

    def nearest(self, point: Array) -> float:
        """Return the arc length at which it is closest to a point, shape (3,) [m]."""
        distances = np.linalg.norm(self._spline(self._marks) - point, axis=1)
        return self.follow(point, self._marks[int(np.argmin(distances))])

    def follow(self, point: Array, along: float) -> float:
        """Return the arc length near another at which it is perpendicular to the line to a point, shape (3,) [m]."""
        for _ in range(MAX_NEWTON_STEPS):
            place, tangent, bend = self.at(along)
            away = point - place
            grows = float(tangent @ tangent - bend @ away)
            # Beyond the centre of curvature the nearest point is far away; stay on the tangent there.
            step = float(tangent @ away) / (grows if grows > 0.1 else float(tangent @ tangent))
            along += min(max(step, -self.length / 20.0), self.length / 20.0)
            if abs(step) < STEP_TOLERANCE * self.length:
                break
        return along


def plane(normal: Array) -> tuple[Array, Array]:
    """Return two directions in the plane of a normal, right-handed with it, shape (3,) each: x first if it can be."""
    unit = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    start = np.array([1.0, 0.0, 0.0]) if abs(unit[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = start - (start @ unit) * unit
    first /= np.linalg.norm(first)
    return first, cross(unit, first)
