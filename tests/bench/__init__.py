"""Measurements of speed: `mjsim bench`. Machines are noisy, so figures of one call are compared, not of two."""

import statistics
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack

from mjsim.bench.asked import ASKED, ASKED_HEAD, ASKED_OF_PEERS, verdict
from mjsim.bench.figure import Clock, Figure
from mjsim.errors import UsageError, did_you_mean

HEAD = f"{'figure':<26}{'median':>10}{'min':>10}{'max':>10}  {'unit':<28}{'runs':>4}"


def measure(only: Sequence[str], *, runs: int, peers: bool = False, clock: Clock = time.perf_counter) -> Iterator[str]:
    """Yield a table, one line a figure: name, median, min, max, unit, runs; then what is asked of their ratios.

    Args:
        only: Names of figures; all of them when empty.
        runs: How often each is measured. The figures take turns, so that a slow minute of the machine falls on all.
        peers: Whether other simulators are measured too.
        clock: By which times are taken.

    Raises:
        UsageError: There is no such figure, or another simulator is not installed.
    """
    chosen = _chosen(only, peers=peers)
    values: dict[str, list[float]] = {figure.name: [] for figure in chosen}
    with ExitStack() as stack:
        ready = [(figure, stack.enter_context(figure.prepare())) for figure in chosen]
        for _ in range(runs):
            for figure, once in ready:
                values[figure.name].append(once(clock))
    yield HEAD
    for figure in chosen:
        got = values[figure.name]
        numbers = "".join(f"{value:>10.4g}" for value in (statistics.median(got), min(got), max(got)))
        yield f"{figure.name:<26}{numbers}  {figure.unit:<28}{len(got):>4}"
    asked = [each for each in (*ASKED, *ASKED_OF_PEERS) if all(name in values for name in each.of)]
    if asked:
        yield from ("", ASKED_HEAD, *(verdict(each, values) for each in asked))


def _chosen(only: Sequence[str], *, peers: bool) -> list[Figure]:
    from mjsim.bench.figures import FIGURES  # which import every algorithm; who takes another module does without

    known = {figure.name: figure for figure in FIGURES}
    if peers:
        from mjsim.bench.peers import PEER_FIGURES

        known |= {figure.name: figure for figure in PEER_FIGURES}
    for name in only:
        if name not in known:
            raise UsageError(f"no figure '{name}'{did_you_mean(name, known)}")
    return [known[name] for name in only] or list(known.values())
