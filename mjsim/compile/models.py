"""Objects from MJCF and URDF files, rebuilt in the scene.

MuJoCo compiles the file by itself, in memory, and the scene is built from the result: bodies, joints, geoms, meshes and
looks. A file's own settings, classes and units therefore do not affect the scene, the file can be scaled, and many
objects of one file share meshes and looks. A model is a body `obstacle/NAME`; bodies, joints and geoms of the file keep
their names below it: `obstacle/NAME/seat`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile.model_looks import LookOf
from mjsim.compile.room import COLLISION, VISUAL, Covers, shape_triangles
from mjsim.geometry import Array
from mjsim.models import ModelShape, no_warnings, seen_and_touched
from mjsim.sentences import Sentence
from mjsim.world import ModelObstacle

SEEN = 0
"""Group of geoms that are visible and collide."""
MAX_MASS = 1e6
"""[kg]"""
MIN_INERTIA = 1e-12
"""Minimum inertia of a moving body [kg m^2]: slightly above MuJoCo's own bound."""


@dataclass(frozen=True, slots=True, eq=False)
class LoadedFile:
    """A file compiled by MuJoCo, for objects in one scene."""

    model: mujoco.MjModel
    urdf: bool
    looks: LookOf
    key: str
    """Prefix of the names of its meshes in the scene."""
    covers: Covers
    """Surfaces of its shapes that have a texture in metres."""
    meshes: dict[tuple[int, float], str] = field(default_factory=dict)
    """Names of the meshes already in the scene, by number and scale."""


def original(spec: mujoco.MjSpec, shape: ModelShape, *, key: str) -> LoadedFile:
    """Return a file for the objects of a scene.

    Args:
        spec: The scene.
        shape: Content of the file.
        key: Prefix of the names of its meshes and materials in the scene.
    """
    return LoadedFile(shape.model, shape.files.urdf, LookOf(spec, shape.model, key), key, Covers(spec, key))


def try_alone(spec: mujoco.MjSpec, path: str) -> None:
    """Raise ValueError when a scene with one model fails to compile, or MuJoCo warns about it."""
    with no_warnings(path):
        spec.compile()


def add_model(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    obstacle: ModelObstacle,
    original: LoadedFile,
    *,
    name: str,
    solid: Mapping[str, Any],
) -> None:
    """Add the content of a model to a body of the scene, whose frame becomes that of the file.

    Args:
        spec: The scene.
        body: Body at the obstacle's pose, lifted so that the model's lowest point is at its elevation.
        obstacle: The obstacle.
        original: Its file.
        name: `obstacle/NAME`.
        solid: Common keys of all geoms that collide.

    Raises:
        ValueError: It is movable but has no mass.
    """
    model, scale = original.model, obstacle.scale
    bodies = _add_bodies(body, model, scale=scale, name=name)
    heavier = _heavier(obstacle, model)
    for number in range(1, model.nbody):
        _set_inertia(bodies[number], model, number, heavier=heavier, scale=scale)
    for number in range(model.njnt):
        _add_joint(bodies[int(model.jnt_bodyid[number])], model, number, scale=scale, name=name)
    plain = None if obstacle.color == type(obstacle).model_fields["color"].default else obstacle.color
    seen, touched = seen_and_touched(model, urdf=original.urdf)
    for number in np.flatnonzero(seen | touched).tolist():
        keys = dict(solid) if touched[number] else {"contype": 0, "conaffinity": 0}
        keys["group"] = COLLISION if not seen[number] else SEEN if touched[number] else VISUAL
        if touched[number] and "friction" not in keys:
            keys["friction"] = model.geom_friction[number]
        keys |= original.looks.of_geom(number, plain=plain)
        keys |= {"name": _below(name, model.geom(number).name), "quat": model.geom_quat[number]}
        keys["pos"] = model.geom_pos[number] * scale
        part = bodies[int(model.geom_bodyid[number])]
        if seen[number] and plain is None and _add_cover(part, original, number, scale=scale, **keys):
            keys |= {"group": COLLISION, "material": "matte", "rgba": original.looks.mean(number)}
        if touched[number] or keys["group"] != COLLISION:
            copy_geom(spec, part, original, number, scale=scale, **keys)
    _add_excludes(spec, model, bodies)


def _add_cover(body: mujoco.MjsBody, original: LoadedFile, number: int, *, scale: float, **keys: Any) -> bool:
    """Add a mesh for a shape whose texture the file repeats in metres; return whether it is one."""
    model, tile = original.model, original.looks.tile(number)
    shape = shape_triangles(mujoco.mjtGeom(model.geom_type[number]), model.geom_size[number] * scale)
    if tile is None or shape is None:
        return False
    looks = {key: keys[key] for key in ("pos", "quat", "rgba")} | {"material": original.looks.metric(keys["material"])}
    unfelt = {"group": VISUAL, "contype": 0, "conaffinity": 0, "mass": 0.0}
    mesh = original.covers.mesh(shape, tile * scale)
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh, **looks, **unfelt)
    return True


def copy_geom(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, original: LoadedFile, number: int, *, scale: float, **keys: Any
) -> None:
    """Add a geom of a file to a body of the scene; it has no mass, as bodies carry the masses.

    Args:
        spec: The scene.
        body: Body in the scene.
        original: The file.
        number: Number of the geom in the file.
        scale: Metres per unit of length of the file.
        keys: Its other keys: pose, looks, contacts.
    """
    model = original.model
    size = model.geom_size[number] * scale
    geom = body.add_geom(type=int(model.geom_type[number]), size=size, mass=0.0, **keys)
    if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
        geom.meshname = _mesh_of(spec, original, int(model.geom_dataid[number]), scale)


def _below(name: str, own: str) -> str:
    """Return the name of a part in the scene; '' for a part without a name."""
    return f"{name}/{own}" if own else ""


def _add_bodies(body: mujoco.MjsBody, model: mujoco.MjModel, *, scale: float, name: str) -> list[mujoco.MjsBody]:
    """Add the bodies of a model below the one for its world body; return them by number."""
    bodies = [body]
    for number in range(1, model.nbody):
        parent = bodies[int(model.body_parentid[number])]
        place, turn = model.body_pos[number] * scale, model.body_quat[number]
        still = not model.body_jntnum[number] and not place.any() and turn[0] == 1.0
        if model.body_parentid[number] == 0 and still and len(bodies) == 1:
            # The body that carries all others is the object itself.
            bodies.append(body)
            continue
        own = model.body(number).name or str(number)
        bodies.append(parent.add_body(name=f"{name}/{own}", pos=place, quat=turn))
    return bodies


def _heavier(obstacle: ModelObstacle, model: mujoco.MjModel) -> float:
    """Return the factor by which the masses of a file are multiplied."""
    total = float(model.body_mass.sum())
    if not total < MAX_MASS:
        raise ValueError(
            Sentence("'{model}' weighs {total:g} kg, too much for an object; check its units", obstacle.model, total)
        )
    # The part that moves as a whole consists of the bodies that no joint of the file moves.
    base = float(model.body_mass[model.body_weldid == 0].sum())
    if base <= 0.0 and (obstacle.movable or obstacle.path is not None):
        raise ValueError(
            Sentence("'{model}' is movable but has no mass; give its geoms a mass or a density", obstacle.model)
        )
    return obstacle.mass / total if obstacle.mass is not None else obstacle.scale**3


def _set_inertia(body: mujoco.MjsBody, model: mujoco.MjModel, number: int, *, heavier: float, scale: float) -> None:
    if model.body_mass[number] > 0.0:
        body.explicitinertial = True
        body.mass = model.body_mass[number] * heavier
        body.ipos, body.iquat = model.body_ipos[number] * scale, model.body_iquat[number]
        body.inertia = model.body_inertia[number] * heavier * scale**2
        if min(*body.inertia, body.mass) < MIN_INERTIA:
            raise ValueError(
                Sentence(
                    "a part of {mass:g} kg is too small for the physics; scale it up or make it heavier", body.mass
                )
            )


def _add_joint(body: mujoco.MjsBody, model: mujoco.MjModel, number: int, *, scale: float, name: str) -> None:
    kind, address, axis = int(model.jnt_type[number]), model.jnt_qposadr[number], model.jnt_dofadr[number]
    joint = body.add_joint(
        name=_below(name, model.joint(number).name),
        type=kind,
        pos=model.jnt_pos[number] * scale,
        axis=model.jnt_axis[number],
        armature=model.dof_armature[axis],
        frictionloss=model.dof_frictionloss[axis],
    )
    joint.stiffness[0], joint.damping[0] = model.jnt_stiffness[number], model.dof_damping[axis]
    # Angles in a scene are in degrees.
    unit = scale if kind == mujoco.mjtJoint.mjJNT_SLIDE else 180.0 / np.pi
    if kind != mujoco.mjtJoint.mjJNT_BALL:
        joint.ref, joint.springref = model.qpos0[address] * unit, model.qpos_spring[address] * unit
    if model.jnt_limited[number]:
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = model.jnt_range[number] * unit


def _mesh_of(spec: mujoco.MjSpec, original: LoadedFile, number: int, scale: float) -> str:
    """Return the name of a mesh in the scene, which is added if missing."""
    name = original.meshes.get((number, scale))
    if name is not None:
        return name
    model = original.model
    name = original.meshes[number, scale] = f"{original.key}/mesh{len(original.meshes) + 1}"
    corners, triangles, textured = _mesh_corners(model, number)
    mesh = spec.add_mesh(name=name, inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL)
    mesh.uservert = (corners[:, :3] * scale).ravel()
    mesh.usernormal = corners[:, 3:6].ravel()
    if textured:
        mesh.usertexcoord = corners[:, 6:].ravel()
    mesh.userface = triangles.astype(np.int32).ravel()
    return name


def _mesh_corners(model: mujoco.MjModel, number: int) -> tuple[Array, NDArray[np.intp], bool]:
    """Return the vertices of a mesh, its triangles, shape (m, 3), and whether it has texture coordinates.

    A vertex is position, normal and texture coordinates, shape (n, 6 or 8).
    """
    faces = slice(first := int(model.mesh_faceadr[number]), first + int(model.mesh_facenum[number]))
    textured = bool(model.mesh_texcoordadr[number] >= 0 and model.mesh_texcoordnum[number] > 0)
    kinds = [
        (model.mesh_vert, model.mesh_vertadr[number], model.mesh_face[faces]),
        (model.mesh_normal, model.mesh_normaladr[number], model.mesh_facenormal[faces]),
    ]
    if textured:
        kinds.append((model.mesh_texcoord, model.mesh_texcoordadr[number], model.mesh_facetexcoord[faces]))
    # One number for the data of a triangle's corner, because numbers sort fast.
    keys = np.zeros(3 * model.mesh_facenum[number], dtype=np.int64)
    for _, _, indices in kinds:
        keys = keys * (int(indices.max()) + 1) + indices.ravel()
    _, first_rows, triangles = np.unique(keys, return_index=True, return_inverse=True)
    columns = [values[int(first) + indices.ravel()[first_rows]] for values, first, indices in kinds]
    return np.hstack(columns).astype(float), triangles.reshape(-1, 3), textured


def _add_excludes(spec: mujoco.MjSpec, model: mujoco.MjModel, bodies: list[mujoco.MjsBody]) -> None:
    """Exclude collisions of bodies joined by joints, and those that the file excludes."""
    pairs = {(int(model.body_parentid[number]), number) for number in range(2, model.nbody)}
    pairs |= {(int(signature) >> 16, int(signature) & 0xFFFF) for signature in model.exclude_signature}
    named = {tuple(sorted((bodies[a].name, bodies[b].name))) for a, b in pairs}
    for first, second in sorted(named):
        if first != second:
            spec.add_exclude(bodyname1=first, bodyname2=second)
