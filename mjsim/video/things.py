"""Moving parts of a plan besides robots, and what events change: objects, doors, lamps."""

import math
from itertools import chain

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.sim import LedPeople
from mjsim.video.ink import INK, PAPER, Color, blend, draw_disc, draw_polyline, parse_color
from mjsim.video.moment import Moment
from mjsim.video.plan import draw_beacon, draw_outline
from mjsim.video.symbols import LAMP
from mjsim.video.view import PlanView
from mjsim.world import Beacon, World, first_looks, footprint, item_names, leaves, stays, world_from_obstacle

LAMP_RADIUS = 5.0
"""[px]"""


class Things:
    """Draws the changeable parts of a plan at an instant on top of the static ones."""

    def __init__(self, world: World) -> None:
        """Prepare the parts of the world that may change during a run."""
        self._looks = first_looks(world)
        self._lamps = list(zip(item_names(world.lamps), world.lamps, strict=True))
        self._obstacles: list[tuple[str, Pose, Array, Color]] = []
        for obstacle, name in zip(world.obstacles, item_names(world.obstacles), strict=True):
            if not stays(obstacle):
                start = world_from_obstacle(obstacle)
                outline = start.inverse().transform(footprint(obstacle))
                self._obstacles.append((name, start, outline, parse_color(obstacle.color)))
        self._leaves = leaves(world)
        self._people = LedPeople(world)
        carriers = {item.name for item in world.robots} | {name for name, *_ in self._obstacles}
        self._carried = [beacon for beacon in world.beacons if beacon.on in carriers]
        self._starts = {
            item.name: Pose(item.at[0], item.at[1], math.radians(item.heading_deg)) for item in world.robots
        }

    def draw(self, image: Picture, view: PlanView, moment: Moment, *, robot: str) -> None:
        """Draw everything at its position at a moment of a robot's run."""
        looks = moment.looks or self._looks
        places = self._places(moment, robot)
        for name, _, outline, color in self._obstacles:
            if name not in looks.removed:
                draw_outline(image, view.pixels(places[name].transform(outline)), color)
        for part, clothing in chain.from_iterable(self._people.outlines(looks).values()):
            draw_outline(image, view.pixels(part), parse_color(clothing))
        for leaf in self._leaves:
            place = _pose(moment, f"door/{leaf.name}", leaf.pose(math.radians(leaf.door.angle_deg)))
            ends = view.pixels(place.transform([[0.0, 0.0], [leaf.width, 0.0]]))
            draw_polyline(image, ends, blend(parse_color(leaf.door.color), INK, 0.25), width=3)
            draw_disc(image, ends[0], 3.0, INK)
        for beacon in self._carried:
            if beacon.name not in looks.removed and beacon.on is not None:
                draw_beacon(image, _at(beacon, places[beacon.on]), view)
        for name, lamp in self._lamps:
            middle = view.pixels(np.array(lamp.at))
            draw_disc(image, middle, LAMP_RADIUS, blend(PAPER, LAMP, min(looks.lamps[name], 1.0)))
            draw_disc(image, middle, LAMP_RADIUS, LAMP, width=1)

    def _places(self, moment: Moment, robot: str) -> dict[str, Pose]:
        """Return the pose of each object except doors, by name, and the true poses of robots."""
        things = {name: _pose(moment, f"obstacle/{name}", start) for name, start, *_ in self._obstacles}
        poses = {**moment.others, robot: moment.truth}
        robots = {name: Pose.from_array(pose) for name, pose in poses.items() if np.isfinite(pose).all()}
        return self._starts | things | robots


def _pose(moment: Moment, name: str, start: Pose) -> Pose:
    place = moment.things.get(name)
    return start if place is None else Pose.from_array(place)


def _at(beacon: Beacon, world_from_carrier: Pose) -> Beacon:
    """Return a beacon on a moving carrier as if it were fixed in the room."""
    place = world_from_carrier @ Pose(beacon.at[0], beacon.at[1], math.radians(beacon.heading_deg))
    update = {"at": (place.x, place.y), "heading_deg": math.degrees(place.heading), "on": None}
    return beacon.model_copy(update=update)
