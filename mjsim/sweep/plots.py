"""The plots of a sweep."""

from collections.abc import Sequence

from mjsim.sweep.plan import Plan
from mjsim.sweep.table import Row
from mjsim.sweep.worker import Outcome


def plots(plan: Plan, rows: Sequence[Row], outcomes: Sequence[Outcome], robots: Sequence[str]) -> dict[str, bytes]:
    """Return the plots as files of PNG by their names."""
    return {}
