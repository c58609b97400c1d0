"""The files of `mjsim ergonomics`: a page for each seated person."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjsim.errors import UsageError
from mjsim.output import free_paths, write_set
from mjsim.world import World


def write_ergonomics(
    world: World, folder: Path, *, formats: Sequence[str] = ("png",), overwrite: bool = False
) -> dict[str, dict[str, Any]]:
    """Write the page of each seated person of a world; return their results by name.

    Args:
        world: The world.
        folder: Output folder; created if necessary.
        formats: Formats of the plots beside PNG, which the page has: 'pdf', 'svg'.
        overwrite: Whether files may be replaced.

    Raises:
        UsageError: Nobody is seated in it, or a file exists.
    """
    from mjsim.ergonomics.workplace_page import page_files
    from mjsim.ergonomics.workplace_study import figures_of, studies

    names = [person.name for person in world.people if person.seat is not None]
    if not names:
        raise UsageError("no person in this world is seated; give one seat: THING, and the thing a seat")
    free_paths(folder, [f"{name}.{end}" for name in names for end in ("html", "json")], overwrite=overwrite)
    figures = {}
    for study in studies(world):
        name = study.person.name
        write_set(folder, page_files(study, formats=formats), of=f"person {name}", overwrite=overwrite)
        figures[name] = figures_of(study)
    return figures
