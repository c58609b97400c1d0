"""The command `export-world`: writes worlds in other formats."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite, WorldFile
from mjsim.errors import UsageError
from mjsim.output import require_free


def export_world(
    world: WorldFile,
    map: Annotated[Path | None, typer.Option(metavar="DIR", help="A map for Nav2: map.yaml and map.pgm.")] = None,
    resolution: Annotated[float, typer.Option(help="Cell size of the map [m].")] = 0.05,
    sdf: Annotated[
        Path | None, typer.Option(metavar="FILE", help="SDF for Gazebo, with its pictures beside it.")
    ] = None,
    usd: Annotated[Path | None, typer.Option(metavar="FILE", help="USD, including robots; needs usd-core.")] = None,
    glb: Annotated[Path | None, typer.Option(metavar="FILE", help="glTF in one file, including robots.")] = None,
    svg: Annotated[Path | None, typer.Option(metavar="FILE", help="A plan to scale, with names.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a world in other formats.

    There are formats for Nav2, Gazebo, animation, 3-D viewers and print.
    """
    from mjsim.exchange import write_map, write_sdf, write_svg
    from mjsim.world import load_checked

    files = (sdf, usd, glb, svg)
    if all(file is None for file in (map, *files)):
        raise UsageError(
            "nothing to write; name at least one of --map DIR, --sdf FILE, --usd FILE, --glb FILE, --svg FILE"
        )
    require_free(*(file for file in files if file is not None), overwrite=overwrite)
    checked = load_checked(world)
    if map is not None:
        print(write_map(checked, map, resolution=resolution, overwrite=overwrite))
    if sdf is not None:
        print(write_sdf(checked, sdf, overwrite=overwrite))
    if usd is not None:
        from mjsim.compile import write_usd

        print(write_usd(checked, usd, overwrite=overwrite))
    if glb is not None:
        from mjsim.sim import write_glb

        print(write_glb(checked, glb, overwrite=overwrite))
    if svg is not None:
        print(write_svg(checked, svg, overwrite=overwrite))
