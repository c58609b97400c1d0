"""Robots brought in by the command, as tests do it."""

import contextlib
import io
from collections.abc import Iterator
from pathlib import Path

import pytest

from mjsim import exchange
from mjsim.cli import main
from mjsim.exchange.robots import bring_robot, slip


def typed(*line: str) -> tuple[int, str]:
    """Return the exit code of a command, and what it says to people."""
    said = io.StringIO()
    with (
        pytest.raises(SystemExit) as caught,
        contextlib.redirect_stderr(said),
        contextlib.redirect_stdout(io.StringIO()),
    ):
        main(line)
    return int(caught.value.code or 0), said.getvalue()


def brought(path: Path, folder: Path, *options: str) -> tuple[Path, str]:
    """Return the preset that the command writes, and what it says."""
    preset = folder / f"{path.stem}.yaml"
    code, said = typed("new", "--robot-from", str(path), "-o", str(preset), *options)
    assert code == 0, said
    return preset, said


@contextlib.contextmanager
def few_drives(count: int = 10) -> Iterator[None]:
    """Let a robot's slip be learned from so many drives of 10 s, not 80: 10 tell its track as well.

    Robots are read in this process meanwhile, which alone has these numbers; two on rollers are enough, not five.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exchange, "bring_robot", bring_robot)
        fewer = {"DRIVE_COUNT": count, "TICKS_PER_DRIVE": 250, "ON_ROLLERS": 2, "ROBOTS_AT_ONCE": 2}
        for name, number in fewer.items():
            patch.setattr(slip, name, number)
        yield
