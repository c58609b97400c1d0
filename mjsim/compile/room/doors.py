"""Doors: leaves `door/NAME` on hinges, pushed open by robots or driven by events.

The angle of a hinge is 0 when the door is closed, positive to the left side of its wall. A leaf never collides with
its own wall, which it overlaps at every angle. A locked one is held by a constraint of the same name.
"""

import math

import mujoco

from mjsim.compile.geom_groups import DARK, SEEN, make_decor
from mjsim.compile.joint_motors import add_joint, add_motor
from mjsim.compile.textures import color_of
from mjsim.world import THICKNESS, Leaf, World, leaves

LEAF_GAP = 0.006
"""Gap around a leaf [m]."""
HANDLE_HEIGHT = 1.05
"""Height of the handle above the floor [m]."""


def add_doors(spec: mujoco.MjSpec, world: World) -> None:
    """Add the leaves of all doors at their initial angles, each with an idle motor."""
    for leaf in leaves(world):
        _add_leaf(spec, leaf)


def _add_leaf(spec: mujoco.MjSpec, leaf: Leaf) -> None:
    name, door = f"door/{leaf.name}", leaf.door
    heading = leaf.pose(math.radians(door.angle_deg)).heading / 2
    body = spec.worldbody.add_body(
        name=name, pos=[*leaf.hinge, 0.0], quat=[math.cos(heading), 0.0, 0.0, math.sin(heading)]
    )
    joint = leaf.joint()
    add_joint(body, joint)
    gap = min(LEAF_GAP, leaf.width / 8, (leaf.high - leaf.low) / 8)
    low, high = leaf.low + gap, leaf.high - gap
    body.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[leaf.width / 2, 0.0, (low + high) / 2],
        size=[leaf.width / 2 - gap, THICKNESS / 2, (high - low) / 2],
        mass=door.mass,
        group=SEEN,
        material="matte",
        rgba=color_of(door.color),
    )
    if low < HANDLE_HEIGHT < high:
        _add_handle(body, leaf)
    add_motor(spec, joint)


def _add_handle(body: mujoco.MjsBody, leaf: Leaf) -> None:
    """Add a purely visual bar through the leaf near its free edge."""
    bar = body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[leaf.width * 0.9, 0.0, HANDLE_HEIGHT],
        size=[leaf.width * 0.06, THICKNESS / 2 + 0.03, 0.012],
    )
    make_decor(bar, DARK)
