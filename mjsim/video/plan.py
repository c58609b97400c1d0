"""The plan of a world, to scale: what `mjsim show` prints, and the background of the film."""

import math
from pathlib import Path

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.video.ink import (
    BEACON,
    INK,
    MUTED,
    PAPER,
    SEMIBOLD,
    WALL,
    Letters,
    blend,
    draw_polyline,
    fill_polygons,
    fixed,
    parse_color,
    write_picture,
)
from mjsim.video.labels import Label, place_labels
from mjsim.video.view import View, format_metres, round_step
from mjsim.world import World
from mjsim.world.plan import footprint, wall_pieces, wall_polygons
from mjsim.world.things import Beacon

MOST_NAMES = 1000
"""With more things than this the plan is drawn without names: nobody could read them."""
EYE = 1.5
"""Walls that end below this height [m] are drawn light: under a window, or a low wall."""


def world_bounds(world: World) -> Array:
    """Return (x, y) min and (x, y) max of all that the plan shows, shape (2, 2) [m]; 10 x 10 m for an empty world."""
    outlines = [*wall_polygons(world), *(footprint(obstacle) for obstacle in world.obstacles)]
    marks = [item.at for item in world.beacons] + [item.at for item in world.robots]
    points = np.concatenate([*outlines, np.reshape(np.array(marks, dtype=float), (-1, 2))])
    if not len(points):
        return np.array([[-5.0, -5.0], [5.0, 5.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    short = np.maximum(1.0 - (high - low), 0.0) / 2
    return np.stack([low - short, high + short])


def draw_background(image: Picture, world: World, view: View) -> None:
    """Draw floor, grid, walls with open doorways, obstacles and beacons over a picture of the view's size."""
    image[:] = floor_color(world)
    _draw_grid(image, world, view)
    _draw_obstacles(image, world, view)
    _draw_walls(image, world, view)
    for beacon in world.beacons:
        draw_beacon(image, beacon, view)


def draw_beacon(image: Picture, beacon: Beacon, view: View) -> None:
    """Draw a beacon as a stroke as wide as it is, with a tick to where its picture faces."""
    stroke, tick = beacon_stroke(beacon, view)
    draw_polyline(image, stroke, BEACON, width=_stroke_width(view) + 1)
    draw_polyline(image, tick, BEACON, width=_stroke_width(view) - 1)


def beacon_stroke(beacon: Beacon, view: View) -> tuple[Array, Array]:
    """Return the ends of a beacon and of its facing tick in the picture, shape (2, 2) each [px]."""
    place = Pose(beacon.at[0], beacon.at[1], math.radians(beacon.heading_deg))
    half, ahead = max(beacon.width / 2, 4 / view.scale), max(0.1, 6 / view.scale)
    stroke, tick = place.transform([[[0.0, -half], [0.0, half]], [[0.0, 0.0], [ahead, 0.0]]])
    return view.pixels(stroke), view.pixels(tick)


def draw_world(
    world: World, path: str | Path | None = None, *, width: int = 1600, height: int = 1200, names: bool = True
) -> Picture:
    """Draw the plan of a world as one would print it: coordinates, grid, scale bar and names.

    Args:
        world: What to draw.
        path: PNG or JPEG file to write as well.
        width: Most pixels across; the plan keeps its own shape inside.
        height: Most pixels down.
        names: Whether beacons, obstacles and robots are named.

    Returns:
        RGB picture.

    Raises:
        UsageError: The file cannot be written.
    """
    letters, left, top, bottom, right = Letters(), 64, 76, 56, 28
    bounds = world_bounds(world)
    room = bounds + np.array([[-1.0], [1.0]]) * 0.02 * float(np.max(bounds[1] - bounds[0]))
    fit = View.fit(room, width - left - right, height - top - bottom)
    size = np.ceil((room[1] - room[0]) * fit.scale).astype(int)
    view = View(room[0, 0], room[1, 1], fit.scale, max(int(size[0]), 240), max(int(size[1]), 120))
    page = np.full((top + view.height + bottom, left + view.width + right, 3), PAPER, np.uint8)
    inside = page[top : top + view.height, left : left + view.width]
    draw_background(inside, world, view)
    for robot in world.robots:
        _draw_start(inside, Pose(robot.at[0], robot.at[1], math.radians(robot.heading_deg)), robot.body.radius, view)
    if names:
        draw_names(inside, world, view, letters, starts=True)
    cv2.rectangle(page, (left - 1, top - 1), (left + view.width, top + view.height), MUTED, 1)
    _write_axes(page, view, letters, left, top)
    letters.write(page, world.name, (left, 34), 24, weight=SEMIBOLD)
    draw_scale_bar(page, view.scale, letters, (left + view.width, 34))
    if path is not None:
        write_picture(path, page)
    return page


def draw_names(image: Picture, world: World, view: View, letters: Letters, *, starts: bool = False) -> None:
    """Write the names of beacons and obstacles beside them, and of the robots at their starts if asked."""
    if len(world.beacons) + len(world.obstacles) > MOST_NAMES:
        return
    labels = _labels(world, view, letters) + (_start_labels(world, view) if starts else [])
    place_labels(image, labels, letters, _obstructions(world, view))


def draw_scale_bar(image: Picture, scale: float, letters: Letters, at: tuple[int, int]) -> None:
    """Draw a bar of a round length and its name on a white plate, its right end at a pixel."""
    length = round_step(60 / scale)
    name = f"{format_metres(length, length)} m"
    bar = round(length * scale)
    x, y = at
    image[y - 16 : y + 7, max(x - bar - 16 - letters.width(name, 13), 0) : x + 8] = PAPER
    letters.write(image, name, (x - bar - 8, y), 13, MUTED, align=1.0)
    cv2.rectangle(image, (x - bar, y - 7), (x, y - 2), INK, 1)
    cv2.rectangle(image, (x - bar, y - 7), (x - bar // 2, y - 2), INK, -1)


def floor_color(world: World) -> tuple[int, int, int]:
    """Return the floor's colour, calmed."""
    return blend(parse_color(world.floor.color), PAPER, 0.86)


def _draw_grid(image: Picture, world: World, view: View) -> None:
    step = round_step(28 / view.scale)
    color = blend(floor_color(world), INK, 0.06)
    for value in np.arange(math.ceil(view.left / step), view.right / step):
        column = round(float(view.pixels((value * step, 0.0))[0]))
        cv2.line(image, (column, 0), (column, view.height), color, 1)
    for value in np.arange(math.ceil(view.bottom / step), view.top / step):
        row = round(float(view.pixels((0.0, value * step))[1]))
        cv2.line(image, (0, row), (view.width, row), color, 1)


def _draw_walls(image: Picture, world: World, view: View) -> None:
    low: list[Array] = []
    full: list[Array] = []
    for wall in world.walls:
        for piece in wall_pieces(wall):
            if piece.low < EYE:
                (full if piece.high > EYE else low).append(view.pixels(piece.outline))
    for outlines, color in ((low, blend(WALL, PAPER, 0.55)), (full, WALL)):
        for outline in outlines:
            fill_polygons(image, [outline], color)
            if view.scale < 60:  # a thin wall must not fade when it is narrower than two pixels
                draw_polyline(image, outline, color, closed=True)


def _draw_obstacles(image: Picture, world: World, view: View) -> None:
    for obstacle in world.obstacles:
        outline, color = view.pixels(footprint(obstacle)), parse_color(obstacle.color)
        fill_polygons(image, [outline], blend(color, PAPER, 0.55))
        draw_polyline(image, outline, blend(color, INK, 0.35), closed=True)


def _draw_start(image: Picture, start: Pose, radius: float, view: View) -> None:
    middle = view.pixels((start.x, start.y))
    x, y = fixed(middle).tolist()
    cv2.circle(image, (x, y), round(max(radius * view.scale, 5) * 16), INK, 2, cv2.LINE_AA, 4)
    draw_polyline(image, view.pixels(start.transform([[0.0, 0.0], [max(radius, 5 / view.scale), 0.0]])), INK, width=2)


def _labels(world: World, view: View, letters: Letters) -> list[Label]:
    labels = []
    for beacon in world.beacons:
        facing = Pose(0.0, 0.0, math.radians(beacon.heading_deg)).transform((1.0, 0.0)) * (1, -1)
        labels.append(Label(beacon.name, view.pixels(beacon.at), facing, 12, blend(BEACON, INK, 0.5)))
    for obstacle in world.obstacles:
        if obstacle.name is not None:
            outline = view.pixels(footprint(obstacle))
            fits = letters.width(obstacle.name, 12) + 8 < np.ptp(outline[:, 0])
            below = np.array([np.mean(outline[:, 0]), np.max(outline[:, 1])])
            at = view.pixels(obstacle.at) if fits else below
            labels.append(Label(obstacle.name, at, np.array([0.0, 0.0 if fits else 1.0]), 12, MUTED))
    return labels


def _start_labels(world: World, view: View) -> list[Label]:
    labels = []
    for robot in world.robots:
        below = np.array([0.0, max(robot.body.radius * view.scale, 5)])
        labels.append(Label(robot.name, view.pixels(robot.at) + below, np.array([0.0, 1.0]), 14, INK))
    return labels


def _obstructions(world: World, view: View) -> list[Array]:
    outlines = [view.pixels(outline) for outline in wall_polygons(world)]
    outlines += [view.pixels(footprint(obstacle)) for obstacle in world.obstacles if obstacle.name is None]
    outlines += [np.concatenate(beacon_stroke(beacon, view)) for beacon in world.beacons]
    return [np.stack([outline.min(axis=0), outline.max(axis=0)]) for outline in outlines]


def _write_axes(page: Picture, view: View, letters: Letters, left: int, top: int) -> None:
    step, bottom = round_step(70 / view.scale), top + view.height
    for value in np.arange(math.ceil(view.left / step), view.right / step):
        column = left + round(float(view.pixels((value * step, 0.0))[0]))
        cv2.line(page, (column, bottom + 1), (column, bottom + 6), MUTED, 1)
        letters.write(page, format_metres(value * step, step), (column, bottom + 22), 13, MUTED, align=0.5)
    for value in np.arange(math.ceil(view.bottom / step), view.top / step):
        row = top + round(float(view.pixels((0.0, value * step))[1]))
        cv2.line(page, (left - 7, row), (left - 2, row), MUTED, 1)
        letters.write(page, format_metres(value * step, step), (left - 12, row + 5), 13, MUTED, align=1.0)
    letters.write(page, "x east [m]", (left + view.width, bottom + 44), 13, MUTED, align=1.0)
    letters.write(page, "y north [m]", (8, top - 16), 13, MUTED)


def _stroke_width(view: View) -> int:
    return 3 if view.scale < 80 else 4
