"""The page of a plant: matrices, numbers, plots and controllers in one HTML file that opens offline."""

import io
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from mjsim.geometry import Array
from mjsim.lab.closed import ClosedLoop
from mjsim.lab.design import Design
from mjsim.lab.design_modules import module_text
from mjsim.lab.experiment import Experiment
from mjsim.lab.formula import PADE_ORDER, pade_limit
from mjsim.lab.linear import LinearPlant
from mjsim.lab.locus import RootLocus
from mjsim.report import Block, Code, Heading, HtmlTable, Paragraph, drawing_files, html_page, picture, png_of

MATRIX_STYLE = """
pre { background: rgba(128, 128, 128, 0.12); padding: 0.7rem 1rem; border-radius: 6px; overflow-x: auto; }
table.matrix { width: auto; } table.matrix td, table.matrix th { font-size: 0.9rem; }
"""


def page_files(experiment: Experiment, *, formats: Sequence[str] = ("png",)) -> dict[str, bytes]:
    """Return the files of a plant by name: page, results as JSON, plots, and their data as CSV.

    Args:
        experiment: The plant.
        formats: Formats of the plots beside PNG, which the page has: 'pdf', 'svg'.
    """
    from mjsim.lab.plant_plots import tables

    name, plots = experiment.name, _figures(experiment)
    pictures = {key: png_of(figure) for key, figure in plots.items()}
    files = {f"{name}_{key}.png": data for key, data in pictures.items()}
    files |= drawing_files({f"{name}_{key}": plot for key, plot in plots.items()}, [*({*formats} - {"png"})])
    for key, (head, columns) in tables(experiment).items():
        text = io.StringIO()
        np.savetxt(text, columns, fmt="%.17g", delimiter=",", header=",".join(head), comments="")
        files[f"{name}_{key}.csv"] = text.getvalue().encode()
    figures = json.dumps(figures_of(experiment), indent=1, allow_nan=False) + "\n"
    return {f"{name}.html": _page(experiment, pictures).encode(), f"{name}.json": figures.encode(), **files}


def card_of(experiment: Experiment) -> str:
    """Return what a notebook shows of a plant: its key numbers, its responses and its root locus, as HTML."""
    from mjsim.lab import plant_plots as plots

    study, labels = experiment.study, experiment.labels
    held = study.plant.dt > 0.0
    step = plots.response_plot("Response to a unit step", study.time, study.step, labels, held=held)
    cells = ("".join(f"<td>{escape(str(cell))}</td>" for cell in row) for row in _facts(experiment).rows)
    table = "".join(f"<tr>{row}</tr>" for row in cells)
    shown = (picture(title, png_of(figure)) for title, figure in (("step", step), ("poles", plots.poles_plot(study))))
    images = "".join(f'<img alt="{each.title}" src="{each.source}" style="max-width:45em">' for each in shown)
    return f"<div><b>{escape(experiment.about)}</b><table>{table}</table>{images}</div>"


def figures_of(experiment: Experiment) -> dict[str, Any]:
    """Return the results of a plant, as in its JSON file."""
    study, plant = experiment.study, experiment.study.plant
    found: dict[str, Any] = {
        "plant": experiment.name,
        "input": plant.input,
        "outputs": list(plant.outputs),
        "states": list(plant.states),
        "units": list(plant.units),
        **{key: np.asarray(getattr(plant, key)).tolist() for key in "ABCD"},
        "poles": _pairs(study.poles),
        "zeros": _pairs(study.zeros),
        "margins": study.margins,
        "stable_at_gain_1": study.is_stable_closed,
        "root_locus": _locus_figures(study.locus),
        "held_input": experiment.held,
        "designs": [
            _design_figures(design, closed)
            for design, closed in zip(experiment.designs, experiment.closed, strict=True)
        ],
    }
    if plant.dt:
        found["dt"] = plant.dt
    if plant.delay:
        found["delay"] = {
            "seconds": plant.delay,
            "pade_order": PADE_ORDER,
            "exact_to_1_deg_up_to": pade_limit(plant.delay),
        }
    if experiment.nonlinear is not None:
        found["nonlinear_fit_percent"] = experiment.nonlinear_fit
        found["nonlinear_seconds"] = float(experiment.nonlinear[0][-1])
    if experiment.dry_friction:
        found["dry_friction"] = experiment.dry_friction
    if (identified := experiment.identified) is not None:
        found["identification"] = {
            "source": identified.samples.source,
            "poles": _pairs(identified.poles),
            "linear_fit_percent": identified.linear_fit.tolist(),
            "identified_fit_percent": identified.model_fit.tolist(),
        }
    return found


def _locus_figures(locus: RootLocus) -> dict[str, Any]:
    """Return the data of the root locus plot; branches for each pole, a point for each gain, as [re, im]."""
    marks = {"crossings": locus.crossings, "breakaways": locus.breakaways}
    return {
        "gains": locus.gains.tolist(),
        "branches": [_pairs(branch) for branch in locus.branches],
        **{key: [{"gain": m.gain, "point": _pairs([m.point])[0]} for m in each] for key, each in marks.items()},
        "centroid": locus.centroid,
        "asymptotes_deg": [math.degrees(angle) for angle in locus.asymptotes],
        "poles_at_gain_1": _pairs(locus.unity),
        "picture": {"real": [-locus.extent, locus.extent], "imaginary": [-locus.extent, locus.extent]},
    }


def _design_figures(design: Design, closed: ClosedLoop | None) -> dict[str, Any]:
    simulated: dict[str, Any] = {}
    if closed is not None:
        simulated = {"nonlinear_fit_percent": closed.fit, "nonlinear_seconds": float(closed.time[-1])}
    return {
        "name": design.name,
        "gain": list(design.gain),
        "num": list(design.num),
        "den": list(design.den),
        "poles": _pairs(design.poles),
        "stable": design.is_stable,
        "margins": design.margins,
        **simulated,
    }


def _pairs(values: Any) -> list[list[float]]:
    return [[float(value.real), float(value.imag)] for value in values]


def _figures(experiment: Experiment) -> dict[str, Any]:
    """Return the plots by name."""
    from mjsim.lab import plant_plots as plots

    study, labels = experiment.study, experiment.labels
    amplitude, unit = experiment.amplitude, study.plant.units[0]
    found = {
        "step": plots.response_plot(
            f"Response to a step of {study.plant.input} by {amplitude:g} {unit}".rstrip(),
            study.time,
            study.step * amplitude,
            labels,
            ("nonlinear, MuJoCo", experiment.nonlinear),
            ("with dry friction", experiment.rough),
            held=study.plant.dt > 0.0,
        ),
        "impulse": plots.response_plot(
            f"Response to an impulse of {study.plant.input} of {amplitude:g} {unit} s".replace("  ", " "),
            study.time,
            study.impulse * amplitude,
            labels,
            ("nonlinear, MuJoCo", experiment.nonlinear_impulse),
            held=study.plant.dt > 0.0,
        ),
        "bode": plots.bode_plot(study),
        "nyquist": plots.nyquist_plot(study),
        "poles": plots.poles_plot(study),
    }
    if experiment.identified is not None:
        found["identification"] = plots.identified_plot(experiment.identified, labels)
    for number, (design, closed) in enumerate(zip(experiment.designs, experiment.closed, strict=True), start=1):
        found[f"design_{number}"] = plots.design_plot(design, closed, labels, amplitude=amplitude)
    return found


def _page(experiment: Experiment, pictures: Mapping[str, bytes]) -> str:
    images = {key: picture(f"{key} of {experiment.name}", data) for key, data in pictures.items()}
    return html_page(experiment.name, "mjsim lab", *_blocks(experiment, images), style=MATRIX_STYLE)


def _blocks(experiment: Experiment, images: Mapping[str, Block]) -> Iterator[Block]:
    plant = experiment.study.plant
    yield Paragraph(experiment.about, "run")
    yield Heading("Linear plant")
    law = f"x[k + 1] = A x[k] + B u[k], y[k] = C x[k] + D u[k], every {plant.dt:g} s"
    yield Paragraph(law if plant.dt else "x' = A x + B u, y = C x + D u")
    for name, rows, columns in (
        ("A", plant.states, plant.states),
        ("B", plant.states, (plant.input,)),
        ("C", plant.outputs, plant.states),
        ("D", plant.outputs, (plant.input,)),
    ):
        yield from (Heading(name, 3), _matrix(getattr(plant, name), rows, columns))
    yield from (Heading("Figures"), _facts(experiment), Heading("Responses"))
    yield from (images[key] for key in ("step", "impulse", "bode", "nyquist", "poles"))
    if "identification" in images:
        yield from (Heading("Identification"), images["identification"])
    for number, (design, closed) in enumerate(zip(experiment.designs, experiment.closed, strict=True), start=1):
        yield from _design_blocks(experiment, design, closed)
        yield images[f"design_{number}"]
    yield Paragraph(f"{len(experiment.study.poles)} states; numbers by python-control.", "run")


def _facts(experiment: Experiment) -> HtmlTable:
    study, dt = experiment.study, experiment.study.plant.dt
    rows = [
        ("poles", _roots_text(study.poles, dt)),
        ("zeros", _roots_text(study.zeros, dt)),
        ("stable", "yes" if study.is_stable else "no"),
        ("stable with unity feedback", "yes" if study.is_stable_closed else "no: the margins are those to stability"),
        *_margin_rows(study.margins),
    ]
    if delay := study.plant.delay:
        text = f"{delay:g} s; poles, root locus and closed loops have Pade's approximation of order {PADE_ORDER},"
        rows.append(("delay", f"{text} whose phase errs by less than 1 deg up to {pade_limit(delay):.4g} rad/s"))
    if experiment.nonlinear is not None:
        shares = _shares(study.plant, experiment.nonlinear_fit, experiment.nonlinear[0])
        rows.append(("linear step response fits the nonlinear one", shares))
    if experiment.dry_friction:
        text = f"{experiment.dry_friction:.4g} at most; the linear plant and the nonlinear one are compared without it"
        rows.append(("dry friction of its joints [N m, N]", text))
    if experiment.step_poles is not None:
        text = ", ".join(map(complex_text, experiment.step_poles)) + " rad/s"
        rows.append(("nearest poles of MuJoCo's step (mjd_transitionFD), log(z) / dt", text))
    return HtmlTable((), rows)


def _roots_text(roots: Array, dt: float) -> str:
    """Return poles or zeros with their unit; those of z have none."""
    return ", ".join(map(complex_text, roots)) + ("" if dt else " rad/s") if len(roots) else "none"


def _margin_rows(margins: Mapping[str, float | None]) -> list[tuple[str, str]]:
    rows = []
    for name, key, crossover, unit in (
        ("gain margin", "gain_margin", "phase_crossover", ""),
        ("phase margin", "phase_margin_deg", "gain_crossover", " deg"),
    ):
        value, at = margins[key], margins[crossover]
        text = "none or infinite" if value is None or at is None else f"{value:.6g}{unit} at {at:.6g} rad/s"
        rows.append((name, text))
    return rows


def _shares(plant: LinearPlant, shares: Sequence[float] | None, time: Array) -> str:
    """Return the fit of each output, or the time at which the nonlinear plant diverges, as text."""
    if shares is None:
        return f"the nonlinear plant diverges after {time[-1]:.3g} s"
    return ", ".join(f"{name} {value:.2f} %" for name, value in zip(plant.outputs, shares, strict=True))


def _design_blocks(experiment: Experiment, design: Design, closed: ClosedLoop | None) -> Iterator[Block]:
    plant = experiment.study.plant
    rows = [("closed-loop poles", _roots_text(design.poles, design.dt))]
    rows.append(("stable", "yes" if design.is_stable else "no"))
    if design.gain:
        named = zip(plant.states, design.gain, strict=True)
        rows.append(("feedback K", ", ".join(f"{name} {value:.6g}" for name, value in named)))
    else:
        rows.append(("numerator", ", ".join(f"{value:.6g}" for value in design.num)))
        rows.append(("denominator", ", ".join(f"{value:.6g}" for value in design.den)))
    if closed is not None:
        other = "nonlinear" if experiment.plant.of else "simulated"
        rows.append((f"linear loop fits the {other} one", _shares(plant, closed.fit, closed.time)))
    yield Heading(design.name)
    yield HtmlTable((), [*rows, *_margin_rows(design.margins)])
    yield Code(module_text(experiment.plant, plant, design))


def _matrix(values: Array, rows: Sequence[str], columns: Sequence[str]) -> HtmlTable:
    cells = [(name, *(f"{value:.8g}" for value in row)) for name, row in zip(rows, values.tolist(), strict=True)]
    return HtmlTable(("", *columns), cells, kind="matrix", wide=True)


def complex_text(value: complex) -> str:
    """Return a pole or zero as text, such as -1.5 or -1+2j."""
    real = 0.0 if abs(value.real) < 1e-12 else value.real
    return f"{real:.6g}" if abs(value.imag) < 1e-12 else f"{real:.6g}{value.imag:+.6g}j"
