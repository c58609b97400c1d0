"""Plots of the laboratory: results of python-control, and those of the nonlinear plant beside them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from mjsim.geometry import Array
from mjsim.lab.closed import ClosedLoop
from mjsim.lab.design import Design
from mjsim.lab.identify import Identified
from mjsim.lab.study import POINTS, Study, theory
from mjsim.plan import GROUPS
from mjsim.report import ESTIMATE, MAP, NEUTRAL, ODOMETRY, TRUTH, sheet

DAMPINGS = (0.2, 0.4, 0.6, 0.8)
"""Damping ratios of the grid of a root locus."""
GRID = "#8a8a8a"
OTHERS = ((ODOMETRY, "--"), (MAP, ":"))
"""Colours and line styles of nonlinear responses."""
QUIET = -40.0
"""Lower gains are left out of a Nichols chart [dB]."""
LOCUS_RANGE = 3.0
"""Range of a Nyquist or root locus plot, as a multiple of the distance of the critical point or the poles."""


def response_plot(
    title: str,
    time: Array,
    linear: Array,
    labels: Sequence[str],
    *others: tuple[str, tuple[Array, Array] | None],
) -> Figure:
    """Draw outputs over time: of the linear plant and, if given, names, times and outputs of nonlinear ones."""
    figure, panels = sheet(len(linear), height=2.9 * len(linear))
    for row, axes in enumerate(panels):
        axes.plot(time, linear[row], color=ESTIMATE, lw=1.8, label="linear")
        for (name, curve), (color, style) in zip(others, OTHERS, strict=False):
            if curve is not None:
                axes.plot(curve[0], curve[1][row], color=color, lw=1.4, ls=style, label=name)
        axes.set_ylabel(labels[row])
    panels[0].set_title(title, loc="left")
    panels[0].legend(frameon=False, loc="best")
    panels[-1].set_xlabel("time [s]")
    return figure


def bode_plot(found: Study) -> Figure:
    """Draw gain and phase over frequency, with the margins."""
    figure, (gain, phase) = sheet(2, height=5.8)
    gain.semilogx(found.omega, decibels(found.magnitude), color=ESTIMATE, lw=1.8)
    phase.semilogx(found.omega, np.degrees(found.phase), color=ESTIMATE, lw=1.8)
    gain.axhline(0.0, color=NEUTRAL, lw=0.8)
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
    phase, gain = np.degrees(found.phase), decibels(found.magnitude)
    shown = gain > QUIET if (gain > QUIET).any() else gain > -np.inf
    critical = -180.0 + 360.0 * round((float(phase[np.argmin(np.abs(gain))]) + 180.0) / 360.0)
    nichols.set(xlim=_window(phase[shown], critical), ylim=np.clip(_window(gain[shown], 0.0), -60.0, 60.0))
    # python-control draws the grid where data and window overlap.
    nichols.update_datalim(nichols.viewLim.get_points())
    theory().nichols_grid(ax=nichols, label_cl_phases=False)
    nichols.plot([critical], [0.0], "+", color=GROUPS[1], ms=11, mew=2)
    nichols.set(xlabel="phase [deg]", ylabel="gain [dB]")
    nichols.set_title("Nichols", loc="left")
    return figure


def _window(values: Array, critical: float) -> tuple[float, float]:
    """Return limits that include all values and the critical one, with a margin."""
    low, high = min(float(values.min()), critical), max(float(values.max()), critical)
    margin = 0.08 * (high - low) + 1.0
    return low - margin, high + margin


def _damping_grid(axes: Axes, limit: float) -> None:
    """Draw lines of equal damping, and semicircles of equal natural frequency, in the left half plane."""
    for damping in DAMPINGS:
        angle = np.pi - np.arccos(damping)
        for side in (1.0, -1.0):
            end = 1.5 * limit * np.array([np.cos(angle), side * np.sin(angle)])
            axes.plot([0.0, end[0]], [0.0, end[1]], ":", color=GRID, lw=0.8)
        place = 0.93 * limit / max(abs(np.cos(angle)), np.sin(angle)) * np.exp(1j * angle)
        axes.text(place.real, place.imag, f"{damping:g}", fontsize=7, color=GRID, ha="center", va="center")
    turn = np.linspace(np.pi / 2, 1.5 * np.pi, 90)
    for frequency in MaxNLocator(4, prune="lower").tick_values(0.0, limit):
        axes.plot(frequency * np.cos(turn), frequency * np.sin(turn), ":", color=GRID, lw=0.8)


def _loci(found: Study) -> Array:
    """Return the closed-loop poles for gains from 0, complex, shape (gains, n)."""
    control = theory()
    try:
        return np.asarray(control.root_locus_map(found.loop).loci)
    except ValueError:
        # python-control does not choose gains if both degrees are equal and the gain at high frequencies is < 0.
        top = 1.0 / max(abs(float(found.loop.D[0, 0])), 1e-12)
        return np.asarray(control.root_locus_map(found.loop, gains=np.linspace(0.0, 0.99 * top, POINTS)).loci)


def poles_plot(found: Study) -> Figure:
    """Draw poles and zeros, and the root locus for gains from 0."""
    figure, (plane, locus) = sheet(1, 2, height=4.6)
    for branch in _loci(found).T if len(found.poles) else ():
        locus.plot(branch.real, branch.imag, ".", color=ESTIMATE, ms=1.6)
        locus.plot(branch.real, branch.imag, color=ESTIMATE, lw=1.2)
    for axes, title in ((plane, "Poles and zeros"), (locus, "Root locus under unity feedback")):
        axes.plot(found.poles.real, found.poles.imag, "x", color=GROUPS[1], ms=8, mew=1.8, label="poles")
        axes.plot(found.zeros.real, found.zeros.imag, "o", mfc="none", color=MAP, ms=8, mew=1.6, label="zeros")
        axes.axvline(0.0, color=NEUTRAL, lw=0.8)
        axes.axhline(0.0, color=NEUTRAL, lw=0.8)
        axes.set(xlabel="real [rad/s]", ylabel="imaginary [rad/s]")
        axes.set_title(title, loc="left")
    sizes = np.abs(np.concatenate([found.poles, found.zeros]))
    limit = 1.3 * float(sizes.max(initial=0.0)) or 1.0
    for axes, reach in ((plane, limit), (locus, LOCUS_RANGE * limit)):
        axes.grid(visible=False)
        _damping_grid(axes, reach)
    plane.set(xlim=(-limit, limit), ylim=(-limit, limit))
    locus.set(xlim=(-LOCUS_RANGE * limit, LOCUS_RANGE * limit), ylim=(-LOCUS_RANGE * limit, LOCUS_RANGE * limit))
    plane.legend(frameon=False, loc="upper right")
    return figure


def identified_plot(found: Identified, labels: Sequence[str]) -> Figure:
    """Draw the input, and the measured output with those of both models."""
    samples = found.samples
    figure, panels = sheet(1 + len(samples.outputs), height=2.6 * (1 + len(samples.outputs)))
    style = "steps-post" if samples.held else "default"
    panels[0].plot(samples.time, samples.inputs, color=TRUTH, lw=1.0, drawstyle=style)
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


def design_plot(design: Design, closed: ClosedLoop | None, labels: Sequence[str], *, amplitude: float) -> Figure:
    """Draw the response of the closed loop to a step, with that of the nonlinear plant if available."""
    return response_plot(
        f"Closed loop, a step of {amplitude:g}: {design.name}",
        design.time,
        design.step * amplitude,
        labels,
        ("nonlinear, MuJoCo", None if closed is None else (closed.time, closed.step)),
        ("with dry friction", None if closed is None else closed.rough),
    )


def decibels(magnitude: Array) -> Array:
    """Return gains in dB."""
    return np.asarray(20.0 * np.log10(np.maximum(magnitude, 1e-300)))


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _decibel_text(value: float | None) -> str:
    return "-" if value is None else f"{20.0 * np.log10(value):.4g} dB"


def tables(found: Study) -> Mapping[str, tuple[list[str], Any]]:
    """Return the data of the plots by file name: column heads, and columns."""
    names = list(found.plant.outputs)
    return {
        "step": (["time_s", *names], np.column_stack([found.time, *found.step])),
        "impulse": (["time_s", *names], np.column_stack([found.time, *found.impulse])),
        "bode": (
            ["omega_rad_s", "magnitude", "phase_rad"],
            np.column_stack([found.omega, found.magnitude, found.phase]),
        ),
    }
