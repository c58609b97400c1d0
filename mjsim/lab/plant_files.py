"""The laboratory's files: a page for each plant."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from mjsim.lab.experiment import Designer, experiment, plants_of
from mjsim.output import free_paths, write_set
from mjsim.record import Recording
from mjsim.world import World


def write_lab(
    world: World,
    folder: Path,
    *,
    plant: str | None = None,
    designers: Sequence[Designer] = (),
    recording: Recording | None = None,
    formats: Sequence[str] = ("png",),
    overwrite: bool = False,
) -> dict[str, dict[str, Any]]:
    """Write the page of one plant or of all plants of a world; return their results by name.

    Args:
        world: The world.
        folder: Output folder; created if necessary.
        plant: Name of the plant; by default all.
        designers: Functions that return a controller for each, such as `lambda plant: lqr_design(plant, weights,
            effort)`.
        recording: Recording of a run for identification.
        formats: Formats of the plots beside PNG, which the page has: 'pdf', 'svg'.
        overwrite: Whether files may be replaced.

    Raises:
        UsageError: The plant does not exist or cannot be linearised, or a file exists.
    """
    from mjsim.lab.plant_page import figures_of, page_files

    chosen = plants_of(world, plant)
    free_paths(folder, [f"{each.name}.{end}" for each in chosen for end in ("html", "json")], overwrite=overwrite)
    figures = {}
    for each in chosen:
        found = experiment(world, each, designers=designers, recording=recording)
        write_set(folder, page_files(found, formats=formats), of=f"plant {each.name}", overwrite=overwrite)
        figures[each.name] = figures_of(found)
    return figures
