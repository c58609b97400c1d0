#!/usr/bin/env python3
"""Compare the measurements of `mjsim bench` between two checkouts, which take turns.

    git worktree add ../before COMMIT && ../before/scripts/setup
    .venv/bin/python scripts/measure/against.py ../before [FIGURE]... [--cpu] [--runs 7] [--rounds 2]

Each checkout has a process of its own, with its own environment. For each benchmark both get ready, then measure in
turns, so that a slow minute of the machine affects both. A round starts both processes afresh. The ratio is the median
over all pairs of runs: above 1, this checkout is faster (or smaller) than the other one. The exit code is 1 when a
ratio is below what `--least` says.
"""

import argparse
import statistics
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import IO

HERE = Path(__file__).resolve().parents[2]
RATE = (" a second",)
"""Endings of units for which higher values are better; for all others, lower ones are."""
WORKER = """
import os, sys, time
answers = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)
from mjsim.bench.figures import FIGURES
known = {figure.name: figure for figure in FIGURES}
clock = getattr(time, sys.argv[1])
print(*(f"{name}={figure.unit}" for name, figure in known.items()), sep=";", file=answers)
for line in sys.stdin:
    with known[line.strip()].prepare() as once:
        print("ready", file=answers)
        while sys.stdin.readline().strip() == "run":
            print(once(clock), file=answers)
"""


class Bench:
    """The measurements of one checkout, made in a separate process."""

    def __init__(self, checkout: Path, *, clock: str) -> None:
        """Start the process."""
        command = [str(checkout / ".venv" / "bin" / "python"), "-c", WORKER, clock]
        self._process = subprocess.Popen(
            command, cwd=checkout, text=True, bufsize=1, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._in: IO[str] = self._process.stdin
        self._out: IO[str] = self._process.stdout
        self.units = dict(part.split("=") for part in self._answer().split(";"))

    def ask(self, line: str) -> str:
        """Send a line; return the answer."""
        self._in.write(f"{line}\n")
        return self._answer()

    def _answer(self) -> str:
        line = self._out.readline()
        if not line:
            raise SystemExit(f"{self._process.args[0]} ended")
        return line.strip()

    def done(self) -> None:
        """End the current measurement."""
        self._in.write("done\n")

    def close(self) -> None:
        """End the process."""
        self._in.close()
        self._process.wait()


def main() -> None:
    """Measure and print a table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("other", type=Path, help="the other checkout")
    parser.add_argument("figures", nargs="*", metavar="FIGURE", help="all that both have unless given")
    parser.add_argument("--runs", type=int, default=7, help="pairs a round")
    parser.add_argument("--rounds", type=int, default=2, help="how often both processes are started")
    parser.add_argument("--least", type=float, default=0.97, help="a smaller ratio fails")
    parser.add_argument("--cpu", action="store_true", help="processor time, for a busy machine")
    given = parser.parse_intermixed_args()
    clock = "process_time" if given.cpu else "perf_counter"
    pairs: dict[str, list[tuple[float, float]]] = {}
    units: dict[str, str] = {}
    for _ in range(given.rounds):
        with ExitStack() as stack:
            other, ours = (Bench(place, clock=clock) for place in (given.other.resolve(), HERE))
            stack.callback(other.close)
            stack.callback(ours.close)
            units = ours.units
            for name in given.figures or [name for name in units if name in other.units]:
                pairs.setdefault(name, []).extend(measured(other, ours, name, runs=given.runs))
                print(line(name, pairs[name], units[name], least=given.least)[0], file=sys.stderr, flush=True)
    sys.exit(not table(pairs, units, least=given.least))


def measured(other: Bench, ours: Bench, name: str, *, runs: int) -> list[tuple[float, float]]:
    """Return the values of a measurement in turns: one of the other checkout, one of ours."""
    for bench in (other, ours):
        bench.ask(name)
    pairs = []
    for run in range(runs):
        first, second = (other, ours) if run % 2 == 0 else (ours, other)
        values = {first: float(first.ask("run")), second: float(second.ask("run"))}
        pairs.append((values[other], values[ours]))
    for bench in (other, ours):
        bench.done()
    return pairs


def table(pairs: dict[str, list[tuple[float, float]]], units: dict[str, str], *, least: float) -> bool:
    """Print a line for each measurement; return whether all hold."""
    print(f"{'figure':<22}{'other':>10}{'ours':>10}{'ratio':>8}{'quartiles':>16}  unit")
    lines = [line(name, values, units[name], least=least) for name, values in pairs.items()]
    print(*(text for text, _ in lines), sep="\n")
    return all(holds for _, holds in lines)


def line(name: str, values: list[tuple[float, float]], unit: str, *, least: float) -> tuple[str, bool]:
    """Return the line of a measurement, and whether it holds."""
    ratios = sorted(ours / other if unit.endswith(RATE) else other / ours for other, ours in values)
    ratio = statistics.median(ratios)
    low, _, high = statistics.quantiles(ratios, n=4) if len(ratios) > 1 else (ratio, ratio, ratio)
    medians = "".join(f"{statistics.median(column):>10.4g}" for column in zip(*values, strict=True))
    mark = "" if ratio >= least else "  SLOWER"
    return f"{name:<22}{medians}{ratio:>8.3f}{low:>8.3f}{high:>8.3f}  {unit}{mark}", not mark


if __name__ == "__main__":
    main()
