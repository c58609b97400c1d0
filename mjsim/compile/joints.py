"""Joints of mechanisms, each with an idle motor and a lock."""

import math

import mujoco

from mjsim.world import MotorJoint

DIGITS = 12
"""To which angles in degrees are rounded, so that 30 degrees stay 30 on the way through radians."""


def add_joint(body: mujoco.MjsBody, joint: MotorJoint) -> None:
    """Let a body, placed as it stands at the start, move about or along a joint; its frame is the joint's."""
    revolute = joint.kind == "revolute"
    body.add_joint(
        name=joint.name,
        type=mujoco.mjtJoint.mjJNT_HINGE if revolute else mujoco.mjtJoint.mjJNT_SLIDE,
        axis=joint.axis,
        ref=_spec_value(joint, joint.start),
        limited=True,
        range=[_spec_value(joint, joint.lower), _spec_value(joint, joint.upper)],
        damping=joint.damping,
        stiffness=joint.stiffness,
        springref=0.0,
    )


def add_motor(spec: mujoco.MjSpec, joint: MotorJoint) -> None:
    """Add the motor of a joint, and the lock that holds it when it is locked."""
    spec.add_actuator(
        name=joint.name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint.name,
        ctrllimited=True,
        ctrlrange=[-joint.effort, joint.effort],
    )
    lock(spec, joint.name, held=joint.locked)


def lock(spec: mujoco.MjSpec, name: str, *, held: bool) -> None:
    """Add the lock of a joint, which holds it at its reference.

    Args:
        spec: The scene.
        name: Of the joint, and of the lock.
        held: Whether it is locked at the start.
    """
    added = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, name1=name, active=held)
    # The equality counts from the joint's reference.
    added.objtype = mujoco.mjtObj.mjOBJ_JOINT
    added.data[:5] = [0.0, 1.0, 0.0, 0.0, 0.0]


def _spec_value(joint: MotorJoint, value: float) -> float:
    """Return a value as a spec has it: angles of joints are in degrees there."""
    return round(math.degrees(value), DIGITS) if joint.kind == "revolute" else value
