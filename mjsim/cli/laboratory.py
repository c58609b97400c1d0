"""The command `lab`: linearises, analyses and controls plants."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mjsim.cli.arguments import Formats, Overwrite, Settings, WorldFile, recorded
from mjsim.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Iterable

    from mjsim.lab import Designer


def lab(
    world: WorldFile,
    plant: Annotated[str | None, typer.Argument(metavar="PLANT", help="One plant of the world; default: all.")] = None,
    output: Annotated[Path, typer.Option("-o", metavar="DIR", help="Folder for the pages.")] = Path("out/lab"),
    run: Annotated[
        Path | None, typer.Option(metavar="RUN.mcap", help="Identify the plant from this recording.")
    ] = None,
    pid: Annotated[
        list[str] | None,
        typer.Option(
            metavar="RULE", help="PID tuning rule, or several: ziegler-nichols, tyreus-luyben, cohen-coon or simc."
        ),
    ] = None,
    place: Annotated[
        str | None,
        typer.Option(metavar="P1,P2,...", help="State feedback with these closed-loop poles, such as -3,-2+1j,-2-1j."),
    ] = None,
    lqr: Annotated[
        str | None, typer.Option(metavar="Q1,Q2,...:R", help="State feedback that minimises x' Q x + R u^2.")
    ] = None,
    lead: Annotated[
        str | None,
        typer.Option(
            metavar="DEG@RAD/S[:LAG]", help="Lead compensator with this phase margin at this crossover frequency."
        ),
    ] = None,
    formats: Formats = "png",
    settings: Settings = None,
    overwrite: Overwrite = False,
) -> None:
    """Linearise plants, and write a page about each.

    Each page has matrices, poles, responses, margins, identification and controllers.
    """
    from mjsim.lab import write_lab
    from mjsim.report import parse_formats
    from mjsim.world import load_checked, with_settings

    kinds = parse_formats(formats)
    designers = list(_designers(pid=pid or (), place=place, lqr=lqr, lead=lead))
    found = load_checked(world)
    if settings:
        found = with_settings(found, settings)
    recording = None if run is None else recorded(run)
    figures = write_lab(
        found, output, plant=plant, designers=designers, recording=recording, formats=kinds, overwrite=overwrite
    )
    for name, each in figures.items():
        print(*_lines(name, each), sep="\n")
        print(output / f"{name}.html")


def _designers(*, pid: "Iterable[str]", place: str | None, lqr: str | None, lead: str | None) -> "list[Designer]":
    """Return the design functions of the requested controllers."""
    from mjsim.lab import lqr_design, pid_design, placed_design

    found: list[Designer] = []
    found += [partial(pid_design, rule=rule) for rule in pid]
    if place is not None:
        found.append(partial(placed_design, poles=_numbers(place, "--place", complex)))
    if lqr is not None:
        weights, _, effort = lqr.partition(":")
        (effort_value,) = _numbers(effort or "1", "--lqr", float)
        found.append(partial(lqr_design, weights=_numbers(weights, "--lqr", float), effort=effort_value))
    if lead is not None:
        found.append(_lead(lead))
    return found


def _lead(text: str) -> "Designer":
    from mjsim.lab import lead_design

    target, _, lag = text.partition(":")
    parts = target.split("@")
    if len(parts) != 2:
        raise UsageError(f"--lead is '{text}'; write a margin and a crossover, such as 50@6")
    (margin,), (crossover,) = (_numbers(part, "--lead", float) for part in parts)
    (more,) = _numbers(lag or "1", "--lead", float)
    return partial(lead_design, margin_deg=margin, crossover=crossover, lag=more)


def _numbers(text: str, option: str, kind: type[Any]) -> list[Any]:
    try:
        values = [kind(_imaginary(part.strip())) for part in text.split(",")]
    except ValueError:
        raise UsageError(f"{option} is '{text}'; give numbers separated by commas") from None
    if not all(abs(value) < 1e12 for value in values):
        raise UsageError(f"{option} is '{text}'; its numbers must be finite")
    return values


def _imaginary(text: str) -> str:
    """Return a number with its imaginary unit written as in Python."""
    return f"{text[:-1]}j" if text.endswith("i") else text


def _lines(name: str, figures: dict[str, Any]) -> list[str]:
    """Return the key numbers of a plant as text."""
    from mjsim.lab import complex_text

    def shown(pairs: list[list[float]]) -> str:
        return ", ".join(complex_text(complex(*pair)) for pair in pairs) or "none"

    states = ", ".join(figures["states"]) or "none"
    lines = [f"{name}: {figures['input']} -> {', '.join(figures['outputs'])}; states {states}"]
    lines.append(f"  poles {shown(figures['poles'])}; zeros {shown(figures['zeros'])}")
    if "nonlinear_fit_percent" in figures:
        lines.append(f"  {_nonlinear_text(figures, 'the linear step response', 'after its step')}")
    if "dry_friction" in figures:
        lines.append(
            f"  dry friction of up to {figures['dry_friction']:.4g} is left out of both; the page also shows it"
        )
    if (found := figures.get("identification")) is not None:
        shares = ", ".join(f"{value:.2f} %" for value in found["identified_fit_percent"])
        lines.append(f"  identified from {found['source']}: poles {shown(found['poles'])}; fit {shares}")
    for design in figures["designs"]:
        unstable = "" if design["stable"] else "; not stable"
        lines.append(f"  {design['name']}: closed-loop poles {shown(design['poles'])}{unstable}")
        if "nonlinear_seconds" in design:
            lines.append(f"  {_nonlinear_text(design, 'its linear loop', 'under it')}")
    return lines


def _nonlinear_text(figures: dict[str, Any], linear: str, when: str) -> str:
    """Return how well the linear response fits that of the nonlinear plant, or when the latter diverges."""
    if figures["nonlinear_fit_percent"] is None:
        return f"{when} the nonlinear plant diverges after {figures['nonlinear_seconds']:.3g} s"
    shares = ", ".join(f"{value:.2f} %" for value in figures["nonlinear_fit_percent"])
    return f"{linear} fits the nonlinear one by {shares}"
