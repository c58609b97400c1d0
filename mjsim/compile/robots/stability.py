"""Likely causes of failing physics: servos too stiff for their load, joints that move almost no mass."""

from collections.abc import Iterator

import mujoco
import numpy as np

from mjsim.geometry import Array

MAX_DAMPED = 2.0
"""Proportion of a speed that a servo may remove in one step; beyond it, the servo is unstable."""
MAX_PULLED = 4.0
"""The same for a position error, per step squared."""
MIN_INERTIA = 1e-5
"""Inertia of a joint below which it counts as none [kg m^2] or [kg]."""
STEPS = 125
"""Physics steps of a robot tested alone, for each motion."""
MANOEUVRES = ((0.0, 0.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0))
"""Factors of the speed of the left and right wheels: at rest, ahead, back, turning left and right."""


def likely_cause(model: mujoco.MjModel) -> str:
    """Return the likely cause of failing physics and a remedy, in a sentence; '' if nothing is suspicious."""
    return next((text for _, text in sorted(_suspicions(model), key=lambda found: -found[0])), "")


def drives(model: mujoco.MjModel, *, speed: float) -> bool:
    """Return whether a robot can be simulated for half a second each at rest, ahead, back, and turning either way.

    Args:
        model: Model of only a robot and a floor.
        speed: Speed of its wheels [rad/s], unless their servos are limited to less.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    orders = [_orders(model, data, left * speed, right * speed) for left, right in MANOEUVRES]
    before = mujoco.get_mju_user_warning()
    # Otherwise MuJoCo prints warnings; their counts are sufficient.
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        for order in orders:
            data.ctrl = order
            for _ in range(STEPS):
                mujoco.mj_step(model, data)
                if data.warning.number.any() or not np.isfinite(data.qpos).all():
                    return False
    finally:
        mujoco.set_mju_user_warning(before)
    return True


def _orders(model: mujoco.MjModel, data: mujoco.MjData, left: float, right: float) -> Array:
    """Return the commands of all servos for a speed of the wheels on each side [rad/s], shape (nu,).

    Position servos get the middle of their range; so do torque motors, whose command is not a speed.
    """
    order = np.zeros(model.nu)
    for number in range(model.nu):
        joint = int(model.actuator_trnid[number][0])
        kp, kv = -float(model.actuator_biasprm[number][1]), -float(model.actuator_biasprm[number][2])
        if int(model.actuator_trntype[number]) == int(mujoco.mjtTrn.mjTRN_JOINT) and kv > 0.0 and kp == 0.0:
            root = int(model.body_rootid[model.jnt_bodyid[joint]])
            _, lateral, _ = data.xmat[root].reshape(3, 3).T @ (data.xanchor[joint] - data.xpos[root])
            order[number] = left if lateral > 0.0 else right
            if model.actuator_ctrllimited[number]:
                order[number] = np.clip(order[number], *model.actuator_ctrlrange[number])
    return order


def _suspicions(model: mujoco.MjModel) -> Iterator[tuple[float, str]]:
    """Yield the severity of each suspicion, and a sentence about it."""
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
        max_kv, max_kp = MAX_DAMPED * inertia / step, MAX_PULLED * inertia / step**2
        target = f"for joint '{model.joint(joint).name}', which has an inertia of {inertia:.2g} kg m^2{bare}"
        if damped > MAX_DAMPED:
            yield (
                damped,
                f"servo '{name}' with kv={kv:g} is too stiff {target}; reduce kv to {max_kv:.2g} or add an armature",
            )
        if pulled > MAX_PULLED:
            yield (
                pulled,
                f"servo '{name}' with kp={kp:g} is too stiff {target}; reduce kp to {max_kp:.2g} or add an armature",
            )
    for joint in range(model.njnt):
        dof = int(model.jnt_dofadr[joint])
        single = int(model.jnt_type[joint]) in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
        if single and model.dof_armature[dof] == 0.0 and model.dof_M0[dof] < MIN_INERTIA:
            name, inertia = model.joint(joint).name, float(model.dof_M0[dof])
            yield (
                1.0,
                f"joint '{name}' has no armature and moves an inertia of {inertia:.2g} kg m^2; give the part that"
                " it moves more mass, or, in a file, the joint an armature",
            )
