"""Symbols of joints in kinematic diagrams; lengths are in millimetres on paper.

References:
    ISO 3952-1 (1981), Kinematic diagrams: graphical symbols of kinematic pairs.
"""

import math
from collections.abc import Callable

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan import arc
from mjsim.video.ink import ESTIMATE, INK, PAPER
from mjsim.video.paper import Paper

HINGE_RADIUS = 0.9
"""Radius of a hinge seen along its axis [mm]."""
FINE_LINE, BOLD_LINE = 0.2, 0.3
"""Thickness of lines [mm]."""
Symbol = Callable[[Paper, Pose, bool], None]
"""Draws a joint at a pose whose x axis is the joint's axis; the flag says whether the view is along that axis."""


def draw_joint(drawing: Paper, kind: str, place: Pose, *, along: bool) -> None:
    """Draw the symbol of a joint.

    Args:
        drawing: Sheet to draw on.
        kind: Kind of joint, such as 'revolute'.
        place: Position and direction of the axis, in the plane of the drawing.
        along: Whether the view is along the axis.
    """
    SYMBOLS[kind](drawing, place, along)


def draw_ground(drawing: Paper, place: Pose) -> None:
    """Draw the hatched ground line below a joint of the ground."""
    low = -1.9
    for foot in (-0.9, 0.9):
        _stroke(drawing, place, [(0.0, 0.0), (foot, low)], FINE_LINE)
    _stroke(drawing, place, [(-2.0, low), (2.0, low)], BOLD_LINE)
    for x in np.arange(-2.0, 1.5, 0.8):
        _stroke(drawing, place, [(x, low - 0.9), (x + 0.7, low)], FINE_LINE)


def draw_turning(drawing: Paper, place: Pose) -> None:
    """Draw the arrow of an actuator that rotates a joint."""
    curve = arc((0.0, 0.0), 2.3, -0.6, 3.6)
    points = place.transform(curve * drawing.metres(1.0))
    drawing.line(points[:-3], ESTIMATE, BOLD_LINE)
    drawing.arrow(points[[-4, -1]], ESTIMATE, BOLD_LINE)


def draw_sliding(drawing: Paper, place: Pose) -> None:
    """Draw the arrow of an actuator that translates a joint, beside it."""
    drawing.arrow(_points(drawing, place, [(-2.2, 1.7), (2.6, 1.7)]), ESTIMATE, BOLD_LINE)


def _points(drawing: Paper, place: Pose, millimetres: "list[tuple[float, float]]") -> Array:
    return place.transform(np.array(millimetres) * drawing.metres(1.0))


def _stroke(
    drawing: Paper, place: Pose, millimetres: "list[tuple[float, float]]", thickness: float, *, closed: bool = False
) -> None:
    drawing.line(_points(drawing, place, millimetres), INK, thickness, closed=closed)


def _ring(drawing: Paper, place: Pose, radius: float = HINGE_RADIUS) -> None:
    middle = (place.x, place.y)
    drawing.disc(middle, drawing.metres(radius), PAPER)
    drawing.disc(middle, drawing.metres(radius), INK, thickness=BOLD_LINE)


def _dot(drawing: Paper, place: Pose, radius: float) -> None:
    drawing.disc((place.x, place.y), drawing.metres(radius), INK)


def _block(drawing: Paper, place: Pose, length: float, width: float) -> None:
    x, y = length / 2, width / 2
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    drawing.fill(_points(drawing, place, corners), PAPER)
    _stroke(drawing, place, corners, BOLD_LINE, closed=True)


def _shaft(drawing: Paper, place: Pose, half: float) -> None:
    _stroke(drawing, place, [(-half, 0.0), (half, 0.0)], BOLD_LINE)


def _cross(drawing: Paper, place: Pose, half: float) -> None:
    for ends in ([(-half, 0.0), (half, 0.0)], [(0.0, -half), (0.0, half)]):
        _stroke(drawing, place, ends, FINE_LINE)


def _turned(place: Pose) -> Pose:
    return Pose(place.x, place.y, place.heading + math.pi / 4)


def _weld(drawing: Paper, place: Pose, along: bool) -> None:
    corners = [(-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)]
    drawing.fill(_points(drawing, place, corners), INK)


def _revolute(drawing: Paper, place: Pose, along: bool) -> None:
    if along:
        _ring(drawing, place)
        return
    _shaft(drawing, place, 2.2)
    _block(drawing, place, 1.8, 1.3)
    for x in (-1.3, 1.3):
        _stroke(drawing, place, [(x, -0.8), (x, 0.8)], BOLD_LINE)


def _prismatic(drawing: Paper, place: Pose, along: bool) -> None:
    if along:
        _block(drawing, place, 1.7, 1.7)
        _cross(drawing, _turned(place), 1.15)
        return
    _shaft(drawing, place, 3.2)
    _block(drawing, place, 2.8, 1.5)


def _cylindrical(drawing: Paper, place: Pose, along: bool) -> None:
    if along:
        _ring(drawing, place, 1.1)
        _ring(drawing, place, 0.5)
        return
    _block(drawing, place, 2.2, 1.5)
    _shaft(drawing, place, 2.8)


def _screw(drawing: Paper, place: Pose, along: bool) -> None:
    if along:
        _ring(drawing, place, 1.1)
        _cross(drawing, _turned(place), 1.1)
        return
    _shaft(drawing, place, 2.8)
    _block(drawing, place, 2.4, 1.6)
    _stroke(drawing, place, [(-1.2, -0.8), (-0.4, 0.8), (0.4, -0.8), (1.2, 0.8)], FINE_LINE)


def _planar(drawing: Paper, place: Pose, along: bool) -> None:
    if along:
        _block(drawing, place, 2.4, 2.4)
        _ring(drawing, place, 0.6)
        return
    for x in (-0.4, 0.4):
        _stroke(drawing, place, [(x, -2.2), (x, 2.2)], BOLD_LINE)


def _in_plane(drawing: Paper, place: Pose, along: bool) -> None:
    _planar(drawing, place, along)
    if along:
        _block(drawing, place, 2.4, 2.4)
        _cross(drawing, place, 1.2)
    else:
        _block(drawing, place, 0.8, 1.4)


def _spherical(drawing: Paper, place: Pose, along: bool) -> None:
    _ring(drawing, place, 1.2)
    _dot(drawing, place, 0.75)


def _universal(drawing: Paper, place: Pose, along: bool) -> None:
    _ring(drawing, place, 1.1)
    _cross(drawing, place, 1.1)


def _gimbal(drawing: Paper, place: Pose, along: bool) -> None:
    _ring(drawing, place, 1.5)
    _universal(drawing, place, along)


def _bearing(drawing: Paper, place: Pose, along: bool) -> None:
    _shaft(drawing, place, 3.0)
    _block(drawing, place, 2.8, 2.2)
    _spherical(drawing, place, along)


def _telescoping(drawing: Paper, place: Pose, along: bool) -> None:
    _prismatic(drawing, place, along)
    _dot(drawing, place, 0.75)


def _bushing(drawing: Paper, place: Pose, along: bool) -> None:
    _ring(drawing, place, 1.5)
    _stroke(drawing, place, [(-1.5, 0), (-0.9, 0), (-0.6, 0.7), (0, -0.7), (0.6, 0.7), (0.9, 0), (1.5, 0)], FINE_LINE)


def _six_dof(drawing: Paper, place: Pose, along: bool) -> None:
    drawing.dashes(arc((place.x, place.y), drawing.metres(1.3), 0.0, 2.0 * math.pi), INK, BOLD_LINE, dash=0.7)


def _custom(drawing: Paper, place: Pose, along: bool) -> None:
    _block(drawing, _turned(place), 1.8, 1.8)


SYMBOLS: dict[str, Symbol] = {
    "weld": _weld,
    "revolute": _revolute,
    "prismatic": _prismatic,
    "cylindrical": _cylindrical,
    "planar": _planar,
    "in_plane": _in_plane,
    "universal": _universal,
    "gimbal": _gimbal,
    "spherical": _spherical,
    "bearing": _bearing,
    "telescoping": _telescoping,
    "bushing": _bushing,
    "screw": _screw,
    "six_dof": _six_dof,
    "custom": _custom,
}
"""Symbols by the joint's key in a world file."""
