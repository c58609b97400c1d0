"""The page of a workplace: posture, reach, sight and clearance in one HTML file that opens offline.

It has pictures from a person's eyes and from outside, and plots: the posture from the side and from above, reach as
surfaces, and the visual fields as angles.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import cv2
import mujoco
import numpy as np

from mjsim.ergonomics.sight import FIELD, MIN_DISPLAY_ANGLE, Eye, points_on
from mjsim.ergonomics.workplace_study import PersonStudy, contact_figure, figures_of
from mjsim.errors import OpenGLError
from mjsim.geometry import Array
from mjsim.people import SIDES
from mjsim.posture import ANGLES, comfort_of
from mjsim.progress import say
from mjsim.report import Block, Heading, HtmlTable, Paragraph, drawing_files, html_page, picture, png_of
from mjsim.sim import SEEN_FROM_OUTSIDE, Renderer
from mjsim.world import DisplayTarget, PlacedTarget

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def page_files(study: PersonStudy, *, formats: Sequence[str] = ("png",)) -> dict[str, bytes]:
    """Return the files of a person by name: page, results as JSON, plots, and pictures if OpenGL is available.

    Args:
        study: The person.
        formats: Formats of the plots beside PNG, which the page has: 'pdf', 'svg'.
    """
    name = study.person.name
    plots = {"posture": posture_plot(study), "reach": reach_plot(study), "sight": sight_plot(study)}
    drawn = {kind: png_of(plot) for kind, plot in plots.items()}
    others = drawing_files({f"{name}_{kind}": plot for kind, plot in plots.items()}, [*({*formats} - {"png"})])
    drawn |= pictures_of(study.model, name, study.eyes)
    figures = json.dumps(figures_of(study), indent=1, allow_nan=False) + "\n"
    return {
        f"{name}.html": _page(study, drawn).encode(),
        f"{name}.json": figures.encode(),
        **{f"{name}_{kind}.png": data for kind, data in drawn.items()},
        **others,
    }


def _page(study: PersonStudy, drawn: dict[str, bytes]) -> str:
    images = {kind: picture(f"{kind} of {study.person.name}", data) for kind, data in drawn.items()}
    return html_page(study.person.name, "mjsim ergonomics", *_blocks(study, images))


def _blocks(study: PersonStudy, images: Mapping[str, Block]) -> Iterator[Block]:
    person = study.person
    along, up = (1000.0 * value for value in study.seated.set_by)
    yield Paragraph(
        f"{person.sex}, stature {1000 * person.figure.measures['stature']:.0f} mm, on {person.seat}, "
        f"set {along:+.0f} mm along and {up:+.0f} mm up from the middle of its travel",
        "run",
    )
    yield from (Paragraph(each, "fault") for each in fault_lines(study))
    yield from (images[kind] for kind in ("outside",) if kind in images)
    yield from (Heading("Posture"), images["posture"], _angles(study))
    yield Paragraph(
        "Published ranges are shown as they are; there is no score. For joints without one, the middle position is "
        "preferred, and each deviation counts as a fraction of the joint's range."
    )
    yield from (Heading("Contacts"), _contacts(study), Heading("Reach"), images["reach"], _reaches(study))
    yield from (Heading("Sight"), images["sight"], *_views(study))
    yield from (images[kind] for kind in ("left_eye", "right_eye") if kind in images)
    yield from (Heading("Clearance"), _clearances(study), Heading("Seat"), _settings(study))


def fault_lines(study: PersonStudy) -> list[str]:
    """Return a message for each contact out of reach, and for each object that the posture collides with."""
    errors = study.seated.errors
    missed = [
        f"{name} is off by {math.degrees(errors[name]):.1f} degrees"
        if name == "gaze"
        else f"{name} is out of reach by {1000 * errors[name]:.1f} mm"
        for name in study.seated.missed
    ]
    return [
        *missed,
        *(f"{each.segment} goes {-1000 * each.distance:.0f} mm into {each.thing}" for each in study.collisions),
    ]


def _angles(study: PersonStudy) -> HtmlTable:
    rows = []
    for name, value in study.angles.items():
        bare = name.removeprefix("left_").removeprefix("right_")
        ranges = comfort_of(name)
        side = "" if bare == name else name.removesuffix(f"_{bare}") + ", "
        comfort = "; ".join(f"{each.low:g} to {each.high:g} ({each.source})" for each in ranges)
        rows.append((side + ANGLES[bare], f"{value:.0f}", comfort or "none"))
    return HtmlTable(("angle", "[deg]", "published comfort [deg]"), rows, wide=True)


def _contacts(study: PersonStudy) -> HtmlTable:
    rows = []
    for name, error in study.seated.errors.items():
        ((unit, value),) = contact_figure(name, error).items()
        rows.append((name, f"{value:.4f} {unit.removeprefix('error_')}"))
    return HtmlTable(("contact", "error"), rows, wide=True)


def _reaches(study: PersonStudy) -> HtmlTable:
    rows = [(each.target, each.limb, _short(each.short), _short(each.leaning)) for each in study.reaches]
    return HtmlTable(("target", "limb", "back on the backrest", "leaning"), rows, wide=True)


def _short(short: float) -> str:
    return "reached" if short == 0.0 else f"out of reach by {1000 * short:.0f} mm"


def _views(study: PersonStudy) -> Iterator[Block]:
    rows = []
    for name, view in study.views.items():
        shares = [f"{100 * view.shares[key]:.1f} %" for key in ("left", "right", "both", "either")]
        hidden = ", ".join(f"{name} {100 * share:.1f} %" for name, share in view.hidden_by.items()) or "nothing"
        steep = f"{view.incidence_deg:.0f}" + (
            "" if view.incidence_deg >= MIN_DISPLAY_ANGLE else f" (below {MIN_DISPLAY_ANGLE:g})"
        )
        rows.append((name, *shares, hidden, f"{view.distance:.2f}", steep))
    heads = ("display", "left eye", "right eye", "both", "either", "hidden from both by", "distance [m]", "angle [deg]")
    if not rows:
        yield Paragraph("There is no display.")
        return
    yield HtmlTable(heads, rows, wide=True)
    yield Paragraph(
        f"The angle is that of the line of sight to the face; NUREG-0700 rev. 3 asks for {MIN_DISPLAY_ANGLE:g} or more."
    )


def _clearances(study: PersonStudy) -> HtmlTable:
    rows = [(each.segment, each.thing, f"{1000 * each.distance:.0f}") for each in study.clearances]
    return HtmlTable(("segment", "thing", "[mm]"), rows, wide=True)


def _settings(study: PersonStudy) -> HtmlTable:
    rows = [
        (
            f"{each.sex}, percentile {each.percentile:g}",
            *(f"{1000 * value:+.0f}" for value in (*each.set_by, *each.ideal)),
            ", ".join(each.missed) or "none",
        )
        for each in study.settings
    ]
    return HtmlTable(("figure", "along [mm]", "up [mm]", "wished along", "wished up", "out of reach"), rows, wide=True)


LOOKING = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""eye_from_camera: right, up and back of the camera in the axes of an eye, as columns."""
WIDTH, HEIGHT = 640, 480
"""Size of a picture [px]."""
VIEW = 2.6, 62.0, -16.0
"""External view of a person: distance [m], azimuth and elevation relative to the seat [deg]."""


def pictures_of(model: mujoco.MjModel, person: str, eyes: tuple[Eye, Eye]) -> dict[str, bytes]:
    """Return the pictures of a person by name; none if rendering is impossible, which is reported.

    Args:
        model: The compiled world.
        person: Name of the person.
        eyes: Both eyes with their lines of sight.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    pelvis = model.body(f"{person}/pelvis").id
    try:
        with Renderer(model, width=WIDTH, height=HEIGHT, groups=SEEN_FROM_OUTSIDE) as renderer:
            found = {"outside": renderer.render(data, _outside(data, pelvis)).copy()}
            for eye in eyes:
                name = f"{person}/{eye.side}_eye"
                # A camera of MuJoCo looks along -z, with x to the right; an eye looks along its line of sight.
                data.cam_xmat[model.camera(name).id] = (eye.axes @ LOOKING).ravel()
                found[f"{eye.side}_eye"] = renderer.render(data, name).copy()
    except OpenGLError as error:
        say(f"no pictures: {error}")
        return {}
    return {name: _png(image) for name, image in found.items()}


def _outside(data: mujoco.MjData, pelvis: int) -> mujoco.MjvCamera:
    """Return a camera beside and behind the shoulder of a seated person."""
    camera = mujoco.MjvCamera()
    camera.type = mujoco.mjtCamera.mjCAMERA_FREE
    camera.lookat[:] = data.xpos[pelvis] + (0.0, 0.0, 0.25)
    axes = data.xmat[pelvis].reshape(3, 3)
    heading = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    camera.distance, camera.azimuth, camera.elevation = VIEW[0], heading + VIEW[1], VIEW[2]
    return camera


def _png(image: np.ndarray[tuple[int, ...], np.dtype[np.uint8]]) -> bytes:
    return bytes(cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())


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
