"""The plan of a world with its legend as a sheet of paper, as drawn by `mjsim show`, for printing at a round scale."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.output import require_free
from mjsim.plan import HEAD, PlanItem, Words, circle, world_shapes, world_words
from mjsim.video.diagram_drawing import draw_mechanism, posed
from mjsim.video.diagrams import diagrams_page
from mjsim.video.ink import INK, MUTED, PAPER, SEMIBOLD
from mjsim.video.paper import Paper, blank, px, write_sheet
from mjsim.video.people_figures import people_page
from mjsim.video.placed_names import MAX_NAMES, size_of, write_words
from mjsim.video.plan_parts import draw_grid, world_bounds
from mjsim.video.plan_view import PlanView, format_metres, round_step
from mjsim.world import Lamp, RampObstacle, StepsObstacle, World

A4 = (297.0, 210.0)
"""Length and width of the paper [mm]."""
LEFT, TOP, RIGHT, BOTTOM = 17.0, 21.0, 9.0, 21.0
"""Margins around the plan, for axis, title, edge, axis and legend [mm]."""
FREE_MARGIN = 5.0
"""Free space around the outermost walls [mm]."""
MIN_SHEET_WIDTH = 120.0
"""Minimum width of a sheet, for title and legend [mm]."""
MAX_COVERED_SHARE = 0.025
"""Obstacle names are omitted, unless requested, if they would cover a larger fraction of the plan."""
SCALE_STEPS = (1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.5)
"""Scale denominators are these times a power of ten."""


Labels = Literal["none", "walls", "all"]


def draw_world(
    world: World,
    path: str | Path | None = None,
    *,
    names: bool = True,
    labels: Labels | None = None,
    overwrite: bool = False,
) -> Picture:
    """Draw the plan of a world for print: at most A4, at a round scale, with coordinates and names.

    Below it are kinematic diagrams of mechanisms, each to its own scale, and people from the right and from above.

    Args:
        world: The world.
        path: PNG or JPEG file to write as well.
        names: Whether to write names.
        labels: Names to write: none, those of walls, or all; by default those of robots, beacons, doors and lamps, and
            those of obstacles if there is space.
        overwrite: Whether an existing file may be replaced.

    Returns:
        RGB picture with `DPI` pixels per inch.

    Raises:
        UsageError: The file exists or cannot be written.
    """
    if path is not None:
        require_free(Path(path), overwrite=overwrite)
    page = plan_page(world, world_bounds(world), labels=labels if names else "none")
    if world.mechanisms:
        page = np.concatenate([page, diagrams_page(world, page.shape[1], names=names and labels != "none")])
    if world.people:
        page = np.concatenate([page, people_page(world, page.shape[1], names=names and labels != "none")])
    if path is not None:
        write_sheet(path, page, overwrite=overwrite)
    return page


def plan_page(world: World, bounds: Array, *, labels: Labels | None = None) -> Picture:
    """Return the sheet with the plan of a world within bounds, shape (2, 2) [m]."""
    ratio = scale_for(bounds)
    sheet = lay_out(bounds, ratio)
    plan = sheet.inner(LEFT, TOP, RIGHT, BOTTOM)
    draw_paper_grid(plan)
    _draw_things(plan, world)
    write_words(plan, _chosen_words(plan, world, labels))
    draw_axes(sheet, plan)
    write_head(sheet, world.name, world_bounds(world), ratio)
    draw_legend(sheet, world, left=LEFT, right=RIGHT)
    return sheet.image


def _chosen_words(plan: Paper, world: World, labels: Labels | None) -> list[Words]:
    """Return the names to write."""
    if labels == "none" or len(world.beacons) + len(world.obstacles) > MAX_NAMES:
        return []
    words = world_words(world)
    if labels is not None:
        return [each for each in words if labels == "all" or each.of == "wall"]
    room = plan.image.shape[0] * plan.image.shape[1]
    ink = sum(float(np.prod(size_of(plan, each))) for each in words if each.of == "thing")
    return [each for each in words if each.of == "other" or (each.of == "thing" and ink <= MAX_COVERED_SHARE * room)]


def scale_for(bounds: Array) -> float:
    """Return the smallest round N for which a world within bounds [m] fits on A4 at a scale of 1 : N."""
    size = (bounds[1] - bounds[0]) * 1000.0
    fits = []
    for length, width in (A4, A4[::-1]):
        room = np.array([length - LEFT - RIGHT, width - TOP - BOTTOM]) - 2 * FREE_MARGIN
        fits.append(float(np.max(size / room)))
    power = 10.0 ** math.floor(math.log10(min(fits)) + 1e-9)
    return next(step * power for step in (*SCALE_STEPS, 10.0) if step * power >= min(fits) * (1 - 1e-9))


def lay_out(bounds: Array, ratio: float) -> Paper:
    """Return an empty sheet for a plan with given bounds and scale."""
    scale = px(1000.0) / ratio
    size = (bounds[1] - bounds[0]) * scale + 2 * px(FREE_MARGIN)
    width = max(float(size[0]) + px(LEFT + RIGHT), px(MIN_SHEET_WIDTH))
    left = bounds[0, 0] - (px(LEFT) + (width - px(LEFT + RIGHT) - (size[0] - 2 * px(FREE_MARGIN))) / 2) / scale
    above = bounds[1, 1] + px(TOP + FREE_MARGIN) / scale
    return blank(PlanView(float(left), float(above), scale, math.ceil(width), math.ceil(size[1] + px(TOP + BOTTOM))))


def draw_paper_grid(plan: Paper) -> None:
    """Draw the grid: a line at each number on the axes, fainter lines between."""
    coarse = _axis_step(plan.view)
    for step, share in ((coarse / 2 if coarse > 0.5 else coarse / 5, 0.07), (coarse, 0.14)):
        draw_grid(plan, PAPER, step=step, share=share)


def _draw_things(plan: Paper, world: World) -> None:
    """Draw everything in the world, from the floor up; mechanisms stand below robots and people."""
    shapes = world_shapes(world)
    on_top = [shape.group in ("people", "robots", "beacons") for shape in shapes]
    plan.draw(shape for shape, above in zip(shapes, on_top, strict=True) if not above)
    for mechanism in world.mechanisms:
        draw_mechanism(plan, posed(mechanism, mechanism.assembly.start))
    plan.draw(shape for shape, above in zip(shapes, on_top, strict=True) if above)


def _axis_step(view: PlanView) -> float:
    return round_step(px(9.0) / view.scale)


def draw_axes(sheet: Paper, plan: Paper) -> None:
    """Draw the frame, and coordinates along its left and lower edge."""
    view, step, page, letters = plan.view, _axis_step(plan.view), sheet.image, sheet.letters
    left, right, bottom, high = px(LEFT), px(LEFT) + view.width, px(TOP) + view.height, px(TOP)
    size = round(px(2.3))
    frame = sheet.view.world([[left, high], [right, high], [right, bottom], [left, bottom]])
    sheet.line(frame, MUTED, 0.15, closed=True)
    for x in np.arange(math.ceil(view.left / step), view.right / step) * step:
        column = float(sheet.view.pixels((x, 0.0))[0])
        sheet.line(sheet.view.world([[column, bottom], [column, bottom + px(1.0)]]), MUTED, 0.15)
        letters.write(page, format_metres(x, step), (column, bottom + px(3.6)), size, MUTED, align=0.5)
    for y in np.arange(math.ceil(view.bottom / step), view.top / step) * step:
        row = float(sheet.view.pixels((0.0, y))[1])
        sheet.line(sheet.view.world([[left - px(1.0), row], [left, row]]), MUTED, 0.15)
        letters.write(page, format_metres(y, step), (left - px(1.8), row + px(0.8)), size, MUTED, align=1.0)
    letters.write(page, "x east [m]", (right, bottom + px(7.2)), size, MUTED, align=1.0)
    letters.write(page, "y north [m]", (px(4.0), high - px(2.4)), size, MUTED)


def write_head(sheet: Paper, title: str, bounds: Array, ratio: float) -> None:
    """Write title and size at the left, scale bar and north arrow at the right."""
    letters, page, right = sheet.letters, sheet.image, sheet.view.width - px(RIGHT)
    letters.write(page, title, (px(LEFT), px(10.5)), round(px(5.2)), INK, weight=SEMIBOLD)
    metres = " \N{MULTIPLICATION SIGN} ".join(
        format_metres(round(value, 1), 0.1) for value in np.ptp(bounds, axis=0).tolist()
    )
    letters.write(page, f"{metres} m, 1 : {ratio:g}", (px(LEFT), px(15.2)), round(px(2.6)), MUTED)
    _draw_north(sheet, right - px(3.0), px(5.5))
    _draw_scale(sheet, right - px(11.0), px(11.5))


def _draw_north(sheet: Paper, x: float, y: float) -> None:
    sheet.arrow(sheet.view.world([[x, y + px(7.5)], [x, y]]), INK, 0.3)
    sheet.letters.write(sheet.image, "N", (x, y - px(0.6)), round(px(2.6)), INK, weight=SEMIBOLD, align=0.5)


def _draw_scale(sheet: Paper, right: float, y: float) -> None:
    """Draw a scale bar of four parts, black and white, labelled at its ends and centre."""
    part = round_step(px(7.0) / sheet.view.scale)
    width = part * sheet.view.scale
    left = right - 4 * width
    for number in range(4):
        x = left + number * width
        box = sheet.view.world([[x, y], [x + width, y], [x + width, y + px(1.2)], [x, y + px(1.2)]])
        sheet.fill(box, PAPER if number % 2 else INK)
        sheet.line(box, INK, 0.15, closed=True)
    for number in (0, 2, 4):
        text = f"{number * part:g}" + (" m" if number == 4 else "")
        sheet.letters.write(sheet.image, text, (left + number * width, y - px(1.0)), round(px(2.3)), MUTED, align=0.5)


TINT = "#8a6f4d"
"""Colour of the things that symbols show."""
BOX = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def draw_legend(sheet: Paper, world: World, *, left: float, right: float) -> None:
    """Draw the symbol and the meaning of each kind present, in rows at the bottom, within margins [mm]."""
    x, y = px(left), sheet.view.height - px(8.0)
    size = round(px(2.3))
    for words, symbol in _signs(world):
        if x + px(8.0) + sheet.letters.width(words, size) > sheet.view.width - px(right):
            x, y = px(left), y + px(4.2)
        place = sheet.view.world([x + px(3.0), y - px(0.8)])
        at = Pose(float(place[0]), float(place[1]), 0.0)
        sheet.draw(replace(shape, place=at) for shape in symbol)
        sheet.letters.write(sheet.image, words, (x + px(7.0), y), size, MUTED)
        x += px(12.0) + sheet.letters.width(words, size)


def _signs(world: World) -> Iterator[tuple[str, list[PlanItem]]]:
    """Yield the entries of the legend: the text, and the symbol."""
    if world.robots:
        head = np.array([[3.0, 0.0], [1.4, 0.6], [1.4, -0.6]])
        yield (
            "robot at its start",
            [_area("heading", head), _area("robot", circle(1.0)), _line("heading", [[0.0, 0.0], [1.4, 0.0]])],
        )
    if any(beacon.image is not None for beacon in world.beacons):
        yield "picture, facing its tick", _plate("beacon")
    if any(beacon.marker is not None for beacon in world.beacons):
        yield "marker", [*_plate("beacon"), *_plate("marker")[:1]]
    if any(beacon.reflects for beacon in world.beacons):
        yield "reflector", [_area("reflector", circle(0.7))]
    if any(beacon.anchor and not beacon.has_face for beacon in world.beacons):
        yield "radio anchor", [_area("reflector", circle(0.8, 4))]
    if any(opening.sill > 0 for wall in world.walls for opening in wall.openings):
        yield "window", [_area("low wall", BOX * (2.4, 0.5)), _line("window", [[-2.4, 0.0], [2.4, 0.0]])]
    if world.lamps:
        lamp = World(lamps=(Lamp(at=(0.0, 0.0)),))
        yield "lamp, hollow when off", world_shapes(lamp)
    if any(item.movable for item in world.obstacles):
        yield "can be pushed", [_area("movable", BOX * (2.2, 1.1))]
    if any(item.path is not None for item in world.obstacles):
        yield "goes by itself", [_line("route", [[-2.5, 0.0], [2.5, 0.0]]), _area("route", HEAD + np.array([2.5, 0.0]))]
    if any(isinstance(item, (RampObstacle, StepsObstacle)) for item in world.obstacles):
        yield "way up", [_line("way up", [[-2.5, 0.0], [1.0, 0.0]]), _area("way up", HEAD + np.array([2.5, 0.0]))]


def _area(role: str, outline: ArrayLike) -> PlanItem:
    return PlanItem(role=role, parts=(np.asarray(outline),), symbol=True, tint=TINT)


def _line(role: str, points: ArrayLike) -> PlanItem:
    return PlanItem(role=role, kind="line", parts=(np.asarray(points),), symbol=True, tint=TINT)


def _plate(role: str) -> list[PlanItem]:
    return [_line(role, [[-2.2, 0.0], [2.2, 0.0]]), _line("tick", [[0.0, 0.0], [0.0, 1.2]])]
