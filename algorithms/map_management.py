"""Landmarks on probation: what has been seen too seldom to enter the map.

One bad first look would bend the whole map, so a landmark enters when some looks at it agree about its place. With
names the looks of one name are compared; without, each look joins the candidate that it fits best.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from mjsim.geometry import Array

DRIFT = 0.05
"""How far the robot may lose its way between two looks that are compared, standard deviation [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """One sighting of a landmark that is not in the map yet."""

    time: float
    """[s]"""
    place: Array
    """Where it puts the landmark, shape (2,) [m]."""
    covariance: Array
    """Of the place as the measurement alone gives it, shape (2, 2) [m^2]."""

    def distance(self, other: "Look") -> float:
        """Return the squared Mahalanobis distance of two looks at what may be one place."""
        apart = self.place - other.place
        spread = self.covariance + other.covariance + DRIFT**2 * np.eye(2)
        return float(apart @ np.linalg.solve(spread, apart))


class Probation:
    """Remembers looks until enough of them agree.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 10.3.3: a list of landmarks that are provisional.
    """

    def __init__(self, *, confirmations: int, patience: float, gate: float) -> None:
        """Set the rules.

        Args:
            confirmations: How many looks must agree.
            patience: How long a look waits for others [s].
            gate: Largest squared Mahalanobis distance of looks that agree.
        """
        self._confirmations, self._patience, self._gate = confirmations, patience, gate
        self._named: dict[Hashable, list[Look]] = {}
        self._nameless: list[list[Look]] = []

    def passes(self, name: Hashable, look: Look) -> bool:
        """Take a look at a landmark with a name; return whether it may enter the map now."""
        waiting = self._fresh(self._named.get(name, []), look.time)
        if self._agreed(look, waiting):
            self._named.pop(name, None)
            return True
        self._named[name] = [*waiting, look]
        return False

    def passing(self, looks: Sequence[Look]) -> list[bool]:
        """Take the looks of one moment at landmarks without names; return which may enter the map now."""
        if not looks:
            return []
        known = [fresh for old in self._nameless if (fresh := self._fresh(old, looks[0].time))]
        pairs = self._paired(looks, known)
        entered = [False] * len(looks)
        gone = set()
        for row, look in enumerate(looks):
            column = pairs.get(row)
            if column is None:
                entered[row] = self._confirmations == 1
                if not entered[row]:
                    known.append([look])
            elif self._agreed(look, known[column]):
                entered[row] = True
                gone.add(column)
            else:
                known[column].append(look)
        self._nameless = [looks for column, looks in enumerate(known) if column not in gone]
        return entered

    def _paired(self, looks: Sequence[Look], known: Sequence[Sequence[Look]]) -> dict[int, int]:
        """Return for each look the candidate that it belongs to, if any."""
        if not known:
            return {}
        cost = np.array([[min(look.distance(old) for old in candidate) for candidate in known] for look in looks])
        fits = cost < self._gate
        rows, columns = linear_sum_assignment(np.where(fits, cost, 1e6))
        return {row: column for row, column in zip(rows.tolist(), columns.tolist(), strict=True) if fits[row, column]}

    def _agreed(self, look: Look, others: Sequence[Look]) -> bool:
        return 1 + sum(look.distance(old) < self._gate for old in others) >= self._confirmations

    def _fresh(self, looks: Sequence[Look], time: float) -> list[Look]:
        return [look for look in looks if time - look.time < self._patience]
