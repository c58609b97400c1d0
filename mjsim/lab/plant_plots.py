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
from mjsim.lab.experiment import Experiment
from mjsim.lab.identify import Identified
from mjsim.lab.locus import RootLocus
from mjsim.lab.plant_study import Study, theory
from mjsim.plan import GROUPS
from mjsim.report import ESTIMATE, MAP, NEUTRAL, ODOMETRY, TRUTH, sheet

DAMPING_RATIOS = (0.2, 0.4, 0.6, 0.8)
"""Damping ratios of the grid of a root locus."""
MAX_ROOMY_WIDTH = 2.5
"""Maximum half width of a picture in which the unit circle has room for numbers."""
GRID = "#8a8a8a"
OTHERS = ((ODOMETRY, "--"), (MAP, ":"))
"""Colours and line styles of nonlinear responses."""
MAX_TURN, MAX_POINTS = 0.05, 100
"""Maximum turn of Nyquist's curve between points [rad], and maximum number of points between two frequencies."""
MAX_PHASE = 1080.0
"""Bode and Nichols plots show this much of the phase of a delay, which has no end [deg]."""
MIN_GAIN_DB = -40.0
"""Lower gains are left out of a Nichols chart [dB]."""


def response_plot(
    title: str,
    time: Array,
    linear: Array,
    labels: Sequence[str],
    *others: tuple[str, tuple[Array, Array] | None],
    held: bool = False,
) -> Figure:
    """Draw outputs over time: of the linear plant and, if given, names, times and outputs of simulated ones.

    Outputs of discrete time are held until the next sample.
    """
    steps = "steps-post" if held else "default"
    figure, panels = sheet(len(linear), height=2.9 * len(linear))
    for row, axes in enumerate(panels):
        axes.plot(time, linear[row], color=ESTIMATE, lw=1.8, label="linear", drawstyle=steps)
        for (name, curve), (color, style) in zip(others, OTHERS, strict=False):
            if curve is not None:
                axes.plot(curve[0], curve[1][row], color=color, lw=1.4, ls=style, label=name, drawstyle=steps)
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
    unstable = "" if found.is_stable_closed else ", unstable with unity feedback"
    gain.set_title(f"Bode: {found.plant.input} to {found.plant.outputs[0]}{unstable}", loc="left")
    phase.set(ylabel="phase [deg]", xlabel="frequency [rad/s]")
    low, high = np.degrees(found.phase.min()), np.degrees(found.phase.max())
    if high - low > MAX_PHASE:
        phase.set_ylim(np.degrees(found.phase[0]) - MAX_PHASE, high + MAX_PHASE / 20.0)
    return figure


def nyquist_plot(found: Study) -> Figure:
    """Draw Nyquist's curve and the Nichols chart."""
    figure, (nyquist, nichols) = sheet(1, 2, height=4.6)
    curve = _smooth_curve(found)
    for values, style in ((curve, "-"), (np.conj(curve), ":")):
        nyquist.plot(values.real, values.imag, style, color=ESTIMATE, lw=1.6)
    nyquist.plot([-1.0], [0.0], "+", color=GROUPS[1], ms=11, mew=2, label="-1")
    limit = min(max(1.6, float(np.abs(curve).max()) * 1.15), 12.0)
    nyquist.set(xlim=(-limit, limit), ylim=(-limit, limit), xlabel="real", ylabel="imaginary", aspect="equal")
    nyquist.set_title("Nyquist", loc="left")
    nyquist.legend(frameon=False, loc="upper right")
    nichols.plot(np.degrees(found.phase), decibels(found.magnitude), color=ESTIMATE, lw=1.6)
    phase, gain = np.degrees(found.phase), decibels(found.magnitude)
    turned = phase > phase[0] - MAX_PHASE
    shown = turned & (gain > MIN_GAIN_DB) if (turned & (gain > MIN_GAIN_DB)).any() else turned
    critical = -180.0 + 360.0 * round((float(phase[np.argmin(np.abs(gain))]) + 180.0) / 360.0)
    nichols.set(xlim=_window(phase[shown], critical), ylim=np.clip(_window(gain[shown], 0.0), -60.0, 60.0))
    # python-control draws the grid where data and window overlap.
    nichols.update_datalim(nichols.viewLim.get_points())
    theory().nichols_grid(ax=nichols, label_cl_phases=False)
    nichols.plot([critical], [0.0], "+", color=GROUPS[1], ms=11, mew=2)
    nichols.set(xlabel="phase [deg]", ylabel="gain [dB]")
    nichols.xaxis.set_major_locator(MaxNLocator(5))
    nichols.set_title("Nichols", loc="left")
    return figure


def _smooth_curve(found: Study) -> Array:
    """Return the response, complex, with points between those of the study where it turns by more than a few degrees.

    It ends at twice the phase that Bode plots show.
    """
    shown = found.phase > found.phase[0] - 2.0 * np.radians(MAX_PHASE)
    phase = found.phase[shown]
    counts = np.ceil(np.abs(np.diff(phase)) / MAX_TURN).astype(int).clip(1, MAX_POINTS)
    places = np.concatenate([k + np.arange(n) / n for k, n in enumerate(counts)] + [[len(phase) - 1.0]])
    known = np.arange(len(phase))
    size = np.exp(np.interp(places, known, np.log(np.maximum(found.magnitude[shown], 1e-300))))
    return np.asarray(size * np.exp(1j * np.interp(places, known, phase)))


def _window(values: Array, critical: float) -> tuple[float, float]:
    """Return limits that include all values and the critical one, with a margin."""
    low, high = min(float(values.min()), critical), max(float(values.max()), critical)
    margin = 0.08 * (high - low) + 1.0
    return low - margin, high + margin


def _damping_grid(axes: Axes, limit: float) -> None:
    """Draw lines of equal damping, and semicircles of equal natural frequency, in the left half plane."""
    for damping in DAMPING_RATIOS:
        angle = np.pi - np.arccos(damping)
        for side in (1.0, -1.0):
            end = 1.5 * limit * np.array([np.cos(angle), side * np.sin(angle)])
            axes.plot([0.0, end[0]], [0.0, end[1]], ":", color=GRID, lw=0.8)
        place = 0.93 * limit / max(abs(np.cos(angle)), np.sin(angle)) * np.exp(1j * angle)
        axes.text(place.real, place.imag, f"{damping:g}", fontsize=7, color=GRID, ha="center", va="center")
    turn = np.linspace(np.pi / 2, 1.5 * np.pi, 90)
    for frequency in MaxNLocator(4, prune="lower").tick_values(0.0, limit):
        axes.plot(frequency * np.cos(turn), frequency * np.sin(turn), ":", color=GRID, lw=0.8)


def _sampled_grid(axes: Axes, limit: float) -> None:
    """Draw the unit circle, and lines of equal damping and of tenths of Nyquist's frequency within it."""
    circle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(circle), np.sin(circle), color=NEUTRAL, lw=1.1)
    turn = np.linspace(0.0, np.pi, 120)
    for damping in DAMPING_RATIOS:
        curve = np.exp((-damping / np.sqrt(1.0 - damping**2) + 1j) * turn)
        for side in (1.0, -1.0):
            axes.plot(curve.real, side * curve.imag, ":", color=GRID, lw=0.8)
        place = curve[30]
        if limit < MAX_ROOMY_WIDTH:
            axes.text(place.real, place.imag, f"{damping:g}", fontsize=7, color=GRID, ha="center", va="center")
    angle, damped = np.arange(0.2, 1.0, 0.2) * np.pi, np.linspace(0.0, 0.999, 60)[:, None]
    curves = np.exp(angle * (-damped + 1j * np.sqrt(1.0 - damped**2)))
    for side in (1.0, -1.0):
        axes.plot(curves.real, side * curves.imag, ":", color=GRID, lw=0.8)


def poles_plot(found: Study) -> Figure:
    """Draw poles and zeros, and the root locus with its crossings, breakaways, asymptotes and poles at gain 1."""
    figure, (plane, locus) = sheet(1, 2, height=4.9)
    _locus_lines(locus, found.locus)
    dt = found.plant.dt
    unit = "" if dt else " [rad/s]"
    for axes, title in ((plane, "Poles and zeros"), (locus, "Root locus under unity feedback")):
        axes.plot(found.poles.real, found.poles.imag, "x", color=GROUPS[1], ms=8, mew=1.8, label="poles")
        axes.plot(found.zeros.real, found.zeros.imag, "o", mfc="none", color=MAP, ms=8, mew=1.6, label="zeros")
        axes.axvline(0.0, color=NEUTRAL, lw=0.8)
        axes.axhline(0.0, color=NEUTRAL, lw=0.8)
        axes.set(xlabel=f"real{unit}", ylabel=f"imaginary{unit}", aspect="equal")
        axes.set_title(title, loc="left")
    limit = 1.3 * float(np.abs(np.concatenate([found.poles, found.zeros])).max(initial=1.0 if dt else 0.0)) or 1.0
    for axes, reach in ((plane, limit), (locus, found.locus.extent)):
        axes.grid(visible=False)
        (_sampled_grid if dt else _damping_grid)(axes, reach)
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    plane.legend(frameon=False, loc="upper right")
    locus.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.16), fontsize=7.5, ncols=2)
    return figure


def _locus_lines(axes: Axes, locus: RootLocus) -> None:
    for angle in locus.asymptotes if locus.centroid is not None else ():
        end = complex(locus.centroid or 0.0) + 4.0 * locus.extent * np.exp(1j * angle)
        axes.plot([locus.centroid, end.real], [0.0, end.imag], "--", color=NEUTRAL, lw=0.9)
    for branch in locus.branches:
        axes.plot(branch.real, branch.imag, color=ESTIMATE, lw=1.5)
    upper = [mark for mark in locus.crossings if mark.point.imag >= 0.0]
    for marks, style, color in ((upper, "D", GROUPS[1]), (locus.breakaways, "s", TRUTH)):
        for mark in marks:
            kind = "crosses" if style == "D" else "branches meet"
            label = f"{kind} at {complex_label(mark.point)}, gain {mark.gain:.4g}"
            axes.plot(mark.point.real, mark.point.imag, style, mfc="none", color=color, ms=6, label=label)
    axes.plot(locus.unity.real, locus.unity.imag, "*", color=ODOMETRY, ms=7, label="gain 1")
    if locus.centroid is not None:
        axes.plot([], [], "--", color=NEUTRAL, lw=0.9, label=f"asymptotes from {locus.centroid:.4g}")


def complex_label(value: complex) -> str:
    """Return a point of the plane as short text, such as -1.42 or 3.317j."""
    if abs(value.real) < 1e-9 * abs(value):
        return f"{value.imag:.4g}j"
    return f"{value.real:.4g}" + ("" if abs(value.imag) < 1e-9 * abs(value) else f"{value.imag:+.4g}j")


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
        ("" if closed is None else closed.what, None if closed is None else (closed.time, closed.step)),
        ("with dry friction", None if closed is None else closed.rough),
        held=design.dt > 0.0,
    )


def decibels(magnitude: Array) -> Array:
    """Return gains in dB."""
    return np.asarray(20.0 * np.log10(np.maximum(magnitude, 1e-300)))


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def _decibel_text(value: float | None) -> str:
    return "-" if value is None else f"{20.0 * np.log10(value):.4g} dB"


def tables(found: Experiment) -> Mapping[str, tuple[list[str], Any]]:
    """Return the data of the plots by file name: column heads, and columns."""
    study, names = found.study, list(found.study.plant.outputs)
    tables: dict[str, tuple[list[str], Any]] = {
        "step": (["time_s", *names], np.column_stack([study.time, *study.step])),
        "impulse": (["time_s", *names], np.column_stack([study.time, *study.impulse])),
        "bode": (
            ["omega_rad_s", "magnitude", "phase_rad"],
            np.column_stack([study.omega, study.magnitude, study.phase]),
        ),
    }
    for number, design in enumerate(found.designs, start=1):
        tables[f"design_{number}"] = (["time_s", *names], np.column_stack([design.time, *design.step]))
    return tables
