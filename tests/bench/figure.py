"""A figure of the table."""

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

Clock = Callable[[], float]
"""Gives a time [s]: that of the wall, or that of all processors which this process has used."""
Once = Callable[[Clock], float]
"""Measures once by a clock, and returns the value."""
Prepare = Callable[[], AbstractContextManager[Once]]


@dataclass(frozen=True)
class Figure:
    """One figure of the table."""

    name: str
    unit: str
    prepare: Prepare
    """Gets ready; what it gives is called once a run and returns the value."""
