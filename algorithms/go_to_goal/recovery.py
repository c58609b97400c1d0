"""Detects that a robot makes no progress towards its goal, and chooses what to try next."""

import math
from enum import Enum

import numpy as np

from mjsim.geometry import Array, Pose

GAIN = 0.3
"""A time to the goal shorter by this counts as progress [s]."""
STANDING, ROAMING = 2.0, 8.0
"""Time without motion, and without progress, after which it tries something else [s]."""
MOVED, TURNED = 0.15, 0.5
"""Change of the pose that counts as motion [m, rad]."""
DETOUR = 60.0
"""Longest planned detour during which a lack of progress is accepted [s]."""
NEWS = 0.5
"""Area seen for the first time that counts as progress [m^2]."""
SILENT = 5.0
"""Time without progress after which the robot says why [s]."""
BACK, BACKING = 0.7, 3.0
"""Maximum distance and duration of backing out [m, s]."""
LOOKING = 4.0
"""Time for which it looks around [s]."""
SPACING = 0.1
"""Distance between the remembered places on its own path [m]."""
REMEMBERED = 200
"""Number of these places."""


class Attempt(Enum):
    """What the robot is trying."""

    DRIVE = "drive to the goal"
    BACK = "back out"
    LOOK = "look round"
    SEARCH = "search a way for its shape"


class Toward:
    """Time to a place in a straight line, with the back of the robot first."""

    def __init__(self, place: Array) -> None:
        """Store the place, shape (2,) [m]."""
        self._place = place

    def at(self, points: Array) -> Array:
        """Return the times from points (..., 2) [s]."""
        return np.asarray(3.0 * np.hypot(points[..., 0] - self._place[0], points[..., 1] - self._place[1]))

    def direction(self, points: Array) -> tuple[Array, Array]:
        """Return where the front of the robot should point, components along x and y."""
        return points[..., 0] - self._place[0], points[..., 1] - self._place[1]


class Around:
    """A turn: all places are equally good, and the robot should face elsewhere."""

    def __init__(self, heading: float) -> None:
        """Store the current heading of the robot [rad]."""
        self._heading = heading + 2.0

    def at(self, points: Array) -> Array:
        """Return the same time for all points (..., 2) [s]."""
        return np.ones(points.shape[:-1])

    def direction(self, points: Array) -> tuple[Array, Array]:
        """Return where the front of the robot should point, components along x and y."""
        ones = np.ones(points.shape[:-1])
        return math.cos(self._heading) * ones, math.sin(self._heading) * ones


class Recovery:
    """Follows the progress of a robot, and chooses what it tries.

    Without progress the robot backs out along its own path, then looks around; places where it got stuck cost more
    afterwards, so that it tries other ways.
    """

    def __init__(self, *, searches: bool = False) -> None:
        """Start without a history.

        Args:
            searches: Whether it searches a way for its shape before it backs out.
        """
        self._searches = searches
        self._trail: list[Pose] = []
        self.stuck: list[tuple[float, float]] = []
        """Places where it got stuck [m]."""
        self._began = -math.inf
        self.restart(0.0)

    def restart(self, now: float) -> None:
        """Begin with a new goal at a time [s]."""
        self._best, self._nearest = math.inf, math.inf
        self._detour, self._area, self.since = 0.0, 0.0, now
        self._rest: Pose | None = None
        self._rested = now
        self.attempt, self._until, self._tries = Attempt.DRIVE, math.inf, 0
        self.target: Array = np.zeros(2)
        self._barred = False

    def silent(self, now: float) -> bool:
        """Return whether there was no progress for so long that the robot must report why."""
        return now - self.since > SILENT + (0.0 if self._tries else self._detour)

    def update(self, pose: Pose, seconds: float, now: float, *, area: float = 0.0, barred: bool = False) -> bool:
        """Follow the robot; return whether it begins something new.

        Args:
            pose: Pose of the robot.
            seconds: Time to the goal from here [s].
            now: [s]
            area: Area seen so far that was unknown [m^2].
            barred: Whether there is no way, so that `seconds` leads through obstacles.
        """
        self._note(pose, now)
        self._barred = barred
        best = self._nearest if barred else self._best
        if seconds < best - GAIN:
            self._best, self._nearest = (self._best, seconds) if barred else (seconds, self._nearest)
            self._detour, self.since = 0.0, now
            if self._tries and self.attempt is Attempt.DRIVE:
                self._tries = 0
        elif not barred:
            self._detour = min(max(self._detour, seconds - best), DETOUR)
        if area > self._area + NEWS:
            self._area, self.since = area, now
        if self.attempt is not Attempt.DRIVE:
            return self._end(pose, now)
        standing, roaming = now - self._rested > STANDING, now - max(self.since, self._began) > ROAMING + self._detour
        return self._begin(pose, now) if standing or roaming else False

    def avoid(self, x: float, y: float) -> None:
        """Avoid a place [m] from now on."""
        self.stuck = [*self.stuck[-20:], (x, y)]

    def _note(self, pose: Pose, now: float) -> None:
        """Remember the path and when the robot last moved."""
        if self._rest is None or _apart(self._rest, pose) > MOVED or _turned(self._rest, pose) > TURNED:
            self._rest, self._rested = pose, now
        if not self._trail or _apart(self._trail[-1], pose) > SPACING:
            self._trail = [*self._trail[-REMEMBERED:], pose]

    def _begin(self, pose: Pose, now: float) -> bool:
        """Begin to back out or to look around."""
        self._tries += 1
        if self._searches and self._tries % 3 and not self._barred:
            self.attempt, self._until = Attempt.SEARCH, math.inf
            return True
        self.avoid(pose.x + 0.3 * math.cos(pose.heading), pose.y + 0.3 * math.sin(pose.heading))
        away = [place for place in self._trail if _apart(place, pose) > BACK]
        looks = self._tries % (6 if self._searches else 3) == 0
        if looks or not away:
            self.attempt, self._until = Attempt.LOOK, now + LOOKING
        else:
            self.attempt, self._until = Attempt.BACK, now + BACKING
            self.target = np.array([away[-1].x, away[-1].y])
        return True

    def _end(self, pose: Pose, now: float) -> bool:
        """Return whether what it tried is over."""
        there = self.attempt is Attempt.BACK and math.hypot(pose.x - self.target[0], pose.y - self.target[1]) < 0.15
        if not there and now < self._until:
            return False
        self.drive(now)
        return True

    def drive(self, now: float, *, dead_end: Array | None = None) -> None:
        """Go back to driving to the goal at a time [s], but not to a place (2,) [m] where a search found no way."""
        if dead_end is not None:
            self.avoid(*dead_end.tolist())
        self.attempt, self._rest, self._began = Attempt.DRIVE, None, now


def _apart(one: Pose, other: Pose) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


def _turned(one: Pose, other: Pose) -> float:
    return abs(math.remainder(one.heading - other.heading, 2.0 * math.pi))
