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
    overwrite: bool = False,
) -> dict[str, dict[str, Any]]:
    """Write the page of a plant, or of all plants of a world; return their figures by name.

    Args:
        world: Where the plants are.
        folder: Where the files go; created if necessary.
        plant: The one that is looked at; by default all.
        designers: Give controllers for each, such as `lambda plant: lqr_design(plant, weights, effort)`.
        recording: Of a run, to identify the plant from.
        overwrite: Whether files may be replaced.

    Raises:
        UsageError: The plant does not exist, it cannot be made linear, or a file exists.
    """
    from mjsim.lab.page import figures_of, page_files

    chosen = plants_of(world, plant)
    free_paths(folder, [f"{each.name}.{end}" for each in chosen for end in ("html", "json")], overwrite=overwrite)
    figures = {}
    for each in chosen:
        found = experiment(world, each, designers=designers, recording=recording)
        write_set(folder, page_files(found), of=f"plant {each.name}", overwrite=overwrite)
        figures[each.name] = figures_of(found)
    return figures
