"""The display list of stationary arms in an oblique view, with the same items as that of a plan."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.plan import PlanItem, link_outline, start_of
from mjsim.record import Recording
from mjsim.video.diagrams import OBLIQUE, some_of, view_along
from mjsim.video.moment import Moment
from mjsim.video.plan_view import round_step
from mjsim.world import NoBody, Robot, RobotArm, extent, top

POSTURES = 200
"""Number of postures of each arm to which a view is scaled."""
AXIS = 0.12
"""Length of the axes of a tool's frame, as a fraction of the width of the view."""
LINES = 10
"""Minimum number of squares of the floor across the view."""


@dataclass(frozen=True, slots=True, eq=False)
class StandingArm:
    """An arm on a base that does not move, and its motion."""

    robot: Robot
    item: RobotArm
    positions: Array
    """Joint values over time, shape (N, n) [rad, m]; NaN where unknown."""
    tool: Array
    """Positions of the tool over time, world frame, shape (N, 3) [m]; NaN where unknown."""

    @property
    def name(self) -> str:
        """`ROBOT/ARM`."""
        return f"{self.robot.name}/{self.item.name}"

    def placed(self, points: Array) -> Array:
        """Return points of the robot's frame in the world, shape (..., 3) [m]."""
        place = start_of(self.robot)
        return np.concatenate([place.transform(points[..., :2]), points[..., 2:]], axis=-1)

    def bones(self, q: Array) -> Array:
        """Return both ends of each part at q, base, links and tool, world frame, shape (links + 2, 2, 3) [m]."""
        arm, posture = self.item.arm, self.item.arm.posture(q)
        ends = np.array([[[*end, 1.0] for end in link.bone] for link in arm.links])
        links = (posture.links[:, None] @ ends[..., None])[..., :3, 0]
        base = np.stack([arm.base[:3, 3], links[0, 0]])
        hand = np.stack([posture.links[arm.carrier, :3, 3], posture.tool[:3, 3]])
        return self.placed(np.concatenate([base[None], links, hand[None]]))

    @property
    def radii(self) -> list[float]:
        """Radii of these parts [m]."""
        links = [link.radius for link in self.item.arm.links]
        return [links[0], *links, 0.4 * links[-1]]


def standing_arms(recording: Recording) -> list[StandingArm]:
    """Return the arms of a recording whose robots do not move."""
    return [
        StandingArm(robot, item, track.positions, track.tool[:, :3])
        for robot in recording.world.robots
        for item in robot.arms
        if robot.base == "fixed" and (track := recording.joints.get(f"{robot.name}/{item.name}")) is not None
    ]


class ObliqueView:
    """Arms and their surroundings, in a drawing whose x is to the right and y up [m]."""

    def __init__(self, recording: Recording, arms: Sequence[StandingArm]) -> None:
        """Choose the direction and the bounds by the motion of the arms."""
        azimuth, elevation = OBLIQUE
        toward = np.array([math.cos(azimuth), math.sin(azimuth), math.tan(elevation)])
        self._view = view_along(toward / np.linalg.norm(toward))[:, :3]
        self._world, self._arms = recording.world, arms
        spans = [span for arm in arms for span in _spans(arm)]
        self._points = np.concatenate(spans)
        flat = (self._points @ self._view.T)[:, :2]
        pad = 0.06 * float(np.ptp(flat, axis=0).max())
        self.bounds: Array = np.stack([flat.min(axis=0) - pad, flat.max(axis=0) + pad])
        """Bounds of all postures, minimum and maximum of (x, y), shape (2, 2) [m]."""

    def items(self, moment: Moment, row: int) -> list[PlanItem]:
        """Return the visible items at a row of the recording, the farthest first."""
        solids = sorted(self._solids(moment), key=lambda pair: pair[0])
        return [*self._floor(), *(item for _, items in solids for item in items), *self._tools(row)]

    def _flat(self, points: Array) -> Array:
        return np.asarray((points @ self._view.T)[..., :2])

    def _nearness(self, points: Array) -> float:
        """Return how near points are to the viewer [m]."""
        return float((points.reshape(-1, 3) @ self._view[2]).mean())

    def _floor(self) -> Iterator[PlanItem]:
        """Yield the floor below the arms as a grid."""
        low, high = self._points[:, :2].min(axis=0), self._points[:, :2].max(axis=0)
        step = round_step(float((high - low).max()) / LINES)
        low, high = np.floor(low / step - 0.5) * step, np.ceil(high / step + 0.5) * step
        lines = [
            np.array([[x, low[1], 0.0], [x, high[1], 0.0]]) for x in np.arange(low[0], high[0] + step / 2, step)
        ] + [np.array([[low[0], y, 0.0], [high[0], y, 0.0]]) for y in np.arange(low[1], high[1] + step / 2, step)]
        yield PlanItem(role="floor grid", kind="line", parts=[self._flat(line) for line in lines])

    def _solids(self, moment: Moment) -> Iterator[tuple[float, list[PlanItem]]]:
        """Yield items of each solid with its nearness."""
        for thing in self._world.obstacles:
            if self._is_beside(extent(thing)):
                yield self._prism(extent(thing), 0.0, top(thing), "obstacle", thing.color)
        for robot in self._world.robots:
            place = start_of(robot) if robot.base == "fixed" else _pose(moment, robot.name)
            if place is not None and not isinstance(robot.body, NoBody):
                outline = place.transform(robot.body.outline())
                yield self._prism(outline, 0.0, robot.body.height, "robot", robot.body.color)
        for arm in self._arms:
            q = moment.arms.get(arm.name, np.array(arm.item.start()))
            if np.isfinite(q).all():
                yield from self._links(arm, q)

    def _is_beside(self, outline: Array) -> bool:
        """Whether an outline on the floor comes near the arms."""
        low, high = self._points[:, :2].min(axis=0), self._points[:, :2].max(axis=0)
        return bool((outline.min(axis=0) < high).all() and (outline.max(axis=0) > low).all())

    def _links(self, arm: StandingArm, q: Array) -> Iterator[tuple[float, list[PlanItem]]]:
        for radius, bone in zip(arm.radii, arm.bones(q), strict=True):
            (x, y), (u, v) = self._flat(bone)
            outline = link_outline(np.array([x, y, u, v, radius]))
            yield self._nearness(bone), [PlanItem(role="link", parts=(outline,), tint=arm.item.color)]

    def _prism(self, outline: Array, low: float, high: float, role: str, tint: str) -> tuple[float, list[PlanItem]]:
        """Return a solid over an outline on the floor: its silhouette and its upper face."""
        foot, lid = (np.column_stack([outline, np.full(len(outline), z)]) for z in (low, high))
        both = self._flat(np.concatenate([foot, lid])).astype(np.float32)
        silhouette = cv2.convexHull(both)[:, 0].astype(float)
        items = [PlanItem(role=role, parts=(part,), tint=tint) for part in (silhouette, self._flat(lid))]
        return self._nearness(np.concatenate([foot, lid])), items

    def _tools(self, row: int) -> Iterator[PlanItem]:
        """Yield the path of each tool up to a row."""
        for arm in self._arms:
            path = arm.tool[: row + 1]
            path = path[np.isfinite(path).all(axis=1)]
            if len(path) > 1:
                yield PlanItem(role="tool path", kind="line", parts=(self._flat(path),))
            if len(path):
                yield PlanItem(role="landmark", kind="dots", parts=(self._flat(path[-1:]),))


def _spans(arm: StandingArm) -> Iterable[Array]:
    """Yield points that a view of an arm must show, world frame, shape (n, 3) [m]."""
    postures = [np.array(arm.item.start()), *some_of(arm.positions, POSTURES)]
    radius = max(link.radius for link in arm.item.arm.links)
    bones = np.concatenate([arm.bones(q).reshape(-1, 3) for q in postures])
    foot = arm.placed(np.zeros((1, 3)))
    yield from (bones + radius, bones - radius, foot, arm.tool[np.isfinite(arm.tool).all(axis=1)])


def _pose(moment: Moment, robot: str) -> Pose | None:
    pose = moment.others.get(robot)
    return Pose.from_array(pose) if pose is not None and np.isfinite(pose).all() else None
