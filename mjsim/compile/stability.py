"""Why the physics of a model fails: servos too stiff for what they turn, joints that move next to nothing."""

from collections.abc import Iterator

import mujoco
import numpy as np

MOST_DAMPED = 2.0
"""Share of a speed that a servo may take away in one step; beyond, it swings ever farther."""
MOST_PULLED = 4.0
"""The same of a position, in a step squared."""
LIGHT = 1e-5
"""Inertia of a joint that is as good as none [kg m^2] or [kg]."""
STEPS = 125
"""Of a robot that is tried alone."""


def likely_cause(model: mujoco.MjModel) -> str:
    """Return what is likely to make physics fail, in a sentence with what would help; '' for nothing suspicious."""
    return next((text for _, text in sorted(_suspicions(model), key=lambda found: -found[0])), "")


def stands(model: mujoco.MjModel) -> bool:
    """Return whether a model can be simulated for half a second, told nothing."""
    data = mujoco.MjData(model)
    before = mujoco.get_mju_user_warning()
    # MuJoCo prints warnings otherwise; their numbers tell all that matters.
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        for _ in range(STEPS):
            mujoco.mj_step(model, data)
            if data.warning.number.any() or not np.isfinite(data.qpos).all():
                return False
    finally:
        mujoco.set_mju_user_warning(before)
    return True


def _suspicions(model: mujoco.MjModel) -> Iterator[tuple[float, str]]:
    """Yield how bad what is suspicious is, and a sentence about it."""
    step = float(model.opt.timestep)
    for number in range(model.nu):
        if int(model.actuator_trntype[number]) != int(mujoco.mjtTrn.mjTRN_JOINT):
            continue
        joint = int(model.actuator_trnid[number][0])
        inertia = float(model.dof_M0[model.jnt_dofadr[joint]])
        bare = "" if model.dof_armature[model.jnt_dofadr[joint]] > 0.0 else " and no armature"
        kp, kv = -float(model.actuator_biasprm[number][1]), -float(model.actuator_biasprm[number][2])
        name = model.actuator(number).name or model.joint(joint).name
        damped, pulled = kv * step / inertia, kp * step**2 / inertia
        most_kv, most_kp = MOST_DAMPED * inertia / step, MOST_PULLED * inertia / step**2
        what = f"for joint '{model.joint(joint).name}', which has an inertia of {inertia:.2g} kg m^2{bare}"
        if damped > MOST_DAMPED:
            yield damped, f"servo '{name}' with kv={kv:g} is too stiff {what}: {most_kv:.2g} at most, or an armature"
        if pulled > MOST_PULLED:
            yield pulled, f"servo '{name}' with kp={kp:g} is too stiff {what}: {most_kp:.2g} at most, or an armature"
    for joint in range(model.njnt):
        dof = int(model.jnt_dofadr[joint])
        single = int(model.jnt_type[joint]) in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
        if single and model.dof_armature[dof] == 0.0 and model.dof_M0[dof] < LIGHT:
            name, inertia = model.joint(joint).name, float(model.dof_M0[dof])
            yield (
                1.0,
                f"joint '{name}' has no armature and moves an inertia of {inertia:.2g} kg m^2; give it an armature",
            )
