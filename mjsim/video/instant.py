"""One instant of a run as a picture, or its plan as SVG or PDF."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, ellipse_magnification
from mjsim.output import require_free, write_file
from mjsim.plan import PlanItem, SvgPlan, Theme, Words, bounds_of, pdf_plan, world_words
from mjsim.record import Recording, Track
from mjsim.sentences import Sentence
from mjsim.video.diagram_drawing import body_outlines, posed
from mjsim.video.film import display_of
from mjsim.video.ink import encoded_picture
from mjsim.video.moment import Moment, moments
from mjsim.video.oblique import ObliqueView, standing_arms
from mjsim.video.run_plan import MAX_TRAIL_STEP, PlanState
from mjsim.video.views import arms_alone, composed_picture, first_robot, plan_picture
from mjsim.world import World

SUFFIXES = (".svg", ".pdf", ".png", ".jpg", ".jpeg")
"""Suffixes of files of an instant."""
RATIOS = (10, 15, 20, 25, 30, 40, 50, 75, 100, 150, 200, 250, 500, 750, 1000, 2000, 5000, 10000)
"""Scale denominators; the first with which the plan fits on `WIDTH` is used."""
WIDTH = 250.0
"""Maximum side of a plan [mm]."""
COLUMN, CLOSE_UP = 85.0, "close-up"
"""Width of a close-up of the robot and what it sees, that of a paper's column [mm]; name of that view."""
BELIEF = ("true robot", "estimated robot", "pose ellipse", "sighting")
"""Roles that a close-up shows whole."""
PAPER = (".svg", ".pdf")
MARGIN = 5.0
"""Margin around everything [mm]."""


def write_instant(
    recording: Recording,
    path: str | Path,
    time: float,
    *,
    view: str | None = None,
    follow: str | None = None,
    sightings: bool | None = None,
    ellipses: bool | None = None,
    trails: bool | None = None,
    theme: Theme = "light",
    overwrite: bool = False,
) -> None:
    """Write one instant of a recording: the plan as SVG or PDF, to scale, or a frame of the film as PNG or JPEG.

    Args:
        recording: The recording.
        path: Output file; its suffix chooses the format.
        time: The instant [s]; the last tick not after it is shown.
        view: 'plan', 'close-up' of the robot and what it sees (SVG and PDF), or by default the composed view for PNG
            and JPEG.
        follow: As for `make_video`, like the following ones.
        sightings: Whether to draw lines to sighted beacons.
        ellipses: Whether to draw 95 % ellipses.
        trails: Whether to draw the paths of the robot.
        theme: Colours of SVG and PDF: for white or for dark paper.
        overwrite: Whether an existing file may be replaced.

    Raises:
        UsageError: The time is outside the recording, the view or the format does not exist, or the file exists or
            cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise UsageError(
            Sentence(
                "cannot write an instant as '{path}'; name it {suffixes} or {other_suffixes}",
                path,
                ", ".join(SUFFIXES[:-1]),
                SUFFIXES[-1],
            )
        )
    require_free(Path(path), overwrite=overwrite)
    if view not in (None, "plan") and (view, suffix in PAPER) != (CLOSE_UP, True):
        raise UsageError(
            Sentence("view is '{view}'; an instant is shown as plan, as close-up (SVG, PDF), or without a view", view)
        )
    begin, end = float(recording.time[0]), float(recording.time[-1])
    if not begin <= time <= end + 1e-6:
        raise UsageError(Sentence("time is {time:g} s; the recording has {begin:g} to {end:g} s", time, begin, end))
    row = int(np.searchsorted(recording.time, time + 1e-6, side="right")) - 1
    display = display_of(recording.world.run.view, follow, sightings, ellipses, trails)
    if suffix not in PAPER:
        draw = composed_picture if view is None else plan_picture
        write_file(path, encoded_picture(path, draw(recording, row, display)), overwrite=overwrite)
        return
    robot = first_robot(recording)
    (moment,) = moments(recording, robot, [row])
    if view is None and arms_alone(recording):
        oblique = ObliqueView(recording, standing_arms(recording))
        write_file(path, _plan(oblique.items(moment, row), (), path, theme, oblique.bounds), overwrite=overwrite)
        return
    state, note = PlanState(recording.world, robot, display), ""
    if view == CLOSE_UP and display.ellipses:
        (radius,) = (each.body.radius for each in recording.world.robots if each.name == robot)
        moment, note = _magnified(moment, radius)
    paths = _paths(recording.robots[robot], row) if display.trails else ()
    still, machines = state.still(state.gone(moment)), _mechanisms(recording.world, moment)
    moving = state.moving(moment)
    around, width = (_close_bounds(moving), COLUMN) if view == CLOSE_UP else (None, WIDTH)
    items = [*still, *paths, *machines, *moving]
    write_file(path, _plan(items, _words(recording.world), path, theme, around, width, note), overwrite=overwrite)


def _plan(
    shapes: Sequence[PlanItem],
    words: Sequence[Words],
    path: str | Path,
    theme: Theme,
    bounds: Array | None = None,
    width: float = WIDTH,
    note: str = "",
) -> bytes:
    """Return a plan as the contents of an SVG or PDF file, by its name; by default all of it, with a note below."""
    bounds = bounds_of(shapes) if bounds is None else bounds
    size = float(np.ptp(bounds, axis=0).max()) * 1000.0
    ratio = float(next((each for each in RATIOS if size / each <= width), RATIOS[-1]))
    margin = MARGIN * ratio / 1000.0
    bounds = bounds + np.array([[-margin], [margin]])
    if note:
        bounds[0, 1] -= margin
        words = [*words, Words(text=note, at=bounds[0] + [0.0, 0.6 * margin], side=np.array([1.0, 0.0]))]
    if Path(path).suffix.lower() == ".pdf":
        return pdf_plan(shapes, words, bounds, ratio=ratio, theme=theme)
    plan = SvgPlan(bounds, ratio=ratio, theme=theme)
    plan.draw(shapes)
    plan.name(words)
    return plan.data()


def _magnified(moment: Moment, radius: float) -> tuple[Moment, str]:
    """Return a moment with ellipses magnified to be visible, at most to the size of the body, and a note."""
    if not np.isfinite(moment.estimate).all():
        return moment, ""
    factor = ellipse_magnification(moment.covariance[:2, :2], radius)
    larger = replace(moment, covariance=factor**2 * moment.covariance, covariances=factor**2 * moment.covariances)
    return larger, f"95 % ellipses, magnified {factor} times" if factor > 1 else "95 % ellipses"


def _close_bounds(moving: Sequence[PlanItem]) -> Array:
    """Return the bounds of a robot, its estimate with its ellipse, and its lines of sight, shape (2, 2) [m].

    They are as wide as the column, and at least half as high.
    """
    low, high = bounds_of([item for item in moving if item.role in BELIEF])
    size = float(np.max(high - low))
    half = np.maximum((high - low) / 2.0, [size / 2.0, size / 4.0])
    return np.stack([(low + high) / 2.0 - half, (low + high) / 2.0 + half])


def _words(world: World) -> list[Words]:
    return [each for each in world_words(world) if not each.moves and each.of != "wall"]


def _paths(track: Track, row: int) -> Iterator[PlanItem]:
    """Yield the paths of a robot up to a row; it leaves none where it was lifted."""
    named = ((track.odometry, "odometry path"), (track.truth, "true path"), (track.estimate, "estimated path"))
    for poses, role in named:
        points = poses[: row + 1, :2]
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) > 1:
            yield PlanItem(role=role, kind="line", parts=_pieces(points) if role == "true path" else [points])


def _pieces(points: Array) -> list[Array]:
    jumps = np.flatnonzero(np.hypot(*np.diff(points, axis=0).T) > MAX_TRAIL_STEP) + 1
    return [piece for piece in np.split(points, jumps) if len(piece) > 1]


def _mechanisms(world: World, moment: Moment) -> Iterator[PlanItem]:
    """Yield the bodies of mechanisms."""
    for item in world.mechanisms:
        values = moment.arms.get(item.name, item.assembly.start)
        if np.isfinite(values).all():
            for name, outline in body_outlines(posed(item, values)):
                yield PlanItem(role="obstacle", parts=(outline,), tint=item.body(name).color)
