"""The commands `new` and `export-world`: worlds from what people have, and out to what others read."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from mjsim.cli.arguments import Overwrite, WorldFile
from mjsim.cli.robots import (
    DriveKind,
    Forward,
    LeftWheel,
    Package,
    RightWheel,
    RobotFrom,
    Steering,
    Wished,
    XacroArgument,
    write_robot,
)
from mjsim.errors import UsageError
from mjsim.output import require_free, write_file
from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.world import Use


def new(
    source: Annotated[
        Path | None,
        typer.Option("--from", metavar="FILE", help="A map's YAML file, an SVG or DXF drawing, a landmark map (.mat)."),
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
    overwrite: Annotated[bool, typer.Option("--overwrite", "--force", help="Replace a file that exists.")] = False,
    robot: Annotated[
        str | None, typer.Option(metavar="PRESET", help="Which robot is put into it; the pioneer3dx unless given.")
    ] = None,
    lidar: Annotated[
        str | None, typer.Option(metavar="NAME", help="A lidar for it: lds-01, lds-02, hokuyo-ust-10lx, sick-lms111.")
    ] = None,
    estimator: Annotated[
        str | None,
        typer.Option(
            metavar="SPEC",
            help="How it finds out where it is: monte_carlo, lidar_slam, or module:Class{key: value}.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Of the maze or the things.", min=0)] = 1,
    cell: Annotated[float, typer.Option(help="Side of a cell of the maze [m].")] = 1.5,
    beacons: Annotated[int, typer.Option(help="Markers along the robot's way through the maze.", min=0)] = 0,
    scale: Annotated[
        float | None, typer.Option(help="Metres to one unit of a drawing or a landmark map.", min=1e-6)
    ] = None,
    thickness: Annotated[
        float | None, typer.Option(help="Of walls in a drawing [m]; as the lines are drawn unless given.", min=0.01)
    ] = None,
    layer: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Layer of the drawing that holds walls; may be repeated.")
    ] = None,
    furniture: Annotated[
        Literal["keep", "drop"], typer.Option(help="Whether furniture of a drawing becomes obstacles.")
    ] = "keep",
    no_robot: Annotated[bool, typer.Option("--no-robot", help="Leave the robot out.")] = False,
    robot_from: RobotFrom = None,
    left_wheel: LeftWheel = None,
    right_wheel: RightWheel = None,
    steering: Steering = None,
    drive: DriveKind = None,
    forward: Forward = None,
    package: Package = None,
    arg: XacroArgument = None,
) -> None:
    """Write a new world: from the map of a robot or a drawing, a maze, a cluttered room, a template; or a robot."""
    if robot_from is not None:
        if any(value is not None for value in (source, maze, clutter, template, robot)):
            raise UsageError("--robot-from makes the preset of a robot; bring the world with a command of its own")
        wishes = Wished(left_wheel or (), right_wheel or (), steering or (), drive, forward, package or (), arg or ())
        write_robot(robot_from, output, wishes, overwrite=overwrite)
        return
    from mjsim.exchange import Newcomer, Reading, bring_clutter, bring_file, bring_maze, bring_template, name_of

    if sum(value is not None for value in (source, maze, clutter, template)) != 1:
        raise UsageError(
            "a world is made from one thing; give one of --from FILE, --maze 9x9, --clutter 12x10, --template NAME,"
            " --robot-from FILE"
        )
    if template is not None and (robot is not None or no_robot):
        raise UsageError("a template has a robot of its own; change it in the new file")
    if source is None and (lidar is not None or estimator is not None):
        raise UsageError("--lidar and --estimator are for worlds from maps and drawings; they go with --from FILE")
    if no_robot and (lidar is not None or estimator is not None):
        raise UsageError("--lidar and --estimator need a robot; leave out --no-robot")
    if output is not None:
        require_free(output, overwrite=overwrite)
    preset = None if no_robot else _preset(robot or "pioneer3dx")
    name = None if output is None else name_of(output)
    if source is not None:
        use = None if estimator is None else _estimator(estimator, output)
        newcomer = None if preset is None else Newcomer(preset, lidar, use)
        reading = Reading(scale, thickness, layer or (), furniture == "keep")
        brought = bring_file(source, robot=newcomer, reading=reading)
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
    print(write_file(output, brought.text.encode(), overwrite=overwrite))


def _preset(name: str) -> str:
    """Return the name of a robot that comes with mjsim.

    Raises:
        UsageError: There is none such.
    """
    from mjsim.errors import did_you_mean
    from mjsim.world import preset_names

    if name.endswith((".yaml", ".yml")):
        raise UsageError(f"'{name}' is the file of a robot; make the world, then write preset: {name} in it")
    if name not in preset_names():
        raise UsageError(f"no preset '{name}'{did_you_mean(name, preset_names())}")
    return name


def _estimator(spec: str, output: Path | None) -> "Use":
    """Return the module that a text names, written as the new world names it; it is looked at, not kept.

    Raises:
        UsageError: There is none such, or a world at this place cannot name its file.
    """
    from mjsim.exchange import ESTIMATORS
    from mjsim.modules import module_of

    name, brace, rest = spec.partition("{")
    if ":" not in name and name.strip() not in ESTIMATORS:
        known = ", ".join(ESTIMATORS)
        raise UsageError(f"no estimator '{name:.60}'; write {known}, module:Class or file.py:Class")
    _, use = module_of(ESTIMATORS.get(name.strip(), name) + brace + rest, role="estimator", robot="scout")
    place, _, called = use.use.rpartition(":")
    if not place.endswith(".py"):
        return use
    folder = (output or Path("world.yaml")).resolve().parent
    if not Path(place).resolve().is_relative_to(folder):
        raise UsageError(f"'{place}' must be in the folder of the new world, '{folder}'; move one of them")
    return use.model_copy(update={"use": f"{Path(place).resolve().relative_to(folder)}:{called}"})


def export_world(
    world: WorldFile,
    map: Annotated[Path | None, typer.Option(metavar="DIR", help="A map for Nav2: map.yaml and map.pgm.")] = None,
    resolution: Annotated[float, typer.Option(help="Side of a cell of the map [m].")] = 0.05,
    sdf: Annotated[Path | None, typer.Option(metavar="FILE", help="SDF for Gazebo, its pictures beside it.")] = None,
    usd: Annotated[Path | None, typer.Option(metavar="FILE", help="USD, robots too; needs usd-core.")] = None,
    svg: Annotated[Path | None, typer.Option(metavar="FILE", help="A plan to scale, with names.")] = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a world in other formats: for Nav2, for Gazebo, for films, for print."""
    from mjsim.exchange import write_map, write_sdf, write_svg
    from mjsim.world import load_checked

    if all(file is None for file in (map, sdf, usd, svg)):
        raise UsageError("nothing to write; name at least one of --map DIR, --sdf FILE, --usd FILE, --svg FILE")
    require_free(*(file for file in (sdf, usd, svg) if file is not None), overwrite=overwrite)
    checked = load_checked(world)
    if map is not None:
        print(write_map(checked, map, resolution=resolution, overwrite=overwrite))
    if sdf is not None:
        print(write_sdf(checked, sdf, overwrite=overwrite))
    if usd is not None:
        from mjsim.compile import write_usd

        print(write_usd(checked, usd, overwrite=overwrite))
    if svg is not None:
        print(write_svg(checked, svg, overwrite=overwrite))
