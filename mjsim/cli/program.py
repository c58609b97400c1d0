"""The command line: arguments in, one call, text out. Results go to stdout, everything for people to stderr."""

import atexit
import gc
import os
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Annotated

import typer

from mjsim.cli import (
    arms,
    exchange,
    experiments,
    logs,
    machine,
    new,
    recordings,
    reports,
    runs,
    shipped,
    studio,
    sweeps,
    worlds,
)
from mjsim.errors import MjsimError
from mjsim.progress import say

INTERRUPTED = 130
"""Exit code after Ctrl-C, as shells have it."""
COMMANDS: dict[str, Callable[..., None]] = {
    "doctor": machine.doctor,
    "new": new.new,
    "check": worlds.check,
    "worlds": shipped.worlds,
    "fmt": worlds.fmt,
    "show": worlds.show,
    "studio": studio.studio,
    "run": runs.run,
    "replay": runs.replay,
    "sweep": sweeps.sweep,
    "report": reports.report,
    "compare": reports.compare,
    "video": recordings.video,
    "export": recordings.export,
    "import-log": logs.import_log,
    "export-world": exchange.export_world,
    "arm": arms.arm,
    "compile": worlds.compile,
    "schema": worlds.schema,
    "experiments": experiments.experiments,
    "bench": machine.bench,
}
"""Each command by its name, in the order of the help."""

app = typer.Typer(
    name="mjsim",
    help="A simulator for navigation and SLAM of indoor wheeled robots, with real camera pictures.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"mjsim {version('mjsim')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    pass


for _name, _command in COMMANDS.items():
    app.command(_name)(_command)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0, 2 for the user's mistake, 1 for a failed run, 130 when interrupted."""
    # At the end Python looks through all objects once more, which takes as long as loading many of them.
    atexit.register(gc.freeze)
    # Pydantic would look through all installed packages for plugins, which takes as long as reading a world.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    code = _exit_code(lambda: app(args=arguments, prog_name="mjsim", standalone_mode=False))
    _name_unfinished_threads()
    sys.exit(code)


def _name_unfinished_threads() -> None:
    """Say which threads Python waits for at its end; ours are daemons, so a module started them."""
    for thread in threading.enumerate():
        if thread is not threading.main_thread() and not thread.daemon:
            say(f"waiting for thread '{thread.name}' of a module; end it, or make it a daemon")


def _exit_code(call: Callable[[], int | None]) -> int:
    try:
        code = call() or 0
    except typer.TyperException as error:
        # What was typed is wrong; without any command the message is the help.
        text = error.format_message()
        print(text if text.startswith("Usage") else f"mjsim: {text}", file=sys.stderr)
        return 2
    except MjsimError as error:
        print(error, file=sys.stderr)
        return error.exit_code
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:
        say("interrupted; what was recorded until then is closed and readable")
    return code
