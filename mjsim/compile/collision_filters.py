"""Collision filters: leaves of doors pass through walls and floor, movers through everything static."""

import mujoco

SOLID_BIT, LEAF_BIT, MOVER_BIT, GHOST = 1, 2, 4, 8
"""Bits of contact: solids collide with solids; each of the others with those whose `conaffinity` has its bit.
A ghost is a removed object: it lies on the floor and collides with nothing else."""
GROUND = ("floor", "wall/")
"""Prefixes of the names of floor and walls."""


def sort_contacts(spec: mujoco.MjSpec) -> None:
    """Set the collisions of leaves and movers; a scene without either is unchanged."""
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
            geom.contype, geom.conaffinity = LEAF_BIT, MOVER_BIT
        elif root in movers:
            geom.contype, geom.conaffinity = MOVER_BIT, 0
        else:
            geom.conaffinity |= LEAF_BIT if root == "world" else LEAF_BIT | MOVER_BIT


def _root(body: mujoco.MjsBody) -> str:
    """Return the name of the top-level body that a body is part of."""
    while body.name != "world" and body.parent.name != "world":
        body = body.parent
    return str(body.name)
