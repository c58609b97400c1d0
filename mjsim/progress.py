"""How far a long command is: a bar on a terminal, plain lines elsewhere; all of it on stderr."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

EVERY = 10.0
"""Least time between two plain lines [s]."""


def say(text: str) -> None:
    """Print a line for people."""
    print(f"mjsim: {text}", file=sys.stderr, flush=True)


@contextmanager
def tracked(label: str, *, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    """Show progress while the block runs; the function that it gets is called with how much is done."""
    with _bar(label, total, unit) if sys.stderr.isatty() else _lines(label, total, unit) as advance:
        yield advance


@contextmanager
def _bar(label: str, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn(f"{{task.completed:.0f}}/{{task.total:.0f}} {unit}"),
        TextColumn("{task.fields[pace]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True)) as progress:
        task = progress.add_task(label, total=total, pace="")
        began, shown = time.perf_counter(), 0.0

        def advance(done: float) -> None:
            nonlocal shown
            now = time.perf_counter()
            # A tick costs less than a redraw of the bar.
            if now - shown > 0.1 or done >= total:
                shown = now
                progress.update(task, completed=done, pace=_pace(done, now - began, unit))

        yield advance


@contextmanager
def _lines(label: str, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    began = shown = time.perf_counter()
    reached = 0.0

    def advance(done: float) -> None:
        nonlocal shown, reached
        reached = done
        now = time.perf_counter()
        if now - shown >= EVERY:
            shown = now
            say(f"{label}: {done:.0f} of {total:.0f} {unit}{_pace(done, now - began, unit)}")

    yield advance
    seconds = time.perf_counter() - began
    say(f"{label}: {reached:.0f} of {total:.0f} {unit} in {seconds:.1f} s{_pace(reached, seconds, unit)}")


def _pace(done: float, seconds: float, unit: str) -> str:
    if seconds <= 0.0:
        return ""
    return f" ({done / seconds:.1f} times real time)" if unit == "s" else f" ({done / seconds:.0f} {unit} a second)"
