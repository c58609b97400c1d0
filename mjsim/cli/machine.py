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
        typer.Option("-o", metavar="PNG", help="The test picture; out/doctor.png unless given, or doctor-2.png."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Tell which OpenGL backend works and how fast, with a test picture, and whether GNU Octave is there."""
    from mjsim.doctor import diagnose, report_lines

    default = Path("out") / "doctor.png"
    picture = output or (default if overwrite else free_path(default))
    diagnosis = diagnose(picture, overwrite=overwrite)
    print(*report_lines(diagnosis), sep="\n")
    if diagnosis.backend is None:
        raise typer.Exit(1)


def bench(
    only: Annotated[list[str] | None, typer.Argument(metavar="[FIGURE]...", help="Figures to measure; all.")] = None,
    runs: Annotated[int, typer.Option(help="How often each is measured.", min=1)] = 5,
    peers: Annotated[bool, typer.Option("--peers", help="Measure ir-sim and PyBullet too.")] = False,
    cpu: Annotated[bool, typer.Option("--cpu", help="Processor time, for busy machines.")] = False,
) -> None:
    """Measure speeds on this machine: name, median, min, max, unit, runs; then what is asked of their ratios."""
    from mjsim.bench import measure

    for line in measure(only or (), runs=runs, peers=peers, clock=time.process_time if cpu else time.perf_counter):
        print(line, flush=True)
