"""Plots of mechanisms in reports: joints over time, sensors, phase plots, energy."""

import numpy as np
from matplotlib.figure import Figure

from mjsim.geometry import Array
from mjsim.plan import GROUPS
from mjsim.record import JointTrack, SensorTrack
from mjsim.report.plots import joint_legend, joint_sheet, sheet

MAX_LINES = 16
"""Maximum number of values in one panel, and of sensors in one sheet."""


def mechanism_plots(time: Array, joints: JointTrack, slides: Array, sensors: SensorTrack) -> dict[str, Figure]:
    """Return the plots of a mechanism by name.

    Args:
        time: Time of the ticks, shape (N,) [s].
        joints: Their motion.
        slides: Which values are lengths, shape (values,).
        sensors: Their readings.
    """
    known = np.isfinite(joints.positions).all(axis=1)
    if not known.any() or not len(joints.names):
        return {}
    part, times, read = joints.at(np.flatnonzero(known)), time[known], sensors.at(np.flatnonzero(known))
    plots = {"joints": _joints(times, part, slides), "phase": _phase(part, slides)}
    plots |= {f"sensors_{unit}": figure for unit, figure in _sensors(times, read)}
    energy = _energy(times, read)
    return plots | ({} if energy is None else {"energy": energy})


def _joints(time: Array, track: JointTrack, slides: Array) -> Figure:
    """Draw positions, speeds, accelerations and efforts; angles in degrees."""
    scale = np.where(slides, 1.0, 180.0 / np.pi)
    angle = "m" if slides.all() else "deg, m" if slides.any() else "deg"
    effort = "N" if slides.all() else "N m, N" if slides.any() else "N m"
    rows = (
        (track.positions * scale, f"position [{angle}]"),
        (track.velocities * scale, f"speed [{angle}, per s]"),
        (track.accelerations * scale, f"acceleration [{angle}, per s²]"),
        (track.torques, f"actuators [{effort}]"),
    )
    figure, panels = joint_sheet(time, track.names[:MAX_LINES], rows)
    joint_legend(panels[0])
    return figure


def _phase(track: JointTrack, slides: Array) -> Figure:
    """Draw speed over position of each joint."""
    count = min(len(track.names), MAX_LINES)
    columns = min(count, 4)
    rows = -(-count // columns)
    figure = Figure(figsize=(2.9 * columns + 0.4, 2.7 * rows + 0.3), dpi=110, layout="constrained")
    for number in range(count):
        axes = figure.add_subplot(rows, columns, number + 1)
        unit, scale = ("m", 1.0) if slides[number] else ("deg", 180.0 / np.pi)
        axes.plot(track.positions[:, number] * scale, track.velocities[:, number] * scale, color=GROUPS[0], lw=1.0)
        axes.plot(track.positions[:1, number] * scale, track.velocities[:1, number] * scale, "o", color="#009e73", ms=5)
        axes.set(title=track.names[number], xlabel=f"[{unit}]", ylabel=f"[{unit}/s]")
        axes.grid(visible=True, color="#e6e6e6", lw=0.6)
    return figure


def _sensors(time: Array, track: SensorTrack) -> list[tuple[str, Figure]]:
    """Return a sheet for each unit that sensors read."""
    groups: dict[str, list[int]] = {}
    for number, (name, unit) in enumerate(zip(track.names, track.units, strict=True)):
        if not name.startswith("energy."):
            groups.setdefault(unit, []).append(number)
    found = []
    for unit, numbers in groups.items():
        names = {number: track.names[number].rpartition(".")[0] for number in numbers}
        sensors = list(dict.fromkeys(names.values()))[:MAX_LINES]
        figure, panels = sheet(len(sensors), height=0.8 + 1.9 * len(sensors))
        for axes, sensor in zip(panels, sensors, strict=True):
            own = [number for number in numbers if names[number] == sensor]
            for place, number in enumerate(own):
                label = track.names[number].rpartition(".")[2]
                axes.plot(time, track.values[:, number], color=GROUPS[place % len(GROUPS)], lw=1.2, label=label)
            axes.set_ylabel(f"{sensor}\n[{unit or '1'}]", fontsize=8)
            axes.legend(loc="upper right", frameon=False, fontsize=8, ncols=4)
        panels[0].set_title(f"Sensors [{unit or '1'}]", loc="left")
        panels[-1].set_xlabel("time [s]")
        found.append((_word(unit), figure))
    return found


def _word(unit: str) -> str:
    """Return a unit as a part of a file's name."""
    return unit.replace("/", "_per_").replace("^", "").replace(" ", "") or "1"


def _energy(time: Array, track: SensorTrack) -> Figure | None:
    """Draw energies, work of actuators, losses, and the residual of their balance."""
    parts = {name.removeprefix("energy."): track.column(name) for name in track.names if name.startswith("energy.")}
    if not parts:
        return None
    figure, panels = sheet(2, height=5.5)
    for number, (name, values) in enumerate(parts.items()):
        panels[0].plot(
            time, values - (values[0] if name == "potential" else 0.0), color=GROUPS[number], lw=1.2, label=name
        )
    total = parts["kinetic"] + parts["potential"] + parts.get("springs", 0.0)
    balance = total - total[0] - parts.get("work", 0.0) + parts.get("lost", 0.0)
    panels[0].set(ylabel="[J]", title="Energy, potential from the start")
    panels[0].legend(loc="upper right", frameon=False, fontsize=8, ncols=4)
    panels[1].plot(time, balance, color=GROUPS[1], lw=1.2)
    panels[1].set(
        ylabel="[J]", xlabel="time [s]", title="Balance: energy gained, less the work put in, plus what was lost"
    )
    return figure
