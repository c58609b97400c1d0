"""The command `experiments`: the classic experiments."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.progress import say, tracked


def experiments(
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for the page.")],
    only: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help="bump, odometry, avoidance, triangulation, slam.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Run the classic experiments.

    Update a page with results, plots and verdicts after each. The same command continues an interrupted page.
    """
    from mjsim.experiments import EXPERIMENTS, lines, run_experiments

    names = only or list(EXPERIMENTS)
    with tracked("experiments", total=len(names), unit="experiments") as advance:
        results = run_experiments(
            output,
            only=names,
            progress=lambda name, share: advance(names.index(name) + share),
            overwrite=overwrite,
        )
    print(*lines(results), sep="\n")
    say(f"open {output / 'index.html'}")
    if not all(result.holds for result in results):
        raise typer.Exit(1)
