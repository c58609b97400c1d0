"""Reads an MJCF scene as what surrounds a robot: bodies with their geoms, lamps, and where its own robots start."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models.colours import hex_of
from mjsim.models.model_reader import UNSAID, no_warnings
from mjsim.models.rotations import frame_at

_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_DIRECTIONAL = int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)


@dataclass(frozen=True, slots=True, eq=False)
class SceneGeom:
    """A geom that collides."""

    kind: str
    """As in MJCF: 'box', 'mesh', ..."""
    size: Array
    """As in MJCF, shape (3,) [m]."""
    pose: Array
    """In the world, shape (4, 4) [m]."""
    color: str | None
    """'#rrggbb'; None if the file gives none."""
    vertices: Array
    """Of a mesh, in the frame of the geom, shape (n, 3) [m]."""
    faces: NDArray[np.int64]
    """Shape (m, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class SceneBody:
    """Geoms that move as one, or not at all."""

    name: str
    pose: Array
    """In the world, shape (4, 4) [m]."""
    geoms: Sequence[SceneGeom]
    mass: float | None
    """Mass of a free body [kg]; None if it is not free."""
    jointed: bool
    """Whether it hangs on a joint that is not free."""
    bare: int
    """Number of geoms that nothing touches."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfScene:
    """The contents of a scene, with all joints at their reference."""

    bodies: Sequence[SceneBody]
    """The geoms of the world itself first."""
    robots: Sequence[tuple[str, Array]]
    """Bodies that motors move: name, and pose in the world, shape (4, 4) [m]."""
    lamps: Sequence[tuple[str, Array, bool]]
    """Name, place, shape (3,) [m], and whether it is directional."""
    textured: bool
    height_fields: Sequence[str]
    """Names of height fields, which are left out."""


def read_mjcf_scene(path: Path) -> MjcfScene:
    """Return the contents of an MJCF scene.

    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    with no_warnings(str(path)):
        spec = mujoco.MjSpec.from_file(str(path))
        # A world takes no textures from a scene, and MuJoCo could not read all of them.
        for material in spec.materials:
            material.textures = ["" for _ in material.textures]
        textures, fields = list(spec.textures), [each.name for each in spec.hfields]
        for texture in textures:
            spec.delete(texture)
        model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    robots = sorted(_robots(model))
    lamps = [
        (model.light(k).name, model.light_pos[k].copy(), int(model.light_type[k]) == _DIRECTIONAL)
        for k in range(model.nlight)
    ]
    starts = [(model.body(body).name, frame_at(data.xpos[body], data.xmat[body])) for body in robots]
    return MjcfScene(_bodies(model, data, set(robots)), starts, lamps, bool(textures), fields)


def _bodies(model: Any, data: Any, robots: set[int]) -> list[SceneBody]:
    """Return the bodies that are no robots, with the geoms of what is fixed to them."""
    groups: dict[int, list[int]] = {}
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) not in robots:
            groups.setdefault(_carrier(model, body), []).append(geom)
    return [_body(model, data, body, geoms) for body, geoms in sorted(groups.items())]


def _body(model: Any, data: Any, body: int, geoms: Sequence[int]) -> SceneBody:
    touched = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    joints = int(model.body_jntnum[body])
    free = joints > 0 and int(model.jnt_type[model.body_jntadr[body]]) == _FREE
    return SceneBody(
        name=model.body(body).name or f"body-{body}",
        pose=frame_at(data.xpos[body], data.xmat[body]),
        geoms=[_geom(model, data, geom) for geom in touched],
        mass=float(model.body_subtreemass[body]) if free else None,
        jointed=joints > 0 and not free,
        bare=len(geoms) - len(touched),
    )


def _geom(model: Any, data: Any, geom: int) -> SceneGeom:
    kind = mujoco.mjtGeom(int(model.geom_type[geom])).name.removeprefix("mjGEOM_").lower()
    vertices, faces = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)
    if int(model.geom_type[geom]) == _MESH:
        mesh = model.mesh(int(model.geom_dataid[geom]))
        first, begin = int(mesh.vertadr[0]), int(mesh.faceadr[0])
        vertices = np.asarray(model.mesh_vert[first : first + int(mesh.vertnum[0])], dtype=float)
        faces = np.asarray(model.mesh_face[begin : begin + int(mesh.facenum[0])], dtype=np.int64)
    pose = frame_at(data.geom_xpos[geom], data.geom_xmat[geom])
    return SceneGeom(kind, model.geom_size[geom].copy(), pose, _color(model, geom), vertices, faces)


def _color(model: Any, geom: int) -> str | None:
    """Return the colour of a geom, or of its material."""
    material = int(model.geom_matid[geom])
    shares = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    if np.allclose(shares, UNSAID):
        return None
    return hex_of(shares[:3].tolist())


def _carrier(model: Any, body: int) -> int:
    """Return the nearest body above with joints, or the one in the world; 0 for geoms of the world itself."""
    while int(model.body_parentid[body]) and not model.body_jntnum[body]:
        body = int(model.body_parentid[body])
    return body


def _robots(model: Any) -> set[int]:
    """Return the bodies in the world that motors move."""
    joint = int(mujoco.mjtTrn.mjTRN_JOINT)
    moved = [int(model.actuator_trnid[k, 0]) for k in range(model.nu) if int(model.actuator_trntype[k]) == joint]
    return {int(model.body_rootid[int(model.jnt_bodyid[k])]) for k in moved}
