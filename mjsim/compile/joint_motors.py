"""Joints of mechanisms, each with an idle motor and a lock."""

import math

import mujoco

from mjsim.world import MotorJoint

DIGITS = 12
"""Decimals of angles in degrees, so that 30 degrees stay 30 after conversion through radians."""


def add_joint(body: mujoco.MjsBody, joint: MotorJoint) -> None:
    """Add a revolute or prismatic joint to a body in its initial pose; the joint's frame is the body's."""
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
        name: Name of the joint and of the lock.
        held: Whether it is locked at the start.
    """
    added = spec.add_equality(name=name, type=mujoco.mjtEq.mjEQ_JOINT, name1=name, active=held)
    # The equality is relative to the joint's reference; its default coefficients hold the joint there.
    added.objtype = mujoco.mjtObj.mjOBJ_JOINT


def _spec_value(joint: MotorJoint, value: float) -> float:
    """Return a value in the units of an MjSpec: angles of joints in degrees."""
    return round(math.degrees(value), DIGITS) if joint.kind == "revolute" else value
