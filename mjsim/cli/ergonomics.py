"""The command `ergonomics`: how well people fit their workplaces."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from mjsim.cli.arguments import Formats, Overwrite, Settings, WorldFile


def ergonomics(
    world: WorldFile,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for the pages.")] = Path("out/ergonomics"),
    formats: Formats = "png",
    settings: Settings = None,
    overwrite: Overwrite = False,
) -> None:
    """Write a page about the posture of each seated person.

    Each page has contacts, reach, sight, clearances and the travel of the seat.
    """
    from mjsim.ergonomics import write_ergonomics
    from mjsim.report import parse_formats
    from mjsim.world import load_checked, with_settings

    kinds = parse_formats(formats)
    found = load_checked(world)
    if settings:
        found = with_settings(found, settings)
    for name, figures in write_ergonomics(found, output, formats=kinds, overwrite=overwrite).items():
        print(*_lines(name, figures), sep="\n")
        print(output / f"{name}.html")


def _lines(name: str, figures: dict[str, Any]) -> Iterator[str]:
    """Yield the key results of a person as text."""
    errors = [value for key, each in figures["contacts"].items() if key != "gaze" for value in each.values()]
    yield f"{name}: {len(figures['contacts'])} contacts, the largest error {max(errors, default=0.0):.4g} mm"
    for contact in figures["missed"]:
        ((unit, value),) = figures["contacts"][contact].items()
        yield f"  {contact} is out of reach by {value:.1f} {unit.removeprefix('error_')}"
    for each in figures["collisions"]:
        yield f"  {each['segment']} goes {-1000 * each['distance_m']:.0f} mm into {each['thing']}"
    for target, each in figures["reach"].items():
        if each["short_m"] > 0.0:
            leaning = "leaning reaches it" if each["short_leaning_m"] == 0.0 else "leaning does not reach it"
            yield f"  {target} is {math.ceil(1000 * each['short_m'])} mm out of reach; {leaning}"
    for display, each in figures["displays"].items():
        hidden = ", ".join(f"{obstacle} {100 * share:.1f} %" for obstacle, share in each["hidden_by"].items())
        yield f"  {display}: {100 * each['visible']['either']:.1f} % visible" + (
            f"; hidden: {hidden}" if hidden else ""
        )
