"""Movers: obstacles with a scripted motion.

A mover is a body on two slides, `obstacle/NAME/x` and `obstacle/NAME/y`, whose values are the displacement from its
start. The simulation sets them; contacts use its true velocity, and no object slows it down.
"""

import math

import mujoco

MOVER_INERTIA = 1e4
"""Inertia of a mover along its slides [kg]: no contact within one physics step can slow it down."""


def add_slides(body: mujoco.MjsBody, name: str, *, heading: float) -> None:
    """Add slides in the plane, with a practically infinite inertia, to a body with a heading in the world [rad]."""
    c, s = math.cos(heading), math.sin(heading)
    # An axis is given in the frame of its body.
    for axis, direction in (("x", [c, -s, 0.0]), ("y", [s, c, 0.0])):
        body.add_joint(name=f"{name}/{axis}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=direction, armature=MOVER_INERTIA)
