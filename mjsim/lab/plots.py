"""Plots of the laboratory: each draws numbers of python-control, and of the nonlinear plant beside them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mjsim.geometry import Array
from mjsim.lab.design import Design
from mjsim.lab.identify import Identified
from mjsim.lab.study import Study, theory
from mjsim.report import ESTIMATE, GROUPS, MAP, ODOMETRY, TRUTH

NEAR = 3.0
"""How much of a Nyquist or root locus plot is shown: so many times the distance of the critical point, or of poles."""


def sheet(rows: int, columns: int = 1, *, height: float = 3.4) -> tuple[Figure, list[Axes]]:
    """Return an empty figure and its panels, row by row."""
    figure = Figure(figsize=(9.6, height * rows), dpi=110, layout="constrained")
    panels = list(np.atleast_1d(figure.subplots(rows, columns)).ravel())
    for axes in panels:
        axes.grid(alpha=0.3)
        axes.spines[["top", "right"]].set_visible(False)
    return figure, panels


def response_plot(
    title: str, time: Array, linear: Array, labels: Sequence[str], nonlinear: tuple[Array, Array] | None = None
) -> Figure:
    """Draw outputs over time, the linear plant's and, when given, times and outputs of the nonlinear one."""
    figure, panels = sheet(len(linear), height=2.9)
    for row, axes in enumerate(panels):
        axes.plot(time, linear[row], color=ESTIMATE, lw=1.8, label="linear")
        if nonlinear is not None:
            axes.plot(nonlinear[0], nonlinear[1][row], color=ODOMETRY, lw=1.4, ls="--", label="nonlinear, MuJoCo")
        axes.set_ylabel(labels[row])
    panels[0].set_title(title, loc="left")
    panels[0].legend(frameon=False, loc="best")
    panels[-1].set_xlabel("time [s]")
    return figure


def bode_plot(found: Study) -> Figure:
    """Draw gain and phase over frequency, with the margins."""
    figure, (gain, phase) = sheet(2, height=2.9)
    gain.semilogx(found.omega, decibels(found.magnitude), color=ESTIMATE, lw=1.8)
    phase.semilogx(found.omega, np.degrees(found.phase), color=ESTIMATE, lw=1.8)
    gain.axhline(0.0, color=TRUTH, lw=0.8)
    margins = found.margins
    for key, color, label in (
        ("gain_crossover", MAP, f"phase margin {_number(margins['phase_margin_deg'])} deg"),
        ("phase_crossover", GROUPS[1], f"gain margin {_decibel_text(margins['gain_margin'])}"),
    ):
        if (at := margins[key]) is not None and found.omega[0] <= at <= found.omega[-1]:
            gain.axvline(at, color=color, lw=1.0, ls=":", label=f"{label} at {at:.3g} rad/s")
            phase.axvline(at, color=color, lw=1.0, ls=":")
    if gain.get_legend_handles_labels()[0]:
        gain.legend(frameon=False, loc="lower left")
    gain.set(ylabel="gain [dB]")
    gain.set_title(f"Bode: {found.plant.input} to {found.plant.outputs[0]}", loc="left")
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    return figure


def nyquist_plot(found: Study) -> Figure:
    """Draw Nyquist's curve and the Nichols chart."""
    figure, (nyquist, nichols) = sheet(1, 2, height=4.6)
    curve = found.magnitude * np.exp(1j * found.phase)
    for values, style in ((curve, "-"), (np.conj(curve), ":")):
        nyquist.plot(values.real, values.imag, style, color=ESTIMATE, lw=1.6)
    nyquist.plot([-1.0], [0.0], "+", color=GROUPS[1], ms=11, mew=2, label="-1")
    limit = min(max(1.6, float(np.abs(curve).max()) * 1.15), 12.0)
    nyquist.set(xlim=(-limit, limit), ylim=(-limit, limit), xlabel="real", ylabel="imaginary", aspect="equal")
    nyquist.set_title("Nyquist", loc="left")
    nyquist.legend(frameon=False, loc="upper right")
    nichols.plot(np.degrees(found.phase), decibels(found.magnitude), color=ESTIMATE, lw=1.6)
    critical = -180.0 + 360.0 * round((float(np.degrees(found.phase).mean()) + 180.0) / 360.0)
    nichols.plot([critical], [0.0], "+", color=GROUPS[1], ms=11, mew=2)
    nichols.set(xlabel="phase [deg]", ylabel="gain [dB]")
    nichols.set_title("Nichols", loc="left")
    return figure


def poles_plot(found: Study) -> Figure:
    """Draw poles and zeros, and the root locus for gains from 0."""
    figure, (plane, locus) = sheet(1, 2, height=4.6)
    loci = theory().root_locus_map(found.loop)
    for branch in np.asarray(loci.loci).T:
        locus.plot(branch.real, branch.imag, ".", color=ESTIMATE, ms=1.6)
        locus.plot(branch.real, branch.imag, color=ESTIMATE, lw=1.2)
    for axes, title in ((plane, "Poles and zeros"), (locus, "Root locus under unity feedback")):
        axes.plot(found.poles.real, found.poles.imag, "x", color=GROUPS[1], ms=8, mew=1.8, label="poles")
        axes.plot(found.zeros.real, found.zeros.imag, "o", mfc="none", color=MAP, ms=8, mew=1.6, label="zeros")
        axes.axvline(0.0, color=TRUTH, lw=0.8)
        axes.axhline(0.0, color=TRUTH, lw=0.8)
        axes.set(xlabel="real [rad/s]", ylabel="imaginary [rad/s]")
        axes.set_title(title, loc="left")
    sizes = np.abs(np.concatenate([found.poles, found.zeros]))
    limit = 1.3 * float(sizes.max(initial=0.0)) or 1.0
    plane.set(xlim=(-limit, limit), ylim=(-limit, limit))
    locus.set(xlim=(-NEAR * limit, NEAR * limit), ylim=(-NEAR * limit, NEAR * limit))
    plane.legend(frameon=False, loc="upper left")
    return figure


def identified_plot(found: Identified, labels: Sequence[str]) -> Figure:
    """Draw the input, and what was measured beside what both models do."""
    samples = found.samples
    figure, panels = sheet(1 + len(samples.outputs), height=2.6)
    panels[0].step(samples.time, samples.inputs, where="post", color=TRUTH, lw=1.0)
    panels[0].set_ylabel("input")
    panels[0].set_title(f"Identification from {samples.source}", loc="left")
    for row, axes in enumerate(panels[1:]):
        axes.plot(samples.time, samples.outputs[row] - samples.outputs[row, 0], color=TRUTH, lw=2.2, label="measured")
        for values, share, color, name in (
            (found.linear, found.linear_fit, ESTIMATE, "linear plant"),
            (found.model, found.model_fit, ODOMETRY, "identified"),
        ):
            axes.plot(samples.time, values[row], color=color, lw=1.2, label=f"{name}, fit {share[row]:.2f} %")
        axes.set_ylabel(labels[row])
        axes.legend(frameon=False, loc="best", ncols=3, fontsize=8)
    panels[-1].set_xlabel("time [s]")
    return figure


def design_plot(design: Design, labels: Sequence[str]) -> Figure:
    """Draw the step response of the closed loop."""
    return response_plot(f"Closed loop: {design.name}", design.time, design.step, labels)


def decibels(magnitude: Array) -> Array:
    """Return gains in dB."""
    return np.asarray(20.0 * np.log10(np.maximum(magnitude, 1e-300)))


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _decibel_text(value: float | None) -> str:
    return "-" if value is None else f"{20.0 * np.log10(value):.4g} dB"


def tables(found: Study) -> Mapping[str, tuple[list[str], Any]]:
    """Return the numbers of the plots by the names of their files: heads, and columns side by side."""
    names = list(found.plant.outputs)
    return {
        "step": (["time_s", *names], np.column_stack([found.time, *found.step])),
        "impulse": (["time_s", *names], np.column_stack([found.time, *found.impulse])),
        "bode": (
            ["omega_rad_s", "magnitude", "phase_rad"],
            np.column_stack([found.omega, found.magnitude, found.phase]),
        ),
    }
