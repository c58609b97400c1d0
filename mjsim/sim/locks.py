"""Motions that loops of a mechanism do not permit, and where they stop."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.geometry import Array
from mjsim.mechanics import Apart, Linear, Rows, close, rates, residual
from mjsim.sim.followers import Follower
from mjsim.world import Mechanism

TRIED = 9
"""Number of positions along the path of a led joint at which closing of the loops is tested."""


class Locks:
    """Tests whether prescribed motions are compatible with the loops of a mechanism."""

    def __init__(self, mechanism: Mechanism, followers: Sequence[Follower]) -> None:
        """Store a mechanism, and the motions that its joints follow."""
        self._mechanism, self._assembly, self._followers = mechanism, mechanism.assembly, followers

    def led(self, step: int) -> list[Rows]:
        """Return the constraints of the motions at a step."""
        return [_constraint(each, each.goal(step)) for each in self._followers]

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
        goals = " and ".join(self._described(each, each.goal(step)) for each in self._followers)
        return f"{self._missed(goals, closed.values)}; change the lengths, or the signal"

    def barred(self, joint: str, goal: float, step: int, values: Array) -> str:
        """Return how loops prevent a joint from reaching a value from its current one, as text; '' if they do not.

        Args:
            joint: A joint that follows a motion, or that motions move through loops; all other motions stay constant.
            goal: The value [rad, m].
            step: Current step.
            values: Current joint values, shape (values,) [rad, m].
        """
        return self._reached(joint, goal, step, values)[1]

    def source(self, joint: str, goal: float, step: int, values: Array) -> tuple[Follower, float]:
        """Return the motion that moves a joint most, and its value when the joint reaches its own [rad, m].

        The arguments are those of `barred`; beyond what loops permit, the motion ends where they stop it.
        """
        return self.moves_most(joint, step, values), self._reached(joint, goal, step, values)[0]

    def _reached(self, joint: str, goal: float, step: int, values: Array) -> tuple[float, str]:
        """Return the last value of the joint's motion on the way to a goal, and what stops it, '' if nothing does."""
        column = self._assembly.names.index(joint)
        own = self.moves_most(joint, step, values)
        others = [_constraint(each, each.goal(step)) for each in self._followers if each is not own]
        rows, begin = [*self._assembly.rows, *others], float(values[column])
        if own.drive.column == column:
            begin = own.goal(step)
        for value in np.linspace(begin, goal, TRIED)[1:].tolist():
            closed = close(self._assembly.linkage, [*rows, Linear({column: 1.0}, value)], values)
            if not closed.good:
                turns = not self._assembly.slides[column]
                shown = f"'{joint}' at {math.degrees(value):.4g} degrees" if turns else f"'{joint}' at {value:.4g} m"
                return float(values[own.drive.column]), self._missed(shown, closed.values)
            values = closed.values
        return float(values[own.drive.column]), ""

    def moves_most(self, joint: str, step: int, values: Array) -> Follower:
        """Return the motion of a joint, or the motion of another that moves it most."""
        column = self._assembly.names.index(joint)
        own = [each for each in self._followers if each.drive.column >= 0]
        for each in own:
            if each.drive.column == column:
                return each
        found, led = self._assembly, self.led(step)
        count = len(residual(found.linkage, found.rows, values))

        def moved(follower: Follower) -> float:
            targets = np.zeros(count + len(led))
            targets[count + self._followers.index(follower)] = 1.0
            speeds, _ = rates(found.linkage, [*found.rows, *led], values, held={}, targets=targets)
            return abs(float(speeds[column]))

        return max(own, key=moved)

    def _missed(self, goals: str, values: Array) -> str:
        worst, how = self._assembly.gap(values)
        return f"mechanism '{self._mechanism.name}' locks: with {goals} its loop at '{worst}' does not close, by {how}"

    def _described(self, follower: Follower, goal: float) -> str:
        drive = follower.drive
        turns = drive.column >= 0 and not self._assembly.slides[drive.column]
        shown = f"{math.degrees(goal):.4g} degrees" if turns else f"{goal:.4g} m"
        return f"'{self._mechanism.actuators[drive.number].target}' at {shown}"


def _constraint(follower: Follower, goal: float) -> Rows:
    drive = follower.drive
    return Linear({drive.column: 1.0}, goal) if drive.ends is None else Apart(drive.ends, goal)
