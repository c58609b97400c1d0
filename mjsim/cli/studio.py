"""The command `studio`: the page to edit worlds, to run them, and to look at what was recorded."""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim.cli.page import addresses_on_signal, has_screen, how_to_get_another, read_token
from mjsim.errors import UsageError
from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.web import Studio


def studio(
    world: Annotated[
        str | None,
        typer.Argument(metavar="[WORLD]", help="A world file, a shipped world, or a folder; the working folder."),
    ] = None,
    port: Annotated[int, typer.Option(help="Of the page; 0 takes a free one.", min=0, max=65535)] = 0,
    host: Annotated[str, typer.Option(metavar="ADDRESS", help="To listen at; 0.0.0.0 lets other machines in.")] = (
        "127.0.0.1"
    ),
    token: Annotated[
        str | None,
        typer.Option(metavar="file:PATH|env:NAME", help="Where the token stands that lets in any browser, to log in."),
    ] = None,
    no_token: Annotated[
        bool, typer.Option("--no-token", help="Let in every user of this machine; they can then run code as you.")
    ] = False,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Do not open a browser; print an address that works once.")
    ] = False,
) -> None:
    """Edit worlds, run them and look at recordings in the browser."""
    from mjsim.web import Studio

    folder, name = opened(world)
    word = None if token is None else read_token(token)
    with (
        Studio(folder, world=name, host=host, port=port, token=word, without_token=no_token) as page,
        addresses_on_signal(lambda: page.url),
    ):
        if no_token:
            say("warning: without a token every user and program of this machine can run code as you through the page")
        if no_browser or not has_screen():
            _print_address(page)
        else:
            say(f"the studio is at {page.address} and opens in your browser; Ctrl-C ends it")
            page.open(failed=lambda: _print_address(page))
        # This is how it is meant to end.
        with suppress(KeyboardInterrupt):
            page.wait()


def _print_address(page: "Studio") -> None:
    say(f"the studio is at {page.url} ; Ctrl-C ends it")
    if page.asks_for_token:
        say(f"that address works once, within 5 minutes{how_to_get_another()}")


def opened(world: str | None) -> tuple[Path, str | None]:
    """Return the folder to be opened, and the world in it: the working folder, where `mjsim run` puts recordings."""
    from mjsim.web import shipped_name
    from mjsim.world import world_path

    here = Path.cwd()
    if world is None:
        return here, None
    if (shipped := shipped_name(world)) is not None:
        return here, shipped
    if Path(world).is_dir():
        return Path(world), None
    path = world_path(world).resolve()
    if not path.is_file():
        raise UsageError(f"no file '{world}'; name a world file or a folder")
    # A home is no folder of worlds: all that lies below is looked through.
    if path.is_relative_to(here) and here not in (Path.home(), Path(here.anchor)):
        return here, path.relative_to(here).as_posix()
    return path.parent, path.name
