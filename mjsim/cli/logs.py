"""The command `import-log`: the log of a real robot -> a recording."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.errors import UsageError
from mjsim.progress import tracked


def import_log(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Text files of MRCLAM or of Victoria Park.")],
    output: Annotated[Path, typer.Option("-o", metavar="RUN.mcap", help="The recording to write.")],
    robot: Annotated[list[int] | None, typer.Option(metavar="N", help="Of MRCLAM; may be repeated; all.")] = None,
    rate: Annotated[float | None, typer.Option(help="Ticks a second.", min=0.1, max=250)] = None,
    begin: Annotated[float, typer.Option(help="Leave so much of the beginning out [s].", min=0.0)] = 0.0,
    seconds: Annotated[float | None, typer.Option(help="Take so much of it [s].", min=0.0)] = None,
    known_map: Annotated[bool, typer.Option("--known-map", help="Of MRCLAM; modules know the landmarks.")] = False,
    distance_noise: Annotated[float | None, typer.Option(help="Of odometry [m/sqrt(m)].", min=0.0)] = None,
    turn_noise: Annotated[float | None, typer.Option(help="Of odometry [rad/sqrt(rad)].", min=0.0)] = None,
    veer_noise: Annotated[float | None, typer.Option(help="Of odometry [rad/sqrt(m)].", min=0.0)] = None,
    range_noise: Annotated[float | None, typer.Option(help="Of a sighting [m].", min=1e-6)] = None,
    bearing_noise_deg: Annotated[float | None, typer.Option(help="Of a sighting.", min=1e-6)] = None,
    overwrite: Overwrite = False,
) -> None:
    """Make a recording of a real robot's log; which kind it is, its files tell."""
    from mjsim.logs import import_mrclam, import_victoria_park, mrclam, victoria_park

    kind = _kind(folder)
    defaults = mrclam if kind == "mrclam" else victoria_park
    given = {"distance": distance_noise, "turn": turn_noise, "veer": veer_noise}
    motion = replace(defaults.MOTION, **{name: value for name, value in given.items() if value is not None})
    sighting = (
        defaults.RANGE if range_noise is None else range_noise,
        defaults.BEARING if bearing_noise_deg is None else math.radians(bearing_noise_deg),
    )
    with tracked(f"import {folder.name}", total=100.0, unit="%") as advance:
        if kind == "mrclam":
            import_mrclam(
                folder,
                robots=robot,
                rate_hz=rate or mrclam.RATE,
                begin=begin,
                seconds=seconds,
                known_map=known_map,
                motion=motion,
                sighting=sighting,
                record=output,
                progress=advance,
                overwrite=overwrite,
            )
        else:
            if robot or known_map:
                raise UsageError("Victoria Park has one car and no known map; leave out --robot and --known-map")
            import_victoria_park(
                folder,
                rate_hz=rate or victoria_park.RATE,
                begin=begin,
                seconds=seconds,
                motion=motion,
                sighting=sighting,
                record=output,
                progress=advance,
                overwrite=overwrite,
            )
    print(output)


def _kind(folder: Path) -> str:
    """Return whose files there are in a folder."""
    if not folder.is_dir():
        raise UsageError(f"'{folder}' is not a folder; name the one that holds the text files")
    if (folder / "Barcodes.dat").exists():
        return "mrclam"
    if (folder / "inputs.dat").exists():
        return "victoria park"
    raise UsageError(f"no Barcodes.dat (MRCLAM) and no inputs.dat (Victoria Park) in '{folder}'; it is no log we read")
