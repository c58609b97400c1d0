"""Parts of one robot, which do not collide with each other."""

from itertools import combinations

import mujoco

ROLLER = "/roller"
"""Part of the names of rollers, which do not collide with each other anyway."""


def exclude_parts(spec: mujoco.MjSpec, base: mujoco.MjsBody) -> None:
    """Exclude collisions among the parts of a robot."""
    whole = [base, *base.find_all(mujoco.mjtObj.mjOBJ_BODY)]
    names = sorted({body.name for body in whole if _touches(body)})
    for first, second in combinations(names, 2):
        if ROLLER not in first or ROLLER not in second:
            spec.add_exclude(bodyname1=first, bodyname2=second)


def _touches(body: mujoco.MjsBody) -> bool:
    return any(geom.contype or geom.conaffinity for geom in body.geoms)
