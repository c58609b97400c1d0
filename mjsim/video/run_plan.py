"""The display list of a run at an instant: static and moving things, one robot's belief, and items of modules."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import cv2
import numpy as np

from mjsim.geometry import Array, Pose, ellipse_points
from mjsim.interface import ShownGrid, ShownLines, ShownPoints
from mjsim.plan import PlanItem, arm_shapes, placed_at, start_of, world_shapes
from mjsim.sim import LedPeople
from mjsim.video.moment import Moment
from mjsim.world import View, World, first_looks

OF_ROBOTS = ("robot", "heading", "link", "tool")
"""Roles of robots at their start."""
MIN_ROBOT_RADIUS = 0.8
"""Minimum radius of a robot [mm on paper]."""
MAX_TRAIL_STEP = 1.0
"""A robot that moves farther than this between two pictures was lifted, and leaves no trail [m]."""


class PlanState:
    """Static and moving things on the plan of a world, at instants of one robot's run."""

    def __init__(self, world: World, robot: str, display: View) -> None:
        """Prepare the shapes at the start.

        Args:
            world: The world.
            robot: The robot whose belief is shown.
            display: Whether to show scans, sightings and ellipses.
        """
        self._robot, self._display = robot, display
        shapes = world_shapes(world)
        # Doors are drawn where they stand: the arcs of their swing would be in the way.
        self._still = [shape for shape in shapes if not shape.frame and shape.role != "swing"]
        self._moving = [shape for shape in shapes if shape.frame and shape.role not in OF_ROBOTS]
        self._robots = {item.name: item for item in world.robots}
        self._looks, self._people = first_looks(world), LedPeople(world)

    def still(self, removed: frozenset[str] = frozenset()) -> list[PlanItem]:
        """Return all that never moves, without the things of some names."""
        return [shape for shape in self._still if shape.of not in removed]

    def gone(self, moment: Moment) -> frozenset[str]:
        """Return the names of removed things, and of people that moved their hands."""
        looks = moment.looks or self._looks
        return looks.removed | looks.reached.keys()

    def moving(self, moment: Moment) -> list[PlanItem]:
        """Return all that moves, from the floor up, with the belief of the robot."""
        looks = moment.looks or self._looks
        poses = {**moment.others, self._robot: moment.truth}
        robots = {name: Pose.from_array(pose) for name, pose in poses.items() if np.isfinite(pose).all()}
        frames = {name: Pose.from_array(pose) for name, pose in moment.things.items()}
        frames |= {f"robot/{name}": pose for name, pose in robots.items()}
        present = placed_at((shape for shape in self._moving if shape.of not in looks.removed), frames)
        people = self._people.outlines(looks)
        return [
            *(_lit(shape, looks.lamps) for shape in present),
            *(PlanItem(role="person", parts=(part,), tint=tint) for each in people.values() for part, tint in each),
            *(shape for name, pose in moment.others.items() for shape in self._body("other robot", name, pose)),
            *shown_items(moment),
            *self._belief(moment),
            *self._arms(moment, robots),
        ]

    def _belief(self, moment: Moment) -> Iterator[PlanItem]:
        """Yield the robot, its estimate and its map.

        The true robot is filled, the estimated one an outline on top: where they coincide, both are visible.
        """
        display, believes = self._display, bool(np.isfinite(moment.estimate).all())
        if display.scans and moment.scans:
            yield PlanItem(role="scan", kind="dots", parts=list(moment.scans.values()))
        if display.sightings and believes and moment.sightings:
            yield PlanItem(role="sighting", kind="line", parts=_sightings(moment))
        if display.ellipses and len(moment.means):
            yield PlanItem(
                role="landmark ellipse", parts=list(ellipse_points(moment.means, moment.covariances, count=20))
            )
        if len(moment.means):
            yield PlanItem(role="landmark", kind="dots", parts=(moment.means,))
        yield from self._body("true robot", self._robot, moment.truth)
        yield from self._body("estimated robot", self._robot, moment.estimate)
        if believes and display.ellipses:
            outline = ellipse_points(moment.estimate[:2], moment.covariance[:2, :2])
            yield PlanItem(role="pose ellipse", parts=(outline,))

    def _body(self, role: str, name: str, pose: Array) -> Iterator[PlanItem]:
        """Yield the outline of a robot with its heading."""
        if not np.isfinite(pose).all():
            return
        body, place = self._robots[name].body, Pose.from_array(pose)
        yield PlanItem(role=role, parts=(body.outline(),), place=place, least=MIN_ROBOT_RADIUS)
        is_belief = role == "estimated robot"
        share = 1.45 if is_belief else 0.9
        nose = np.array([[0.0, 0.0], [share * body.radius, 0.0]])
        shown = role if is_belief else "nose"
        yield PlanItem(role=shown, kind="line", parts=(nose,), place=place, least=share * MIN_ROBOT_RADIUS)

    def _arms(self, moment: Moment, places: dict[str, Pose]) -> Iterator[PlanItem]:
        unknown = {*moment.others, self._robot} - places.keys()
        for name, arm in ((name, arm) for name, item in self._robots.items() for arm in item.arms):
            q = moment.arms.get(f"{name}/{arm.name}", np.array(arm.start()))
            if name not in unknown and np.isfinite(q).all():
                yield from arm_shapes(name, arm, q, places.get(name, start_of(self._robots[name])))


def _lit(shape: PlanItem, lamps: Mapping[str, float]) -> PlanItem:
    """Return a lamp as bright as it is now; other shapes as they are."""
    kind, _, name = shape.frame.partition("/")
    return replace(shape, level=min(lamps[name], 1.0)) if kind == "lamp" else shape


def _sightings(moment: Moment) -> list[Array]:
    robot = Pose.from_array(moment.estimate)
    ranges = np.array([seen.range for seen in moment.sightings])
    bearings = np.array([seen.bearing for seen in moment.sightings])
    ends = robot.transform(np.stack([ranges * np.cos(bearings), ranges * np.sin(bearings)], axis=-1))
    return [np.stack([moment.estimate[:2], end]) for end in ends]


MIN_OCCUPANCY = 0.5
"""Regions of a grid from this occupancy on are outlined."""
OUTLINE_SUBDIVISIONS = 4
"""Parts into which a side of a cell is divided for its outline."""


def shown_items(moment: Moment) -> Iterator[PlanItem]:
    """Yield the points, lines and grids that the modules of a robot show; texts are for the studio."""
    frames = {"world": Pose(0.0, 0.0, 0.0), "estimate": _pose(moment.estimate), "base": _pose(moment.truth)}
    for item in moment.shown:
        place = frames[item.frame]
        if place is None:
            continue
        if isinstance(item, ShownGrid):
            yield PlanItem(role="shown cells", parts=_outlines(item), place=place @ item.origin)
        elif isinstance(item, ShownLines) and len(item.points):
            flat = item.points[:, :2]
            parts = [flat] if item.joined else list(flat.reshape(-1, 2, 2))
            yield PlanItem(role="shown lines", kind="line", parts=parts, place=place, tint=item.color)
        elif isinstance(item, ShownPoints) and len(item.points):
            yield PlanItem(role="shown points", kind="dots", parts=(item.points[:, :2],), place=place, tint=item.color)


def _pose(values: Array) -> Pose | None:
    return Pose.from_array(values) if np.isfinite(values).all() else None


def _outlines(grid: ShownGrid) -> list[Array]:
    """Return the outlines of the occupied cells in the frame of the grid, shape (n, 2) each [m]."""
    fine = np.kron(grid.cells >= MIN_OCCUPANCY, np.ones((OUTLINE_SUBDIVISIONS, OUTLINE_SUBDIVISIONS))).astype(np.uint8)
    found, _ = cv2.findContours(fine, cv2.RETR_LIST, cv2.CHAIN_APPROX_SIMPLE)
    return [(outline[:, 0].astype(float) + 0.5) * (grid.resolution / OUTLINE_SUBDIVISIONS) for outline in found]
