"""Reads an MJCF scene as what surrounds a robot: bodies with their geoms, lamps, and where its own robots start."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models.colours import hex_of
from mjsim.models.model_reader import UNSAID, no_warnings
from mjsim.models.picture_pixels import Picture
from mjsim.models.picture_sizes import PNG, picture_size
from mjsim.models.rotations import frame_at

MAX_TEXTURES = 50_000_000
"""Maximum number of pixels of all textures together, and of bytes of one."""

_FREE, _BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)
_KINDS = {int(mujoco.mjtJoint.mjJNT_HINGE): "hinge", int(mujoco.mjtJoint.mjJNT_SLIDE): "slide"}
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)
_DIRECTIONAL = int(mujoco.mjtLightType.mjLIGHT_DIRECTIONAL)


@dataclass(frozen=True, slots=True, eq=False)
class SceneGeom:
    """A geom that collides."""

    kind: str
    """Kind as in MJCF: 'box', 'mesh', ..."""
    size: Array
    """Size as in MJCF, shape (3,) [m]."""
    pose: Array
    """Pose in the world, shape (4, 4) [m]."""
    color: str | None
    """'#rrggbb'; None if the file gives none."""
    vertices: Array
    """Vertices of a mesh, in the frame of the geom, shape (n, 3) [m]."""
    faces: NDArray[np.int64]
    """Shape (m, 3)."""
    texture: str = ""
    """Name of the texture of its material, see `MjcfScene.textures`; '' for none."""
    tile: float = 0.0
    """Size of one repetition of the texture; 0 if its repetitions fill the geom [m]."""
    repeats: float = 1.0
    """Number of repetitions over the height of the geom."""
    name: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class SceneJoint:
    """A hinge or a slide of a scene; its value is 0 at its pose in the scene."""

    kind: str
    """'hinge' or 'slide'."""
    anchor: Array
    """A point on its axis, in the world, shape (3,) [m]."""
    axis: Array
    """Axis in the world, shape (3,)."""
    range: tuple[float, float] | None = None
    """[rad or m]"""
    damping: float = 0.0
    """[N m s/rad or N s/m]"""
    friction: float = 0.0
    """[N m or N]"""
    stiffness: float = 0.0
    """[N m/rad or N/m]"""
    rest: float = 0.0
    """Value at which its spring is at rest [rad or m]."""

    def moved(self, outer_from_inner: Array) -> "SceneJoint":
        """Return the joint in an outer frame."""
        turn = outer_from_inner[:3, :3]
        return replace(self, anchor=turn @ self.anchor + outer_from_inner[:3, 3], axis=turn @ self.axis)


@dataclass(frozen=True, slots=True, eq=False)
class SceneBody:
    """Geoms that move as one, or not at all."""

    name: str
    pose: Array
    """Pose in the world, shape (4, 4) [m]."""
    geoms: Sequence[SceneGeom]
    mass: float
    """Mass of all parts that move together [kg]."""
    free: bool
    joints: Sequence[SceneJoint]
    """Its hinges and slides."""
    above: str
    """Name of the body that carries it; '' for none."""
    held: bool
    """Whether it has a ball joint, which is not in `joints`."""
    bare: int
    """Number of geoms that collide with nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class MjcfScene:
    """The contents of a scene, with all joints at their reference."""

    bodies: Sequence[SceneBody]
    """The geoms of the world itself first."""
    robots: Sequence[tuple[str, Array]]
    """Bodies that motors move: name, and pose in the world, shape (4, 4) [m]."""
    lamps: Sequence[tuple[str, Array, bool]]
    """Name, place, shape (3,) [m], and whether it is directional."""
    textures: Mapping[str, Picture]
    """Name of a texture of a material -> its pixels; of a cube, its first face."""
    no_textures: Mapping[str, str]
    """Name of a texture that is left out -> why."""
    height_fields: Sequence[str]
    """Names of height fields, which are left out."""
    couplings: int
    """Number of equality constraints between its bodies or joints, which are left out."""
    cameras: Sequence[str]
    """Names of its cameras, except those of robots."""


def read_mjcf_scene(path: Path) -> MjcfScene:
    """Return the contents of an MJCF scene.

    Raises:
        ValueError: MuJoCo cannot read the file.
    """
    with no_warnings(str(path)):
        spec = mujoco.MjSpec.from_file(str(path))
        no_textures, left = dict[str, str](), MAX_TEXTURES
        for texture in spec.textures:
            pixels, why = _size_of(texture, path.parent, spec.texturedir or "")
            left -= 0 if why else pixels
            if why or left < 0:
                no_textures[texture.name or "sky"] = why or "the textures have too many pixels together"
        _drop(spec, no_textures)
        fields = [each.name for each in spec.hfields]
        try:
            model = spec.compile()
        except ValueError:
            # Some damage shows only when a picture is decoded; other errors occur again below.
            no_textures |= {texture.name: "MuJoCo cannot read this texture or another one" for texture in spec.textures}
            _drop(spec, no_textures)
            model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    robots = sorted(_robots(model))
    lamps = [
        (model.light(k).name, model.light_pos[k].copy(), int(model.light_type[k]) == _DIRECTIONAL)
        for k in range(model.nlight)
    ]
    starts = [(model.body(body).name, frame_at(data.xpos[body], data.xmat[body])) for body in robots]
    pictures = {model.texture(k).name: _pixels(model, k) for k in range(model.ntex)}
    bodies = _bodies(model, data, set(robots))
    apart = np.flatnonzero(~np.isin(model.body_rootid[model.cam_bodyid], robots)).tolist()
    cameras = [model.camera(number).name for number in apart]
    return MjcfScene(bodies, starts, lamps, pictures, no_textures, fields, int(model.neq), cameras)


def _drop(spec: Any, names: Collection[str]) -> None:
    """Remove textures by name; a sky without a name is 'sky'."""
    for material in spec.materials:
        material.textures = ["" if name in names else name for name in material.textures]
    for texture in list(spec.textures):
        if (texture.name or "sky") in names:
            spec.delete(texture)


def _size_of(texture: Any, home: Path, folder: str) -> tuple[int, str]:
    """Return the number of pixels of a texture, and why it is left out, or ''; files must be below `home`."""
    if texture.type not in (mujoco.mjtTexture.mjTEXTURE_2D, mujoco.mjtTexture.mjTEXTURE_CUBE):
        return 0, "a world has no sky of its own"
    if texture.builtin != mujoco.mjtBuiltin.mjBUILTIN_NONE:
        return texture.width * max(texture.height, 6 * texture.width), ""
    if not texture.file:
        return 0, "its faces are files of their own"
    place = (home / folder / texture.file).resolve()
    if not place.is_relative_to(home.resolve()) or not place.is_file():
        return 0, "not in the folder of the scene; put it there"
    try:
        data = place.read_bytes() if place.stat().st_size <= MAX_TEXTURES else b""
        width, height = picture_size(data)
    except ValueError as error:
        return 0, str(error)
    return width * height, "" if data.startswith(PNG) else "it is not a PNG"


def _pixels(model: Any, number: int) -> Picture:
    """Return the RGB picture of a texture; of a cube, its first face."""
    height, width, channels = (int(each[number]) for each in (model.tex_height, model.tex_width, model.tex_nchannel))
    first = int(model.tex_adr[number])
    whole = model.tex_data[first : first + height * width * channels].reshape(height, width, channels)
    is_cube = int(model.tex_type[number]) == int(mujoco.mjtTexture.mjTEXTURE_CUBE)
    shown = whole[: width if is_cube else height]
    return np.ascontiguousarray(shown[..., :3] if channels >= 3 else np.repeat(shown[..., :1], 3, axis=2))


def _bodies(model: Any, data: Any, robots: set[int]) -> list[SceneBody]:
    """Return the bodies other than robots, each after its parent, with the geoms of all bodies fixed to it."""
    carriers = [_carrier(model, body) for body in range(model.nbody)]
    groups: dict[int, list[int]] = {}
    for body, carrier in enumerate(carriers):
        if int(model.body_rootid[body]) not in robots:
            groups.setdefault(carrier, []).append(body)
    found = []
    for carrier, own in sorted(groups.items()):
        geoms = [geom for body in own for geom in _geoms_of(model, body)]
        if geoms or carrier:
            above = carriers[int(model.body_parentid[carrier])]
            mass = float(sum(model.body_mass[body] for body in own))
            found.append(_body(model, data, carrier, geoms, mass=mass, above=_name(model, above) if above else ""))
    return found


def _geoms_of(model: Any, body: int) -> range:
    first = int(model.body_geomadr[body])
    return range(first, first + int(model.body_geomnum[body]))


def _name(model: Any, body: int) -> str:
    return model.body(body).name or f"body-{body}"


def _body(model: Any, data: Any, body: int, geoms: Sequence[int], *, mass: float, above: str) -> SceneBody:
    touched = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    first = int(model.body_jntadr[body])
    joints = range(first, first + int(model.body_jntnum[body]))
    kinds = [int(model.jnt_type[joint]) for joint in joints]
    return SceneBody(
        name=_name(model, body),
        pose=frame_at(data.xpos[body], data.xmat[body]),
        geoms=[_geom(model, data, geom) for geom in touched],
        mass=mass,
        free=_FREE in kinds,
        joints=[_joint(model, data, each) for each, kind in zip(joints, kinds, strict=True) if kind in _KINDS],
        above=above,
        held=_BALL in kinds,
        bare=len(geoms) - len(touched),
    )


def _joint(model: Any, data: Any, joint: int) -> SceneJoint:
    """Return a hinge or a slide, with values from its reference on."""
    place, axis = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    start = float(model.qpos0[place])
    low, high = (float(end) - start for end in model.jnt_range[joint])
    return SceneJoint(
        kind=_KINDS[int(model.jnt_type[joint])],
        anchor=data.xanchor[joint].copy(),
        axis=data.xaxis[joint].copy(),
        range=(low, high) if model.jnt_limited[joint] else None,
        damping=float(model.dof_damping[axis]),
        friction=float(model.dof_frictionloss[axis]),
        stiffness=float(model.jnt_stiffness[joint]),
        rest=float(model.qpos_spring[place]) - start,
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
    look = _texture_of(model, int(model.geom_matid[geom]))
    size, color, name = model.geom_size[geom].copy(), _color(model, geom), model.geom(geom).name
    return SceneGeom(kind, size, pose, color, vertices, faces, *look, name=name)


def _texture_of(model: Any, material: int) -> tuple[str, float, float]:
    """Return texture, tile and repeats of a geom with a material, as `SceneGeom` has them."""
    texture = int(model.mat_texid[material, int(mujoco.mjtTextureRole.mjTEXROLE_RGB)]) if material >= 0 else -1
    if texture < 0:
        return "", 0.0, 1.0
    repeats = float(model.mat_texrepeat[material, 1])
    # Those of a cube cover each face once.
    if int(model.tex_type[texture]) == int(mujoco.mjtTexture.mjTEXTURE_CUBE) or not repeats > 0.0:
        repeats = 1.0
    is_uniform = bool(model.mat_texuniform[material])
    return model.texture(texture).name, 1.0 / repeats if is_uniform else 0.0, repeats


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
