"""The commands about the machine: `doctor` and `bench`."""

import time
from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.output import free_path


def doctor(
    output: Annotated[
        Path | None,
        typer.Option("-o", metavar="PNG", help="The test picture; default: out/doctor.png, or the next free name."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Report which OpenGL works, how fast, and what is missing.

    Render a test picture; list the optional packages and what each is for; look
    for GNU Octave; check whether untrusted files are read with limits.
    """
    from mjsim.doctor import diagnose, report_lines

    default = Path("out") / "doctor.png"
    picture = output or (default if overwrite else free_path(default))
    diagnosis = diagnose(picture, overwrite=overwrite)
    print(*report_lines(diagnosis), sep="\n")
    if diagnosis.backend is None:
        raise typer.Exit(1)


def bench(
    only: Annotated[
        list[str] | None,
        typer.Argument(metavar="[FIGURE]...", help="What to measure, such as sense-640x480; default: all."),
    ] = None,
    runs: Annotated[int, typer.Option(help="Number of repetitions of each measurement.", min=1)] = 5,
    peers: Annotated[bool, typer.Option("--peers", help="Also measure ir-sim and PyBullet.")] = False,
    cpu: Annotated[
        bool, typer.Option("--cpu", help="Measure processor time instead of wall-clock time, for busy machines.")
    ] = False,
) -> None:
    """Measure the speed of mjsim on this machine.

    Print name, median, min, max, unit and runs of each measurement, then the required ratios.
    """
    from mjsim.bench import measure

    for line in measure(only or (), runs=runs, peers=peers, clock=time.process_time if cpu else time.perf_counter):
        print(line, flush=True)
