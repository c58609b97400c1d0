"""Motions that loops of a mechanism do not permit, and where they stop."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, Linear, Rows, close
from mjsim.sim.followers import Follower
from mjsim.world import Mechanism

TRIED = 9
"""Number of positions along the path of a led joint at which closing of the loops is tested."""


class Locks:
    """Tests whether prescribed motions are compatible with the loops of a mechanism."""

    def __init__(self, mechanism: Mechanism, followers: Sequence[Follower]) -> None:
        """Store a mechanism, and the motions that its joints follow."""
        self._mechanism, self._assembly, self._followers = mechanism, mechanism.assembly, followers

    def follower(self, joint: str) -> Follower:
        """Return the motion of a joint, named by the joint or as `JOINT.VALUE`."""
        column = self._assembly.names.index(joint)
        return next(each for each in self._followers if each.drive.column == column)

    def led(self, step: int) -> list[Rows]:
        """Return the constraints of the motions at a step."""
        return [_asked_of(each, each.goal(step)) for each in self._followers]

    def locked(self, step: int, values: Array) -> str:
        """Return how motions contradict the loops at a step, as text; '' if they do not.

        Args:
            step: Step at which motions are tested.
            values: Initial values of the search, shape (values,) [rad, m].
        """
        if not self._followers:
            return ""
        closed = close(self._assembly.linkage, [*self._assembly.rows, *self.led(step)], values)
        if closed.good:
            return ""
        asked = " and ".join(self._said(each, each.goal(step)) for each in self._followers)
        return f"{self._missed(asked, closed.values)}; change the lengths, or the signal"

    def barred(self, joint: str, goal: float, step: int, values: Array) -> str:
        """Return how loops prevent a joint from reaching a value from its current one, as text; '' if they do not.

        Args:
            joint: A joint that follows a motion; all other motions stay constant.
            goal: The value [rad, m].
            step: Current step.
            values: Current joint values, shape (values,) [rad, m].
        """
        own = self.follower(joint)
        others = [_asked_of(each, each.goal(step)) for each in self._followers if each is not own]
        rows = [*self._assembly.rows, *others]
        for asked in np.linspace(own.goal(step), goal, TRIED)[1:].tolist():
            closed = close(self._assembly.linkage, [*rows, _asked_of(own, asked)], values)
            if not closed.good:
                return self._missed(self._said(own, asked), closed.values)
            values = closed.values
        return ""

    def _missed(self, asked: str, values: Array) -> str:
        worst, how = self._assembly.gap(values)
        return f"mechanism '{self._mechanism.name}' locks: with {asked} its loop at '{worst}' does not close, by {how}"

    def _said(self, follower: Follower, goal: float) -> str:
        drive = follower.drive
        turns = drive.column >= 0 and not self._assembly.slides[drive.column]
        shown = f"{math.degrees(goal):.4g} degrees" if turns else f"{goal:.4g} m"
        return f"'{self._mechanism.actuators[drive.number].target}' at {shown}"


def _asked_of(follower: Follower, goal: float) -> Rows:
    drive = follower.drive
    return Linear({drive.column: 1.0}, goal) if drive.ends is None else Apart(drive.ends, goal)
