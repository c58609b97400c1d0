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
    maze: Annotated[str | None, typer.Option(metavar="9x9", help="A maze of so many cells.")] = None,
    clutter: Annotated[
        str | None, typer.Option(metavar="12x10", help="A room of so many metres, full of things.")
    ] = None,
    template: Annotated[
        str | None, typer.Option(metavar="NAME", help="A shipped world: office, corridor, empty or gallery.")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="WORLD.yaml", help="The file; printed unless given.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
    robot: Annotated[
        str | None, typer.Option(metavar="PRESET", help="Which robot is put into it; the pioneer3dx unless given.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the maze or the things.", min=0)] = 1,
    cell: Annotated[float, typer.Option(help="Side of a cell of the maze [m].")] = 1.5,
    beacons: Annotated[int, typer.Option(help="Markers along the robot's way through the maze.", min=0)] = 0,
    scale: Annotated[float | None, typer.Option(help="Metres to one unit of the drawing.", min=1e-6)] = None,
    thickness: Annotated[
        float | None, typer.Option(help="Of walls in a drawing [m]; as the lines are drawn unless given.", min=0.01)
    ] = None,
    layer: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Layer of the drawing that holds walls; may be repeated.")
    ] = None,
    no_robot: Annotated[bool, typer.Option("--no-robot", help="Leave the robot out.")] = False,
) -> None:
    """Write a new world: from the map of a robot or a drawing, a maze, a cluttered room, or a template."""
    from mjsim.exchange.bring import bring_clutter, bring_file, bring_maze, bring_template
    from mjsim.exchange.maps import name_of

    if sum(value is not None for value in (source, maze, clutter, template)) != 1:
        raise UsageError(
            "a world is made from one thing; give one of --from FILE, --maze 9x9, --clutter 12x10, --template NAME"
        )
    if template is not None and (robot is not None or no_robot):
        raise UsageError("a template has a robot of its own; change it in the new file")
    if output is not None and output.exists() and not force:
        raise UsageError(f"'{output}' is there already; name another file or add --force")
    preset = None if no_robot else robot or "pioneer3dx"
    name = None if output is None else name_of(output)
    if source is not None:
        brought = bring_file(source, preset=preset, scale=scale, thickness=thickness, layers=layer or ())
    elif maze is not None:
        brought = bring_maze(maze, preset=preset, seed=seed, cell=cell, beacons=beacons, name=name)
    elif clutter is not None:
        brought = bring_clutter(clutter, preset=preset, seed=seed, name=name)
    else:
        brought = bring_template(str(template), name=name)
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
    sdf: Annotated[Path | None, typer.Option(metavar="FILE", help="SDF for Gazebo, its pictures beside it.")] = None,
    usd: Annotated[Path | None, typer.Option(metavar="FILE", help="USD, robots too; needs 'mjsim[usd]'.")] = None,
    svg: Annotated[Path | None, typer.Option(metavar="FILE", help="A plan to scale, with names.")] = None,
) -> None:
    """Write a world in other formats: for Nav2, for Gazebo, for films, for print."""
    from mjsim.exchange import write_map, write_sdf, write_svg
    from mjsim.world import load_checked

    if all(file is None for file in (map, sdf, usd, svg)):
        raise UsageError("nothing to write; name at least one of --map DIR, --sdf FILE, --usd FILE, --svg FILE")
    checked = load_checked(world)
    if map is not None:
        print(write_map(checked, map, resolution=resolution))
    if sdf is not None:
        print(write_sdf(checked, sdf))
    if usd is not None:
        from mjsim.compile.usd import write_usd

        print(write_usd(checked, usd))
    if svg is not None:
        print(write_svg(checked, svg))
