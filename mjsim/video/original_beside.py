"""Draws a world beside the map or drawing from which it was made, at the same scale and with the same grid."""

from pathlib import Path

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.output import require_free
from mjsim.plan import Original, blend
from mjsim.video.ink import INK, PAPER
from mjsim.video.paper import Paper, write_sheet
from mjsim.video.plan_parts import world_bounds
from mjsim.video.sheet import (
    BOTTOM,
    LEFT,
    RIGHT,
    TOP,
    Labels,
    draw_axes,
    draw_paper_grid,
    lay_out,
    plan_page,
    scale_for,
    write_head,
)
from mjsim.world import World

MAX_ASPECT = 1.25
"""Sheets whose ratio of width to height exceeds this are stacked, instead of side by side."""


def draw_beside(
    world: World,
    original: Original,
    path: str | Path | None = None,
    *,
    labels: Labels | None = None,
    overwrite: bool = False,
) -> Picture:
    """Draw a map or drawing, and beside it the plan of the world made from it.

    Args:
        world: The world made from it.
        original: The map or drawing, as returned by `mjsim.exchange.read_original`.
        path: PNG or JPEG file to write as well.
        labels: Names to write, as for `draw_world`.
        overwrite: Whether an existing file may be replaced.

    Raises:
        UsageError: The file exists or cannot be written.
    """
    if path is not None:
        require_free(Path(path), overwrite=overwrite)
    both = np.concatenate([world_bounds(world), original.bounds])
    bounds = np.stack([both.min(axis=0), both.max(axis=0)])
    first, second = _original_page(original, bounds), plan_page(world, bounds, labels=labels)
    stacked = first.shape[1] > MAX_ASPECT * first.shape[0]
    page = np.concatenate([first, second], axis=0 if stacked else 1)
    if path is not None:
        write_sheet(path, page, overwrite=overwrite)
    return page


def _original_page(original: Original, bounds: Array) -> Picture:
    """Return the sheet with a map or a drawing."""
    ratio = scale_for(bounds)
    sheet = lay_out(bounds, ratio)
    plan = sheet.inner(LEFT, TOP, RIGHT, BOTTOM)
    draw_paper_grid(plan)
    if original.picture is not None:
        _draw_picture(plan, original.picture, original)
    shapes: dict[tuple[int, float], list[Array]] = {}
    for stroke in original.strokes:
        if stroke.dark is not None:
            shapes.setdefault((stroke.path, stroke.dark), []).append(stroke.points)
    for (_, dark), outlines in shapes.items():
        plan.fill_all(outlines, blend(PAPER, INK, 0.85 * dark))
    for stroke in original.strokes:
        plan.line(stroke.points, INK, 0.12, closed=stroke.closed)
    draw_axes(sheet, plan)
    write_head(sheet, original.name, original.bounds, ratio)
    return sheet.image


def _draw_picture(plan: Paper, picture: Picture, original: Original) -> None:
    """Draw an image at its position on the plan."""
    corners = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]) * picture.shape[1::-1] * original.cell
    source = np.array([[0, 0], [picture.shape[1], 0], [0, picture.shape[0]]], dtype=np.float32) - np.float32(0.5)
    target = plan.view.pixels(original.world_from_picture.transform(corners)).astype(np.float32)
    matrix = cv2.getAffineTransform(source, target)
    size = (plan.image.shape[1], plan.image.shape[0])
    flags = cv2.INTER_AREA if plan.view.scale * original.cell < 1.0 else cv2.INTER_NEAREST
    warped = cv2.warpAffine(picture, matrix, size, flags=flags, borderValue=PAPER)
    np.minimum(plan.image, warped, out=plan.image)  # the grid is visible where the map is light
