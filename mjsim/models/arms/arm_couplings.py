"""Couplings of an arm's joints: mimic joints of URDF, and equalities of joints of MJCF."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco

from mjsim.models.inertia_repair import finite_number
from mjsim.models.model_sources import Element


@dataclass(frozen=True, slots=True)
class JointCoupling:
    """A joint that another one moves: its value is `ratio` times the other's plus `offset` [rad, m]."""

    joint: str
    leader: str
    ratio: float
    offset: float


def mimics(root: Element) -> Iterator[JointCoupling]:
    """Yield the mimic joints of a URDF."""
    for joint in root.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None:
            ratio, offset = (finite_number(mimic.get(key)) for key in ("multiplier", "offset"))
            ratio = 1.0 if ratio is None else ratio
            yield JointCoupling(joint.get("name", ""), mimic.get("joint", ""), ratio, offset or 0.0)


def equalities(model: mujoco.MjModel) -> Iterator[JointCoupling]:
    """Yield the equalities of two joints of MJCF whose polynomials are straight lines."""
    for number in range(model.neq):
        two = int(model.eq_type[number]) == int(mujoco.mjtEq.mjEQ_JOINT) and int(model.eq_obj2id[number]) >= 0
        offset, ratio, *curved = model.eq_data[number, :5].tolist()
        if not two or any(curved):
            continue
        first, second = (int(ids[number]) for ids in (model.eq_obj1id, model.eq_obj2id))
        own, other = (float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (first, second))
        # MuJoCo's are relative to the reference positions.
        offset += own - ratio * other
        yield JointCoupling(model.joint(first).name, model.joint(second).name, ratio, offset)


def coupled(couplings: Sequence[JointCoupling], names: Sequence[str]) -> tuple[tuple[int, int, float, float], ...]:
    """Return index of the joint, index of its leader, ratio and offset of the couplings between some joints."""
    index = {name: number for number, name in enumerate(names)}
    return tuple(
        (index[each.joint], index[each.leader], each.ratio, each.offset)
        for each in couplings
        if each.joint in index and each.leader in index and each.joint != each.leader
    )
