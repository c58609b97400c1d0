"""What an experiment shows: figures with what was expected of them, and pictures."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One figure of an experiment."""

    what: str
    """What was measured, with its unit."""
    value: float
    wanted: str
    """What was expected of it, in words."""
    holds: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Plot:
    """A plot of an experiment."""

    name: str
    """Of its file, without its ending."""
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """An experiment that was made."""

    name: str
    title: str
    question: str
    findings: tuple[Finding, ...]
    pictures: tuple[Plot, ...]

    @property
    def holds(self) -> bool:
        """Whether all is as it was expected."""
        return all(finding.holds for finding in self.findings)


def at_least(what: str, value: float, least: float) -> Finding:
    """Return a figure that is to be no smaller than something."""
    return Finding(what=what, value=float(value), wanted=f"at least {least:g}", holds=bool(value >= least))


def at_most(what: str, value: float, most: float) -> Finding:
    """Return a figure that is to be no larger than something."""
    return Finding(what=what, value=float(value), wanted=f"at most {most:g}", holds=bool(value <= most))


def exactly(what: str, value: float, wanted: float) -> Finding:
    """Return a figure that is to be just that."""
    return Finding(what=what, value=float(value), wanted=f"{wanted:g}", holds=bool(value == wanted))


def within(what: str, value: float, low: float, high: float) -> Finding:
    """Return a figure that is to lie between two."""
    return Finding(what=what, value=float(value), wanted=f"{low:g} to {high:g}", holds=bool(low <= value <= high))
