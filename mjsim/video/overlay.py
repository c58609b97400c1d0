"""Moving parts of a plan: trails, robots, the estimated map with its ellipses, and lines to sighted beacons."""

from collections.abc import Mapping

import numpy as np

from mjsim.geometry import Array, Pose, ellipse_points
from mjsim.interface import Picture
from mjsim.video.ink import (
    ESTIMATE,
    MUTED,
    ODOMETRY,
    PAPER,
    SCANNED,
    SEEN,
    TRUTH,
    Color,
    blend,
    draw_disc,
    draw_dots,
    draw_polyline,
    fixed_polylines,
)
from mjsim.video.moment import Moment
from mjsim.video.view import PlanView
from mjsim.world import View

TRAILS: tuple[tuple[str, Color, int, int], ...] = (
    ("odometry", ODOMETRY, 1, 1),
    ("truth", blend(TRUTH, PAPER, 0.55), 5, 1),
    ("estimate", ESTIMATE, 1, 5),
)
"""Trail, colour, width [px], and number of segments drawn again: the estimate's trail is thin and on top of the
truth's, whose round ends would cover it."""
STEP = 3.0
"""A trail is extended when its robot has moved this far [px]."""

LIFTED = 1.0
"""A robot that moves farther than this between two pictures was lifted, and leaves no trail [m]."""


class Trails:
    """The paths of one robot on a persistent plan, extended incrementally."""

    def __init__(self, plan: Picture, view: PlanView) -> None:
        """Store the plan, which is drawn on."""
        self._plan = plan
        self._view = view
        self._last: dict[str, list[Array]] = {}

    def add(self, moment: Moment) -> None:
        """Extend the trails to the robot's current position."""
        for name, color, width, again in TRAILS:
            pixel = self._view.pixels(getattr(moment, name)[:2])
            if not np.isfinite(pixel).all():
                continue
            last = self._last.setdefault(name, [pixel])
            if name == "truth" and np.abs(pixel - last[-1]).max() > LIFTED * self._view.scale:
                self._last[name] = [pixel]
                continue
            if np.abs(pixel - last[-1]).max() >= STEP:
                draw_polyline(self._plan, np.stack([*last, pixel]), color, width=width)
                self._last[name] = [*last, pixel][-again:]


def draw_others(image: Picture, view: PlanView, moment: Moment, radii: Mapping[str, float]) -> None:
    """Draw the other robots as discs of their radii, by name [m]."""
    for name, pose in moment.others.items():
        if not np.isfinite(pose).all():
            continue
        _draw_robot(image, view, pose, max(radii[name], 5.0 / view.scale), MUTED, filled=True)


def draw_moment(image: Picture, view: PlanView, moment: Moment, *, display: View, radius: float) -> None:
    """Draw one robot, its estimate and its map on a plan.

    Args:
        image: The plan; modified.
        view: View of the plan.
        moment: The data to draw.
        display: Whether to draw ellipses and sightings.
        radius: Radius of the robot's body [m].
    """
    believes = bool(np.isfinite(moment.estimate).all())
    if display.scans:
        for points in moment.scans.values():
            draw_dots(image, view.pixels(points), SCANNED)
    if display.sightings and believes:
        _draw_sightings(image, view, moment)
    _draw_map(image, view, moment, ellipses=display.ellipses)
    # The true robot is a filled disc, the estimated one an outline on top: where they coincide, both are visible.
    size = max(radius, 5.0 / view.scale)
    if np.isfinite(moment.truth).all():
        _draw_robot(image, view, moment.truth, size, TRUTH, filled=True)
    if believes:
        _draw_robot(image, view, moment.estimate, size, ESTIMATE, filled=False)
    if believes and display.ellipses:
        outline = ellipse_points(moment.estimate[:2], moment.covariance[:2, :2])
        draw_polyline(image, view.pixels(outline), ESTIMATE, closed=True)


def _draw_sightings(image: Picture, view: PlanView, moment: Moment) -> None:
    robot = Pose.from_array(moment.estimate)
    for seen in moment.sightings:
        place = robot.transform((seen.range * np.cos(seen.bearing), seen.range * np.sin(seen.bearing)))
        draw_polyline(image, view.pixels([moment.estimate[:2], place]), SEEN)


def _draw_map(image: Picture, view: PlanView, moment: Moment, *, ellipses: bool) -> None:
    if not len(moment.means):
        return
    middles = view.pixels(moment.means)
    if ellipses:
        outlines = ellipse_points(moment.means, moment.covariances, count=20)
        fixed_polylines(image, view.pixels(outlines), SEEN)
    for middle in middles:
        draw_disc(image, middle, 2.6, SEEN)


def _draw_robot(image: Picture, view: PlanView, pose: Array, radius: float, color: Color, *, filled: bool) -> None:
    place = Pose.from_array(pose)
    middle = view.pixels(pose[:2])
    nose = view.pixels(place.transform([[0.0, 0.0], [radius * (1.0 if filled else 1.45), 0.0]]))
    if filled:
        draw_disc(image, middle, radius * view.scale, color)
        draw_polyline(image, nose, PAPER, width=2)
    else:
        draw_disc(image, middle, radius * view.scale, color, width=2)
        draw_polyline(image, nose, color, width=2)
