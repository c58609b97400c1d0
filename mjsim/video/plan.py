"""The plan of a world, to scale, on a screen: the background of films."""

import math

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.posture import from_above
from mjsim.video.ink import (
    BEACON,
    INK,
    MUTED,
    PAPER,
    WALL,
    Color,
    Letters,
    blend,
    draw_polyline,
    fill_polygons,
    parse_color,
)
from mjsim.video.labels import Label, place_labels
from mjsim.video.view import PlanView, format_metres, round_step
from mjsim.world import Beacon, Obstacle, World, extent, footprint, solid_pieces, stays, wall_polygons
from mjsim.world import hung as beacons_of

MAX_NAMES = 1000
"""With more objects than this, the plan is drawn without names, which would be unreadable."""
EYE = 1.5
"""Walls that end below this height are drawn light: below a window, or a low wall [m]."""


def world_bounds(world: World) -> Array:
    """Return minimum and maximum of (x, y) of all that the plan shows, shape (2, 2) [m]; 10 x 10 m if empty."""
    outlines = [*wall_polygons(world), *(extent(obstacle) for obstacle in world.obstacles)]
    marks = [item.at for item in hung(world)] + [item.at for item in world.robots]
    outlines += [mechanism.spanned()[:, :2] for mechanism in world.mechanisms]
    outlines += [outline for person in world.people for outline, _ in from_above(world, person)]
    points = np.concatenate([*outlines, np.reshape(np.array(marks, dtype=float), (-1, 2))])
    if not len(points):
        return np.array([[-5.0, -5.0], [5.0, 5.0]])
    low, high = points.min(axis=0), points.max(axis=0)
    short = np.maximum(1.0 - (high - low), 0.0) / 2
    return np.stack([low - short, high + short])


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


def draw_background(
    image: Picture,
    world: World,
    view: PlanView,
    *,
    removed: frozenset[str] = frozenset(),
    letters: Letters | None = None,
) -> None:
    """Draw everything static: floor, grid, walls with open doorways, obstacles and beacons.

    Args:
        image: Picture of the view's size; overwritten.
        world: The world.
        view: The view.
        removed: Names of removed items, and of people that are drawn elsewhere.
        letters: Font for names beside beacons and obstacles; by default there are no names.
    """
    image[:] = floor_color(world)
    for patch in world.floor.patches:
        fill_polygons(image, [view.pixels(patch.outline())], blend(parse_color(patch.color), PAPER, 0.7))
    _draw_grid(image, world, view)
    for obstacle in _standing(world, removed):
        draw_outline(image, view.pixels(footprint(obstacle)), parse_color(obstacle.color))
    for person in (each for each in world.people if each.name not in removed):
        for outline, color in from_above(world, person):
            draw_outline(image, view.pixels(outline), parse_color(color))
    _draw_walls(image, world, view)
    for beacon in hung(world, removed):
        draw_beacon(image, beacon, view)
    if letters is not None:
        _draw_names(image, world, view, letters, removed)


def draw_outline(image: Picture, outline: Array, color: Color) -> None:
    """Draw an object from above in a muted version of its colour; its outline is in pixels, shape (n, 2)."""
    fill_polygons(image, [outline], blend(color, PAPER, 0.55))
    draw_polyline(image, outline, blend(color, INK, 0.35), closed=True)


def _standing(world: World, removed: frozenset[str]) -> list[Obstacle]:
    return [item for item in world.obstacles if stays(item) and item.name not in removed]


def hung(world: World, removed: frozenset[str] = frozenset()) -> list[Beacon]:
    """Return the static beacons, with those on static obstacles as if fixed in the room."""
    placed = []
    for item in beacons_of(world):
        if item.fixed and item.beacon.name not in removed:
            at, heading = (item.place.x, item.place.y), math.degrees(item.place.heading)
            update = {"at": at, "heading_deg": heading, "on": None}
            placed.append(item.beacon if item.carrier is None else item.beacon.model_copy(update=update))
    return placed


def draw_beacon(image: Picture, beacon: Beacon, view: PlanView) -> None:
    """Draw a beacon as a line of its width, with a tick in the direction that it faces."""
    stroke, tick = beacon_stroke(beacon, view)
    draw_polyline(image, stroke, BEACON, width=_stroke_width(view) + 1)
    draw_polyline(image, tick, BEACON, width=_stroke_width(view) - 1)


def beacon_stroke(beacon: Beacon, view: PlanView) -> tuple[Array, Array]:
    """Return the ends of a beacon and of its tick in the picture, shape (2, 2) each [px]."""
    place = Pose(beacon.at[0], beacon.at[1], math.radians(beacon.heading_deg))
    half, ahead = max(beacon.width / 2, 4 / view.scale), max(0.1, 6 / view.scale)
    stroke, tick = place.transform([[[0.0, -half], [0.0, half]], [[0.0, 0.0], [ahead, 0.0]]])
    return view.pixels(stroke), view.pixels(tick)


def _draw_names(image: Picture, world: World, view: PlanView, letters: Letters, removed: frozenset[str]) -> None:
    """Write the names of beacons and obstacles beside them."""
    if len(world.beacons) + len(world.obstacles) > MAX_NAMES:
        return
    place_labels(image, _labels(world, view, letters, removed), letters, _obstructions(world, view))


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


def _draw_grid(image: Picture, world: World, view: PlanView) -> None:
    step = round_step(28 / view.scale)
    color = blend(floor_color(world), INK, 0.06)
    for value in np.arange(math.ceil(view.left / step), view.right / step):
        column = round(float(view.pixels((value * step, 0.0))[0]))
        cv2.line(image, (column, 0), (column, view.height), color, 1)
    for value in np.arange(math.ceil(view.bottom / step), view.top / step):
        row = round(float(view.pixels((0.0, value * step))[1]))
        cv2.line(image, (0, row), (view.width, row), color, 1)


def _draw_walls(image: Picture, world: World, view: PlanView) -> None:
    low: list[Array] = []
    full: list[Array] = []
    for pieces in solid_pieces(world.walls):
        for piece in pieces:
            if piece.low < EYE:
                (full if piece.high > EYE else low).append(view.pixels(piece.outline))
    for outlines, color in ((low, blend(WALL, PAPER, 0.55)), (full, WALL)):
        for outline in outlines:
            fill_polygons(image, [outline], color)
            if view.scale < 60:  # a thin wall must not fade when it is narrower than two pixels
                draw_polyline(image, outline, color, closed=True)


def _labels(world: World, view: PlanView, letters: Letters, removed: frozenset[str]) -> list[Label]:
    labels = []
    for beacon in hung(world, removed):
        facing = Pose(0.0, 0.0, math.radians(beacon.heading_deg)).transform((1.0, 0.0)) * (1, -1)
        labels.append(Label(beacon.name, view.pixels(beacon.at), facing, 12, blend(BEACON, INK, 0.5)))
    for obstacle in _standing(world, removed):
        if obstacle.name is not None:
            outline = view.pixels(footprint(obstacle))
            fits = letters.width(obstacle.name, 12) + 8 < np.ptp(outline[:, 0])
            below = np.array([np.mean(outline[:, 0]), np.max(outline[:, 1])])
            at = view.pixels(obstacle.at) if fits else below
            labels.append(Label(obstacle.name, at, np.array([0.0, 0.0 if fits else 1.0]), 12, MUTED))
    return labels


def _obstructions(world: World, view: PlanView) -> list[Array]:
    outlines = [view.pixels(outline) for outline in wall_polygons(world)]
    outlines += [view.pixels(footprint(obstacle)) for obstacle in world.obstacles if obstacle.name is None]
    outlines += [np.concatenate(beacon_stroke(beacon, view)) for beacon in hung(world)]
    return [np.stack([outline.min(axis=0), outline.max(axis=0)]) for outline in outlines]


def _stroke_width(view: PlanView) -> int:
    return 3 if view.scale < 80 else 4
