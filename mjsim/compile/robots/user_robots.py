"""Robots from MJCF files, for user-defined drives."""

import mujoco

from mjsim.compile.geom_groups import DECOR, RUNNING_GEAR, SEEN
from mjsim.geometry import Array
from mjsim.models import no_warnings, spec_of
from mjsim.world import ModelBody

BASE = "base"
"""Name of the body in the file that becomes the robot's."""


def add_user_robot(
    spec: mujoco.MjSpec, body: ModelBody, *, name: str, at: tuple[float, ...], quaternion: Array
) -> mujoco.MjsBody:
    """Add the body `base` of a file with its servos, all names prefixed with `ROBOT/`; return it.

    Its wheels are visible to cameras but not to rays, as those of all robots.

    Raises:
        ValueError: MuJoCo cannot read the file, or it has no such body; the message is a sentence.
    """
    files = body.files
    if files.urdf:
        raise ValueError(
            f"'{body.model}' is URDF, which has no servos for a drive of your own;"
            f" mjsim new --robot-from {body.model} -o ROBOT.yaml makes it a robot"
        )
    with no_warnings(body.model):
        spec_of(files).compile()
        model = spec_of(files)
    base = model.body(BASE)
    if base is None:
        raise ValueError(f"'{body.model}' has no body named '{BASE}'; give the robot's that name")
    for joint in list(base.joints):
        model.delete(joint)
    base.pos, base.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    _take_assets(spec, model, name)
    frame = spec.worldbody.add_frame(pos=[*at, 0.0], quat=quaternion)
    placed = frame.attach_body(base, f"{name}/", "")
    placed.add_freejoint(name=f"{name}/free")
    for geom in placed.geoms:
        geom.group = SEEN if geom.contype or geom.conaffinity else DECOR
    for part in placed.find_all(mujoco.mjtObj.mjOBJ_BODY):
        for geom in list(part.geoms):
            _hide_from_rays(part, geom)
    return placed


def _take_assets(spec: mujoco.MjSpec, model: mujoco.MjSpec, name: str) -> None:
    """Add the meshes and textures of a robot to the scene under unique names."""
    for item in (*model.meshes, *model.textures):
        if item.file:
            key = f"{name}-{item.file}"
            spec.assets[key] = model.assets[item.file]
            item.file = key


def _hide_from_rays(wheel: mujoco.MjsBody, geom: mujoco.MjsGeom) -> None:
    """Move a part of the running gear to the group that only collides, and add a visual copy of it."""
    if not (geom.contype or geom.conaffinity):
        geom.group = DECOR
        return
    geom.group = RUNNING_GEAR
    seen = wheel.add_geom(type=geom.type, size=geom.size, pos=geom.pos, quat=geom.quat, rgba=geom.rgba)
    seen.meshname, seen.material = geom.meshname, geom.material
    seen.group, seen.contype, seen.conaffinity, seen.mass = DECOR, 0, 0, 0.0
