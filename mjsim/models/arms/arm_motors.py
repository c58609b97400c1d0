"""Motor limits of an arm's file."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from mjsim.models.model_sources import Element


@dataclass(frozen=True, slots=True)
class Motors:
    """Limits in the text of a URDF, by joint name."""

    efforts: Mapping[str, float]
    """Maximum efforts [N m, N]."""
    velocities: Mapping[str, float]
    """Maximum velocities [rad/s, m/s]."""

    def torque(self, model: mujoco.MjModel, joint: int) -> float:
        """Return the maximum torque of a joint [N m, N]: from its limits, or the sum over its actuators."""
        found = self.efforts.get(model.joint(joint).name, math.inf)
        if model.jnt_actfrclimited[joint]:
            found = min(found, float(np.abs(model.jnt_actfrcrange[joint]).max()))
        shares = [
            limit * lever
            for number in range(model.nu)
            if (lever := _lever(model, number, joint)) > 0.0 and (limit := _max_force(model, number)) > 0.0
        ]
        return min(found, sum(shares)) if shares else found


def motors_of(root: Element) -> Motors:
    """Return the limits in the text of a URDF; none for MJCF, for which MuJoCo provides them."""
    limits = [(joint.get("name", ""), joint.find("limit")) for joint in root.findall("joint")]
    found: dict[str, dict[str, float]] = {"effort": {}, "velocity": {}}
    for name, limit in limits:
        for key, values in found.items():
            # Converters write 0 for unknown limits.
            if limit is not None and (value := _number(limit.get(key))) > 0.0:
                values[name] = value
    return Motors(found["effort"], found["velocity"])


def _number(text: str | None) -> float:
    try:
        value = float(text or "0")
    except ValueError:
        return 0.0
    return value if math.isfinite(value) else 0.0


def _lever(model: mujoco.MjModel, number: int, joint: int) -> float:
    """Return the torque at a joint per unit of an actuator's force."""
    kind, target = int(model.actuator_trntype[number]), int(model.actuator_trnid[number][0])
    gear = abs(float(model.actuator_gear[number][0]))
    if kind in (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)):
        return gear if target == joint else 0.0
    if kind != int(mujoco.mjtTrn.mjTRN_TENDON):
        return 0.0
    first, count = int(model.tendon_adr[target]), int(model.tendon_num[target])
    wraps = range(first, first + count)
    joints = [wrap for wrap in wraps if int(model.wrap_type[wrap]) == int(mujoco.mjtWrap.mjWRAP_JOINT)]
    return gear * sum(abs(float(model.wrap_prm[wrap])) for wrap in joints if int(model.wrap_objid[wrap]) == joint)


def _max_force(model: mujoco.MjModel, number: int) -> float:
    """Return the maximum force of an actuator, infinite without a limit."""
    if model.actuator_forcelimited[number]:
        return float(np.abs(model.actuator_forcerange[number]).max())
    plain = not model.actuator_biasprm[number][:3].any()
    if plain and model.actuator_ctrllimited[number]:
        gain = abs(float(model.actuator_gainprm[number][0]))
        return gain * float(np.abs(model.actuator_ctrlrange[number]).max())
    return math.inf
