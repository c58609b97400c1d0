"""Draws people on a sheet: each from the right and, below that, from above, all to the same scale."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.people import SIDES
from mjsim.plan import blend, parse_color
from mjsim.posture import poses_of
from mjsim.video.ink import BEACON, INK, MUTED, PAPER, SEMIBOLD, Letters
from mjsim.video.paper import Paper, px
from mjsim.video.plan_view import PlanView
from mjsim.world import Person, World, item_names, look_beside, look_over, person_outlines, placed_targets, prisms

RATIOS = {4: 20.0, 12: 30.0, 32: 50.0}
"""Scale denominators by the maximum number of people."""
TITLE, HEAD = 7.0, 9.0
"""Margin above all people for the title, and above each for the name [mm]."""
MARGIN = 3.0
"""Margin around each drawing [mm]."""
MIN_PANEL_WIDTH = 26.0
"""Minimum width of a panel, for the text above it [mm]."""
WORKPLACE_MARGIN = 0.12
"""Margin of the workplace drawn around the body [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PersonView:
    """A person in a posture and the workplace, seen from a direction; coordinates are in the drawing [m]."""

    body: Sequence[tuple[Array, str]]
    """Convex outlines of the body, shape (n, 2), and their colours, farthest first."""
    things: Sequence[Array]
    """Outlines of the seat and of objects that carry targets of the person, shape (n, 2)."""
    targets: Array
    """Positions of these targets, shape (n, 2)."""

    @property
    def bounds(self) -> Array:
        """Minimum and maximum coordinates of the body with a margin of the workplace, shape (2, 2) [m]."""
        points = np.concatenate([outline for outline, _ in self.body])
        around = WORKPLACE_MARGIN if self.things else 0.0
        return np.stack([points.min(axis=0) - around, points.max(axis=0) + around])


def person_view(world: World, person: Person, poses: Mapping[str, Array], drawing_from_world: Array) -> PersonView:
    """Return the view of a person and of the targets of hands, feet and eyes.

    Args:
        world: World that contains the person.
        person: The person.
        poses: world_from_segment, shape (4, 4) each [m].
        drawing_from_world: View, shape (3, 4) [m]: `look_beside(poses)` or `look_over(poses)`.
    """
    named = {person.hands.left, person.hands.right, person.feet.left, person.feet.right, person.gaze}
    targets = [each for each in placed_targets(world) if each.name in named]
    used = {person.seat, *(each.name.rpartition(".")[0] for each in targets)}
    things = dict(zip(item_names(world.obstacles), world.obstacles, strict=True))
    held = [prism for name, thing in things.items() if name in used for prism in prisms(thing)]
    places = np.array([each.world_from_target[:3, 3] for each in targets]).reshape(-1, 3)
    return PersonView(
        body=list(person_outlines(person, poses, drawing_from_world)),
        things=[_prism_outline(*prism, drawing_from_world) for prism in held],
        targets=_seen(places, drawing_from_world),
    )


def _prism_outline(outline: Array, low: float, high: float, drawing_from_world: Array) -> Array:
    """Return the convex hull of a vertical prism in a drawing, shape (n, 2) [m]."""
    corners = np.concatenate([np.insert(outline, 2, height, axis=1) for height in (low, high)])
    return np.asarray(cv2.convexHull(_seen(corners, drawing_from_world).astype(np.float32))[:, 0], dtype=float)


def _seen(points: Array, drawing_from_world: Array) -> Array:
    """Return points of the world, shape (n, 3) [m], in a drawing, shape (n, 2) [m]."""
    return np.asarray(points @ drawing_from_world[:2, :3].T + drawing_from_world[:2, 3])


def draw_view(drawing: Paper, view: PersonView) -> None:
    """Draw a person over the lines of the workplace; targets are crosses."""
    for line in _around(view):
        drawing.line(line, blend(MUTED, PAPER, 0.4), 0.15)
    for outline, color in view.body:
        _draw_outline(drawing, outline, color)
    arm = drawing.metres(0.8)
    for x, y in view.targets:
        for ends in ([(x - arm, y - arm), (x + arm, y + arm)], [(x - arm, y + arm), (x + arm, y - arm)]):
            drawing.line(ends, BEACON, 0.25)


def _around(view: PersonView) -> Iterator[Array]:
    """Yield the lines of the workplace within the bounds of a view, shape (n, 2) each [m]."""
    from shapely import LinearRing, box, get_coordinates, get_parts, line_merge

    frame = box(*view.bounds.ravel().tolist())
    for outline in view.things:
        within = LinearRing(outline).intersection(frame)
        merged = line_merge(within) if within.geom_type == "MultiLineString" else within
        yield from (get_coordinates(part) for part in get_parts(merged) if part.length > 0.0)


def _draw_outline(drawing: Paper, outline: Array, color: str) -> None:
    drawing.fill(outline, blend(parse_color(color), PAPER, 0.5))
    drawing.line(outline, blend(parse_color(color), INK, 0.45), 0.15, closed=True)


def people_page(world: World, width: int, *, names: bool) -> Picture:
    """Return all people of a world from the right and from above, RGB, in rows of the given width [px]."""
    ratio = next(each for count, each in RATIOS.items() if len(world.people) <= count)
    letters = Letters()
    panels = [_panel(world, person, ratio, letters, names=names) for person in world.people]
    title = np.full((round(px(TITLE)), width, 3), PAPER, np.uint8)
    if names:
        words = f"People from the right and from above, 1 : {ratio:g}"
        letters.write(title, words, (px(MARGIN), px(5.0)), round(px(2.6)), MUTED)
    return np.concatenate([title, *(_row(row, width) for row in _rows(panels, width))])


def _rows(panels: Sequence[Picture], width: int) -> list[list[Picture]]:
    """Return panels in rows that are no wider than a width [px], unless a single panel is."""
    rows: list[list[Picture]] = [[]]
    for panel in panels:
        if rows[-1] and sum(each.shape[1] for each in rows[-1]) + panel.shape[1] > width:
            rows.append([])
        rows[-1].append(panel)
    return rows


def _row(panels: Sequence[Picture], width: int) -> Picture:
    """Return panels side by side, aligned at the top, cut off at the page width."""
    row = np.full((max(panel.shape[0] for panel in panels), width, 3), PAPER, np.uint8)
    column = 0
    for panel in panels:
        part = panel[:, : width - column]
        row[: part.shape[0], column : column + part.shape[1]] = part
        column += part.shape[1]
    return row


def _floor(person: Person, poses: Mapping[str, Array]) -> float:
    """Return the height of the line below a person [m]: the floor if seated, the lowest sole if standing."""
    if person.seat is not None:
        return 0.0
    spots = person.figure.spots(poses)
    return min(float(spots[f"{side}_{part}"][2]) for side in SIDES for part in ("heel", "ball"))


def _panel(world: World, person: Person, ratio: float, letters: Letters, *, names: bool) -> Picture:
    """Return a person from the right, with the floor as a line, and below that from above."""
    poses, scale = poses_of(world, person), px(1000.0) / ratio
    views = [person_view(world, person, poses, view_of(poses)) for view_of in (look_beside, look_over)]
    bounds = [view.bounds for view in views]
    floor = _floor(person, poses)
    bounds[0][0, 1] = min(bounds[0][0, 1], floor)
    left, right = min(each[0, 0] for each in bounds), max(each[1, 0] for each in bounds)
    width = math.ceil(max((right - left) * scale + 2 * px(MARGIN), px(MIN_PANEL_WIDTH)))
    middle = (left + right) / 2
    parts = []
    for view, (low, high), is_beside in zip(views, bounds, (True, False), strict=True):
        image = np.full((math.ceil((high[1] - low[1]) * scale + 2 * px(MARGIN)), width, 3), PAPER, np.uint8)
        plan = PlanView(middle - width / 2 / scale, float(high[1]) + px(MARGIN) / scale, scale, width, len(image))
        paper = Paper(image, plan, letters)
        if is_beside:
            paper.line([(left, floor), (right, floor)], INK, 0.25)
        draw_view(paper, view)
        parts.append(image)
    head = np.full((round(px(HEAD)), width, 3), PAPER, np.uint8)
    if names:
        letters.write(head, person.name, (px(MARGIN), px(4.6)), round(px(3.2)), INK, weight=SEMIBOLD)
        words = f"{person.sex}, {person.figure.measures['stature']:.3f} m"
        letters.write(head, words, (px(MARGIN), px(8.2)), round(px(2.3)), MUTED)
    return np.concatenate([head, *parts])
