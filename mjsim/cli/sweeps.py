"""The command `sweep`: many runs, one table."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Formats, WorldFile
from mjsim.errors import how_to_install
from mjsim.progress import counted, say


def sweep(
    world: WorldFile,
    seeds: Annotated[
        str, typer.Option(metavar="0:50", help="Seeds, one run each: 0:50 means 0 to 49; or a list: 1,2,7.")
    ],
    output: Annotated[
        Path, typer.Option("-o", metavar="DIR", help="Folder for the results; a sweep begun there is resumed.")
    ],
    workers: Annotated[
        int | None, typer.Option(metavar="N", help="Number of processes; default: one per core.", min=1)
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Run on this Dask cluster instead, such as tcp://10.0.0.5:8786."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=V1,V2", help="Values to try: robots.scout.odometry.scale=1,1.05"),
    ] = None,
    seconds: Annotated[float | None, typer.Option(help="Duration of each run, in simulated seconds.", min=0.0)] = None,
    robot: Annotated[str | None, typer.Option(metavar="R", help="The robot in the table; default: all.")] = None,
    keep: Annotated[bool, typer.Option("--keep", help="Keep the recording of each run.")] = False,
    formats: Formats = "png",
) -> None:
    """Run a world with many seeds and settings.

    Write a table, means with confidence intervals, and plots.
    """
    from mjsim.modules import load_runnable
    from mjsim.report import parse_formats
    from mjsim.sweep import SweepPlan, key_lines, parse_seeds, parse_settings, run_plan

    kinds = parse_formats(formats)
    checked = load_runnable(world)
    plan = SweepPlan(
        seeds=parse_seeds(seeds), settings=parse_settings(settings or ()), seconds=seconds, robot=robot, keep=keep
    )
    with counted(f"sweep {checked.name}", total=len(plan), unit="runs") as advance:
        result = run_plan(checked, plan, output, workers=workers, dask=dask, formats=kinds, progress=advance)
    print(*key_lines(result.summary), sep="\n")
    table = result.folder / "table.parquet"
    if not table.exists():
        table = table.with_suffix(".csv")
        say(f"for the table as Parquet, install pyarrow: {how_to_install('pyarrow')}")
    print(table)
    if result.failed:
        for name, error in list(result.failed.items())[:10]:
            say(f"run {name} failed: {error}")
        say(f"{len(result.failed)} of {len(plan)} runs failed")
        raise typer.Exit(1)
