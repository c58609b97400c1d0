"""The command `worlds`: the worlds that come with mjsim."""

from pathlib import Path
from typing import Annotated

import typer

from mjsim.cli.arguments import Overwrite
from mjsim.errors import UsageError, did_you_mean
from mjsim.output import write_file


def worlds(
    copy: Annotated[str | None, typer.Option("--copy", metavar="NAME", help="Copy this world, to edit it.")] = None,
    output: Annotated[
        Path | None, typer.Option("-o", metavar="WORLD.yaml", help="File to write; default: NAME.yaml.")
    ] = None,
    overwrite: Overwrite = False,
) -> None:
    """List the worlds that come with mjsim, or copy one.

    The list has the name, the file and a short description of each.
    """
    from mjsim.world import own_copy, shipped_worlds, world_summary

    shipped = shipped_worlds()
    if copy is not None:
        if copy not in shipped:
            raise UsageError(f"no shipped world '{copy:.60}'{did_you_mean(copy, shipped)}")
        print(write_file(output or f"{copy}.yaml", own_copy(shipped[copy]).encode(), overwrite=overwrite))
        return
    if output is not None:
        raise UsageError("-o names the file of a copy; name the world to copy with --copy NAME")
    wide, long = max(map(len, shipped)), max(len(str(path)) for path in shipped.values())
    for name, path in shipped.items():
        print(f"{name:<{wide}}  {path!s:<{long}}  {world_summary(path)}")
