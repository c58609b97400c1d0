"""Results of an experiment: numbers with their expected values, and plots."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """One result of an experiment, with its expected value."""

    what: str
    """A measured quantity with its unit."""
    value: float
    wanted: str
    """The expectation, as text."""
    holds: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Plot:
    """A plot of an experiment."""

    name: str
    """File name without suffix."""
    caption: str
    png: bytes


@dataclass(frozen=True, slots=True, kw_only=True)
class Result:
    """The results of an experiment."""

    name: str
    title: str
    question: str
    findings: tuple[Finding, ...]
    pictures: tuple[Plot, ...]

    @property
    def holds(self) -> bool:
        """Whether all findings meet the expectations."""
        return all(finding.holds for finding in self.findings)


def at_least(what: str, value: float, least: float) -> Finding:
    """Return a finding that must not be smaller than a bound."""
    return Finding(what=what, value=float(value), wanted=f"at least {least:g}", holds=bool(value >= least))


def at_most(what: str, value: float, bound: float) -> Finding:
    """Return a finding that must not be larger than a bound."""
    return Finding(what=what, value=float(value), wanted=f"at most {bound:g}", holds=bool(value <= bound))


def exactly(what: str, value: float, wanted: float) -> Finding:
    """Return a finding that must equal a value."""
    return Finding(what=what, value=float(value), wanted=f"{wanted:g}", holds=bool(value == wanted))


def within(what: str, value: float, low: float, high: float) -> Finding:
    """Return a finding that must lie between two bounds."""
    return Finding(what=what, value=float(value), wanted=f"{low:g} to {high:g}", holds=bool(low <= value <= high))
