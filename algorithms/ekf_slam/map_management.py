"""Provisional landmarks: those in the state of a filter not yet seen often enough for the published map.

A landmark enters the state at its first sighting, when the pose is most certain, and keeps its correlation with the
pose. But one outlier would distort the whole map: so the landmark is published only when enough sightings agree, and is
removed from the state if the next ones disagree.
"""

from collections.abc import Hashable
from dataclasses import dataclass, field


@dataclass(slots=True)
class _Case:
    """Evidence for and against a landmark on probation."""

    agreeing: list[float] = field(default_factory=list)
    """Times of the sightings that agree, including the first [s]."""
    against: int = 0
    """Number of sightings that disagreed."""


class Probation:
    """Remembers which landmarks of a filter are on probation.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 10.3.3: a list of provisional landmarks.
    """

    def __init__(self, *, confirmations: int, patience: float) -> None:
        """Set the rules.

        Args:
            confirmations: Number of sightings that must agree.
            patience: Time within which they must agree [s].
        """
        self._confirmations, self._patience = confirmations, patience
        self._cases: dict[Hashable, _Case] = {}

    def __contains__(self, name: Hashable) -> bool:
        """Return whether this landmark is on probation."""
        return name in self._cases

    def begin(self, name: Hashable, time: float) -> None:
        """Add a landmark that has been seen once."""
        if self._confirmations > 1:
            self._cases[name] = _Case([time])

    def agrees(self, name: Hashable, time: float) -> None:
        """Count a sighting that agrees with its landmark; enough of them end the probation."""
        if (case := self._cases.get(name)) is None:
            return
        case.agreeing = [*(stamp for stamp in case.agreeing if time - stamp < self._patience), time]
        if len(case.agreeing) >= self._confirmations:
            del self._cases[name]

    def fails(self, name: Hashable) -> bool:
        """Count a sighting that disagrees; return whether the landmark fails, with more against it than for it."""
        if (case := self._cases.get(name)) is None:
            return False
        case.against += 1
        if failed := case.against >= len(case.agreeing):
            del self._cases[name]
        return failed

    def overdue(self, time: float) -> list[Hashable]:
        """Return the landmarks that were not seen again in time."""
        return [name for name, case in self._cases.items() if time - case.agreeing[-1] >= self._patience]

    def end(self, name: Hashable) -> None:
        """Forget a landmark."""
        del self._cases[name]
