"""Doors: leaves `door/NAME` on hinges, pushed open by robots or driven by events.

The angle of a hinge is 0 when the door is closed, positive to the left side of its wall. A leaf never touches the
wall that it hangs in, which it meets at every angle. A locked one is held by a constraint of the same name.
"""

import math

import mujoco

from mjsim.compile.parts import DARK, SEEN, make_decor
from mjsim.compile.pictures import color_of
from mjsim.world.doors import THICKNESS, Leaf, leaves
from mjsim.world.model import World

GAP = 0.006
"""Around a leaf [m]."""
DAMPING = 0.6
"""Of the hinge, as a share of the leaf's inertia: a push dies away within some seconds [1/s]."""
PUSH = 40.0
"""With which a motor moves a leaf at its edge [N]: less than a robot of some weight withstands."""
HANDLE = 1.05
"""Height of the handle [m]."""


def add_doors(spec: mujoco.MjSpec, world: World) -> None:
    """Add the leaves of all doors as they stand at the start, each with a motor that does nothing by itself."""
    for leaf in leaves(world):
        _add_leaf(spec, leaf)


def inertia(leaf: Leaf) -> float:
    """Return the inertia of a leaf around its hinge [kg m^2]."""
    return leaf.door.mass * leaf.width**2 / 3


def _add_leaf(spec: mujoco.MjSpec, leaf: Leaf) -> None:
    name, door = f"door/{leaf.name}", leaf.door
    heading = leaf.pose(math.radians(door.angle_deg)).heading / 2
    body = spec.worldbody.add_body(
        name=name, pos=[*leaf.hinge, 0.0], quat=[math.cos(heading), 0.0, 0.0, math.sin(heading)]
    )
    body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_HINGE,
        axis=[0.0, 0.0, leaf.turn],
        # In a spec angles of joints are in degrees.
        ref=door.angle_deg,
        limited=True,
        range=[-door.limit_deg, door.limit_deg],
        damping=DAMPING * inertia(leaf),
        stiffness=door.spring,
        springref=0.0,
    )
    gap = min(GAP, leaf.width / 8, (leaf.high - leaf.low) / 8)
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
    if low < HANDLE < high:
        _add_handle(body, leaf)
    spec.add_actuator(
        name=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=name,
        ctrllimited=True,
        ctrlrange=[-PUSH * leaf.width, PUSH * leaf.width],
    )
    lock = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, name1=name, active=door.locked)
    # The equality counts from the joint's reference.
    lock.objtype = mujoco.mjtObj.mjOBJ_JOINT
    lock.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]


def _add_handle(body: mujoco.MjsBody, leaf: Leaf) -> None:
    """Add a bar through the leaf near its free edge, for the eye."""
    bar = body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[leaf.width * 0.9, 0.0, HANDLE],
        size=[leaf.width * 0.06, THICKNESS / 2 + 0.03, 0.012],
    )
    make_decor(bar, DARK)
