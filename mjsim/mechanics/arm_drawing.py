"""A picture of an arm: links, joints with their axes, the frame of the tool, and the floor below."""

from typing import TYPE_CHECKING, Any

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics.arm_links import Link
from mjsim.mechanics.chain import Chain, Posture
from mjsim.mechanics.transforms import IDENTITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = ("#d62728", "#2ca02c", "#1f77b4")
"""Colours of the axes x, y and z of the tool."""
BONE, JOINT, SHADOW = "#5b6470", "#e8a33d", "#c9ced6"
AXIS_LENGTH = 0.15
"""Length of the drawn axes as a fraction of the arm's reach."""


def drawing(name: str, links: tuple[Link, ...], chain: Chain, posture: Posture) -> "Figure":
    """Return a picture of an arm at k postures, the last one drawn strongest, with the tool's path between them.

    Args:
        name: Name of the arm.
        links: Links from the base outwards.
        chain: The same as arrays.
        posture: Where the parts are, arrays with one leading axis of k.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 6.2), layout="constrained")
    FigureCanvasAgg(figure)
    axes: Any = figure.add_subplot(projection="3d")
    draw_arm(axes, links, chain, posture)
    axes.set_title(name)
    return figure


def draw_arm(
    axes: Any, links: tuple[Link, ...], chain: Chain, posture: Posture, *, bounds: Array | None = None
) -> None:
    """Draw an arm at k postures into 3-D axes, the last one strongest.

    Args:
        axes: Axes of matplotlib, with a 3-D projection.
        links: Links from the base outwards.
        chain: The same as arrays.
        posture: Where the parts are, arrays with one leading axis of k.
        bounds: Points that the view includes, shape (m, 3) [m]; by default those of the arm, with the path of its tool.
    """
    lines, fingers = _lines(links, chain, posture), _fingers(links, chain, posture)
    strengths = [0.25] * (len(lines) - 1) + [1.0]
    for number, (line, strength) in enumerate(zip(lines, strengths, strict=True)):
        _draw_links(axes, line, strength)
        for finger in fingers[number]:
            axes.plot(*finger.T, color=BONE, linewidth=3, alpha=strength, solid_capstyle="round")
        _draw_joints(axes, links, posture.joints[number], 0.05 * _reach(line), strength)
    if len(lines) > 1 and bounds is None:
        axes.plot(*posture.tool[:, :3, 3].T, color=COLORS[2], linewidth=1.0)
    _draw_frame(axes, posture.tool[-1], AXIS_LENGTH * _reach(lines[-1]), "")
    _draw_frame(axes, IDENTITY, AXIS_LENGTH * _reach(lines[-1]), "xyz")
    _set_view(axes, lines.reshape(-1, 3) if bounds is None else bounds)


def extent_of(links: tuple[Link, ...], chain: Chain, posture: Posture) -> Array:
    """Return the points of an arm at k postures, shape (m, 3) [m]."""
    return _lines(links, chain, posture).reshape(-1, 3)


def _lines(links: tuple[Link, ...], chain: Chain, posture: Posture) -> Array:
    """Return the points of the arm's centreline: base, ends of links and tool, shape (k, m, 3) [m]."""
    count = len(posture.links)
    points = [np.broadcast_to(chain.first[:3, 3], (count, 3))]
    for number, link in enumerate(links):
        if chain.carried[chain.end, number]:
            points += [(posture.links[:, number] @ [*end, 1.0])[:, :3] for end in link.bone]
    return np.stack([*points, posture.links[:, chain.end, :3, 3], posture.tool[:, :3, 3]], axis=1)


def _fingers(links: tuple[Link, ...], chain: Chain, posture: Posture) -> Array:
    """Return the points of each link that does not carry the tool, from its carrier on, shape (k, links, 3, 3) [m]."""
    found = [np.zeros((len(posture.links), 0, 3, 3))]
    for number in np.flatnonzero(chain.carried[chain.end] == 0.0).tolist():
        ends = [(posture.links[:, number] @ [*end, 1.0])[:, :3] for end in links[number].bone]
        parent = chain.parents[number]
        before = posture.links[:, parent, :3, 3] if parent >= 0 else np.broadcast_to(chain.first[:3, 3], ends[0].shape)
        found.append(np.stack([before, *ends], axis=1)[:, None])
    return np.concatenate(found, axis=1)


def _draw_links(axes: Any, line: Array, strength: float) -> None:
    axes.plot(line[:, 0], line[:, 1], np.full(len(line), _floor(line)), color=SHADOW, linewidth=3, alpha=strength)
    axes.plot(*line.T, color=BONE, linewidth=5, alpha=strength, solid_capstyle="round", solid_joinstyle="round")


def _draw_joints(axes: Any, links: tuple[Link, ...], joints: Array, half: float, strength: float) -> None:
    """Draw a thick piece of axis at each joint, with a thin one through it where it slides."""
    for link, frame in zip(links, joints, strict=True):
        for length, width in ((1.0, 9.0), (2.0, 3.0 if link.slide else 0.0)):
            ends = frame[:3, 3] + half * length * np.array([[-1.0], [1.0]]) * frame[:3, 2]
            axes.plot(*ends.T, color=JOINT, linewidth=width, alpha=strength, solid_capstyle="butt")


def _draw_frame(axes: Any, frame: Array, length: float, names: str) -> None:
    origin = frame[:3, 3]
    for column, color in enumerate(COLORS):
        end = origin + length * frame[:3, column]
        axes.plot(*np.array([origin, end]).T, color=color, linewidth=2)
        if names:
            axes.text(*(origin + 1.25 * length * frame[:3, column]), names[column], color=color)


def _set_view(axes: Any, points: Array) -> None:
    """Show all points at one scale, seen from above at the front right."""
    points = np.concatenate([points, np.zeros((1, 3))])
    middle, half = (points.max(axis=0) + points.min(axis=0)) / 2, 0.55 * _reach(points)
    for set_limits, center in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, strict=True):
        set_limits(center - half, center + half)
    axes.set_box_aspect((1, 1, 1))
    axes.view_init(elev=22, azim=-55)
    for set_label, name in zip((axes.set_xlabel, axes.set_ylabel, axes.set_zlabel), "xyz", strict=True):
        set_label(f"{name} [m]")


def _reach(points: Array) -> float:
    """Return the largest extent of points along an axis [m]."""
    return float(max(np.ptp(points, axis=0).max(), 1e-3))


def _floor(points: Array) -> float:
    return float(min(points[:, 2].min(), 0.0))
