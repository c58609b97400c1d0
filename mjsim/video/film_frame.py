"""The composed picture of a run: the plan with paths, a close-up, the onboard camera, and the error so far."""

from collections.abc import Sequence

import cv2
import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array
from mjsim.interface import Picture
from mjsim.plan import PlanItem, Rgb, paint_of, world_words
from mjsim.sentences import Sentence
from mjsim.video.beam_points import mounts_of
from mjsim.video.chart import ErrorChart
from mjsim.video.diagram_drawing import draw_mechanism, posed
from mjsim.video.ink import (
    BEACON,
    BUMP,
    ESTIMATE,
    INK,
    MUTED,
    ODOMETRY,
    PAGE,
    PAPER,
    SCANNED,
    SEEN,
    SEMIBOLD,
    TRUTH,
    Letters,
    draw_disc,
    draw_polyline,
)
from mjsim.video.moment import Moment
from mjsim.video.paper import Paper
from mjsim.video.picture_layout import HEIGHT, MARGIN, WIDTH, Pane, arrange
from mjsim.video.placed_names import MAX_NAMES, write_words
from mjsim.video.plan_parts import bounds_with, draw_grid, draw_scale_bar, floor_color
from mjsim.video.plan_view import PlanView, round_step
from mjsim.video.run_plan import MAX_TRAIL_STEP, PlanState
from mjsim.world import Camera, View, World

DENSITY = 6.0
"""Pixels per millimetre on paper, for lines and symbols of films."""
CLOSE_UP = 110.0
"""Scale of the close-up [px/m]; smaller in a world too large to cache at this scale."""
MAX_CACHED_PIXELS = 16e6
"""Maximum number of pixels of a cached plan."""
FIGURE_EDGES = (58, 138, 258)
"""Right edges of time, speed and number of landmarks, right of the title [px]: fixed, so that the numbers do not move.
"""
LEGEND: tuple[tuple[str, Rgb], ...] = (
    ("truth", TRUTH),
    ("estimate", ESTIMATE),
    ("odometry", ODOMETRY),
    ("beacons", BEACON),
    ("landmarks, sightings", SEEN),
)


class Panel:
    """A plan with moving objects; the whole plan is cached, and a window of it is shown."""

    def __init__(self, world: World, state: PlanState, view: PlanView, *, names: bool = False) -> None:
        """Draw the plan once, with names if requested."""
        self._world, self._state, self._names = world, state, names
        self._letters = Letters()
        self.view = view
        self._removed: frozenset[str] = frozenset()
        self.plan = self._background()
        self._trails = Trails(self.plan, view)

    def add(self, moment: Moment) -> None:
        """Extend the trails."""
        self._trails.add(moment)

    def _background(self) -> Picture:
        plan = np.empty((self.view.height, self.view.width, 3), np.uint8)
        plan[:] = floor_color(self._world)
        drawing = Paper(plan, self.view, self._letters, DENSITY)
        draw_grid(drawing, floor_color(self._world), step=round_step(28 / self.view.scale))
        drawing.draw(self._state.still(self._removed))
        if self._names and len(self._world.beacons) + len(self._world.obstacles) <= MAX_NAMES:
            words = [each for each in world_words(self._world) if not each.moves and each.of != "wall"]
            write_words(drawing, [each for each in words if each.text not in self._removed])
        return plan

    def _take_away(self, removed: frozenset[str]) -> None:
        """Redraw the plan where objects were removed; trails elsewhere stay."""
        before, self._removed = self._background(), removed
        now = self._background()
        other = (before != now).any(axis=2)
        self.plan[other] = now[other]

    def draw(
        self, image: Picture, moment: Moment, shapes: Sequence[PlanItem], *, around: Array | None = None
    ) -> PlanView:
        """Draw the plan, or its window around a world point, with what moves; return the view of the result."""
        if (gone := self._state.gone(moment)) != self._removed:
            self._take_away(gone)
        height, width = image.shape[:2]
        column, row = 0, 0
        if around is not None:
            column, row = (np.rint(self.view.pixels(around)) - (width // 2, height // 2)).astype(int).tolist()
            column = int(np.clip(column, 0, max(self.view.width - width, 0)))
            row = int(np.clip(row, 0, max(self.view.height - height, 0)))
        window = self.plan[row : row + height, column : column + width]
        if window.shape != image.shape:
            image[:] = PAPER
        image[: window.shape[0], : window.shape[1]] = window
        view = self.view.part(column, row, width, height)
        self._draw_mechanisms(image, view, moment)
        Paper(image, view, self._letters, DENSITY).draw(shapes)
        return view

    def _draw_mechanisms(self, image: Picture, view: PlanView, moment: Moment) -> None:
        drawing = Paper(image, view, self._letters)
        for item in self._world.mechanisms:
            values = moment.arms.get(item.name, item.assembly.start)
            if np.isfinite(values).all():
                draw_mechanism(drawing, posed(item, values))


class Frame:
    """Composes pictures of one robot's run, 1280 x 720: call `add` for every moment, `draw` for those to show."""

    def __init__(
        self,
        world: World,
        robot: str | None = None,
        *,
        display: View | None = None,
        seconds: float | None = None,
        reach: Array | None = None,
    ) -> None:
        """Draw everything static once.

        Args:
            world: World of the run.
            robot: Name of the robot; by default the first one.
            display: Display settings; by default those of the world.
            seconds: Time at the right edge of the chart [s]; by default that of the world's run.
            reach: Points that the plan must show even if they lie outside the world, shape (n, 2) [m].

        Raises:
            UsageError: The robot does not exist.
        """
        robots = {item.name: item for item in world.robots}
        self.robot = robot if robot is not None else next(iter(robots), "")
        if self.robot not in robots:
            raise UsageError(
                Sentence(
                    "no robot '{robot}' to show in this world{did_you_mean}",
                    self.robot,
                    did_you_mean(self.robot, robots),
                )
            )
        self._display = display or world.run.view
        self._letters = Letters()
        self._page = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        self._page[:] = PAGE
        bounds = bounds_with(world, reach)
        self._middle = bounds.mean(axis=0)
        """Centre of a close-up that follows nothing, world frame [m]."""
        camera = next((sensor for sensor in robots[self.robot].sensors if isinstance(sensor, Camera)), None)
        layout = arrange(bounds, camera=camera.width / camera.height if camera else None)
        self._whole_part = self._part(layout.plan)
        self._chart_part = self._part(layout.chart)
        self._close_part = self._part(layout.close_up)
        self._seen_part = self._part(layout.onboard) if layout.onboard else None
        whole = PlanView.fit(bounds, layout.plan.width, layout.plan.height, margin=14)
        self._state = PlanState(world, self.robot, self._display)
        self._whole = Panel(world, self._state, whole)
        self._close = Panel(world, self._state, _close_view(bounds, layout.close_up), names=True)
        seconds = seconds or world.run.seconds
        self._chart = ErrorChart(layout.chart.width, layout.chart.height, self._letters, seconds=seconds)
        self._shown: Picture | None = None
        self._last: tuple[float, Array] | None = None
        self._speed = 0.0
        self._write_head(world)

    def add(self, moment: Moment) -> None:
        """Add a moment, in order of time: extends trails and errors."""
        if self._display.trails:
            self._whole.add(moment)
            self._close.add(moment)
        self._chart.add(moment)
        if not np.isfinite(moment.truth).all():
            return
        if self._last is not None and moment.time > self._last[0]:
            step = float(np.hypot(*(moment.truth - self._last[1])[:2]))
            if step > MAX_TRAIL_STEP:
                step = 0.0
            # Low-pass filter with weight 0.1 for the newest step: driving noise would make the number flicker.
            self._speed += 0.1 * (step / (moment.time - self._last[0]) - self._speed)
        self._last = moment.time, moment.truth

    def draw(self, moment: Moment) -> Picture:
        """Return the picture of a moment, RGB, shape (720, 1280, 3); every call returns the same array."""
        shapes = self._state.moving(moment)
        self._whole.draw(self._whole_part, moment, shapes)
        self._draw_close_up(moment, shapes)
        self._chart.draw(self._chart_part)
        if self._seen_part is not None and moment.picture is not self._shown:
            draw_seen(self._seen_part, moment, self._letters)
            self._shown = moment.picture
        self._write_figures(moment)
        return self._page

    def _part(self, box: Pane) -> Picture:
        part = self._page[box.y : box.y + box.height, box.x : box.x + box.width]
        part[:] = PAPER
        return part

    def _draw_close_up(self, moment: Moment, shapes: Sequence[PlanItem]) -> None:
        middles = {"truth": moment.truth, "estimate": moment.estimate, "nothing": self._middle}
        candidates = (middles[self._display.follow], moment.truth, moment.estimate, moment.odometry, self._middle)
        middle = next(place for place in candidates if np.isfinite(place).all())
        height, width = self._close_part.shape[:2]
        view = self._close.draw(self._close_part, moment, shapes, around=middle[:2])
        draw_scale_bar(self._close_part, view.scale, self._letters, (width - 12, height - 12))

    def _write_head(self, world: World) -> None:
        self._letters.write(self._page, world.name, (MARGIN, 31), 22, weight=SEMIBOLD)
        x = WIDTH - MARGIN
        lidar = (("lidar", SCANNED),) if mounts_of(world, self.robot) else ()
        for name, color in reversed(LEGEND + lidar):
            x -= self._letters.width(name, 13)
            self._letters.write(self._page, name, (x, 31), 13, MUTED)
            draw_disc(self._page, np.array([x - 11.0, 26.0]), 5, color)
            x -= 32
        self._figures_at = MARGIN + self._letters.width(world.name, 22, weight=SEMIBOLD) + 22
        self._figures_end = x

    def _write_figures(self, moment: Moment) -> None:
        strip = self._page[10:42, self._figures_at : self._figures_end]
        strip[:] = PAGE
        mapped = f"{len(moment.names)} landmark{'' if len(moment.names) == 1 else 's'}"
        figures = (f"{moment.time:.1f} s", f"{self._speed:.2f} m/s", mapped)
        for text, right in zip(figures, FIGURE_EDGES, strict=True):
            self._letters.write(strip, text, (right, 21), 14, INK, align=1.0)
        if moment.touched:
            self._letters.write(strip, "bump", (FIGURE_EDGES[-1] + 24, 21), 14, BUMP, weight=SEMIBOLD)


class PlanFrame:
    """Only the plan, 1280 x 720: call `add` for every moment, `draw` for those to show."""

    def __init__(self, world: World, robot: str, *, display: View, reach: Array | None = None) -> None:
        """Draw the plan once; it also shows the points of `reach`, shape (n, 2) [m]."""
        self._page = np.empty((HEIGHT, WIDTH, 3), np.uint8)
        view = PlanView.fit(bounds_with(world, reach), WIDTH, HEIGHT, margin=MARGIN)
        self._state, self._trails = PlanState(world, robot, display), display.trails
        self._panel = Panel(world, self._state, view)
        self._letters = Letters()

    def add(self, moment: Moment) -> None:
        """Extend the trails."""
        if self._trails:
            self._panel.add(moment)

    def draw(self, moment: Moment) -> Picture:
        """Return the picture of a moment, RGB, shape (720, 1280, 3); every call returns the same array."""
        view = self._panel.draw(self._page, moment, self._state.moving(moment))
        draw_scale_bar(self._page, view.scale, self._letters, (WIDTH - MARGIN, HEIGHT - MARGIN))
        self._letters.write(self._page, f"{moment.time:.1f} s", (MARGIN, HEIGHT - MARGIN), 16)
        return self._page


def draw_seen(image: Picture, moment: Moment, letters: Letters) -> None:
    """Draw the onboard picture with outlines and names of recognised beacons, scaled to fit."""
    height, width = image.shape[:2]
    image[:] = PAGE
    if moment.picture is None:
        letters.write(image, "no picture yet", (width / 2, height / 2), 15, MUTED, align=0.5)
        return
    rows, columns = moment.picture.shape[:2]
    scale = min(width / columns, height / rows)
    size = max(round(columns * scale), 1), max(round(rows * scale), 1)
    x, y = (width - size[0]) // 2, (height - size[1]) // 2
    inside = image[y : y + size[1], x : x + size[0]]
    inside[:] = cv2.resize(moment.picture, size, interpolation=cv2.INTER_AREA)
    tags: list[tuple[int, int, int]] = []
    for seen in moment.sightings:
        if seen.corners is None:
            continue
        # Pixel centres are at integers in both pictures.
        outline = (np.asarray(seen.corners) + 0.5) * scale - 0.5
        draw_polyline(inside, outline, PAPER, width=4, closed=True)
        draw_polyline(inside, outline, SEEN, width=2, closed=True)
        if seen.name is not None:
            tags.append(_write_tag(inside, seen.name, outline, tags, letters))


def _write_tag(
    image: Picture, name: str, outline: Array, tags: list[tuple[int, int, int]], letters: Letters
) -> tuple[int, int, int]:
    """Write a name on a plate above an outline, or below it if another plate (x, y, width) is there."""
    width, low, high = letters.width(name, 13) + 10, outline.min(axis=0), outline.max(axis=0)
    x = round(float(np.clip(outline[:, 0].mean() - width / 2, 0, max(image.shape[1] - width, 0))))
    y = round(float(np.clip(low[1] - 22, 0, image.shape[0] - 20)))
    if any(abs(y - other[1]) < 19 and x < other[0] + other[2] and other[0] < x + width for other in tags):
        y = round(float(np.clip(high[1] + 4, 0, image.shape[0] - 20)))
    cv2.rectangle(image, (x, y), (x + width - 1, y + 18), SEEN, -1)
    letters.write(image, name, (x + 5, y + 14), 13, PAPER, weight=SEMIBOLD)
    return x, y, width


def _close_view(bounds: Array, part: Pane) -> PlanView:
    """Return the view of the whole world at the scale of the close-up, with a margin of floor."""
    room = bounds + np.array([[-0.5], [0.5]])
    width, height = room[1] - room[0]
    scale = min(CLOSE_UP, float(np.sqrt(MAX_CACHED_PIXELS / (width * height))))
    size = np.maximum(np.ceil(np.array([width, height]) * scale), (part.width, part.height)).astype(int)
    x, y = room.mean(axis=0).tolist()
    return PlanView.around(x, y, scale, int(size[0]), int(size[1]))


TRAILS = (("odometry", "odometry path", 1, 1), ("truth", "true path", 5, 1), ("estimate", "estimated path", 1, 5))
"""Trail, role, width [px], and number of segments drawn again: the estimate's trail is thin and on top of the
truth's, whose round ends would cover it."""
MIN_TRAIL_STEP = 3.0
"""A trail is extended when its robot has moved this far [px]."""


class Trails:
    """The paths of one robot on a persistent plan, extended incrementally."""

    def __init__(self, plan: Picture, view: PlanView) -> None:
        """Store the plan, which is drawn on."""
        self._plan = plan
        self._view = view
        self._last: dict[str, list[Array]] = {}

    def add(self, moment: Moment) -> None:
        """Extend the trails to the robot's current position."""
        for name, role, width, again in TRAILS:
            pixel = self._view.pixels(getattr(moment, name)[:2])
            if not np.isfinite(pixel).all():
                continue
            last = self._last.setdefault(name, [pixel])
            if name == "truth" and np.abs(pixel - last[-1]).max() > MAX_TRAIL_STEP * self._view.scale:
                self._last[name] = [pixel]
                continue
            if np.abs(pixel - last[-1]).max() >= MIN_TRAIL_STEP:
                draw_polyline(self._plan, np.stack([*last, pixel]), paint_of(role).line or PAPER, width=width)
                self._last[name] = [*last, pixel][-again:]
