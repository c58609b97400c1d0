"""Parts of plans on screens and on paper: bounds, floor, grid, scale bar."""

import math

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import PlanItem, Rgb, blend, bounds_of, parse_color, world_shapes
from mjsim.video.ink import INK, MUTED, PAPER, Letters
from mjsim.video.paper import Paper
from mjsim.video.plan_view import format_metres, round_step
from mjsim.world import World, extent


def world_bounds(world: World) -> Array:
    """Return minimum and maximum of (x, y) of all that the plan shows, shape (2, 2) [m]; 10 x 10 m if empty."""
    shapes = world_shapes(world)
    spans = [mechanism.spanned()[:, :2] for mechanism in world.mechanisms]
    spans += [extent(item) for item in world.obstacles if item.path is not None]
    return bounds_of([*shapes, *([PlanItem(role="wall", kind="line", parts=spans)] if spans else [])])


def bounds_with(world: World, reach: Array | None) -> Array:
    """Return the bounds of the world and of points, shape (n, 2) [m], with a margin of 1 m around the points."""
    bounds = world_bounds(world)
    if reach is None or not len(reach):
        return bounds
    low, high = reach.min(axis=0), reach.max(axis=0)
    # Where walls enclose all points, only the walls bound the plan.
    return np.stack(
        [
            np.where(low < bounds[0], low - 1.0, bounds[0]),
            np.where(high > bounds[1], high + 1.0, bounds[1]),
        ]
    )


def draw_scale_bar(image: Picture, scale: float, letters: Letters, at: tuple[int, int]) -> None:
    """Draw a scale bar of a round length with its label on a white plate, its right end at a pixel."""
    length = round_step(60 / scale)
    name = f"{format_metres(length, length)} m"
    bar = round(length * scale)
    x, y = at
    image[y - 16 : y + 7, max(x - bar - 16 - letters.width(name, 13), 0) : x + 8] = PAPER
    letters.write(image, name, (x - bar - 8, y), 13, MUTED, align=1.0)
    cv2.rectangle(image, (x - bar, y - 7), (x, y - 2), INK, 1)
    cv2.rectangle(image, (x - bar, y - 7), (x - bar // 2, y - 2), INK, -1)


def floor_color(world: World) -> tuple[int, int, int]:
    """Return a muted version of the floor's colour."""
    return blend(parse_color(world.floor.color), PAPER, 0.86)


def draw_grid(plan: Paper, paper: Rgb, *, step: float, share: float = 0.06) -> None:
    """Draw a grid of a step [m] in the colour of the paper with a share of ink."""
    view, color = plan.view, blend(paper, INK, share)
    for x in np.arange(math.ceil(view.left / step), view.right / step) * step:
        plan.line([(x, view.bottom), (x, view.top)], color, 0.1)
    for y in np.arange(math.ceil(view.bottom / step), view.top / step) * step:
        plan.line([(view.left, y), (view.right, y)], color, 0.1)
