"""Progress of long commands, on stderr: a bar on a terminal, plain lines elsewhere, one line in a notebook."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from typing import Any

MIN_LINE_INTERVAL = 10.0
"""Minimum time between two plain lines [s]."""
COUNTED_EVERY = 60.0
"""The same for `counted`, whose items take long [s]."""


def say(text: str) -> None:
    """Print a message."""
    show(f"mjsim: {text}")


def show(line: str) -> None:
    """Print a finished line; it is lost if standard error is closed or full."""
    if sys.stderr is not None:
        with suppress(OSError, ValueError):
            print(line, file=sys.stderr, flush=True)


@contextmanager
def tracked(label: str, *, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    """Show progress while the block runs; the block calls the function it gets with the amount done."""
    with _bar(label, total, unit) if sys.stderr.isatty() else _lines(label, total, unit) as advance:
        yield advance


@contextmanager
def watched(label: str, *, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    """Show progress only where a person reads it: a bar on a terminal until the block ends, one line in a notebook."""
    if sys.stderr is not None and sys.stderr.isatty():
        shown = _bar(label, total, unit, transient=True)
    elif _in_notebook():
        shown = _line_in_notebook(label, total, unit)
    else:
        yield lambda done: None
        return
    with shown as advance:
        yield advance


def _in_notebook() -> bool:
    """Return whether this code runs in a notebook, not in a terminal."""
    python = sys.modules.get("IPython")
    shell = None if python is None else python.get_ipython()
    return shell is not None and type(shell).__name__ != "TerminalInteractiveShell"


@contextmanager
def _line_in_notebook(label: str, total: float, unit: str) -> Iterator[Callable[[float], None]]:
    """Show one line and update it."""
    from IPython.core import display_functions

    began = shown = time.perf_counter()
    display: Any = display_functions.display
    handle = display({"text/plain": f"{label} ..."}, raw=True, display_id=True)

    def advance(done: float) -> None:
        nonlocal shown
        now = time.perf_counter()
        if now - shown >= 0.2 or done >= total - 1e-9:
            shown = now
            text = f"{label}: {_amount(done, total)} of {_amount(total, total)} {unit}{_pace(done, now - began, unit)}"
            handle.update({"text/plain": text}, raw=True)

    yield advance


@contextmanager
def _bar(label: str, total: float, unit: str, *, transient: bool = False) -> Iterator[Callable[[float], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn(f"{{task.completed:.0f}}/{{task.total:.0f}} {unit}"),
        TextColumn("{task.fields[pace]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=transient) as progress:
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
        if now - shown >= MIN_LINE_INTERVAL:
            shown = now
            say(f"{label}: {_amount(done, total)} of {_amount(total, total)} {unit}{_pace(done, now - began, unit)}")

    yield advance
    seconds = time.perf_counter() - began
    amount = f"{_amount(reached, total)} of {_amount(total, total)} {unit}"
    say(f"{label}: {amount} in {seconds:.1f} s{_pace(reached, seconds, unit)}")


def _amount(done: float, total: float) -> str:
    """Return how much of a total is done; a small one keeps its decimals, so that 0.2 s is not shown as 0 s."""
    return f"{done:.0f}" if total >= 10.0 else f"{done:.2g}"


def _pace(done: float, seconds: float, unit: str) -> str:
    if seconds <= 0.0 or unit == "%":
        return ""
    return f" ({done / seconds:.1f} times real time)" if unit == "s" else f" ({done / seconds:.0f} {unit} a second)"


@contextmanager
def counted(label: str, *, total: int, unit: str) -> Iterator[Callable[[float], None]]:
    """Show how many long items are done, and the remaining time; one line per minute without a terminal.

    The first call of the function that the block gets reports how many were done before.
    """
    began = shown = time.perf_counter()
    before: float | None = None
    text = f"{label}: 0 of {total} {unit}"
    with _line_on_terminal(total) if sys.stderr.isatty() else nullcontext() as bar:

        def advance(done: float) -> None:
            nonlocal before, shown, text
            before = done if before is None else before
            now = time.perf_counter()
            left = (total - done) * (now - began) / (done - before) if done > before else None
            text = f"{label}: {done:.0f} of {total} {unit}"
            with_rest = text if left is None or done >= total else f"{text}, {_duration(left)} left"
            if bar is not None:
                bar(done, with_rest)
            elif now - shown >= COUNTED_EVERY and done < total:
                shown = now
                say(with_rest)

        yield advance
    say(f"{text} in {_duration(time.perf_counter() - began)}")


@contextmanager
def _line_on_terminal(total: int) -> Iterator[Callable[[float, str], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("", total=total)
        yield lambda done, text: progress.update(task, completed=done, description=text)


def _duration(seconds: float) -> str:
    """Format a duration: '8 s', '12 min', '3 h 20 min'."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    return f"{minutes} min" if minutes < 90 else f"{minutes // 60} h {minutes % 60} min"
