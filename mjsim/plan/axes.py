"""Draws shapes with matplotlib: below the paths of plots, and as PDF to scale."""

import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mjsim.geometry import Array
from mjsim.plan.look import INKS, Theme, blend, color, hex_of
from mjsim.plan.plan_items import world_shapes
from mjsim.plan.shapes import PlanItem, Words, bounds_of
from mjsim.world import World

if TYPE_CHECKING:
    from matplotlib.axes import Axes

POINTS_PER_MM = 72.0 / 25.4
"""Points per millimetre."""
PLOT_WIDTH = 180.0
"""Assumed width of a plan within a plot [mm]."""
MOVING_FRAMES = ("robot/", "lamp/")
"""Frames of things that plots of paths leave out."""


def draw_plan(axes: "Axes", world: World) -> None:
    """Draw the plan of a world below everything else in a plot: walls, doors, obstacles, beacons."""
    shapes = [
        shape for shape in world_shapes(world) if not shape.frame.startswith(MOVING_FRAMES) and shape.role != "lamp"
    ]
    if shapes:
        draw_shapes(axes, shapes, metres=float(np.ptp(bounds_of(shapes), axis=0).max()) / PLOT_WIDTH)
        axes.autoscale_view()
    if world.beacons:
        axes.plot([], [], color=INKS["beacon"].light, lw=2.5, label="beacons")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")


def draw_shapes(axes: "Axes", shapes: Iterable[PlanItem], *, metres: float, theme: Theme = "light") -> None:
    """Draw shapes in their order in axes with metres, where a millimetre on paper is `metres` metres."""
    from matplotlib.collections import LineCollection, PolyCollection

    for shape in shapes:
        paint, parts = shape.paint(theme), [part for part in shape.placed(metres) if len(part)]
        ink, fill = (None if each is None else hex_of(each) for each in (paint.line, paint.fill))
        width = paint.width * POINTS_PER_MM
        # Dashes are multiples of the line's width.
        style = (0.0, (paint.dash / paint.width, paint.dash / paint.width / 2)) if paint.dash else "solid"
        if shape.kind == "dots":
            for part in parts:
                axes.plot(*part.T, ".", color=fill, ms=width, mew=0.0, zorder=0.9)
        elif shape.kind == "line":
            axes.add_collection(LineCollection(parts, colors=ink, linewidths=width, linestyles=[style], zorder=0.9))
        else:
            axes.add_collection(
                PolyCollection(
                    parts, facecolors=fill or "none", edgecolors=ink or "none", linewidths=width if ink else 0.0,
                    linestyles=[style], zorder=0.9,
                )
            )  # fmt: skip


def pdf_plan(
    shapes: Iterable[PlanItem], words: Sequence[Words], bounds: Array, *, ratio: float, theme: Theme = "light"
) -> bytes:
    """Return a plan as the contents of a PDF.

    Args:
        shapes: Shapes, from the floor up.
        words: Names to write.
        bounds: Bounds of the page, minimum and maximum of (x, y), shape (2, 2) [m].
        ratio: Scale denominator.
        theme: Theme of the paper.
    """
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    metres = ratio / 1000.0
    width, height = (np.ptp(bounds, axis=0) / metres / 25.4).tolist()
    figure = Figure(figsize=(width, height), facecolor=hex_of(color("paper", theme)))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set(xlim=bounds[:, 0], ylim=bounds[:, 1])
    draw_shapes(axes, shapes, metres=metres, theme=theme)
    for each in words:
        away = np.array(each.reach) + (each.gap + 0.9 + each.size / 2) * metres
        x, y = (each.at + each.side * away).tolist()
        side = "center" if abs(each.side[0]) < 0.5 else "left" if each.side[0] > 0.0 else "right"
        ink = hex_of(blend(color(each.ink, theme), color("ink", theme), 0.5))
        axes.text(x, y, each.text, size=each.size * POINTS_PER_MM, color=ink, ha=side, va="center")
    buffer = io.BytesIO()
    with rc_context({"pdf.fonttype": 42}):
        figure.savefig(buffer, format="pdf", metadata={"CreationDate": None})
    return buffer.getvalue()
