"""Mechanisms on the plan of the page: outlines of their bodies at the start, and joints that can be turned there."""

import math
from collections.abc import Iterator

from mjsim.geometry import Array, Pose
from mjsim.video import body_outlines, posed
from mjsim.world import Mechanism

UPRIGHT = 1.0 - 1e-6
"""A joint whose axis has a larger vertical part turns in the plan."""


def outlines(mechanism: Mechanism) -> list[Array]:
    """Return the outlines of all bodies from above as they start, world frame, shape (n, 2) each [m]."""
    return [outline for _, outline in body_outlines(posed(mechanism, mechanism.assembly.start))]


def turning_joints(mechanism: Mechanism) -> Iterator[tuple[int, Array, Pose, float, bool]]:
    """Yield the joints that a person may turn on the plan: revolute, about the vertical, free to start elsewhere.

    A joint that a motion leads starts where that has it; one whose start follows from a loop is none either.

    Yields:
        Its number, the outline of its second body, world frame, shape (n, 2) [m], where it is with the heading of that
        body, its value at the start [deg], and whether its axis points down, so that it turns clockwise.
    """
    assembly = mechanism.assembly
    drawn = posed(mechanism, assembly.start)
    seen, led = dict(body_outlines(drawn)), {drive.column for drive in assembly.drives}
    for number, joint in enumerate(mechanism.joints):
        columns, body = assembly.columns[joint.name], assembly.places[joint.name][1].body
        if joint.kind != "revolute" or columns.start in led or body not in seen:
            continue
        told = "start_deg" in joint.model_fields_set
        if abs(drawn.axis(joint)[2]) < UPRIGHT or not (told or not assembly.rows):
            continue
        x, y, _ = drawn.joint(joint).tolist()
        along = drawn.poses[body][:2, 0]
        place = Pose(x, y, math.atan2(along[1], along[0]))
        start = math.degrees(float(assembly.start[columns.start]))
        yield number, seen[body], place, start, bool(drawn.axis(joint)[2] < 0.0)
