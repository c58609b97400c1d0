"""Cards that notebooks show for values: a few numbers as HTML of a few kilobytes, beside a small plan as SVG."""

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import singledispatch
from html import escape
from itertools import islice

import numpy as np

from mjsim.errors import one_line
from mjsim.geometry import Array
from mjsim.lab import Experiment, card_of
from mjsim.plan import PlanItem, SvgPlan, bounds_of, placed_at, world_shapes
from mjsim.record import Recording, Track
from mjsim.report import FIGURES, Comparison, Statistics, comparison_lines, figure_value, metrics
from mjsim.sentences import number_of
from mjsim.sim import Simulation
from mjsim.sweep import Sweep, key_lines
from mjsim.world import World

MAX_ROWS = 30
"""Maximum number of rows of a table, and of lines of a text."""
MAX_CHARACTERS = 60
"""Maximum length of a text in a cell [characters]."""
Row = Sequence[object]


@singledispatch
def html_of(value: object) -> str:
    """Return the HTML by which a notebook shows a value."""
    raise TypeError(f"a notebook cannot show a {type(value).__name__}")


@html_of.register
def _(world: World) -> str:
    shapes = world_shapes(world)
    wide, deep = np.ptp(bounds_of(shapes), axis=0)
    kinds = ("walls", "obstacles", "beacons", "mechanisms", "people", "lamps")
    rows: list[Row] = [("size", f"{wide:.1f} x {deep:.1f} m")] if shapes else []
    rows += [(kind, len(items)) for kind in kinds if (items := getattr(world, kind))]
    rows += [(robot.name, ", ".join(sensor.kind for sensor in robot.sensors) or "no sensors") for robot in world.robots]
    return _card(svg_of(shapes), f"World {world.name}", [*rows, ("run", f"{world.run.seconds:g} s")])


@html_of.register
def _(sim: Simulation) -> str:
    frames = sim.things() | {f"robot/{name}": pose for name, pose in sim.truths().items()}
    rows = [
        (name, f"x {pose.x:.3f} m, y {pose.y:.3f} m, heading {np.degrees(pose.heading):.1f}°")
        for name, pose in sim.truths().items()
    ]
    head = [("time", f"{sim.time:g} s"), ("seed", sim.seed)]
    return _card(svg_of(placed_at(world_shapes(sim.world), frames)), f"Simulation of {sim.world.name}", [*head, *rows])


@html_of.register
def _(recording: Recording) -> str:
    rows: list[Row] = [("duration", _duration(recording.time)), ("seed", recording.seed)]
    rows += [] if recording.whole else [("incomplete", "the run was killed, or the file truncated")]
    for name, track in recording.robots.items():
        rows += [(f"{name}: {title}", value) for title, value in _errors(track)]
    picture = svg_of(world_shapes(recording.world), recording.robots.values())
    return _card(picture, f"Recording of {recording.world.name}", rows)


@html_of.register
def _(track: Track) -> str:
    seen = sum(map(len, track.sightings))
    rows = [("duration", _duration(track.time)), *_errors(track), ("sightings", seen)]
    return _card(svg_of((), (track,)), "Track of a robot", [*rows, ("landmarks", len(track.landmarks.names))])


@html_of.register
def _(figures: Statistics) -> str:
    robots = {name: each for name, each in figures.items() if name != "run"}
    table = [(figure, [figure_value(each, figure.key) for each in robots.values()]) for figure in FIGURES]
    rows = [(figure.heading, *map(figure.text, values)) for figure, values in table if set(values) != {None}]
    return _card("", "Statistics", rows, heads=("", *robots))


@html_of.register
def _(comparison: Comparison) -> str:
    return _text("Comparison", comparison_lines(comparison))


@html_of.register
def _(sweep: Sweep) -> str:
    return _text(f"Sweep in {sweep.folder}", key_lines(sweep.summary))


@html_of.register
def _(experiment: Experiment) -> str:
    shown: str = card_of(experiment)
    return shown


def _duration(time: Array) -> str:
    return f"{time[-1] - time[0]:g} s, {number_of(len(time), 'tick')}" if len(time) else "no ticks"


def _errors(track: Track) -> Iterator[tuple[str, str]]:
    """Yield title and value of the position errors of a robot whose pose was known."""
    for title, poses in (("position error", track.estimate), ("odometry error", track.odometry)):
        errors = metrics.position_errors(track.truth, poses)
        if np.isfinite(errors).any():
            known = errors[np.isfinite(errors)]
            yield f"{title}, rmse", f"{np.sqrt(np.mean(known**2)):.3f} m"


def _card(picture: str, title: str, rows: Iterable[Row], *, heads: Row = ()) -> str:
    """Return a picture with a table beside it."""
    rows = list(rows)
    left = len(rows) - MAX_ROWS
    shown = [*rows[:MAX_ROWS], *([("...", f"{left} more")] if left > 0 else [])]
    lines = "".join(_row(row, "td") for row in shown)
    table = f"<table>{_row(heads, 'th') if heads else ''}{lines}</table>"
    style = "display:flex;flex-wrap:wrap;gap:1em;align-items:flex-start"
    return f'<div style="{style}">{picture}<div><b>{_cell(title)}</b>{table}</div></div>'


def _row(cells: Row, tag: str) -> str:
    return f"<tr>{''.join(f'<{tag}>{_cell(cell)}</{tag}>' for cell in cells)}</tr>"


def _cell(value: object) -> str:
    text = one_line(str(value))
    return escape(text if len(text) <= MAX_CHARACTERS else f"{text[:MAX_CHARACTERS]}...")


def _text(title: str, lines: Iterable[str]) -> str:
    """Return lines in columns, as a terminal shows them."""
    shown = list(islice(lines, MAX_ROWS + 1))
    if len(shown) > MAX_ROWS:
        shown[MAX_ROWS] = "..."
    return f"<b>{_cell(title)}</b><pre>{escape(chr(10).join(shown))}</pre>"


LONGER_SIDE = 90.0
"""Length of the longer side of the picture [mm]."""
MARGIN = 0.04
"""Margin around everything, as a fraction of the longer side."""
MAX_POINTS = 300
"""Maximum number of points of a path."""


def svg_of(shapes: Iterable[PlanItem], tracks: Iterable[Track] = ()) -> str:
    """Return a plan with paths, true ones wide and light; empty if there is nothing to draw."""
    shapes, tracks = list(shapes), list(tracks)
    truths = [_path("true path", track.truth) for track in tracks]
    if not shapes and not any(len(part) for path in truths for part in path.parts):
        return ""
    bounds = bounds_of([*shapes, *truths])
    side = float(np.ptp(bounds, axis=0).max())
    plan = SvgPlan(bounds + np.array([[-1.0], [1.0]]) * MARGIN * side, ratio=1000.0 * side / LONGER_SIDE)
    paths = [path for track, truth in zip(tracks, truths, strict=True) for path in _paths(track, truth, bounds)]
    plan.draw([*shapes, *paths])
    svg = plan.data().decode().partition("?>")[2]
    # Millimetres are enough, and ids of several pictures on a page would be the same.
    return re.sub(r' id="[^"]*"|\n *', "", re.sub(r"(\.\d)\d+", r"\1", svg))


def _paths(track: Track, truth: PlanItem, bounds: Array) -> Sequence[PlanItem]:
    """Return the dead-reckoned, true and estimated path; those that leave the picture stay beside it."""
    reach = bounds + np.array([[-1.0], [1.0]]) * np.ptp(bounds, axis=0).max()
    odometry = _path("odometry path", np.clip(track.odometry, *np.pad(reach, ((0, 0), (0, 1)))))
    estimate = _path("estimated path", np.clip(track.estimate, *np.pad(reach, ((0, 0), (0, 1)))))
    return odometry, truth, estimate


def _path(role: str, poses: Array) -> PlanItem:
    """Return the known part of a path as a line, poses of shape (N, 3)."""
    known = poses[np.isfinite(poses).all(axis=1), :2]
    rows = np.unique(np.linspace(0, max(len(known) - 1, 0), MAX_POINTS).astype(int))
    return PlanItem(role=role, kind="line", parts=(known[rows[: len(known)]],))
