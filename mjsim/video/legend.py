"""The legend of a plan: a symbol for each kind of item on it, and its meaning."""

from collections.abc import Callable, Iterator

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.video.ink import BEACON, INK, MUTED, SEEN, TRUTH, WALL, Color
from mjsim.video.paper import Paper, px
from mjsim.video.symbols import draw_lamp
from mjsim.world import Lamp, RampObstacle, StepsObstacle, World

Sign = Callable[[Paper, Pose], None]
"""Draws a symbol of the legend, centred on its position."""


def draw_legend(sheet: Paper, world: World, *, left: float, right: float) -> None:
    """Draw the symbol and the meaning of each kind present, in rows at the bottom, within margins [mm]."""
    x, y = px(left), sheet.view.height - px(8.0)
    size = round(px(2.3))
    for words, draw in _signs(world):
        if x + px(8.0) + sheet.letters.width(words, size) > sheet.view.width - px(right):
            x, y = px(left), y + px(4.2)
        place = sheet.view.world([x + px(3.0), y - px(0.8)])
        draw(sheet, Pose(float(place[0]), float(place[1]), 0.0))
        sheet.letters.write(sheet.image, words, (x + px(7.0), y), size, MUTED)
        x += px(12.0) + sheet.letters.width(words, size)


def _signs(world: World) -> Iterator[tuple[str, Sign]]:
    """Yield the entries of the legend: the text, and a function that draws the symbol."""
    if world.robots:
        yield "robot at its start", _robot_sign
    if any(beacon.image is not None for beacon in world.beacons):
        yield "picture, facing its tick", lambda sheet, place: _stroke_sign(sheet, place, BEACON)
    if any(beacon.marker is not None for beacon in world.beacons):
        yield "marker", lambda sheet, place: _stroke_sign(sheet, place, SEEN)
    if any(beacon.reflects for beacon in world.beacons):
        yield "reflector", lambda sheet, place: _ring_sign(sheet, place, TRUTH)
    if any(beacon.anchor and not beacon.has_face for beacon in world.beacons):
        yield (
            "radio anchor",
            lambda sheet, place: sheet.disc((place.x, place.y), sheet.metres(0.7), SEEN, thickness=0.3),
        )
    if any(opening.sill > 0 for wall in world.walls for opening in wall.openings):
        yield "window", _window_sign
    if world.lamps:
        yield "lamp, hollow when off", lambda sheet, place: draw_lamp(sheet, Lamp(at=(place.x, place.y)))
    if any(item.movable for item in world.obstacles):
        yield "can be pushed", _movable_sign
    if any(item.path is not None for item in world.obstacles):
        yield "goes by itself", _path_sign
    if any(isinstance(item, (RampObstacle, StepsObstacle)) for item in world.obstacles):
        yield "way up", lambda sheet, place: sheet.arrow(_along(sheet, place, 2.5), INK)


def _along(sheet: Paper, place: Pose, half: float) -> Array:
    """Return the ends of a line along x through a point, of half a length [mm]."""
    return place.transform(np.array([[-1.0, 0.0], [1.0, 0.0]]) * sheet.metres(half))


def _robot_sign(sheet: Paper, place: Pose) -> None:
    sheet.disc((place.x, place.y), sheet.metres(1.0), INK, thickness=0.3)
    sheet.arrow(place.transform(np.array([[0.0, 0.0], [3.0, 0.0]]) * sheet.metres(1.0)), INK, 0.4)


def _ring_sign(sheet: Paper, place: Pose, color: Color) -> None:
    sheet.disc((place.x, place.y), sheet.metres(0.7), color, thickness=0.3)


def _stroke_sign(sheet: Paper, place: Pose, color: Color) -> None:
    sheet.line(_along(sheet, place, 2.2), color, 0.7)
    sheet.line(place.transform(np.array([[0.0, 0.0], [0.0, 1.2]]) * sheet.metres(1.0)), color, 0.3)


def _window_sign(sheet: Paper, place: Pose) -> None:
    corners = np.array([[-2.4, -0.5], [2.4, -0.5], [2.4, 0.5], [-2.4, 0.5]]) * sheet.metres(1.0)
    sheet.line(place.transform(corners), WALL, 0.15, closed=True)
    sheet.line(_along(sheet, place, 2.4), TRUTH, 0.2)


def _movable_sign(sheet: Paper, place: Pose) -> None:
    corners = np.array([[-2.2, -1.1], [2.2, -1.1], [2.2, 1.1], [-2.2, 1.1], [-2.2, -1.1]]) * sheet.metres(1.0)
    sheet.dashes(place.transform(corners), INK, 0.3)


def _path_sign(sheet: Paper, place: Pose) -> None:
    ends = _along(sheet, place, 2.5)
    sheet.dashes(ends, SEEN, 0.35, dash=0.7)
    sheet.arrow(np.stack([np.mean(ends, axis=0), ends[1]]), SEEN)
