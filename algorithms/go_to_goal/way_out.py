"""Leads a long body out of where sampled motions find no way: searches a path for its shape, and follows it."""

import math

import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, RobotInfo

from .body_discs import BodyDiscs
from .body_search import HALF, BodySearch, moves_of
from .cost_to_go import CostToGo
from .curve_follower import CurveFollower
from .obstacle_map import ObstacleMap

TOP, UNSEEN_TOP = 0.4, 0.15
"""Maximum speed on the path, and where no sensor has seen it [m/s]."""
KINDS = ((1.5, 0.04, True), (1.5, 0.025, True), (1.5, 0.04, False))
"""Searches: how fine, clearance of the path [m], and whether only where sensors have seen; one after the other, while
none is found."""
DRIVEN_ROOM, SOON = 0.015, 15
"""Clearance while it is driven [m], and number of points ahead that are tested from where the robot is."""
STANDING, OFF = 0.03, 0.12
"""Speed below which the robot stands [m/s], and distance from the path at which it searches anew [m]."""
MAX_BEND = 4.0
"""Maximum curvature of the path [1/m]."""
BATCH = 600
"""Number of poses that are expanded in a tick."""
NEARER = 2.5
"""The path brings the goal nearer by the time for this distance, which is clipped [m]."""
MIN_NEARER, MAX_NEARER = 0.8, 2.0
"""[s]"""
MAX_PATHS = 4
"""Number of paths that it begins to drive, at most, before it gives up."""
BLIND = 1.0
"""Distance from the body within which a long one enters nothing that no sensor has seen or faces [m]."""
CELL, SIGHT = 0.0125, 1.5
"""Side of the cells of obstacles, and how far beyond the body they are looked at while it drives [m]."""


class WayOut:
    """Searches and follows a path that brings the goal nearer, for the shape and the kinematics of a robot."""

    def __init__(self, robot: RobotInfo, body: BodyDiscs, *, bend: float, top: float) -> None:
        """Take the robot, its body, the curvature [1/m] up to which it bends, and its maximum speed [m/s]."""
        bend = min(bend, MAX_BEND)
        self._body, self._moves = body, [moves_of(robot, bend=bend, fine=fine) for fine, _, _ in KINDS]
        self._followers = [CurveFollower(robot, bend=bend, top=min(top, most)) for most in (TOP, UNSEEN_TOP)]
        self._nearer = min(max(NEARER / top, MIN_NEARER), MAX_NEARER)
        self.restart()

    @property
    def left(self) -> Array:
        """The rest of the path, shape (n, 2) [m]."""
        return self._follower.left[:, :2]

    def restart(self) -> None:
        """Drop what it searches and follows."""
        self.is_busy, self._kind, self._paths = False, 0, 0
        self._search: BodySearch | None = None
        self._follower, self._follows = self._followers[0], False
        self._follower.stop()
        self._floors: Array = np.zeros(len(self._body.radii))
        self.dead_end: Array | None = None
        """Where a search ended that found nothing, shape (2,) [m]."""

    def command(self, pose: Pose, speed: float, field: CostToGo, near: Array, unseen: Array) -> Command | None:
        """Return the next twist; None when it is at the end, or found nothing.

        Args:
            pose: Pose of the robot.
            speed: Its current speed [m/s].
            field: Times to the goal.
            near: Obstacles, shape (n, 2) [m].
            unseen: Places that no sensor has seen or faces, shape (m, 2) [m].
        """
        if not self.is_busy:
            self.restart()
            self.is_busy = True
        if self._follows:
            self.is_busy = self._follower.is_busy
            if not self.is_busy:
                return None
            if self._is_free(pose, ObstacleMap(_place(pose), near, cell=CELL, half=SIGHT + self._body.reach)):
                return self._follower.command(pose)
            self._follower.stop()
            self._follows, self._kind = False, 0
        shy = KINDS[self._kind][2]
        if abs(speed) > STANDING:
            return Command()
        if self._search is None:
            points = np.concatenate([near, unseen]) if shy else near
            map = ObstacleMap(_place(pose), points, cell=CELL, half=HALF + self._body.reach)
            (fine, room, _), moves = KINDS[self._kind], self._moves[self._kind]
            self._search = BodySearch(
                pose, self._body, map, field, moves=moves, room=room, nearer=self._nearer, fine=fine
            )
        self._search.advance(BATCH)
        if self._search.is_over and not self._takes(self._search, shy=shy):
            self.is_busy = False
            return None
        return Command()

    def _takes(self, search: BodySearch, *, shy: bool) -> bool:
        """Take the path of a search, or go on to the next kind; return whether there is one left."""
        self._search = None
        if search.found is not None:
            self._paths, self._follows = self._paths + 1, True
            self._follower = self._followers[0 if shy else 1]
            self._follower.begin(*search.found)
            self._floors = np.minimum(DRIVEN_ROOM, search.floors)
            return self._paths <= MAX_PATHS
        self._kind += 1
        if self._kind < len(KINDS):
            return True
        self._kind, self.dead_end = 0, search.deepest
        return False

    def _is_free(self, pose: Pose, map: ObstacleMap) -> bool:
        """Return whether the rest of the path is free, and the robot can go on from where it is."""
        left = self._follower.left
        if math.dist(left[0, :2], (pose.x, pose.y)) > OFF:
            return False
        left = left[np.hypot(left[:, 0] - pose.x, left[:, 1] - pose.y) < SIGHT]
        shift = pose @ Pose.from_array(left[0]).inverse()
        soon = np.array([(shift @ Pose.from_array(point)).as_array() for point in left[:SOON:3]])
        return bool(self._fits(left[::3], map).all() and self._fits(soon, map).all())

    def _fits(self, poses: Array, map: ObstacleMap) -> NDArray[np.bool_]:
        """Return whether the body keeps its clearance at poses, shape (n, 3) [m, m, rad]."""
        clear = self._body.clearances(poses[:, 0], poses[:, 1], poses[:, 2], map)
        return np.asarray((clear >= self._floors[:, None]).all(axis=0))


def _place(pose: Pose) -> Array:
    return np.array([pose.x, pose.y])
