"""The command `octave`: runs a MATLAB script, and writes its figures."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.errors import ModuleFault
from mjsim.progress import say


def octave(
    script: Annotated[Path, typer.Argument(metavar="SCRIPT.m", help="Script, or function without arguments.")],
    output: Annotated[
        Path | None, typer.Option("-o", metavar="DIR", help="Folder for its figures; default: out/SCRIPT.")
    ] = None,
    studio: Annotated[
        bool, typer.Option("--studio", help="Open the sliders of `drivebot` and `teach` in the browser, until Ctrl-C.")
    ] = False,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser; print the address.")] = False,
    overwrite: Overwrite = False,
) -> None:
    """Run a MATLAB script in GNU Octave.

    The script can use the functions of the old robotics toolbox for arms. Its figures become PNG and PDF files, moving
    arms also videos. Its output is printed.
    """
    from mjsim.toolbox import run_script

    folder = Path("out") / script.stem if output is None else output
    found = run_script(script, folder, overwrite=overwrite)
    for note in found.notes:
        say(note)
    for file in found.files:
        print(file)
    if found.error is not None:
        raise ModuleFault(found.error)
    if found.driven is not None and studio:
        from mjsim.cli.arm_command import drive_arm

        drive_arm(str(found.driven), None, {}, no_browser=no_browser)
    elif found.driven is not None:
        say(f"for its sliders: --studio, or mjsim arm {found.driven} --drive")
