"""The commands that read world files: `check`, `fmt`, `compile`, `show` and `schema`."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from mjsim.cli.arguments import Overwrite, WorldFile, WorldFiles
from mjsim.errors import UsageError, WorldError
from mjsim.output import require_free
from mjsim.progress import say
from mjsim.progress import show as show_line


def check(worlds: WorldFiles) -> None:
    """Check world files, and print every error.

    Print nothing if there is none.
    """
    right = [_is_right(path) for path in worlds]
    if not all(right):
        raise typer.Exit(2)


def fmt(
    worlds: WorldFiles,
    check: Annotated[bool, typer.Option("--check", help="Change nothing; exit with 1 if a file would change.")] = False,
) -> None:
    """Format world files; comments are kept.

    Every value is kept, too. Print the names of the changed files.
    """
    from mjsim.world import format_file

    code = 0
    for path in worlds:
        try:
            if format_file(path, write=not check):
                print(path)
                code = max(code, 1 if check else 0)
        except (WorldError, UsageError) as error:
            show_line(str(error))
            code = 2
    if code:
        raise typer.Exit(code)


def compile(
    world: WorldFile,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for scene.xml and assets.")],
    overwrite: Overwrite = False,
) -> None:
    """Write the scene as MJCF, for MuJoCo without mjsim.

    The assets are in a folder beside it.
    """
    from mjsim.compile import compile_world, compiled, export_scene, refused_links
    from mjsim.light import light_of
    from mjsim.world import load_checked

    checked = load_checked(world)
    place = export_scene(checked, output, overwrite=overwrite)
    if checked.shading == "baked":
        # Not part of the folder: MuJoCo has no light maps. Runs and videos then find it in the cache.
        light_of(checked, compiled(compile_world(checked)))
    print(place)
    for name in refused_links(checked):
        say(
            f"MuJoCo refuses the mass or inertia of {name}; scene.xml has the nearest valid one, runs use the exact one"
        )


def show(
    world: WorldFile,
    output: Annotated[Path, typer.Option("-o", metavar="PNG", help="The picture to write.")],
    camera: Annotated[
        str | None,
        typer.Option(
            "--camera",
            "--view",
            metavar="NAME",
            help="Instead of the plan: ROBOT/CAMERA, PERSON/left_eye, ROBOT/chase or overview.",
        ),
    ] = None,
    labels: Annotated[
        Literal["none", "walls", "all"] | None,
        typer.Option(help="Names to show; default: robots, beacons, doors, lamps, and objects where there is room."),
    ] = None,
    beside: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Also draw the map (YAML), SVG or DXF from which the world was made."),
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """Draw the plan of a world, or the image of a camera.

    The plan is for printing; the image shows the start of a run.
    """
    from mjsim.video import draw_beside, draw_world, take_picture
    from mjsim.world import load_checked

    if camera is not None and (labels is not None or beside is not None):
        raise UsageError("--labels and --beside are for the plan; leave out --camera")
    require_free(output, overwrite=overwrite)
    checked = load_checked(world)
    if beside is not None:
        from mjsim.exchange import read_original

        draw_beside(checked, read_original(beside, world=world), output, labels=labels, overwrite=overwrite)
    elif camera is None:
        draw_world(checked, output, labels=labels, overwrite=overwrite)
    else:
        take_picture(checked, camera, output, overwrite=overwrite)
    print(output)


def schema() -> None:
    """Print the JSON Schema of world files, for editors.

    Editors use it for completion and to mark errors.
    """
    import json

    from mjsim.world import editor_schema

    print(json.dumps(editor_schema(), indent=1))


def _is_right(path: str) -> bool:
    """Return whether a world file is free of errors; print the errors, and notes on what may surprise its user."""
    from mjsim.modules import check_modules, check_pictures, notes_on
    from mjsim.world import MechanismModel, ModelBody, ModelObstacle, check_world, load_world

    try:
        world = load_world(path)
        if problems := [*check_world(world), *check_modules(world), *check_pictures(world)]:
            raise WorldError(problems)
        parts = (body for mechanism in world.mechanisms for body in mechanism.bodies)
        bodies = (robot.body for robot in world.robots)
        kinds = ModelObstacle | ModelBody | MechanismModel
        if any(isinstance(item, kinds) for item in (*world.obstacles, *bodies, *parts)):
            from mjsim.compile import check_models

            check_models(world)
    except (WorldError, UsageError) as error:
        show_line(str(error))
        return False
    for note in notes_on(world):
        show_line(str(note))
    return True
