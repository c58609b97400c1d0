"""Compiles a single model with MuJoCo, in memory: the only reader of MJCF and URDF."""

import posixpath
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from xml.etree import ElementTree

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.models.model_sources import ModelFiles
from mjsim.models.picture_pixels import bounded, encode_png, read_picture
from mjsim.models.proven import require_readable
from mjsim.sentences import Sentence

LAST_SEEN_GROUP = 2
"""MuJoCo's viewers show groups up to this one by default."""
SHAPES = ("sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh")
"""Geom types allowed in an object; planes of a file are left out, because a room has its own floor."""
UNSAID = [0.5, 0.5, 0.5, 1.0]
"""MuJoCo's colour for a geom without one."""
MAX_TEXTURE_SIDE = 1024
"""[px]"""
MAX_EXTENT = 1e6
"""Maximum extent of an object [units of its file]."""
CIRCLE_CORNERS = 32
"""Number of corners of a circle."""
MAX_CORNERS = 1_200_000
"""Maximum number of corners of all parts of a model together; a ball has 544."""
_TURNS = np.arange(CIRCLE_CORNERS) * (2.0 * np.pi / CIRCLE_CORNERS)
_ONE_AT_A_TIME = threading.Lock()
"""MuJoCo has one warning handler for all threads."""


def compiled(files: ModelFiles) -> mujoco.MjModel:
    """Return the compiled model.

    Raises:
        ValueError: MuJoCo cannot read the files, or warns about them; the message names the file.
    """
    tree = ElementTree.tostring(files.root)
    content = (tree, *(part for name, data in files.assets.items() for part in (name.encode(), data)))
    require_readable("model", files, content=content, about=files.paths[0], files=files.sums)
    with no_warnings(files.paths[0]):
        return spec_of(files).compile()


def spec_of(files: ModelFiles) -> mujoco.MjSpec:
    """Return a model's files as an uncompiled `MjSpec`.

    Raises:
        ValueError: MuJoCo cannot read them.
    """
    assets = {name: _as_png(data) if _is_picture(name) else data for name, data in files.assets.items()}
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(files.root, encoding="unicode"), assets=assets)
    if files.urdf:
        _add_textures(spec, files)
    return spec


def _add_textures(spec: mujoco.MjSpec, files: ModelFiles) -> None:
    """Give the meshes of a URDF the textures of their materials, which MuJoCo's reader of URDF leaves out."""
    pictures: dict[str, str] = {}
    for visual in files.root.iter("visual"):
        mesh, texture = visual.find("geometry/mesh"), visual.find("material/texture")
        if mesh is not None and texture is not None and texture.get("filename", "") in files.assets:
            pictures[posixpath.splitext(mesh.get("filename", ""))[0]] = texture.get("filename", "")
    for name in sorted({*pictures.values()}):
        texture = spec.add_texture(name=name, type=mujoco.mjtTexture.mjTEXTURE_2D, file=name)
        textures = [""] * int(mujoco.mjtTextureRole.mjNTEXROLE)
        textures[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = texture.name
        spec.add_material(name=name, textures=textures)
    for geom in spec.geoms:
        if geom.meshname in pictures:
            geom.material, geom.rgba = pictures[geom.meshname], UNSAID


_HARMLESS = "discarding texture coordinates"
"""MuJoCo's warning about meshes with texture coordinates at only some faces; they get the colour of their material."""


def _is_picture(name: str) -> bool:
    return name.lower().endswith((".jpg", ".jpeg", ".png"))


def _as_png(data: bytes) -> bytes:
    """Return a picture in the form that MuJoCo reads: PNG, of limited size."""
    return encode_png(bounded(read_picture(data), MAX_TEXTURE_SIDE))


@contextmanager
def no_warnings(path: str) -> Iterator[None]:
    """Raise ValueError, naming a file, for every MuJoCo error and every relevant warning."""
    messages: list[str] = []
    with _ONE_AT_A_TIME:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda line: None if _HARMLESS in line else messages.append(line))
        try:
            with warnings.catch_warnings():
                # A model that causes a warning on its own would fail in a room as well.
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", message=f".*{_HARMLESS}")
                yield
        except (ValueError, RuntimeError, UserWarning, mujoco.FatalError) as error:
            messages.append(str(error) or type(error).__name__)
        finally:
            mujoco.set_mju_user_warning(before)
    if messages:
        raise ValueError(Sentence("MuJoCo cannot read '{path}': {reason}", path, " ".join(messages[-1].split())[:200]))


def seen_and_touched(model: mujoco.MjModel, *, urdf: bool) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which geoms of a model are visible and which collide, two masks of shape (ngeom,)."""
    kinds = [int(getattr(mujoco.mjtGeom, f"mjGEOM_{shape.upper()}")) for shape in SHAPES]
    drawable = np.isin(model.geom_type, kinds)
    touched = drawable & ((model.geom_contype != 0) | (model.geom_conaffinity != 0))
    seen = drawable & (model.geom_group <= LAST_SEEN_GROUP) & _opaque(model)
    if urdf and (seen & ~touched).any():
        # URDF has separate visual and collision shapes, on top of each other.
        seen &= ~touched
    if not touched.any():
        touched = seen
    return (seen if seen.any() else touched), touched


@np.errstate(over="ignore", invalid="ignore")  # non-finite values are rejected
def solid_parts(model: mujoco.MjModel, *, urdf: bool) -> list[Array]:
    """Return points whose convex hull is each collision part, file frame and units, joints at rest.

    Returns:
        One array of shape (n, 3) per part; round parts are approximated.

    Raises:
        ValueError: There are too many points, or a part that collides or is seen extends too far.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    seen, touched = seen_and_touched(model, urdf=urdf)
    reach = np.abs(data.geom_xpos).max(axis=1) + np.abs(data.geom_xmat).max(axis=1) * model.geom_rbound
    _check_extent(reach[seen])
    parts, count = [], 0
    for number in np.flatnonzero(touched).tolist():
        corners = corners_of(model, number)
        count += len(corners)
        if count > MAX_CORNERS:
            raise ValueError(
                Sentence("its parts have more than {max_corners} corners; simplify its meshes", MAX_CORNERS)
            )
        part = corners @ data.geom_xmat[number].reshape(3, 3).T + data.geom_xpos[number]
        _check_extent(np.abs(part))
        parts.append(part)
    return parts


def _check_extent(distances: Array) -> None:
    # Written so that NaN is rejected, too.
    if not (distances < MAX_EXTENT).all():
        raise ValueError(
            Sentence("it extends to {largest:g} units, too large for an object; check its units", distances.max())
        )


def _opaque(model: mujoco.MjModel) -> NDArray[np.bool_]:
    """Return which geoms are not fully transparent, shape (ngeom,)."""
    own, materials = model.geom_rgba[:, 3] > 0.0, np.append(model.mat_rgba[:, 3], 1.0) > 0.0
    unsaid = (model.geom_rgba == np.array(UNSAID, dtype=model.geom_rgba.dtype)).all(axis=1)
    return np.asarray(np.where(unsaid & (model.geom_matid >= 0), materials[model.geom_matid], own), dtype=bool)


def corners_of(model: mujoco.MjModel, number: int) -> Array:
    """Return points whose convex hull is a geom, in its own frame, shape (n, 3)."""
    size = model.geom_size[number]
    ring = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=-1)
    match model.geom_type[number]:
        case mujoco.mjtGeom.mjGEOM_BOX:
            signs = np.stack(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0], indexing="ij"), axis=-1)
            return np.asarray(signs.reshape(-1, 3) * size)
        case mujoco.mjtGeom.mjGEOM_CYLINDER:
            heights = np.repeat([-size[1], size[1]], CIRCLE_CORNERS)
            return np.column_stack([np.tile(ring * size[0], (2, 1)), heights])
        case mujoco.mjtGeom.mjGEOM_MESH:
            mesh = model.geom_dataid[number]
            first = model.mesh_vertadr[mesh]
            return np.asarray(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], dtype=float)
    ball = _ball()
    match model.geom_type[number]:
        case mujoco.mjtGeom.mjGEOM_CAPSULE:
            return np.concatenate([ball * size[0] + [0.0, 0.0, side * size[1]] for side in (-1.0, 1.0)])
        case mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return np.asarray(ball * size)
    return np.asarray(ball * size[0])


def _ball() -> Array:
    """Return points on the unit sphere, including poles and equator, shape (n, 3)."""
    rises = np.linspace(-np.pi / 2, np.pi / 2, CIRCLE_CORNERS // 2 + 1)[:, None]
    parts = np.broadcast_arrays(np.cos(_TURNS) * np.cos(rises), np.sin(_TURNS) * np.cos(rises), np.sin(rises))
    return np.stack(parts, axis=-1).reshape(-1, 3)
