"""Movers: obstacles with a scripted motion.

A mover is a body on two slides, `obstacle/NAME/x` and `obstacle/NAME/y`, which hold how far it is from its start.
The simulation sets them; contact sees its true velocity, and nothing that it meets slows it down.
"""

import math

import mujoco

INERTIA = 1e4
"""Of a mover along its slides [kg]: what it meets in one physics step cannot slow it down."""


def add_slides(body: mujoco.MjsBody, name: str, *, heading: float) -> None:
    """Let a body move in the plane, as heavy as if nothing could stop it; its heading is in the world [rad]."""
    c, s = math.cos(heading), math.sin(heading)
    # An axis is given in the frame of its body.
    for axis, direction in (("x", [c, -s, 0.0]), ("y", [s, c, 0.0])):
        body.add_joint(name=f"{name}/{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction, armature=INERTIA)
