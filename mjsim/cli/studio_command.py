"""The command `studio`: the page to edit worlds, run them and review recordings."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim.cli.page_access import addresses_on_signal, has_screen, how_to_get_another, read_token
from mjsim.errors import UsageError
from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.web import Studio


def studio(
    world: Annotated[
        str | None,
        typer.Argument(
            metavar="[WORLD]", help="A world file, a shipped world, or a folder; default: the working folder."
        ),
    ] = None,
    port: Annotated[int, typer.Option(help="Port of the page; 0 selects a free one.", min=0, max=65535)] = 0,
    host: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Address to listen on; 0.0.0.0 allows access from other machines.")
    ] = ("127.0.0.1"),
    token: Annotated[
        str | None,
        typer.Option(
            metavar="file:PATH|env:NAME", help="File or variable with a token with which any browser can log in."
        ),
    ] = None,
    no_token: Annotated[
        bool,
        typer.Option(
            "--no-token", help="Let every user of this machine in without a token; they can then run code as you."
        ),
    ] = False,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Do not open a browser; print an address that works once.")
    ] = False,
) -> None:
    """Edit worlds, run them and review recordings in the browser."""
    from mjsim.web import Studio

    folder, name = opened(world)
    word = None if token is None else read_token(token)
    with (
        Studio(folder, world=name, host=host, port=port, token=word, without_token=no_token) as page,
        addresses_on_signal(lambda: page.url),
    ):
        if no_token:
            say("warning: without a token, every user and program on this machine can run code as you through the page")
        if no_browser or not has_screen():
            _print_address(page)
        else:
            say(f"the studio is at {page.address} and opens in your browser; Ctrl-C stops it")
            page.open(failed=lambda: _print_address(page))
        # This is the intended way to end it.
        with suppress(KeyboardInterrupt):
            page.wait()


def _print_address(page: "Studio") -> None:
    say(f"the studio is at {page.url} ; Ctrl-C stops it")
    if page.asks_for_token:
        say(f"that address works once, within 5 minutes{how_to_get_another()}")


def opened(world: str | None) -> tuple[Path, str | None]:
    """Return the folder to open and the world in it; usually the working folder, where `mjsim run` puts recordings."""
    from mjsim.web import shipped_name
    from mjsim.world import world_path

    folder = Path.cwd()
    if world is None:
        return folder, None
    if (shipped := shipped_name(world)) is not None:
        return folder, shipped
    if Path(world).is_dir():
        return Path(world), None
    path = world_path(world).resolve()
    if not path.is_file():
        raise UsageError(f"no file '{world}'; name a world file or a folder")
    if path.suffix.lower() not in (".yaml", ".yml"):
        raise UsageError(f"'{world}' is not a world file (.yaml); for a recording, open its folder and choose Review")
    # Never open a home folder: the studio searches everything below the folder.
    if path.is_relative_to(folder) and folder not in (Path.home(), Path(folder.anchor)):
        return folder, path.relative_to(folder).as_posix()
    return path.parent, path.name
