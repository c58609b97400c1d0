"""Reads a scene of MuJoCo as the surroundings of a world: geoms, and bodies that move; a robot only as its start."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.meshes import boxed
from mjsim.exchange.scenes.sdf_files import MAX_XML
from mjsim.exchange.scenes.solids import Light, Scene, Solid, Thing
from mjsim.inventory import Fate
from mjsim.models import no_warnings

_GEOMS = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
    int(mujoco.mjtGeom.mjGEOM_PLANE): "plane",
}
_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
LAMP_REACH = 10.0
"""Range of a lamp [m]."""


def read_mjcf(path: Path) -> Scene:
    """Return the scene of an MJCF file, with all joints at their reference.

    Raises:
        UsageError: MuJoCo cannot read the file.
    """
    data = read_bounded(path, limit=MAX_XML, kind="an MJCF file")
    if b"<mujoco" not in data:
        raise UsageError(f"'{path}' has no <mujoco>; a scene is MJCF, or SDF with the ending .sdf or .world")
    scene = Scene()
    model = _compiled(path, scene)
    state = mujoco.MjData(model)
    mujoco.mj_kinematics(model, state)
    _take_things(model, state, scene)
    for light in range(model.nlight):
        name = model.light(light).name
        if model.light_type[light] == int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL):
            scene.tell(Fate.LEFT_OUT, "directional light", name, "a world has ambient light and lamps")
        else:
            scene.lights.append(Light(name, model.light_pos[light].copy(), "#ffffff", LAMP_REACH))
    return scene


def _compiled(path: Path, scene: Scene) -> Any:
    """Return the compiled model, without textures, which a world does not take from a scene."""
    try:
        with no_warnings(str(path)):
            spec = mujoco.MjSpec.from_file(str(path))
            for material in spec.materials:
                material.textures = ["" for _ in material.textures]
            if spec.textures:
                scene.tell(Fate.LEFT_OUT, "textures", why="colours are kept")
            for texture in list(spec.textures):
                spec.delete(texture)
            for height in list(spec.hfields):
                scene.tell(Fate.LEFT_OUT, "height field", height.name, "the floor of a world is level")
            return spec.compile()
    except ValueError as error:
        raise UsageError(f"'{path}': {error}") from None


def _take_things(model: Any, state: Any, scene: Scene) -> None:
    """Take the geoms of a scene, by the bodies that carry them."""
    robots = _robots(model)
    for robot in sorted(robots):
        x, y, _ = state.xpos[robot]
        turn = state.xmat[robot].reshape(3, 3)
        scene.starts.append((float(x), float(y), math.atan2(turn[1, 0], turn[0, 0])))
        why = "its start is kept; bring it in by mjsim new --robot-from"
        scene.tell(Fate.LEFT_OUT, "robot", model.body(robot).name, why)
    groups: dict[int, list[int]] = {}
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) not in robots:
            groups.setdefault(_carrier(model, body), []).append(geom)
    for body, geoms in groups.items():
        _take_thing(model, state, scene, body, geoms)


def _take_thing(model: Any, state: Any, scene: Scene, body: int, geoms: list[int]) -> None:
    """Take the geoms of a body with those fixed to it."""
    name = model.body(body).name or f"body-{body}"
    solid = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    if bare := len(geoms) - len(solid):
        scene.tell(Fate.LEFT_OUT, "visual geom", why=f"{bare} of '{name}' that nothing touches") if not solid else None
    found = [part for geom in solid for part in _solids(model, state, scene, geom, name)]
    if not found:
        return
    free = body > 0 and _is_free(model, body)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = state.xmat[body].reshape(3, 3), state.xpos[body]
    if body > 0 and model.body_jntnum[body] and not free:
        scene.tell(Fate.GUESSED, "jointed body", name, "it stands still, at the reference of its joints")
    parts = [[part] for part in found] if body == 0 else [found]
    for part in parts:
        mass = float(model.body_subtreemass[body]) if free else None
        scene.add(Thing("scene" if body == 0 else name, part, np.eye(4) if body == 0 else pose, mass))


def _solids(model: Any, state: Any, scene: Scene, geom: int, name: str) -> Iterator[Solid]:
    """Yield the solid of a geom."""
    kind = _GEOMS.get(int(model.geom_type[geom]))
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = state.geom_xmat[geom].reshape(3, 3), state.geom_xpos[geom]
    size = model.geom_size[geom]
    color = _color(model, geom)
    if kind == "box":
        yield Solid("box", tuple((2.0 * size).tolist()), pose, color)
    elif kind in ("cylinder", "capsule"):
        long = 2.0 * size[1] + (2.0 * size[0] if kind == "capsule" else 0.0)
        if kind == "capsule":
            scene.tell(Fate.GUESSED, "capsule", name, "a cylinder of its size")
        yield Solid("cylinder", (float(size[0]), float(long)), pose, color)
    elif kind == "sphere":
        yield Solid("sphere", (float(size[0]),), pose, color)
    elif kind == "mesh":
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
        begin, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        vertices = np.asarray(model.mesh_vert[first : first + count], dtype=float)
        yield boxed(Solid("mesh", (), pose, color, vertices, np.asarray(model.mesh_face[begin : begin + faces])))
    elif kind == "ellipsoid":
        scene.tell(Fate.GUESSED, "ellipsoid", name, "a box around it")
        yield Solid("box", tuple((2.0 * size).tolist()), pose, color)
    elif kind != "plane" or abs(pose[2, 2]) < 0.99 or abs(pose[2, 3]) > 0.05:
        scene.tell(Fate.LEFT_OUT, kind or "height field", name, "a world has one floor, at height 0")


def _color(model: Any, geom: int) -> str:
    """Return the colour of a geom, or of its material."""
    material = int(model.geom_matid[geom])
    shares = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return "#" + "".join(f"{round(255 * min(max(float(share), 0.0), 1.0)):02x}" for share in shares[:3])


def _carrier(model: Any, body: int) -> int:
    """Return the nearest body above with joints, or the one in the world; 0 for geoms of the world itself."""
    while int(model.body_parentid[body]) and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
    return body


def _is_free(model: Any, body: int) -> bool:
    return int(model.jnt_type[model.body_jntadr[body]]) == _FREE if model.body_jntnum[body] else False


def _robots(model: Any) -> set[int]:
    """Return the bodies in the world that motors move."""
    joints = [
        int(model.actuator_trnid[motor, 0])
        for motor in range(model.nu)
        if int(model.actuator_trntype[motor]) == int(mujoco.mjtTrn.mjTRN_JOINT)
    ]
    return {int(model.body_rootid[int(model.jnt_bodyid[joint])]) for joint in joints}
