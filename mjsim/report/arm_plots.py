"""Plots of joints in reports: of arms with their tools, and of the driven wheels of balancing bases."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mjsim.geometry import Array
from mjsim.plan import GROUPS
from mjsim.record import JointTrack
from mjsim.report.plots import joint_legend, joint_sheet, sheet

XYZ = ("#d55e00", "#009e73", "#0072b2")
"""Colours of X, Y and Z that the colour-blind can distinguish."""


def arm_plots(time: Array, track: JointTrack, slides: Array) -> dict[str, Figure]:
    """Return the plots of an arm by name.

    Args:
        time: Time of the ticks, shape (N,) [s].
        track: What was recorded.
        slides: Which joints slide, shape (joints,).
    """
    known = np.isfinite(track.positions).all(axis=1)
    if not known.any():
        return {}
    part, times = track.at(np.flatnonzero(known)), time[known]
    return {"joints": _joints(times, part, slides), "tool": _tool(times, part), "tool_path": _path(part)}


def drive_plots(time: Array, track: JointTrack) -> dict[str, Figure]:
    """Return the plots of the wheels of a balancing base, by name.

    Args:
        time: Time of the ticks, shape (N,) [s].
        track: What was recorded.
    """
    known = np.isfinite(track.positions).all(axis=1)
    if not known.any():
        return {}
    part, times = track.at(np.flatnonzero(known)), time[known]
    rows = (
        (np.degrees(part.goal - part.positions), "tracking error [deg]"),
        (np.degrees(part.velocities), "rate [deg/s]"),
        (part.torques, "torque [N m]"),
    )
    figure, panels = joint_sheet(times, part.names, rows, title="Wheels", height=7.0)
    joint_legend(panels[0])
    return {"wheels": figure}


def _joints(time: Array, track: JointTrack, slides: Array) -> Figure:
    """Draw positions with their goals, rates, accelerations and torques of all joints over time."""
    scale = np.where(slides, 1.0, 180.0 / np.pi)
    angle = "m" if slides.all() else "deg, m" if slides.any() else "deg"
    torque = "N" if slides.all() else "N m, N" if slides.any() else "N m"
    rows = (
        (track.positions * scale, f"q [{angle}]"),
        (track.velocities * scale, f"qd [{angle}, per s]"),
        (track.accelerations * scale, f"qdd [{angle}, per s^2]"),
        (track.torques, f"torque [{torque}]"),
    )
    figure, panels = joint_sheet(time, track.names, rows)
    for number, goal in enumerate((track.goal * scale).T):
        color = GROUPS[number % len(GROUPS)]
        panels[0].plot(time, goal, color=color, lw=1.0, ls=":", label="goals" if number == 0 else None)
    joint_legend(panels[0])
    return figure


def _tool(time: Array, track: JointTrack) -> Figure:
    """Draw X, Y and Z of the tool over time."""
    figure, panels = sheet(3, height=6.0)
    for axes, column, name, color in zip(panels, track.tool.T, "XYZ", XYZ, strict=False):
        axes.plot(time, column, color=color, lw=1.4)
        axes.set_ylabel(f"{name} [m]")
    panels[0].set_title("Tool, world frame")
    panels[-1].set_xlabel("time [s]")
    return figure


def _path(track: JointTrack) -> Figure:
    """Draw the path of the tool in space, with its projection on the floor of the plot."""
    figure = Figure(figsize=(7.0, 6.2), dpi=110, layout="constrained")
    axes: Any = figure.add_subplot(projection="3d")
    x, y, z = track.tool[:, :3].T
    middle = [(column.max() + column.min()) / 2 for column in (x, y, z)]
    half = 0.55 * max(float(np.ptp(column)) for column in (x, y, z)) + 1e-3
    low = middle[2] - half
    axes.plot(x, y, np.full_like(z, low), color="#c9ced6", lw=1.5)
    axes.plot(x, y, z, color=XYZ[2], lw=1.8, label="tool")
    axes.plot(x[:1], y[:1], z[:1], "o", color=XYZ[1], ms=6, label="start")
    axes.plot(x[-1:], y[-1:], z[-1:], "s", color=XYZ[0], ms=6, label="end")
    limits = (axes.set_xlim, axes.set_ylim, axes.set_zlim)
    for set_limits, center in zip(limits, middle, strict=True):
        set_limits(center - half, center + half)
    axes.set(xlabel="X [m]", ylabel="Y [m]", zlabel="Z [m]", title="Path of the tool")
    axes.set_box_aspect((1, 1, 1))
    axes.legend(loc="upper left", frameon=False)
    return figure
