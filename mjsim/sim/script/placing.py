"""Moves free bodies to other places."""

import math
from collections.abc import Collection, Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models import matrix_of

MAX_OVERLAP = 1e-3
"""Allowed overlap of a placed object with others [m]."""


def held_by(
    model: mujoco.MjModel, data: mujoco.MjData, own: Collection[int], *, but: Collection[int] = ()
) -> str | None:
    """Return the object inside which some geoms are; None if there is none, such as on the floor.

    Root bodies of `but` do not count.
    """
    mine = set(own)
    for contact in data.contact[: data.ncon]:
        if contact.dist < -MAX_OVERLAP and not mine.isdisjoint(contact.geom.tolist()):
            roots = model.body_rootid[model.geom_bodyid[contact.geom]].tolist()
            for geom, root in zip(contact.geom.tolist(), roots, strict=True):
                if geom not in mine and root not in but and (name := _called(model, geom, root)):
                    return name
    return None


def _called(model: mujoco.MjModel, geom: int, root: int) -> str:
    """Return how a message calls the object of a geom, '' for the floor."""
    kind, _, rest = (model.body(root).name if root else model.geom(geom).name).partition("/")
    if kind not in ("obstacle", "door", "wall"):
        return f"'{kind}'" if root else ""
    rest = rest.rpartition("/")[0] if kind == "wall" else rest
    return f"{kind}s[{int(rest) - 1}]" if rest.isdigit() else f"{kind} '{rest}'"


def put_down(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    joint: str,
    to: Sequence[float],
    *,
    height: float | None,
    heading: float | None,
) -> NDArray[np.intp]:
    """Move a free body elsewhere, with all its parts at rest; its wheels keep their angles.

    Args:
        model: The compiled world.
        data: Its state.
        joint: Name of the free joint.
        to: Where to, x and y [m].
        height: Height of its frame [m]; None for that in the compiled world.
        heading: [rad]; None for the current one.

    Returns:
        The geoms of what was moved.
    """
    found = model.joint(joint)
    start = int(found.qposadr[0])
    if heading is None:
        heading = heading_of(matrix_of(data.qpos[start + 3 : start + 7]).ravel())
    data.qpos[start : start + 2] = to
    data.qpos[start + 2] = model.qpos0[start + 2] if height is None else height
    data.qpos[start + 3 : start + 7] = [math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)]
    root = int(model.body_rootid[model.jnt_bodyid[found.id]])
    data.qvel[model.body_rootid[model.dof_bodyid] == root] = 0.0
    return np.flatnonzero(model.body_rootid[model.geom_bodyid] == root)


def heading_of(matrix: Array) -> float:
    """Return the heading of a body's x axis from above [rad]; its rotation matrix has shape (9,)."""
    return math.atan2(float(matrix[3]), float(matrix[0]))
