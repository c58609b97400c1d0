"""Instances of segmented pictures, with their names."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import merged_into

BUILDING_PARTS = ("wall", "floor", "ceiling")
"""Parts of the building that are one instance each."""


def instances_of(model: mujoco.MjModel) -> tuple[NDArray[np.int32], tuple[str, ...]]:
    """Return the instance of each geom, and the names of all instances.

    Names are those of the compiled scene: 'beacon/NAME', 'obstacle/NAME', 'door/NAME', the name of a robot, and
    'wall', 'floor' and 'ceiling' for all of them. A mesh merged from several objects is not an instance:
    segmented pictures show its parts.
    """
    names: dict[str, int] = {}
    mesh_of, instances = merged_into(model), np.zeros(model.ngeom, dtype=np.int32)
    for geom in np.flatnonzero(mesh_of >= 0).tolist():
        instances[geom] = names.setdefault(_instance(model, geom), len(names))
    return instances, tuple(names)


def _instance(model: mujoco.MjModel, geom: int) -> str:
    name: str = model.geom(geom).name
    if name.startswith("beacon/"):
        return "/".join(name.split("/")[:2])
    root: str = model.body(model.body_rootid[model.geom_bodyid[geom]]).name
    first, _, rest = (root if root.endswith("/base") or not name else name).partition("/")
    if first in BUILDING_PARTS or not rest or root.endswith("/base"):
        return first
    return f"{first}/{rest.partition('/')[0]}"
