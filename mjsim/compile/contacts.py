"""Collision filters: leaves of doors pass through walls and floor, movers through everything static."""

import mujoco

SOLID, LEAF, MOVER, GHOST = 1, 2, 4, 8
"""Bits of contact: what is solid touches what is solid; of the others each touches what lets it by `conaffinity`.
A ghost is what was taken away: it lies on the floor, and touches nothing else."""
GROUND = ("floor", "wall/")
"""How the names of floor and walls begin."""


def sort_contacts(spec: mujoco.MjSpec) -> None:
    """Set what leaves and movers collide with; a scene without either stays as it is."""
    slides = {joint.parent.name for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_SLIDE}
    movers = {name for name in slides if name.startswith("obstacle/")}
    doors = {joint.parent.name for joint in spec.joints if joint.name.startswith("door/")}
    if not movers and not doors:
        return
    for geom in spec.geoms:
        root = _root(geom.parent)
        if not (geom.contype or geom.conaffinity) or geom.name.startswith(GROUND):
            continue
        if root in doors:
            geom.contype, geom.conaffinity = LEAF, MOVER
        elif root in movers:
            geom.contype, geom.conaffinity = MOVER, 0
        else:
            geom.conaffinity |= LEAF if root == "world" else LEAF | MOVER


def _root(body: mujoco.MjsBody) -> str:
    """Return the name of what a body is part of: the one that stands in the world."""
    while body.name != "world" and body.parent.name != "world":
        body = body.parent
    return str(body.name)
