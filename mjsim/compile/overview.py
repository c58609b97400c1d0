"""The view of an entire world from above at an angle, and the box that it must show."""

import math
from collections.abc import Sequence

import numpy as np

from mjsim.compile.room import WallBox, wall_boxes
from mjsim.geometry import Array
from mjsim.world import World, extent, hung, top

OVERVIEW_TILT, OVERVIEW_FOV = math.radians(60.0), 40.0
"""Downwards [rad]; vertical field of view [deg]."""
OVERVIEW_ASPECT, OVERVIEW_FILL = 16 / 9, 0.96
"""Aspect ratio of an image of the entire world, and the part of its height or width that the world fills."""


def scene_bounds(world: World, boxes: Sequence[WallBox]) -> tuple[Array, Array]:
    """Return the lowest and the highest corner of all objects on the floor, shape (3,) each [m]."""
    points = [np.array([[*robot.at, 0.0], [*robot.at, robot.body.height]]) for robot in world.robots]
    if any(robot.arms for robot in world.robots):
        from mjsim.compile.arm_bodies import reached

        points += [reached(robot) for robot in world.robots if robot.arms]
    if world.mechanisms:
        from mjsim.compile.mechanism_specs import seen_box

        points += [seen_box(mechanism) for mechanism in world.mechanisms]
    points += [person.spanned() for person in world.people]
    points += [np.array([[item.place.x, item.place.y, item.center + item.beacon.width / 2]]) for item in hung(world)]
    if boxes:
        outlines, tops = np.array([box.outline for box in boxes]), [box.center[2] + box.half[2] for box in boxes]
        points.append(np.column_stack([outlines.reshape(-1, 2), np.repeat(tops, 4)]))
    for item in world.obstacles:
        outline = extent(item)
        points.append(np.column_stack([outline, np.full(len(outline), top(item))]))
    points += [np.column_stack([patch.outline(), np.zeros(4)]) for patch in world.floor.patches]
    found = np.concatenate([*points, np.zeros((0 if points else 1, 3))])
    lower, upper = found.min(axis=0), found.max(axis=0)
    lower[2] = 0.0
    # Even a bare floor has an extent.
    return np.minimum(lower, upper - [1.0, 1.0, 0.0]), np.maximum(upper, lower + 1.0)


def overview_place(lower: Array, upper: Array) -> tuple[Array, Array, Array]:
    """Return the nearest position of the camera that sees every corner, and its right and up, shape (3,).

    Args:
        lower: Lowest corner of the box to show, world frame, shape (3,) [m].
        upper: Highest corner.
    """
    s, c = math.sin(OVERVIEW_TILT), math.cos(OVERVIEW_TILT)
    right, up, ahead = np.array([1.0, 0, 0]), np.array([0, s, c]), np.array([0, c, -s])
    corners = np.array([[x, y, z] for x in (lower[0], upper[0]) for y in (lower[1], upper[1]) for z in (0, upper[2])])
    offsets = corners - (lower + upper) / 2
    rise = math.tan(math.radians(OVERVIEW_FOV / 2)) * OVERVIEW_FILL
    depth, height = offsets @ ahead, offsets @ up
    # Each corner requires a distance; those at the upper and lower edge require the same when the view is raised by
    # this.
    above, below = np.max(height / rise - depth), np.max(-height / rise - depth)
    beside = np.max(np.abs(offsets @ right) / (rise * OVERVIEW_ASPECT) - depth)
    distance, raised = max((above + below) / 2, beside), rise * (above - below) / 2
    return (lower + upper) / 2 - distance * ahead + raised * up, right, up


def overview_of(world: World, reach: Array) -> Array:
    """Return the position of a camera that shows a world and the motion beyond it, shape (3,) [m].

    Args:
        world: The world at the start.
        reach: Corners of a box around moving objects, world frame, shape (2, 3) [m].
    """
    lower, upper = scene_bounds(world, wall_boxes(world.walls))
    lower, upper = np.minimum(lower, reach[0]), np.maximum(upper, reach[1])
    lower[2] = 0.0
    return overview_place(lower, upper)[0]
