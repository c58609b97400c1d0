"""Measurements of speed: `mjsim bench`. Machines are noisy, so figures of one call are compared, not of two."""

import statistics
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from mjsim.bench.figures import FIGURES
from mjsim.errors import UsageError, did_you_mean

HEAD = f"{'figure':<22}{'median':>10}{'min':>10}{'max':>10}  {'unit':<28}{'runs':>4}"


def measure(only: Sequence[str], *, runs: int) -> Iterator[str]:
    """Yield a table, one line a figure: name, median, min, max, unit, runs.

    Args:
        only: Names of figures; all of them when empty.
        runs: How often each is measured. The figures take turns, so that a slow minute of the machine falls on all.

    Raises:
        UsageError: There is no such figure.
    """
    known = {figure.name: figure for figure in FIGURES}
    for name in only:
        if name not in known:
            raise UsageError(f"no figure '{name}'{did_you_mean(name, known)}")
    chosen = [known[name] for name in only] or list(FIGURES)
    values: dict[str, list[float]] = {figure.name: [] for figure in chosen}
    with ExitStack() as stack:
        ready = [(figure, stack.enter_context(figure.prepare())) for figure in chosen]
        for _ in range(runs):
            for figure, once in ready:
                values[figure.name].append(once())
    yield HEAD
    for figure in chosen:
        got = values[figure.name]
        numbers = "".join(f"{value:>10.4g}" for value in (statistics.median(got), min(got), max(got)))
        yield f"{figure.name:<22}{numbers}  {figure.unit:<28}{len(got):>4}"
