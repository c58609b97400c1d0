"""Recent hits of the proximity rays."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Observation

NO_HIT_RANGE = 1e6
"""Range of a ray that hit nothing [m]: finite, to avoid floating-point warnings."""
RAYS = 16


class Hits:
    """Points hit by the ring, remembered for some seconds in the frame of odometry.

    There are gaps between the rays, so points are remembered while rays pass beside them. A point is stored once,
    however often it is hit, and dropped when a ray passes through it, because the obstacle has moved away.
    """

    CAPACITY = 256
    """Maximum number of points."""
    CELL = 0.04
    """A hit closer than this to a known point is the same point [m]."""
    SECONDS = 8.0
    """Time for which a point is kept without being hit again [s]."""
    BEAM = 0.025
    """Points closer than this to the line of a ray would be hit by it [m]."""
    BEHIND = 0.1
    """A ray that continues this far beyond a point has passed through it [m]."""

    RANGE = 1.5
    """Maximum distance of points from other sensors [m]."""
    SHARES = np.array([0.25, 0.5, 0.75])
    """Positions of the points between the hits of two neighbouring rays, from 0 to 1."""
    STRIDE, PAUSE = 0.04, 0.4
    """Hits are stored when the robot has moved this far [m], turned by twice that [rad], or after this time [s]."""

    def __init__(self, rims: Array, *, join: float = 0.0) -> None:
        """Start without points.

        Args:
            rims: Distance from the origin to the rim along each ray, shape (16,) [m].
            join: Hits of neighbouring rays closer to each other than this have no free path between them [m].
        """
        self._join = join
        angles = np.arange(RAYS) * (2.0 * np.pi / RAYS)
        self._rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self._rims = rims
        self._live = np.full((RAYS, 2), NO_HIT_RANGE)
        self._points = np.full((self.CAPACITY, 2), NO_HIT_RANGE)
        self._stamps = np.full(self.CAPACITY, -np.inf)
        self.x = self.y = self.heading = 0.0
        self._noted = 0.0, 0.0, 0.0, -math.inf

    def see(self, seen: Observation) -> None:
        """Move the robot by odometry; periodically drop old points and those passed through, and store new hits."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        forward, left = seen.odometry.forward, seen.odometry.left
        self.x += c * forward - s * left
        self.y += s * forward + c * left
        self.heading += seen.odometry.turn
        distances = np.minimum(seen.proximity + self._rims, NO_HIT_RANGE)
        np.multiply(self._rays, distances[:, None], out=self._live)
        x, y, heading, time = self._noted
        moved = abs(self.x - x) + abs(self.y - y) + 0.5 * abs(self.heading - heading)
        if moved > self.STRIDE or seen.time - time > self.PAUSE:
            self._noted = self.x, self.y, self.heading, seen.time
            self._drop_outdated(distances, seen.time)
            if (hit := distances < NO_HIT_RANGE).any():
                c, s = math.cos(self.heading), math.sin(self.heading)
                self._keep(self._live[hit] @ np.array([[c, s], [-s, c]]) + (self.x, self.y), seen.time)

    def add(self, points: Array, now: float) -> None:
        """Store points from another sensor: of those that are near, one per cell.

        Args:
            points: Robot's frame, shape (n, 2) [m].
            now: [s]
        """
        away = np.hypot(*points.T)
        close = points[np.argsort(away)][: int(np.count_nonzero(away < self.RANGE))]
        _, first = np.unique(np.rint(close / self.CELL), axis=0, return_index=True)
        chosen = close[np.sort(first)[: self.CAPACITY // 2]]
        c, s = math.cos(self.heading), math.sin(self.heading)
        self._keep(chosen @ np.array([[c, s], [-s, c]]) + (self.x, self.y), now)

    def _drop_outdated(self, distances: Array, now: float) -> None:
        """Drop old points, and those that rays, shape (16,) [m], pass through."""
        x, y = (self._points - (self.x, self.y)).T
        bearings = np.arctan2(y, x) - self.heading
        ray = np.rint(bearings * (RAYS / (2.0 * math.pi))).astype(int)
        deviation, away = bearings - ray * (2.0 * math.pi / RAYS), np.hypot(x, y)
        through = (np.abs(deviation) * away < self.BEAM) & (away < distances[ray % RAYS] - self.BEHIND)
        outdated = through | (self._stamps < now - self.SECONDS)
        self._points[outdated], self._stamps[outdated] = NO_HIT_RANGE, -np.inf

    def _keep(self, hits: Array, now: float) -> None:
        """Store hits, shape (n, 2) [m], frame of odometry: renew known points; new ones replace the oldest."""
        away = hits[:, None] - self._points
        squared = np.einsum("ijk,ijk->ij", away, away)
        nearest = squared.argmin(axis=1)
        known = squared[np.arange(len(hits)), nearest] < self.CELL**2
        self._stamps[nearest[known]] = now
        fresh = hits[~known]
        if len(fresh):
            oldest = np.argpartition(self._stamps, len(fresh))[: len(fresh)]
            self._points[oldest], self._stamps[oldest] = fresh, now

    def within(self, distance: float) -> Array:
        """Return the points within a distance, in the robot's frame, shape (n, 2) [m]."""
        offsets = self._points - (self.x, self.y)
        close = offsets[np.einsum("ij,ij->i", offsets, offsets) < distance**2]
        c, s = math.cos(self.heading), math.sin(self.heading)
        live = self._live[np.einsum("ij,ij->i", self._live, self._live) < distance**2]
        joined = [self._between(distance)] if self._join else []
        return np.concatenate([live, close @ np.array([[c, -s], [s, c]]), *joined])

    def _between(self, distance: float) -> Array:
        """Return points between the hits of neighbouring rays, like `within`, where a corner could hit something."""
        left = np.roll(self._live, -1, axis=0)
        gap = left - self._live
        close = (np.hypot(*gap.T) < self._join) & (np.hypot(*self._live.T) < distance)
        return np.asarray((self._live[close][:, None] + gap[close][:, None] * self.SHARES[:, None]).reshape(-1, 2))
