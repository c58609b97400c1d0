"""Draws arms on plans: their links seen from above."""

import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Picture
from mjsim.video.ink import INK, PAPER, Color, blend, draw_disc, draw_polyline, parse_color
from mjsim.video.moment import Moment
from mjsim.video.paper import Paper, arc
from mjsim.video.view import PlanView
from mjsim.world import RobotArm, World

TOOL_RADIUS = 3.5
"""[px]"""


def shadows(item: RobotArm, q: Array) -> tuple[Array, Array]:
    """Return the links of an arm seen from above, the lowest first, and its tool, in the robot's frame.

    Args:
        item: The arm.
        q: Joint values, shape (n,) [rad, m].

    Returns:
        links: Both ends and radius of each, (x, y, x, y, radius), shape (n, 5) [m].
        tool: Shape (2,) [m].
    """
    posture = item.arm.posture(q)
    bones = np.array([[[*end, 1.0] for end in link.bone] for link in item.arm.links])
    ends = (posture.links[:, None] @ bones[..., None])[..., :3, 0]
    order = np.argsort(ends[..., 2].mean(axis=1), kind="stable")
    radii = np.array([[link.radius] for link in item.arm.links])
    flat = np.concatenate([ends[:, 0, :2], ends[:, 1, :2], radii], axis=1)
    return flat[order], posture.tool[:2, 3]


def outline(link: Array) -> Array:
    """Return the outline of a link (x, y, x, y, radius), counter-clockwise, shape (n, 2) [m]."""
    first, last, radius = link[:2], link[2:4], float(link[4])
    angle = math.atan2(*(last - first)[::-1])
    right = angle - math.pi / 2
    return np.concatenate(
        [arc(last, radius, right, right + math.pi), arc(first, radius, right + math.pi, angle + 1.5 * math.pi)]
    )


def arm_outlines(item: RobotArm, q: Array) -> list[Array]:
    """Return the outlines of an arm's links from above, lowest first, in the robot's frame, shape (n, 2) each [m]."""
    return [outline(link) for link in shadows(item, q)[0]]


def draw_arm(drawing: Paper, item: RobotArm, place: Pose) -> None:
    """Draw an arm in its initial position on a sheet, for a robot at a given pose."""
    links, tool = shadows(item, np.array(item.start()))
    color = blend(parse_color(item.color), PAPER, 0.35)
    for link in links:
        edge = place.transform(outline(link))
        drawing.fill(edge, color)
        drawing.line(edge, INK, 0.2, closed=True)
    drawing.disc(place.transform(tool), drawing.metres(0.5), INK)


class Arms:
    """Draws the arms of all robots in their current position."""

    def __init__(self, world: World) -> None:
        """Prepare the arms in their initial positions."""
        self._arms = [(robot.name, item, _ink(item)) for robot in world.robots for item in robot.arms]
        self._starts = {
            item.name: Pose(item.at[0], item.at[1], math.radians(item.heading_deg)).as_array() for item in world.robots
        }

    def draw(self, image: Picture, view: PlanView, moment: Moment, *, robot: str) -> None:
        """Draw all arms at a moment of a robot's run."""
        places = {**self._starts, **moment.others, robot: moment.truth}
        for name, item, color in self._arms:
            q = moment.arms.get(f"{name}/{item.name}", np.array(item.start()))
            if np.isfinite(places[name]).all() and np.isfinite(q).all():
                _draw(image, view, shadows(item, q), color, Pose.from_array(places[name]))


def _ink(item: RobotArm) -> Color:
    return blend(parse_color(item.color), PAPER, 0.2)


def _draw(image: Picture, view: PlanView, arm: tuple[Array, Array], color: Color, place: Pose) -> None:
    links, tool = arm
    for link in links:
        ends = view.pixels(place.transform(link[:4].reshape(2, 2)))
        width = max(3, round(2.0 * float(link[4]) * view.scale))
        draw_polyline(image, ends, INK, width=width + 2)
        draw_polyline(image, ends, color, width=width)
    draw_disc(image, view.pixels(place.transform(tool)), TOOL_RADIUS, INK)
