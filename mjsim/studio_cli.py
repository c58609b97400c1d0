"""The command `studio`: the page to edit worlds, to run them, and to look at what was recorded."""

import os
import sys
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from mjsim.errors import UsageError
from mjsim.progress import say


def studio(
    world: Annotated[
        Path | None, typer.Argument(metavar="[WORLD]", help="A world file, or a folder; the working folder.")
    ] = None,
    port: Annotated[int, typer.Option(help="Of the page; 0 takes a free one.", min=0, max=65535)] = 0,
    host: Annotated[str, typer.Option(metavar="ADDRESS", help="Another than this machine's own needs a token.")] = (
        "127.0.0.1"
    ),
    token: Annotated[str | None, typer.Option(help="That everybody must have; made for other addresses.")] = None,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Do not open a browser.")] = False,
) -> None:
    """Edit worlds, run them and look at recordings in the browser."""
    from mjsim.web.studio import Studio

    folder, name = _opened(world)
    with Studio(folder, world=name, host=host, port=port, token=token) as page:
        say(f"the studio is at {page.url}; Ctrl-C ends it")
        if not no_browser and _has_screen():
            webbrowser.open(page.url)
        # This is how it is meant to end.
        with suppress(KeyboardInterrupt):
            page.wait()


def _has_screen() -> bool:
    """Return whether a browser has somewhere to appear; one for terminals would take this one."""
    return sys.platform in ("darwin", "win32") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _opened(world: Path | None) -> tuple[Path, str | None]:
    """Return the folder to be opened, and the world in it: the working folder, where `mjsim run` puts recordings."""
    if world is None or world.is_dir():
        return world or Path.cwd(), None
    if not world.is_file():
        raise UsageError(f"no file '{world}'; name a world file or a folder")
    path, here = world.resolve(), Path.cwd()
    # A home is no folder of worlds: all that lies below is looked through.
    if path.is_relative_to(here) and here not in (Path.home(), Path(here.anchor)):
        return here, path.relative_to(here).as_posix()
    return path.parent, path.name
