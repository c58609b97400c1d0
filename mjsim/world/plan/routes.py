"""Routes: the position of a scripted object as a function of time."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from mjsim.geometry import Array
from mjsim.world.items import Obstacle
from mjsim.world.plan.outlines import footprint

Place = tuple[float, float]
"""(x, y)."""


@dataclass(frozen=True, slots=True)
class Route:
    """Stops connected by straight legs, repeated forever; the position depends only on time."""

    stops: tuple[Place, ...]
    """World frame [m]; the last equals the first."""
    arrives: tuple[float, ...]
    """Arrival time at each stop, in a round that starts with the wait at the first [s]."""
    wait: float
    """Wait at each stop [s]."""

    @property
    def period(self) -> float:
        """Time of one round [s]."""
        return self.arrives[-1]

    def at(self, time: float) -> tuple[Place, Place]:
        """Return position [m] and velocity [m/s], world frame, at a time [s]."""
        if self.period <= 0.0:
            return self.stops[0], (0.0, 0.0)
        now = math.fmod(time, self.period)
        # It has reached this stop, but not the next.
        index = min(bisect_right(self.arrives, now), len(self.stops) - 1) - 1
        (x, y), (end_x, end_y) = self.stops[index], self.stops[index + 1]
        leaves = self.arrives[index] + self.wait
        if now < leaves:
            return (x, y), (0.0, 0.0)
        seconds = self.arrives[index + 1] - leaves
        if seconds <= 0.0:
            return (end_x, end_y), (0.0, 0.0)
        u, v = (end_x - x) / seconds, (end_y - y) / seconds
        return (x + u * (now - leaves), y + v * (now - leaves)), (u, v)


def route_of(obstacle: Obstacle) -> Route | None:
    """Return the route of a scripted obstacle; None for one without a path."""
    path = obstacle.path
    if path is None:
        return None
    points: list[Place] = [(x, y) for x, y in (obstacle.at, *path.points)]
    stops = [*points, points[0]] if path.closed else [*points, *points[-2::-1]]
    durations = (math.dist(start, end) / path.speed for start, end in pairwise(stops))
    arrives = accumulate((path.wait + seconds for seconds in durations), initial=0.0)
    return Route(tuple(stops), tuple(arrives), path.wait)


def extent(obstacle: Obstacle) -> Array:
    """Return points that bound an obstacle along its whole path, world frame, shape (n, 2) [m]."""
    outline = footprint(obstacle)
    if obstacle.path is None:
        return outline
    moved = np.array([obstacle.at, *obstacle.path.points]) - obstacle.at
    return np.concatenate([outline + moved.min(axis=0), outline + moved.max(axis=0)])
