"""Visual and collision shapes of arms from files, attached to their links."""

from collections.abc import Iterator
from itertools import combinations
from typing import Any

import mujoco
import numpy as np

from mjsim.compile.geom_groups import DECOR, SEEN
from mjsim.compile.model_looks import LookOf
from mjsim.compile.models import LoadedFile, copy_geom
from mjsim.compile.robot_shapes import TOUCHED
from mjsim.compile.room import Covers
from mjsim.geometry import Array
from mjsim.mechanics import Solid, is_valid, nearest_valid
from mjsim.models import FileArm, pose_keys, seen_and_touched
from mjsim.world import RobotArm

MIN_GAP = 2e-3
"""Links whose shapes are nearer than this at the start never collide with each other [m]."""


def original_of(spec: mujoco.MjSpec, file: FileArm, *, key: str) -> LoadedFile:
    """Return the file of an arm for the scene; the names of its meshes and materials there start with `key`."""
    return LoadedFile(file.model, file.files.urdf, LookOf(spec, file.model, key), key, Covers(spec, key))


def add_stand(base: mujoco.MjsBody, file: FileArm, *, name: str, placed: dict[str, Array]) -> mujoco.MjsBody:
    """Add the fixed parts of an arm's file as a body `ROBOT/ARM/base`, and return it."""
    body = base.add_body(name=f"{name}/base", **placed)
    mass, center, inertia = file.base
    x, y, z = center.tolist()
    xx, yy, zz, xy, yz, xz = inertia[[0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]].tolist()
    solid = Solid(mass, (x, y, z), (xx, yy, zz, xy, yz, xz))
    solid = solid if is_valid(solid) else nearest_valid(solid)
    xx, yy, zz, xy, yz, xz = solid.inertia
    body.explicitinertial, body.mass, body.ipos = True, solid.mass, solid.center
    body.fullinertia = [xx, yy, zz, xy, xz, yz]
    return body


def add_shapes(
    spec: mujoco.MjSpec,
    stand: mujoco.MjsBody,
    bodies: list[mujoco.MjsBody],
    item: RobotArm,
    original: LoadedFile,
    *,
    name: str,
) -> None:
    """Add the geoms of an arm's file to the stand and the links.

    Args:
        spec: The scene.
        stand: Body of the parts that no joint moves.
        bodies: Bodies of the links.
        item: The arm.
        original: Its file in this scene.
        name: `ROBOT/ARM`.
    """
    file = item.file_arm
    plain = item.color if "color" in item.model_fields_set else None
    seen, touched = seen_and_touched(file.model, urdf=file.files.urdf)
    for shape in file.shapes:
        number, body = shape.number, stand if shape.link < 0 else bodies[shape.link]
        if not (seen[number] or touched[number]):
            continue
        own = file.model.geom(number).name
        keys = solid_keys(file.model, number, seen=bool(seen[number]), touched=bool(touched[number]))
        keys |= original.looks.of_geom(number, plain=plain) | pose_keys(shape.pose)
        keys["name"] = f"{name}/{own}" if own and _free(spec, f"{name}/{own}") else ""
        copy_geom(spec, body, original, number, scale=1.0, **keys)


def _free(spec: mujoco.MjSpec, name: str) -> bool:
    return spec.geom(name) is None


def solid_keys(model: mujoco.MjModel, number: int, *, seen: bool, touched: bool) -> dict[str, Any]:
    """Return the keys of a geom of the file in the scene: visual, collision, or both."""
    if not touched:
        return {"group": DECOR, "contype": 0, "conaffinity": 0}
    return {
        "group": SEEN if seen else TOUCHED,
        "condim": int(model.geom_condim[number]),
        "friction": model.geom_friction[number],
        "priority": int(model.geom_priority[number]),
        "solref": model.geom_solref[number],
        "solimp": model.geom_solimp[number],
    }


def passing(item: RobotArm) -> Iterator[tuple[int, int]]:
    """Yield pairs of links (-1 for the base) that do not collide with each other.

    These are links joined by a joint, links that the file excludes, and links that touch at the start.
    """
    file, model = item.file_arm, item.file_arm.model
    yield from ((link.parent, number) for number, link in enumerate(file.links))
    yield from file.apart
    posture = item.arm.moved(np.eye(4)).posture(item.start())
    _, touched = seen_and_touched(model, urdf=file.files.urdf)
    solid = [shape for shape in file.shapes if touched[shape.number]]
    data = mujoco.MjData(model)
    for shape in solid:
        pose = shape.pose if shape.link < 0 else posture.links[shape.link] @ shape.pose
        data.geom_xpos[shape.number], data.geom_xmat[shape.number] = pose[:3, 3], pose[:3, :3].ravel()
    touching: set[tuple[int, int]] = set()
    for first, second in combinations(solid, 2):
        pair = min(first.link, second.link), max(first.link, second.link)
        if pair[0] != pair[1] and pair not in touching and _touch(model, data, first.number, second.number):
            touching.add(pair)
    yield from sorted(touching)


def _touch(model: mujoco.MjModel, data: mujoco.MjData, first: int, second: int) -> bool:
    """Return whether two geoms are near enough to count as touching."""
    reach = float(model.geom_rbound[first] + model.geom_rbound[second]) + MIN_GAP
    if float(np.linalg.norm(data.geom_xpos[first] - data.geom_xpos[second])) > reach:
        return False
    return float(mujoco.mj_geomDistance(model, data, first, second, MIN_GAP, None)) < MIN_GAP
