"""Figures of modules in .m files: recorded while the run lasts, drawn after it."""

import itertools
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from mjsim.errors import MjsimError
from mjsim.output import write_set
from mjsim.toolbox.calls import read_calls, write_recorders
from mjsim.toolbox.script import HERE, drawn_files

VARIABLE = "MJSIM_FIGURES"


def _draws(modules: object) -> bool:
    """Return whether a world's `run`, or the specification of a module, names a module in an .m file."""
    return re.search(r"\.m['\"]", repr(modules)) is not None


@contextmanager
def module_figures(recording: Path, *, overwrite: bool) -> Iterator[list[str]]:
    """Let modules in .m files call figure functions; after the run their figures are in a folder beside the recording.

    This also holds for a run that ends with a fault.

    Args:
        recording: The recording; the folder has its name with `-figures` behind it, and a number if there is such a
            folder already.
        overwrite: Whether files in that folder may be replaced instead.

    Yields:
        A list that gets the names of the files, then lines about what could not be drawn.
    """
    told: list[str] = []
    with tempfile.TemporaryDirectory(prefix="mjsim-figures-") as place:
        write_recorders(Path(place))
        os.environ[VARIABLE] = f"{place}:{HERE / 'recorder'}"
        try:
            yield told
        finally:
            del os.environ[VARIABLE]
            try:
                told += _written(Path(place), recording, overwrite=overwrite)
            except (OSError, MjsimError) as error:  # the line of a fault of the run is more important
                told.append(f"the figures of its modules are not written: {error}")


@contextmanager
def figures_told(modules: object, recording: Path, *, overwrite: bool, tell: Callable[[str], object]) -> Iterator[None]:
    """Let modules in .m files draw figures, and tell at the end, after a fault, too, what came of them.

    Args:
        modules: A world's `run`, or the specification of modules.
        recording: As for `module_figures`.
        overwrite: As for `module_figures`.
        tell: Gets each line: the name of a file, or what could not be drawn.
    """
    if not _draws(modules):
        yield
        return
    figures: list[str] = []
    try:
        with module_figures(recording, overwrite=overwrite) as figures:
            yield
    finally:
        for line in figures:
            tell(line)


def _written(records: Path, recording: Path, *, overwrite: bool) -> list[str]:
    """Draw what modules recorded; return the names of the files, then lines about what could not be drawn."""
    folder = recording.with_name(f"{recording.stem}-figures")
    names = (folder.with_name(f"{folder.name}-{number}") for number in itertools.count(2))
    folder = folder if overwrite or not folder.exists() else next(name for name in names if not name.exists())
    files: dict[str, bytes] = {}
    notes: list[str] = []
    for record in sorted(records.glob("*.mat")):
        drawn, lines, _ = drawn_files(list(read_calls(record)))
        name = record.stem.rpartition("-")[0]
        own = record.stem if any(f"{name}-{file}" in files for file in drawn) else name
        files |= {f"{own}-{file}": content for file, content in drawn.items()}
        notes += [f"{name}.m: {line}" for line in lines]
    if files:
        write_set(folder, files, of=f"modules of {recording.name}", overwrite=True)
    return [*(str(folder / file) for file in files), *notes]
