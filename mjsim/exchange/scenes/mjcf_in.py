"""Reads a scene of MuJoCo as the surroundings of a world: geoms, and bodies that move; a robot only as its start."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.exchange.bounded_file import read_bounded
from mjsim.exchange.scenes.scene_meshes import MAX_SIDE, boxed
from mjsim.exchange.scenes.scene_solids import ON_ROBOTS, Light, Scene, ScenePart, SceneSolid, SceneTexture, SceneThing
from mjsim.exchange.scenes.sdf_files import MAX_XML
from mjsim.inventory import Fate
from mjsim.models import SceneBody, SceneGeom, bounded, encode_png, read_mjcf_scene

Looks = Mapping[str, SceneTexture]
"""Name of a texture in the file -> its picture."""
LAMP_REACH = 10.0
"""Range of a lamp [m]."""
WORLD = "world"
"""Name of the body that holds the geoms of the world itself."""


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
    for name, why in found.no_textures.items():
        scene.tell(Fate.LEFT_OUT, "texture", name, why)
    looks = {name: _file_of(name, k, picture) for k, (name, picture) in enumerate(found.textures.items())}
    for name in found.height_fields:
        scene.tell(Fate.LEFT_OUT, "height field", name, "the floor of a world is level")
    if found.couplings:
        why = "joints of a scene move one by one"
        scene.tell(Fate.LEFT_OUT, f"{found.couplings} couplings of joints or bodies (equality)", why=why)
    for name in found.cameras:
        scene.tell(Fate.LEFT_OUT, "camera", name, ON_ROBOTS)
    for name, pose in found.robots:
        scene.starts.append((float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])))
        scene.tell(Fate.LEFT_OUT, "robot", name, "its start is kept; import it with mjsim new --robot-from")
    _take(scene, found.bodies, looks)
    for name, place, directional in found.lamps:
        if directional:
            scene.tell(Fate.LEFT_OUT, "directional light", name, "a world has ambient light and lamps")
        else:
            scene.lights.append(Light(name, place, "#ffffff", LAMP_REACH))
    return scene


def _take(scene: Scene, bodies: Sequence[SceneBody], looks: Looks) -> None:
    """Take bodies as things, and those that joints move as their parts; each geom of the world is a thing."""
    carried: dict[str, list[SceneBody]] = {}
    for body in bodies:
        carried.setdefault(body.above, []).append(body)
    for body in carried.get("", []):
        if body.joints and not body.free:
            if (part := _part(scene, body, carried, looks)) is not None:
                scene.add(SceneThing(body.name, [], body.pose, parts=[part]))
            continue
        if body.name == WORLD and body.geoms:
            for geom in body.geoms:
                own = replace(body, name=geom.name or WORLD, geoms=[geom])
                for solid in _all_solids(scene, own, looks):
                    scene.add(SceneThing(own.name, [solid], own.pose))
            continue
        solids, parts = _all_solids(scene, body, looks), _parts(scene, body, carried, looks)
        if solids or parts:
            scene.add(SceneThing(body.name, solids, body.pose, body.mass if body.free else None, parts))


def _parts(scene: Scene, body: SceneBody, carried: Mapping[str, Sequence[SceneBody]], looks: Looks) -> list[ScenePart]:
    """Return the parts that joints move on a body."""
    found = (_part(scene, each, carried, looks) for each in carried.get(body.name, []))
    return [part for part in found if part is not None]


def _part(scene: Scene, body: SceneBody, carried: Mapping[str, Sequence[SceneBody]], looks: Looks) -> ScenePart | None:
    """Return a body that joints move, with what they move on it; None if nothing can touch it."""
    solids, parts = _all_solids(scene, body, looks), _parts(scene, body, carried, looks)
    return ScenePart(body.name, body.joints, solids, body.mass, parts) if solids or parts else None


def _all_solids(scene: Scene, body: SceneBody, looks: Looks) -> list[SceneSolid]:
    if body.bare and not body.geoms:
        scene.tell(Fate.LEFT_OUT, "visible body", body.name, "it has no collision shape")
    if body.held:
        scene.tell(Fate.GUESSED, "body on a ball joint", body.name, "it does not turn")
    found = ((geom, solid) for geom in body.geoms for solid in _solids(scene, geom, body.name))
    return [replace(solid, texture=_texture(geom, solid, looks)) for geom, solid in found]


def _file_of(name: str, number: int, picture: NDArray[np.uint8]) -> SceneTexture:
    stem = re.sub(r"[^A-Za-z0-9_-]+", "_", name)[:40] or "texture"
    return SceneTexture(f"{stem}_{number}.png", encode_png(bounded(picture, MAX_SIDE)))


def _texture(geom: SceneGeom, solid: SceneSolid, looks: Looks) -> SceneTexture | None:
    """Return the picture on a geom, with the size of its repetitions."""
    if geom.texture not in looks:
        return None
    return replace(looks[geom.texture], tile=geom.tile or 2.0 * float(solid.half[2]) / geom.repeats)


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
    elif geom.texture:
        scene.tell(Fate.LEFT_OUT, "texture of the floor", geom.texture, "set another one with floor: in the world")
