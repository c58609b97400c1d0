"""Plots of a study: posture from the side and from above, reach as surfaces, and the visual fields as angles."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from mjsim.ergonomics.sight import FIELD, points_on
from mjsim.ergonomics.workplace_study import PersonStudy
from mjsim.geometry import Array
from mjsim.people import SIDES
from mjsim.world import DisplayTarget, PlacedTarget

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BODY, LEFT, RIGHT, TARGET = "#5f6368", "#2c7fb8", "#d95f0e", "#1b7837"
MAX_TARGET_DISTANCE = 1.6
"""Targets farther from the hip point are not drawn with the posture [m]."""
CHAINS = (
    ("pelvis", "abdomen", "thorax", "neck", "head"),
    *((f"{side}_upper_arm", f"{side}_forearm", f"{side}_hand") for side in SIDES),
    *((f"{side}_thigh", f"{side}_shank", f"{side}_foot") for side in SIDES),
)
"""Chains of joints drawn as lines."""
ENDS = {"head": "vertex", "left_hand": "left_grip", "right_hand": "right_grip", "left_foot": "left_toe"}
"""Landmarks at the ends of these lines."""


def posture_plot(study: PersonStudy) -> "Figure":
    """Return the figure from the side and from above, in the frame of the seat, with targets and reach."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 6.5), layout="constrained")
    for place, (across, title) in enumerate(((2, "from the right"), (1, "from above")), start=1):
        axes = figure.add_subplot(1, 2, place)
        _draw_reach(axes, study, across)
        _draw_body(axes, study, across)
        for target in study.place.targets.values():
            _draw_target(axes, study, target, across)
        axes.set(title=title, xlabel="ahead of the hip point [m]", ylabel=("left" if across == 1 else "up") + " [m]")
        axes.set_aspect("equal")
        axes.grid(alpha=0.3)
    figure.axes[0].legend(loc="upper right", fontsize=8)
    return figure


def reach_plot(study: PersonStudy) -> "Figure":
    """Return the surfaces within reach of the thumbs, with the figure and nearby targets, in the frame of the seat."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    figure = Figure(figsize=(8, 6.5), layout="constrained")
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    for line in _body_lines(study):
        axes.plot(*line.T, "-o", color=BODY, lw=3, ms=4, zorder=1)
    for target in study.place.targets.values():
        at = _local(study, target.world_from_target[:3, 3])
        if np.linalg.norm(at) <= MAX_TARGET_DISTANCE:
            axes.plot(*at[:, None], "x", color=TARGET, zorder=2)
            axes.text(*at, f" {target.target.name}", fontsize=7, color=TARGET, zorder=4)
    for envelope, color in zip(study.envelopes, (LEFT, RIGHT), strict=True):
        points = np.moveaxis(_local(study, envelope.points), -1, 0)
        axes.plot_surface(*points, color=color, alpha=0.25, edgecolor=color, lw=0.4, shade=False, zorder=3)
    axes.set(xlabel="ahead of the hip point [m]", ylabel="left [m]", zlabel="up [m]")
    axes.set_aspect("equal")
    axes.view_init(elev=20.0, azim=-55.0)
    patches = [Patch(color=color, alpha=0.5) for color in (LEFT, RIGHT)]
    axes.legend(patches, [f"reach of the {each.side} thumb" for each in study.envelopes], loc="upper right", fontsize=8)
    return figure


def sight_plot(study: PersonStudy) -> "Figure":
    """Return the fields of both eyes and the displays in them, as angles from the line of sight."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 5), layout="constrained")
    axes = figure.add_subplot()
    for eye, color in zip(study.eyes, (LEFT, RIGHT), strict=True):
        axes.plot(*_field_edge(eye.side), color=color, label=f"field of the {eye.side} eye")
        for name, display in study.place.targets.items():
            if isinstance(display.target, DisplayTarget):
                corners = (points_on(display, count=100) - eye.place) @ eye.axes
                x, y, z = corners.T
                away, along = np.degrees(np.arctan2(np.hypot(y, z), x)), np.hypot(y, z)
                axes.plot(-away * y / along, away * z / along, ".", ms=3, color=color, alpha=0.6)
                if eye.side == "left":
                    middle = -float(np.mean(away * y / along)), float(np.max(away * z / along))
                    axes.annotate(name, middle, ha="center", va="bottom", fontsize=8, color=TARGET)
    axes.set(xlabel="to the right of the line of sight [deg]", ylabel="above the line of sight [deg]")
    axes.set_aspect("equal")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower right", fontsize=8)
    return figure


def _field_edge(side: str) -> tuple[Array, Array]:
    """Return the edge of the field of an eye, to the right and up, shape (n,) each [deg]."""
    turn = np.linspace(0.0, 2.0 * np.pi, 181)
    outward = -np.cos(turn) if side == "left" else np.cos(turn)
    wide = np.where(outward > 0.0, FIELD["temporal"], FIELD["nasal"])
    high = np.where(np.sin(turn) > 0.0, FIELD["up"], FIELD["down"])
    return wide * np.cos(turn), high * np.sin(turn)


def _local(study: PersonStudy, points: Array) -> Array:
    """Return points of the world in the frame of the seat, shape (..., 3) [m]."""
    pose = study.place.seating.world_from_seat
    return np.asarray((points - pose[:3, 3]) @ pose[:3, :3])


def _body_lines(study: PersonStudy) -> Iterator[Array]:
    """Yield the chains of the figure's joints in the frame of the seat, shape (n, 3) [m]."""
    spots = study.person.figure.spots(study.poses)
    for chain in CHAINS:
        places = [study.poses[name][:3, 3] for name in chain]
        last = chain[-1]
        end = ENDS.get(last, last.replace("foot", "toe"))
        yield _local(study, np.array([*places, spots[end]]))


def _draw_body(axes: "Axes", study: PersonStudy, across: int) -> None:
    for line in _body_lines(study):
        axes.plot(line[:, 0], line[:, across], "-o", color=BODY, lw=4, ms=5, alpha=0.8)


def _draw_reach(axes: "Axes", study: PersonStudy, across: int) -> None:
    for envelope, color in zip(study.envelopes, (LEFT, RIGHT), strict=True):
        points = _local(study, envelope.points)
        for row in (*points, *points.swapaxes(0, 1)):
            axes.plot(row[:, 0], row[:, across], color=color, lw=0.7, alpha=0.6)
        axes.plot([], [], color=color, label=f"reach of the {envelope.side} thumb")


def _draw_target(axes: "Axes", study: PersonStudy, target: PlacedTarget, across: int) -> None:
    at = _local(study, target.world_from_target[:3, 3])
    if np.linalg.norm(at) > MAX_TARGET_DISTANCE:
        return
    if isinstance(target.target, DisplayTarget):
        points = _local(study, points_on(target, count=60))
        axes.plot(points[:, 0], points[:, across], ".", color=TARGET, ms=3)
    axes.plot(at[0], at[across], "x", color=TARGET)
    axes.annotate(target.target.name, (at[0], at[across]), fontsize=7, color=TARGET)
