"""Rooms of landmarks in which things hide them, and sensors that are not as their data sheets say."""

import dataclasses
import math
from collections.abc import Callable, Mapping

import numpy as np

from mjsim.geometry import Array, wrap_angle
from mjsim.interface import Odometry, Sighting

SIZE, CORNERS = (12.0, 8.0), ((10.0, 2.0), (10.0, 6.0), (2.0, 6.0), (2.0, 2.0))
"""Of a room [m], and where the robot drives round and round, the last corner first the start [m]."""
DT = 0.04
"""Tick [s]."""
Walls = Callable[[float, Array], Array]
"""Both ends of what hides landmarks, shape (n, 2, 2) [m], by time [s] and position of the robot (2,)."""


def _no_walls(time: float, position: Array) -> Array:
    return np.zeros((0, 2, 2))


@dataclasses.dataclass(frozen=True)
class Faults:
    """Errors of sensors that no data sheet states."""

    distance: float = 1.0
    turn: float = 1.0
    drift: float = 0.0
    """What odometry tells: factors on distance and turn, and added to the turn [rad/s]."""
    slip: float = 0.0
    """Speed that wheels which spin add for the last 0.4 of every 15 s [m/s]."""
    bearing: float = 0.0
    range: float = 1.0
    """Of sightings: added to bearings [rad], and factor on ranges."""

    def of_odometry(self, told: Odometry, time: float) -> Odometry:
        """Return what wheels with these errors tell."""
        slip = self.slip * DT if time % 15.0 > 14.6 else 0.0
        forward, turn = told.forward * self.distance + slip, told.turn * self.turn + self.drift * DT
        return Odometry(forward, told.left, turn, told.covariance)

    def of_sighting(self, seen: Sighting) -> Sighting:
        """Return a sighting with these errors."""
        bearing = float(wrap_angle(seen.bearing + self.bearing))
        return dataclasses.replace(seen, range=seen.range * self.range, bearing=bearing)


@dataclasses.dataclass(frozen=True, eq=False)
class LandmarkRoom:
    """What a robot drives in."""

    size: tuple[float, float] = SIZE
    """[m]"""
    corners: tuple[tuple[float, float], ...] = CORNERS
    """Where the robot drives round and round, the last one first the start [m]."""
    places: Mapping[str, Array] | None = None
    """Landmarks, shape (2,) each [m]; None for some drawn near the walls."""
    walls: Walls = _no_walls
    """What hides them."""
    faults: Faults = Faults()
    """Of its sensors."""

    def shows(self, place: Array, time: float, position: Array) -> bool:
        """Return whether nothing hides a place (2,) from a robot."""
        return not _crosses(position, place, self.walls(time, position))


def _crosses(one: Array, other: Array, walls: Array) -> bool:
    """Return whether the line between two points (2,) crosses one of the walls (n, 2, 2)."""
    along, wall, apart = other - one, walls[:, 1] - walls[:, 0], walls[:, 0] - one
    with np.errstate(divide="ignore", invalid="ignore"):
        across = along[0] * wall[:, 1] - along[1] * wall[:, 0]
        on_line = (apart[:, 0] * wall[:, 1] - apart[:, 1] * wall[:, 0]) / across
        on_wall = (apart[:, 0] * along[1] - apart[:, 1] * along[0]) / across
    return bool(np.any((on_line > 0.0) & (on_line < 0.999) & (on_wall > 0.0) & (on_wall < 1.0)))


def _boxes(*boxes: tuple[float, float, float, float]) -> Array:
    """Return the sides of boxes, given by middle and size, shape (4 n, 2, 2) [m]."""
    unit = 0.5 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)])
    corners = [np.array([x, y]) + unit * (width, depth) for x, y, width, depth in boxes]
    return np.concatenate([np.stack([each[:-1], each[1:]], axis=1) for each in corners])


def _named(places: list[tuple[float, float]]) -> dict[str, Array]:
    return {f"l{number}": np.array(place) for number, place in enumerate(places)}


def _still(walls: Array) -> Walls:
    return lambda time, position: walls


def _doors(time: float, position: Array) -> Array:
    """Return a wall across a room with two doors, each closed for 10 of 20 s unless the robot is near."""
    doors = [((6.0, 1.3), (6.0, 2.7)), ((6.0, 5.3), (6.0, 6.7))]
    walls = [((6.0, 0.0), (6.0, 1.3)), ((6.0, 2.7), (6.0, 5.3)), ((6.0, 6.7), (6.0, 8.0))]
    for number, (low, high) in enumerate(doors):
        near = abs(position[0] - low[0]) < 1.5 and low[1] - 0.5 < position[1] < high[1] + 0.5
        if (time + 7.0 * number) % 20.0 < 10.0 and not near:
            walls.append((low, high))
    return np.array(walls)


def _walkers(time: float, position: Array) -> Array:
    """Return four things of 0.8 m that walk to and fro."""
    boxes = []
    for number in range(4):
        way = 0.5 + 0.5 * math.sin((0.25 + 0.05 * number) * time + number)
        boxes.append((1.0 + 10.0 * way, 1.6 * (number + 1), 0.8, 0.8))
    return _boxes(*boxes)


RING = _named([(0.2, 3), (3, 0.2), (7, 0.2), (11, 0.2), (13.8, 4), (13.8, 8), (10, 9.8), (6, 9.8), (2, 9.8), (0.2, 7)])
HALL = _named([(x, y) for x in (0.2, 4.0, 8.0, 11.8) for y in (0.2, 7.8)] + [(0.2, 4.0), (11.8, 4.0)])
CLUTTER = _boxes(
    (4, 4, 1, 0.6), (8, 4, 0.6, 1.2), (6, 3.2, 0.5, 0.5), (6, 5, 0.8, 0.4), (4, 7.2, 0.6, 0.6), (8, 0.8, 1, 0.4)
)
ROOMS = {
    "plain": LandmarkRoom(),
    "ring": LandmarkRoom(
        size=(14.0, 10.0),
        corners=((12.5, 1.5), (12.5, 8.5), (1.5, 8.5), (1.5, 1.5)),
        places=RING,
        walls=_still(_boxes((7.0, 5.0, 8.6, 4.6))),
    ),
    "symmetrical hall": LandmarkRoom(places=HALL),
    "doors": LandmarkRoom(walls=_doors),
    "moving obstacles": LandmarkRoom(walls=_walkers),
    "clutter": LandmarkRoom(walls=_still(CLUTTER)),
}
FAULTS = {
    "wheels spin": Faults(slip=0.5),
    "distances 5 % long": Faults(distance=1.05),
    "turns 10 % short": Faults(turn=0.9),
    "turns by 0.5 degrees per second": Faults(drift=math.radians(0.5)),
    "bearings off by 2 degrees": Faults(bearing=math.radians(2.0)),
    "ranges 4 % long": Faults(range=1.04),
}
