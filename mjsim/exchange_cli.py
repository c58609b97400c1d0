"""The commands `new` and `export-world`: worlds from what people have, and out to what others read."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.errors import UsageError
from mjsim.progress import say


def new(
    source: Annotated[
        Path | None, typer.Option("--from", metavar="FILE", help="A map's YAML file, an SVG or a DXF drawing.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="WORLD.yaml", help="The file; printed unless given.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
    robot: Annotated[str, typer.Option(metavar="PRESET", help="Which robot is put into it.")] = "pioneer3dx",
    scale: Annotated[float | None, typer.Option(help="Metres to one unit of the drawing.", min=1e-6)] = None,
    thickness: Annotated[
        float | None, typer.Option(help="Of walls in a drawing [m]; as the lines are drawn unless given.", min=0.01)
    ] = None,
    layer: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Layer of the drawing that holds walls; may be repeated.")
    ] = None,
    no_robot: Annotated[bool, typer.Option("--no-robot", help="Leave the robot out.")] = False,
) -> None:
    """Write a new world: from the map of a robot, or a drawing."""
    from mjsim.exchange.bring import bring_file

    if source is None:
        raise UsageError("nothing to make a world from; give --from FILE")
    if output is not None and output.exists() and not force:
        raise UsageError(f"'{output}' is there already; name another file or add --force")
    preset = None if no_robot else robot
    brought = bring_file(source, preset=preset, scale=scale, thickness=thickness, layers=layer or ())
    for line in brought.report:
        say(line)
    if output is None:
        print(brought.text, end="")
        return
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
        output.write_text(brought.text)
    except OSError as error:
        raise UsageError(f"cannot write '{output}': {error.strerror}") from error
    print(output)


def export_world(
    world: Annotated[Path, typer.Argument(metavar="WORLD", help="A world file.")],
    map: Annotated[Path | None, typer.Option(metavar="DIR", help="A map for Nav2: map.yaml and map.pgm.")] = None,
    resolution: Annotated[float, typer.Option(help="Side of a cell of the map [m].")] = 0.05,
) -> None:
    """Write a world in other formats."""
    from mjsim.exchange import write_map
    from mjsim.world import load_checked

    if map is None:
        raise UsageError("nothing to write; name --map DIR")
    checked = load_checked(world)
    print(write_map(checked, map, resolution=resolution))
