"""Robots from files of MJCF, for drives of the user's own."""

import mujoco

from mjsim.compile.parts import DECOR, RUNNING_GEAR, SEEN
from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.world.bodies import ModelBody

BASE = "base"
"""Name of the body in the file that becomes the robot's."""


def add_user_robot(
    spec: mujoco.MjSpec, body: ModelBody, *, name: str, at: tuple[float, ...], quaternion: Array
) -> mujoco.MjsBody:
    """Add the body `base` of a file with its servos, all names after `ROBOT/`; return it.

    Its wheels are seen by cameras and hit by no rays, as those of all robots.

    Raises:
        UsageError: MuJoCo cannot read the file, or it has no such body.
    """
    try:
        model = mujoco.MjSpec.from_string(body.text())
    except ValueError as error:
        raise UsageError(f"{body.model} cannot be read: {str(error).splitlines()[0]}") from None
    base = model.body(BASE)
    if base is None:
        raise UsageError(f"{body.model} has no body named '{BASE}'; give the robot's that name")
    for joint in list(base.joints):
        model.delete(joint)
    base.pos, base.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    frame = spec.worldbody.add_frame(pos=[*at, 0.0], quat=quaternion)
    placed = frame.attach_body(base, f"{name}/", "")
    placed.add_freejoint(name=f"{name}/free")
    for geom in placed.geoms:
        geom.group = SEEN if geom.contype or geom.conaffinity else DECOR
    for part in placed.find_all(mujoco.mjtObj.mjOBJ_BODY):
        for geom in list(part.geoms):
            _hide_from_rays(part, geom)
    return placed


def _hide_from_rays(wheel: mujoco.MjsBody, geom: mujoco.MjsGeom) -> None:
    """Give a part of the running gear the group that is touched alone, and one that is seen in its place."""
    if not (geom.contype or geom.conaffinity):
        geom.group = DECOR
        return
    geom.group = RUNNING_GEAR
    seen = wheel.add_geom(type=geom.type, size=geom.size, pos=geom.pos, quat=geom.quat, rgba=geom.rgba)
    seen.group, seen.contype, seen.conaffinity, seen.mass = DECOR, 0, 0, 0.0
