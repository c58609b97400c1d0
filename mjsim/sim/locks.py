"""Motions that loops of a mechanism do not allow, and where they stop."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, Linear, Rows, close
from mjsim.sim.followers import Follower
from mjsim.world import Mechanism

TRIED = 9
"""So many places on the way of a joint that is led are tried, whether loops close there."""


class Locks:
    """What the motions of a mechanism ask of its loops."""

    def __init__(self, mechanism: Mechanism, followers: Sequence[Follower]) -> None:
        """Take a mechanism, and what its joints follow."""
        self._mechanism, self._assembly, self._followers = mechanism, mechanism.assembly, followers

    def follower(self, joint: str) -> Follower:
        """Return the motion that leads a joint, named as it or as `JOINT.VALUE`."""
        column = self._assembly.names.index(joint)
        return next(each for each in self._followers if each.drive.column == column)

    def led(self, step: int) -> list[Rows]:
        """Return what motions ask of the values at a step."""
        return [_asked_of(each, each.goal(step)) for each in self._followers]

    def locked(self, step: int, values: Array) -> str:
        """Return how motions ask for what loops do not allow at a step, in words; '' where they do not.

        Args:
            step: Whose motions are tried.
            values: Where the search begins, shape (values,) [rad, m].
        """
        if not self._followers:
            return ""
        closed = close(self._assembly.linkage, [*self._assembly.rows, *self.led(step)], values)
        if closed.good:
            return ""
        asked = " and ".join(self._said(each, each.goal(step)) for each in self._followers)
        return f"{self._missed(asked, closed.values)}; change the lengths, or the signal"

    def barred(self, joint: str, goal: float, step: int, values: Array) -> str:
        """Return how loops do not allow that a joint is led to a value from where it is, in words; '' where they do.

        Args:
            joint: One that follows a motion; all others stay meanwhile.
            goal: Where to [rad, m].
            step: Now.
            values: Of all joints now, shape (values,) [rad, m].
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
