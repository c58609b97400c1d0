"""The command line: parses arguments and makes one call. Results go to stdout, messages to stderr."""

import atexit
import gc
import io
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from types import FrameType
from typing import Annotated, NoReturn

import typer

from mjsim.errors import MjsimError
from mjsim.progress import say, show

INTERRUPTED = 130
"""Exit code after Ctrl-C, as in shells."""
TERMINATING = tuple(getattr(signal, name) for name in ("SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Signals that end a command as Ctrl-C does: `kill`, `timeout`, services and containers send TERM, a closed terminal
HUP. The exit code is 128 + the number, as in shells."""
BROKEN_PIPE = 141
"""Exit code when nobody reads the output any more, as after `| head`."""
COMMANDS = {
    "doctor": "machine",
    "new": "new",
    "check": "worlds",
    "worlds": "worlds_command",
    "fmt": "worlds",
    "show": "worlds",
    "studio": "studio_command",
    "run": "run_commands",
    "replay": "run_commands",
    "bridge": "bridge_command",
    "sweep": "sweeps",
    "report": "reports",
    "compare": "reports",
    "video": "recordings",
    "export": "recordings",
    "import-log": "logs",
    "calibrate": "logs",
    "export-world": "exchange",
    "arm": "arm_command",
    "lab": "laboratory",
    "octave": "octave",
    "ergonomics": "ergonomics",
    "compile": "worlds",
    "schema": "worlds",
    "experiments": "experiments",
    "bench": "machine",
}
"""Commands in the order of the help, and the module of each in this package, imported only when needed."""
ENDS = {
    **dict.fromkeys(("run", "replay", "bridge"), "; anything recorded so far is closed and readable"),
    "sweep": "; the same command continues the sweep",
    "experiments": "; the same command continues with what is missing",
}
"""What an interrupted command leaves behind, if anything."""
BRIEF = {"check", "schema", "worlds"}
"""Commands that take about a second at most, as help does."""


def _print_version(requested: bool) -> None:
    if requested:
        from importlib.metadata import version

        print(f"mjsim {version('mjsim')}")
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    pass


def app(names: Iterable[str] = COMMANDS) -> typer.Typer:
    """Return the command line with these commands."""
    made = typer.Typer(
        name="mjsim",
        help="A simulator for navigation and SLAM of indoor wheeled robots, with rendered camera images.",
        no_args_is_help=True,
        context_settings={"help_option_names": ["-h", "--help"]},
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        callback=_options,
    )
    for name in names:
        made.command(name)(getattr(import_module(f"mjsim.cli.{COMMANDS[name]}"), name.replace("-", "_")))
    return made


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit, as `mjsim.cli.main` says."""
    # The garbage collection at exit takes as long as loading many modules; skip it.
    atexit.register(gc.freeze)
    # Pydantic's search for plugins in all installed packages takes as long as reading a world.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    words = sys.argv[1:] if arguments is None else list(arguments)
    if arguments is None and (not words or words[0] not in COMMANDS or words[0] in BRIEF):
        # Nearly all objects live until exit; garbage collection would take a tenth of the running time.
        gc.disable()
    terminations = _interrupt_when_terminated() if arguments is None else ()
    # Otherwise the next opened file would get the descriptor of a closed stream, and everything that is printed.
    if sys.stderr is None:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        show("mjsim: standard output is closed; redirect it to a file, or to /dev/null")
        sys.exit(2)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="surrogateescape")  # File names may hold any bytes.
    code = _exit_code(lambda: app(_needed(words))(args=words, prog_name="mjsim", standalone_mode=False), words[:1])
    _name_unfinished_threads()
    sys.exit(128 + terminations[0] if terminations and code == INTERRUPTED else code)


def _interrupt_when_terminated() -> Sequence[int]:
    """Make some signals close open files as Ctrl-C does; return a list to which a signal is added on arrival.

    A signal that is ignored, such as HUP under nohup, stays ignored.
    """
    came: list[int] = []
    process = os.getpid()

    def interrupt(number: int, frame: FrameType | None) -> NoReturn:
        signal.signal(number, signal.SIG_DFL)  # A second signal ends a program that hangs while closing.
        if os.getpid() != process:  # A process forked by a module, which has nothing to close.
            os.kill(os.getpid(), number)
        came.append(number)
        raise KeyboardInterrupt

    for each in TERMINATING:
        if signal.getsignal(each) is not signal.SIG_IGN:
            signal.signal(each, interrupt)
    return came


def _needed(words: Sequence[str]) -> Iterable[str]:
    """Return the command that the words name, or all commands, for the help and for suggestions."""
    return words[:1] if words and words[0] in COMMANDS else COMMANDS


def _name_unfinished_threads() -> None:
    """Print which threads Python waits for at exit; ours are daemons, so a module started them."""
    for thread in threading.enumerate():
        if thread is not threading.main_thread() and not thread.daemon:
            say(f"waiting for thread '{thread.name}' of a module; end it, or make it a daemon")


def _exit_code(call: Callable[[], int | None], command: Sequence[str]) -> int:
    try:
        code = call() or 0
        sys.stdout.flush()
    except typer.TyperException as error:
        # The arguments are wrong; without any command the message is the help.
        text = error.format_message()
        show(text if text.startswith("Usage") else f"mjsim: {_advised(error, text)}")
        return 2
    except MjsimError as error:
        show(str(error))
        return error.exit_code
    except OSError as error:
        return _unwritten(error)
    except SystemExit as left:
        # Typer exits by itself when nobody reads.
        if not isinstance(left.__context__, BrokenPipeError):
            raise
        return _unwritten(left.__context__)
    except (KeyboardInterrupt, typer.Abort):
        code = INTERRUPTED
    if code == INTERRUPTED:
        say(f"interrupted{''.join(ENDS.get(name, '') for name in command)}")
    return code


def _advised(error: typer.TyperException, text: str) -> str:
    """Return what is wrong with the arguments, and what to type; Pydantic adds a prefix to its messages."""
    text = text.replace(": Value error, ", ": ").replace(": Input should be ", ": it must be ")
    context = getattr(error, "ctx", None)
    if context is None:
        return text
    outputs = [option for option in context.command.params if "-o" in option.opts]
    names_a_file = text.startswith("Got unexpected") and "." in text.rpartition("(")[2]
    if outputs and (names_a_file or text.startswith("Missing option '-o'")):
        return f"{text.rstrip('.')}; name the output with -o {outputs[0].metavar}"
    if text.startswith(("Got unexpected", "Missing")):
        return f"{text.rstrip('.')}; {context.command_path} --help shows how to type it"
    if text.startswith("No such command") and "Did you mean" not in text:
        return f"{text.rstrip('.')}; {context.command_path} --help lists the commands"
    return text


def _unwritten(error: OSError) -> int:
    """Return the exit code after an error of standard output, and report it; any other error is raised again."""
    try:
        os.write(1, b"\n")  # Some devices refuse only writes that are not empty.
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # At exit, Python flushes what is left.
    else:
        raise error
    if isinstance(error, BrokenPipeError):
        return BROKEN_PIPE
    show(f"mjsim: cannot write to standard output: {error.strerror}")
    return 2
