"""The command `replay`: other modules on a recording."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.progress import tracked


def replay(
    recording: Annotated[Path, typer.Argument(metavar="RUN.mcap", help="A recording.")],
    robot: Annotated[str, typer.Option(metavar="R", help="Whose observations are replayed.")],
    estimator: Annotated[
        str, typer.Option(metavar="SPEC", help="module:Class or file.py:Class; arguments in braces: {key: value}.")
    ],
    output: Annotated[Path, typer.Option("-o", metavar="RUN2.mcap", help="The recording to write.")],
    observer: Annotated[
        str | None, typer.Option(metavar="SPEC", help="The estimator gets the run's own sightings unless given.")
    ] = None,
) -> None:
    """Run other modules on the observations of a recording."""
    from mjsim.record import read_recording
    from mjsim.run.replay import replay as replay_run
    from mjsim.run.replay import require_observations
    from mjsim.run.spec import module_of

    run = read_recording(recording)
    require_observations(run, robot)
    believes, use = module_of(estimator)
    looks, uses = None, {"estimator": use}
    if observer is not None:
        looks, uses["observer"] = module_of(observer)
    with tracked(f"replay {recording.name}", total=float(run.time[-1]), unit="s") as advance:
        replay_run(run, robot=robot, estimator=believes, observer=looks, record=output, uses=uses, progress=advance)
    print(output)
