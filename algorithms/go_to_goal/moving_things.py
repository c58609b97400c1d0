"""Things that move: found where space was free before, tracked, and predicted."""

import math
from dataclasses import dataclass, field, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose

GAP = 0.15
"""Fresh points within this distance of each other are one thing [m]."""
FEWEST = 3
"""Things of fewer points are noise."""
LARGEST = 1.2
"""Larger groups of points are not one moving object [m]."""
GATE, RIM = 0.5, 0.2
"""How far from its prediction a thing may be seen again, and how far from its rim points are its own [m]."""
MOSTLY = 0.5
"""Share of new points above which a scan is not searched for moving objects."""
GONE = 1.0
"""Time after which a thing that is not seen again is forgotten [s]."""
SIGHTINGS, STRAIGHT = 6, 0.06
"""Number of sightings that the velocity is fitted to, and distance from the fit beyond which a thing has turned [m]."""
SLOWEST, FASTEST = 0.12, 3.0
"""Speeds of things that move [m/s]."""
CONFIRMED = 4
"""Minimum number of sightings of a thing for it to count."""
TRAVELLED, STRAY = 0.15, 0.15
"""How far a thing must have gone, and its mean error at most, to count as moving [m]."""
MAX_PREDICTED = 6
"""Maximum number of things that are predicted, the nearest ones."""
BEHIND = 0.7
"""Distance between the middle of a round thing and the mean of the side that is seen [radii]."""


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """Something that moves."""

    place: Array
    """Shape (2,) [m]."""
    velocity: Array
    """Shape (2,) [m/s]."""
    radius: float
    """[m]"""
    seen: float
    """When it was last seen [s]."""
    count: int
    """How often it was seen."""
    first: Array
    """Where it was seen first, shape (2,) [m]."""
    error: float = 0.0
    """Mean distance between sightings and predictions [m]."""
    sightings: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """Time, x and y of each sighting since it turned, shape (n, 3) [s, m, m]."""

    def after(self, seconds: float) -> Array:
        """Return where it will be after a time [s], shape (2,) [m]."""
        return np.asarray(self.place + seconds * self.velocity)

    @property
    def moves(self) -> bool:
        """Whether it was seen often enough, and moves."""
        speed = float(np.hypot(*self.velocity))
        gone = math.dist(self.place, self.first) > TRAVELLED
        return self.count >= CONFIRMED and SLOWEST < speed < FASTEST and gone and self.error < STRAY


class MovingThings:
    """Tracks groups of fresh points with constant velocity, fitted to its last sightings on a straight line."""

    def __init__(self) -> None:
        """Start without things."""
        self.tracked: list[Thing] = []
        """All groups of fresh points, whether or not they move yet."""

    def update(self, fresh: Array, robot: Pose, now: float) -> None:
        """Add the points of a scan where nothing was before, shape (n, 2) [m], seen from a pose at a time [s]."""
        parts = [part for group in grouped(fresh, GAP) for part in self._parted(group, now)]
        groups = [_thing(part, robot, now) for part in parts]
        unmatched = [group for group in groups if group is not None]
        things, left = [], list(self.tracked)
        apart = {
            (thing, group): math.dist(group.place, thing.after(now - thing.seen))
            for thing in left
            for group in unmatched
        }
        for thing, group in sorted(apart, key=lambda pair: apart[pair]):
            # The nearest first, so that things that pass each other keep their own points.
            if thing in left and group in unmatched and apart[thing, group] < GATE:
                left.remove(thing)
                unmatched.remove(group)
                things.append(_updated(thing, group, now))
        things += [thing for thing in left if now - thing.seen < GONE]
        self.tracked = [*things, *unmatched]

    def _parted(self, group: Array, now: float) -> list[Array]:
        """Return the parts of a group of points (n, 2) that are nearest to different things, at a time [s]."""
        if not self.tracked:
            return [group]
        rims = [np.hypot(*(group - thing.after(now - thing.seen)).T) - thing.radius for thing in self.tracked]
        nearest = np.argmin(rims, axis=0)
        owners = [int(owner) for owner in np.unique(nearest[np.min(rims, axis=0) < RIM])]
        return [group[nearest == owner] for owner in owners] if len(owners) > 1 else [group]

    def near(self, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) [m] cannot locate a robot: all that may move, or those that move if most may."""
        away = {thing: np.hypot(*(points - thing.place).T) < thing.radius + GATE for thing in self.tracked}
        may = np.logical_or.reduce([np.zeros(len(points), dtype=bool), *away.values()])
        if np.count_nonzero(may) <= MOSTLY * len(points):
            return np.asarray(may)
        moves = [near for thing, near in away.items() if thing.moves]
        return np.asarray(np.logical_or.reduce([np.zeros(len(points), dtype=bool), *moves]))

    def predicted(self, robot: Pose, now: float) -> list[Thing]:
        """Return the nearest things that move, where they are at a time [s]."""
        here = np.array([robot.x, robot.y])
        moving = [replace(thing, place=thing.after(now - thing.seen)) for thing in self.tracked if thing.moves]
        return sorted(moving, key=lambda thing: math.dist(thing.place, here))[:MAX_PREDICTED]


def _thing(points: Array, robot: Pose, now: float) -> Thing | None:
    """Return a group of points, seen for the first time; None if it is too small or too large."""
    if len(points) < FEWEST:
        return None
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float(np.hypot(*(high - low)))
    if extent > LARGEST:
        return None
    middle = points.mean(axis=0)
    away = middle - (robot.x, robot.y)
    radius = max(0.5 * extent, 0.1)
    place = middle + BEHIND * radius * away / max(float(np.hypot(*away)), 1e-6)
    return Thing(place, np.zeros(2), radius, now, 1, place, sightings=np.array([[now, *place]]))


def _updated(thing: Thing, seen: Thing, now: float) -> Thing:
    """Return a thing with its new sighting."""
    stray = 0.8 * thing.error + 0.2 * math.dist(seen.place, thing.after(now - thing.seen))
    sightings = np.concatenate([thing.sightings[1 - SIGHTINGS :], seen.sightings])
    while True:
        times, places = sightings[:, 0] - now, sightings[:, 1:]
        middle, centre = times.mean(), places.mean(axis=0)
        velocity = (times - middle) @ places / max(float(((times - middle) ** 2).sum()), 1e-6)
        place = centre - middle * velocity
        misfit = np.abs(places - place - times[:, None] * velocity).max()
        if misfit < STRAIGHT or len(sightings) <= 2:
            break
        sightings = sightings[1:]
    radius = max(0.8 * thing.radius, seen.radius)
    return Thing(place, velocity, radius, now, thing.count + 1, thing.first, stray, sightings)


def grouped(points: Array, gap: float) -> list[Array]:
    """Return groups of points (n, 2) [m] that are connected by distances of about a gap [m]."""
    if not len(points):
        return []
    cells = np.floor((points - points.min(axis=0)) / gap).astype(int)
    taken: NDArray[np.uint8] = np.zeros(cells.max(axis=0) + 1, dtype=np.uint8)
    taken[cells[:, 0], cells[:, 1]] = 1
    _, labels = cv2.connectedComponents(taken, connectivity=8)
    own = labels[cells[:, 0], cells[:, 1]]
    return [points[own == label] for label in np.unique(own)]
