"""The names on a plan: of everything in a world, in order of priority."""

import math
from collections.abc import Iterator

import numpy as np

from mjsim.plan.plan_items import MIN_ROBOT, leaf_path
from mjsim.plan.shapes import Words
from mjsim.world import Obstacle, RampObstacle, StepsObstacle, Wall, World, footprint, hung, leaves, stays

BELOW = np.array([0.0, -1.0])


def world_words(world: World) -> list[Words]:
    """Return the names of everything, the most important first, obstacles and walls last."""
    return [
        *_robots(world),
        *_beacons(world),
        *_doors(world),
        *_others(world),
        *(_obstacle(item, item.name) for item in world.obstacles if item.name is not None),
        *(_wall(wall, wall.name) for wall in world.walls if wall.name is not None),
    ]


def _robots(world: World) -> Iterator[Words]:
    for robot in world.robots:
        reach = (robot.body.radius,) * 2
        yield Words(
            text=robot.name, at=np.array(robot.at), side=BELOW, reach=reach, gap=MIN_ROBOT, ink="ink", size=2.8,
            moves=True,
        )  # fmt: skip


def _beacons(world: World) -> Iterator[Words]:
    for item in hung(world):
        ahead = np.array([math.cos(item.place.heading), math.sin(item.place.heading)])
        at = np.array([item.place.x, item.place.y])
        yield Words(text=item.beacon.name, at=at, side=ahead, gap=1.2, ink="beacon", moves=not item.fixed)


def _doors(world: World) -> Iterator[Words]:
    named = {opening.name for wall in world.walls for opening in wall.openings}
    for leaf in (leaf for leaf in leaves(world) if leaf.name in named):
        middle = leaf_path(leaf, 0.0)[0] / 2 + np.array(leaf.hinge) / 2
        left = leaf.turn * np.array([-math.sin(leaf.closed), math.cos(leaf.closed)])
        yield Words(text=leaf.name, at=middle, side=left, reach=(0.06, 0.06))


def _others(world: World) -> Iterator[Words]:
    """Yield the names of mechanisms, people and lamps."""
    for mechanism in world.mechanisms:
        low, high = mechanism.spanned()[:, :2]
        x, y = ((high - low) / 2).tolist()
        yield Words(text=mechanism.name, at=(low + high) / 2, side=BELOW, reach=(x, y), gap=3.0, ink="ink", moves=True)
    for person in world.people:
        place = person.place()
        yield Words(text=person.name, at=np.array([place.x, place.y]), side=BELOW, reach=(0.3, 0.3), ink="ink")
    for lamp in world.lamps:
        if lamp.name is not None:
            yield Words(text=lamp.name, at=np.array(lamp.at), side=BELOW, gap=1.8)


def _obstacle(item: Obstacle, name: str) -> Words:
    corners = footprint(item)
    low, high = np.min(corners, axis=0), np.max(corners, axis=0)
    (x, y), slope = ((high - low) / 2).tolist(), _slope(item)
    return Words(
        text=name + slope, at=(low + high) / 2, side=BELOW, reach=(x, y), inside=not slope, of="thing",
        moves=not stays(item),
    )  # fmt: skip


def _wall(wall: Wall, name: str) -> Words:
    """Return the name of a wall, beside the centre of its longest segment."""
    start, end = max(wall.segments(), key=lambda ends: math.dist(*ends))
    along = np.subtract(end, start) / math.dist(start, end)
    side, reach = np.array([-along[1], along[0]]), (wall.thickness / 2,) * 2
    return Words(text=name, at=np.add(start, end) / 2, side=side, reach=reach, gap=0.5, of="wall")


def _slope(obstacle: Obstacle) -> str:
    """Return a text on the slope of a ramp or steps, added to the name."""
    match obstacle:
        case RampObstacle(ramp=(length, _, rise)):
            return f" {math.degrees(math.atan2(rise, length)):.1f}\N{DEGREE SIGN}"
        case StepsObstacle(steps=(_, _, rise), count=count):
            return f" {count} \N{MULTIPLICATION SIGN} {rise / count * 100:.0f} cm"
    return ""
