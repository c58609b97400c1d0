"""Recent hits of the proximity rays."""

import math

import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Observation

NOTHING = 1e6
"""Where a ray that hit nothing is put [m]: finite, so that arithmetic on it stays quiet."""
RAYS = 16


class Hits:
    """Points hit by the ring, remembered for some seconds in the frame of odometry.

    The rays leave gaps, so what one has met is kept while it looks past it. A point is kept once, however often it is
    met, and dropped as soon as a ray looks through where it was: what has gone away is in nobody's way.
    """

    CAPACITY = 256
    """Points."""
    APART = 0.04
    """Nearer than this to one that is known, a hit is the same point [m]."""
    SECONDS = 8.0
    """For how long a point is kept that no ray meets again [s]."""
    BEAM = 0.025
    """What is nearer to the line of a ray would have been hit by it [m]."""
    BEHIND = 0.1
    """A ray that goes on by so much has looked through a point [m]."""

    NEAR = 1.5
    """So far away what other sensors meet is kept [m]."""
    SHARES = np.array([0.25, 0.5, 0.75])
    """Where the points lie between what two rays hit."""
    STRIDE, PAUSE = 0.04, 0.4
    """Hits are kept when the robot has moved so far [m], or turned twice that [rad], or waited so long [s]."""

    def __init__(self, rims: Array, *, join: float = 0.0) -> None:
        """Begin with none.

        Args:
            rims: How far the body reaches along each ray, shape (16,) [m].
            join: What neighbouring rays hit nearer to each other than this leaves no way between [m].
        """
        self._join = join
        angles = np.arange(RAYS) * (2.0 * np.pi / RAYS)
        self._rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        self._rims = rims
        self._live = np.full((RAYS, 2), NOTHING)
        self._points = np.full((self.CAPACITY, 2), NOTHING)
        self._stamps = np.full(self.CAPACITY, -np.inf)
        self.x = self.y = self.heading = 0.0
        self._noted = 0.0, 0.0, 0.0, -math.inf

    def see(self, seen: Observation) -> None:
        """Carry the robot on by odometry; now and then forget what is old or gone, and keep what is hit."""
        c, s = math.cos(self.heading), math.sin(self.heading)
        forward, left = seen.odometry.forward, seen.odometry.left
        self.x += c * forward - s * left
        self.y += s * forward + c * left
        self.heading += seen.odometry.turn
        distances = np.minimum(seen.proximity + self._rims, NOTHING)
        np.multiply(self._rays, distances[:, None], out=self._live)
        x, y, heading, time = self._noted
        moved = abs(self.x - x) + abs(self.y - y) + 0.5 * abs(self.heading - heading)
        if moved > self.STRIDE or seen.time - time > self.PAUSE:
            self._noted = self.x, self.y, self.heading, seen.time
            self._look_through(distances, seen.time)
            if (hit := distances < NOTHING).any():
                c, s = math.cos(self.heading), math.sin(self.heading)
                self._keep(self._live[hit] @ np.array([[c, s], [-s, c]]) + (self.x, self.y), seen.time)

    def add(self, points: Array, now: float) -> None:
        """Keep what another sensor has met, of what is near one point for each cell.

        Args:
            points: Robot's frame, shape (n, 2) [m].
            now: [s]
        """
        away = np.hypot(*points.T)
        near = points[np.argsort(away)][: int(np.count_nonzero(away < self.NEAR))]
        _, first = np.unique(np.rint(near / self.APART), axis=0, return_index=True)
        kept = near[np.sort(first)[: self.CAPACITY // 2]]
        c, s = math.cos(self.heading), math.sin(self.heading)
        self._keep(kept @ np.array([[c, s], [-s, c]]) + (self.x, self.y), now)

    def _look_through(self, distances: Array, now: float) -> None:
        """Forget points that are old, and those that rays, shape (16,) [m], look through."""
        x, y = (self._points - (self.x, self.y)).T
        bearings = np.arctan2(y, x) - self.heading
        ray = np.rint(bearings * (RAYS / (2.0 * math.pi))).astype(int)
        off, away = bearings - ray * (2.0 * math.pi / RAYS), np.hypot(x, y)
        through = (np.abs(off) * away < self.BEAM) & (away < distances[ray % RAYS] - self.BEHIND)
        gone = through | (self._stamps < now - self.SECONDS)
        self._points[gone], self._stamps[gone] = NOTHING, -np.inf

    def _keep(self, hits: Array, now: float) -> None:
        """Note hits, shape (n, 2) [m], frame of odometry: as met again, or as new in the place of the oldest."""
        away = hits[:, None] - self._points
        squared = np.einsum("ijk,ijk->ij", away, away)
        nearest = squared.argmin(axis=1)
        known = squared[np.arange(len(hits)), nearest] < self.APART**2
        self._stamps[nearest[known]] = now
        fresh = hits[~known]
        if len(fresh):
            oldest = np.argpartition(self._stamps, len(fresh))[: len(fresh)]
            self._points[oldest], self._stamps[oldest] = fresh, now

    def within(self, distance: float) -> Array:
        """Return the points nearer than a distance, in the robot's frame, shape (n, 2) [m]."""
        offsets = self._points - (self.x, self.y)
        near = offsets[np.einsum("ij,ij->i", offsets, offsets) < distance**2]
        c, s = math.cos(self.heading), math.sin(self.heading)
        live = self._live[np.einsum("ij,ij->i", self._live, self._live) < distance**2]
        joined = [self._between(distance)] if self._join else []
        return np.concatenate([live, near @ np.array([[c, -s], [s, c]]), *joined])

    def _between(self, distance: float) -> Array:
        """Return points between what neighbouring rays hit, as `within` does: a corner of the body may be there."""
        left = np.roll(self._live, -1, axis=0)
        gap = left - self._live
        close = (np.hypot(*gap.T) < self._join) & (np.hypot(*self._live.T) < distance)
        return np.asarray((self._live[close][:, None] + gap[close][:, None] * self.SHARES[:, None]).reshape(-1, 2))
