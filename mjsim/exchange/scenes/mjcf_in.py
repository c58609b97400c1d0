"""Reads a scene of MuJoCo as the surroundings of a world: geoms, and bodies that move; a robot only as its start."""

import math
from collections.abc import Iterator
from pathlib import Path

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.scene_meshes import boxed
from mjsim.exchange.scenes.scene_solids import Light, Scene, SceneSolid, SceneThing
from mjsim.exchange.scenes.sdf_files import MAX_XML
from mjsim.inventory import Fate
from mjsim.models import SceneBody, SceneGeom, read_mjcf_scene

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
    try:
        found = read_mjcf_scene(path)
    except ValueError as error:
        raise UsageError(str(error)) from None
    scene = Scene()
    if found.textured:
        scene.tell(Fate.LEFT_OUT, "textures", why="colours are kept")
    for name in found.height_fields:
        scene.tell(Fate.LEFT_OUT, "height field", name, "the floor of a world is level")
    for name, pose in found.robots:
        scene.starts.append((float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])))
        scene.tell(Fate.LEFT_OUT, "robot", name, "its start is kept; bring it in by mjsim new --robot-from")
    for body in found.bodies:
        _take(scene, body)
    for name, place, directional in found.lamps:
        if directional:
            scene.tell(Fate.LEFT_OUT, "directional light", name, "a world has ambient light and lamps")
        else:
            scene.lights.append(Light(name, place, "#ffffff", LAMP_REACH))
    return scene


def _take(scene: Scene, body: SceneBody) -> None:
    """Take a body as one thing; each geom of the world itself is a thing of its own."""
    if body.bare and not body.geoms:
        scene.tell(Fate.LEFT_OUT, "visible body", body.name, "it has no collision shape")
    solids = [solid for geom in body.geoms for solid in _solids(scene, geom, body.name)]
    if body.jointed and solids:
        scene.tell(Fate.GUESSED, "jointed body", body.name, "it stands still, at the reference of its joints")
    for part in [[solid] for solid in solids] if body.name == "world" else [solids] if solids else []:
        scene.add(SceneThing(body.name, part, body.pose, body.mass))


def _solids(scene: Scene, geom: SceneGeom, name: str) -> Iterator[SceneSolid]:
    """Yield the solid of a geom."""
    radius, half = float(geom.size[0]), float(geom.size[1])
    if geom.kind in ("box", "ellipsoid"):
        if geom.kind == "ellipsoid":
            scene.tell(Fate.GUESSED, "ellipsoid", name, "a box around it")
        yield SceneSolid("box", tuple((2.0 * geom.size).tolist()), geom.pose, geom.color)
    elif geom.kind in ("cylinder", "capsule"):
        if geom.kind == "capsule":
            scene.tell(Fate.GUESSED, "capsule", name, "a cylinder of its size")
        long = 2.0 * half + (2.0 * radius if geom.kind == "capsule" else 0.0)
        yield SceneSolid("cylinder", (radius, long), geom.pose, geom.color)
    elif geom.kind == "sphere":
        yield SceneSolid("sphere", (radius,), geom.pose, geom.color)
    elif geom.kind == "mesh":
        yield boxed(SceneSolid("mesh", (), geom.pose, geom.color, geom.vertices, geom.faces))
    elif geom.kind != "plane" or abs(geom.pose[2, 2]) < 0.99 or abs(geom.pose[2, 3]) > 0.05:
        scene.tell(Fate.LEFT_OUT, geom.kind, name, "a world has one floor, at height 0")
