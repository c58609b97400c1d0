"""Parts of one robot, which pass through each other."""

from itertools import combinations

import mujoco

ROLLER = "/roller"
"""In the names of rollers, which touch nothing of each other anyway."""


def exclude_parts(spec: mujoco.MjSpec, base: mujoco.MjsBody) -> None:
    """Let the parts of a robot pass through each other."""
    whole = [base, *base.find_all(mujoco.mjtObj.mjOBJ_BODY)]
    names = sorted({body.name for body in whole if _touches(body)})
    for first, second in combinations(names, 2):
        if ROLLER not in first or ROLLER not in second:
            spec.add_exclude(bodyname1=first, bodyname2=second)


def _touches(body: mujoco.MjsBody) -> bool:
    return any(geom.contype or geom.conaffinity for geom in body.geoms)
