"""The legend of a plan: a symbol for each kind of item on it, and its meaning."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from mjsim.geometry import Pose
from mjsim.plan import HEAD, PlanItem, circle, world_shapes
from mjsim.video.ink import MUTED
from mjsim.video.paper import Paper, px
from mjsim.world import Lamp, RampObstacle, StepsObstacle, World

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
