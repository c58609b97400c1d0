"""Arguments and options that several commands take."""

import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mjsim.progress import say

if TYPE_CHECKING:
    from mjsim.record import Recording


def complete_world(incomplete: str) -> list[str]:
    """Return what a shell offers for the beginning of a WORLD: shipped worlds, folders and YAML files."""
    from mjsim.world import shipped_worlds

    folder, name = os.path.split(incomplete)
    words = list(shipped_worlds())
    with suppress(OSError), os.scandir(folder or ".") as entries:
        for entry in entries:
            if entry.is_dir() or entry.name.endswith(".yaml"):
                words.append(f"{incomplete.removesuffix(name)}{entry.name}{'/' if entry.is_dir() else ''}")
    return sorted(word for word in words if word.startswith(incomplete))


# Text, because a Path drops the "./" that distinguishes a folder from a shipped world.
WorldFile = Annotated[
    str,
    typer.Argument(
        metavar="WORLD", help="A world file, or the name of a shipped world.", autocompletion=complete_world
    ),
]
WorldFiles = Annotated[
    list[str],
    typer.Argument(metavar="WORLD...", help="World files, or names of shipped worlds.", autocompletion=complete_world),
]
RunFile = Annotated[Path, typer.Argument(metavar="RUN.mcap", help="A recording.")]
Settings = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a value: robots.scout.odometry.scale=1.1")
]
Begin = Annotated[float | None, typer.Option("--from", metavar="S", help="Start at this time of the recording [s].")]
End = Annotated[float | None, typer.Option("--to", metavar="S", help="End at this time of the recording [s].")]
Formats = Annotated[
    str, typer.Option("--formats", metavar="png,pdf,svg", help="File formats of the plots: one or more of these.")
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")]


def recorded(path: Path) -> "Recording":
    """Return a recording, and print a note if it is incomplete."""
    from mjsim.record import INCOMPLETE, read_recording

    run = read_recording(path)
    if not run.whole:
        say(f"{path.name}: {INCOMPLETE}")
    return run
