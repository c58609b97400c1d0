"""Settings of the physics of every scene."""

import mujoco


def set_physics(spec: mujoco.MjSpec, step: float) -> None:
    """Set integrator, contacts and the period of the physics [s]."""
    spec.option.timestep = step
    # Not an implicit one: those damp a wheel's servo separately from the contact of its tyre, which then slips by 5 mm
    # for each metre per second gained. All servos are soft enough for Euler's steps.
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
