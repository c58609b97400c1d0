"""Baked light in the cache folder of the user, one file per content; broken or foreign files are baked again."""

import hashlib
import inspect
import io
import json
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.compile import texture_of, triangles_of
from mjsim.light.baked import DOOR, BakedLight, LightGroup, LightProbes, LitSurface
from mjsim.light.still_surfaces import static_geoms, texture_sample
from mjsim.output import replace_file, try_lock, user_cache
from mjsim.progress import say
from mjsim.world import CloseEvent, LampEvent, OpenEvent, RemoveEvent, World, leaves

MAX_BYTES = 300_000_000
"""Limit of all stored light; beyond it, the least recently used files are deleted [bytes]."""
BAKE_TIMEOUT, POLL_SECONDS = 300.0, 0.2
"""Maximum time to wait for another process that bakes the same light, and polling interval [s]."""
BROKEN = (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile, zlib.error)
"""Exceptions on reading a broken file."""
OF_GEOMS = ("geom_type", "geom_size", "geom_rgba", "geom_matid", "geom_dataid")
"""Arrays of the model with a row per geom that affect light."""
OF_MATERIALS = ("mat_rgba", "mat_emission", "mat_texid", "mat_texrepeat", "mat_texuniform")
"""The same with a row per material."""
OF_MESHES = {
    "mesh_vert": ("mesh_vertadr", "mesh_vertnum"),
    "mesh_normal": ("mesh_normaladr", "mesh_normalnum"),
    "mesh_texcoord": ("mesh_texcoordadr", "mesh_texcoordnum"),
    "mesh_face": ("mesh_faceadr", "mesh_facenum"),
    "mesh_facenormal": ("mesh_faceadr", "mesh_facenum"),
    "mesh_facetexcoord": ("mesh_faceadr", "mesh_facenum"),
}
"""Arrays of meshes, and the arrays with the first row and the number of rows of each."""
LIBRARIES = ("embreex", "numpy", "opencv-python-headless", "scipy", "shapely")
"""Distributions that compute light."""
OF_EVENTS = (LampEvent, OpenEvent, CloseEvent, RemoveEvent)
"""Events that decide which light has a map of its own."""
OF_WORLD = ("light", "lamps", "walls", "ceiling")
"""Keys of the world that affect light."""

_unkept: dict[str, BakedLight] = {}
"""The last light that the cache could not keep, by its key."""


def key_of(world: World, model: mujoco.MjModel) -> str:
    """Return a hash of everything that light depends on, as text."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    whole = hashlib.blake2b(digest_size=24)
    for part in _content(world, model, data):
        whole.update(b"%d:" % len(part))
        whole.update(part)
    return whole.hexdigest()


def _content(world: World, model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[bytes]:
    """Yield everything that light depends on."""
    yield _version()
    yield repr(world.model_dump(include=set(OF_WORLD))).encode()
    yield repr([event for event in world.run.events if isinstance(event, OF_EVENTS)]).encode()
    doors = [model.body(f"{DOOR}{leaf.name}").id for leaf in leaves(world)]
    geoms = np.concatenate([static_geoms(model), np.flatnonzero(np.isin(model.geom_bodyid, doors))])
    yield geoms.tobytes()
    yield repr([model.geom(geom).name for geom in geoms]).encode()
    for name in OF_GEOMS:
        yield np.ascontiguousarray(getattr(model, name)[geoms]).tobytes()
    yield data.geom_xpos[geoms].tobytes()
    yield data.geom_xmat[geoms].tobytes()
    for material in _used(model.geom_matid[geoms]):
        for name in OF_MATERIALS:
            yield np.ascontiguousarray(getattr(model, name)[material]).tobytes()
    for texture in _used(np.array([texture_of(model, geom) for geom in geoms])):
        yield texture_sample(model, texture).tobytes()
    meshes = model.geom_type[geoms] == mujoco.mjtGeom.mjGEOM_MESH
    for mesh in _used(model.geom_dataid[geoms][meshes]):
        for name, (first, count) in OF_MESHES.items():
            start = int(getattr(model, first)[mesh])
            yield np.ascontiguousarray(getattr(model, name)[start : start + getattr(model, count)[mesh]]).tobytes()
    yield model.hfield_data.tobytes()
    yield model.hfield_size.tobytes()


def _used(numbers: NDArray[np.generic]) -> list[int]:
    return [int(number) for number in np.unique(numbers) if number >= 0]


@cache  # Modules do not change while a process runs.
def _version() -> bytes:
    """Return a hash of the modules that bake, and of the libraries whose rounding or rays may differ."""
    modules = [*sorted(Path(__file__).parent.glob("*.py")), Path(inspect.getfile(triangles_of))]
    libraries = [_release(name) for name in LIBRARIES]
    return hashlib.sha256(b"".join(module.read_bytes() for module in modules) + repr(libraries).encode()).digest()


def _release(name: str) -> str:
    """Return the version of a distribution, '' if it is not installed under that name."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def stored(key: str) -> BakedLight | None:
    """Return light from the cache, or from this process if the cache could not be written; None if there is none."""
    place = _folder() / key
    try:
        with np.load(io.BytesIO(place.read_bytes()), allow_pickle=False) as arrays:
            light = _from_arrays(dict(arrays), key)
    except BROKEN:
        return _unkept.get(key)
    with suppress(OSError):
        place.touch()  # Used last.
    return light


def store(key: str, light: BakedLight) -> BakedLight:
    """Keep light in the cache, and return it rounded, as if read from there: pictures are the same to the last bit.

    If the cache cannot be written, a message is printed, and the light is kept in this process.
    """
    data = io.BytesIO()
    arrays: dict[str, Any] = _to_arrays(light, key)
    kept = _from_arrays(arrays, key)
    np.savez_compressed(data, **arrays)
    try:
        _make_room(len(data.getvalue()))
        replace_file(_folder() / key, data.getvalue())
    except OSError as error:
        say(f"light is not kept for later: {error.strerror} in {_folder()}; make room there, or set XDG_CACHE_HOME")
        _unkept.clear()
        _unkept[key] = kept
    return kept


@contextmanager
def baking(key: str, is_done: Callable[[], bool]) -> Iterator[None]:
    """Let one process at a time bake the same light; waits for others until theirs is done."""
    began = time.monotonic()
    try:
        _folder().mkdir(parents=True, exist_ok=True)
        file = (_folder() / f"{key}.lock").open("ab")
    except OSError:  # Without a cache, every process bakes.
        yield
        return
    with file:
        while not try_lock(file.fileno()) and not is_done() and time.monotonic() - began < BAKE_TIMEOUT:
            time.sleep(POLL_SECONDS)
        try:
            yield
        finally:
            with suppress(OSError):  # Windows does not delete a file that others have open.
                Path(file.name).unlink()


def _folder() -> Path:
    return user_cache("light")


def _make_room(size: int) -> None:
    """Remove the least recently used files until a new one fits."""
    files = sorted(_files())
    total = size + sum(each[1] for each in files)
    for _, own, file in files:
        if total <= MAX_BYTES:
            return
        file.unlink(missing_ok=True)
        total -= own


def _files() -> Iterator[tuple[float, int, Path]]:
    """Yield when each file was last used [s], its size [bytes] and path; other processes may remove some meanwhile."""
    for file in filter(Path.is_file, _folder().iterdir()):
        with suppress(FileNotFoundError):
            about = file.stat()
            yield about.st_mtime, about.st_size, file


def _to_arrays(light: BakedLight, key: str) -> dict[str, NDArray[np.generic]]:
    surfaces, groups = light.surfaces, light.groups
    about = {
        "key": key,
        "exposure": light.exposure,
        "groups": [group.name for group in groups],
        "gains": [group.gain for group in groups],
        "angles": [group.angle for group in groups],
    }
    empty = np.zeros((0, 2), np.float32)
    return {
        "about": np.array(json.dumps(about)),
        "geoms": np.array([surface.geom for surface in surfaces], dtype=np.int32),
        "corners": np.array([len(surface.points) for surface in surfaces], dtype=np.int32),
        "faces": np.array([len(surface.triangles) for surface in surfaces], dtype=np.int32),
        "pictured": np.array([surface.texcoords is not None for surface in surfaces], dtype=bool),
        "points": np.concatenate([surface.points for surface in surfaces]).astype(np.float32),
        "normals": np.concatenate([surface.normals for surface in surfaces]).astype(np.float16),
        "texcoords": np.concatenate(
            [empty, *(each.texcoords for each in surfaces if each.texcoords is not None)]
        ).astype(np.float32),
        "lightcoords": np.concatenate([surface.lightcoords for surface in surfaces]),
        "triangles": np.concatenate([surface.triangles for surface in surfaces]),
        "texels": np.stack([group.texels for group in groups]),
        "start": np.stack([group.start for group in groups]),
        "probes": light.probes.light,
        "grid": np.stack([light.probes.origin, light.probes.spacing]),
    }


def _from_arrays(arrays: dict[str, NDArray[np.generic]], key: str) -> BakedLight:
    """Return light from a file.

    Raises:
        ValueError, KeyError, TypeError: The file has other content.
    """
    about = json.loads(str(arrays["about"]))
    if about["key"] != key:
        raise ValueError("this file holds the light of another scene")
    corners, faces, pictured = arrays["corners"], arrays["faces"], arrays["pictured"]
    cuts = np.cumsum(corners)[:-1]
    points, normals = (np.split(arrays[name].astype(float), cuts) for name in ("points", "normals"))
    lightcoords = np.split(arrays["lightcoords"].astype(np.float32), cuts)
    triangles = np.split(arrays["triangles"].astype(np.int32), np.cumsum(faces)[:-1])
    pictures = iter(np.split(arrays["texcoords"].astype(float), np.cumsum(corners[pictured])[:-1]))
    texcoords = [next(pictures) if own else None for own in pictured.tolist()]
    rows = zip(arrays["geoms"].tolist(), points, normals, texcoords, lightcoords, triangles, strict=True)
    groups = zip(
        about["groups"],
        arrays["texels"].astype(np.float16),
        arrays["start"].astype(float),
        about["gains"],
        about["angles"],
        strict=True,
    )
    origin, spacing = arrays["grid"].astype(float)
    return BakedLight(
        tuple(LitSurface(*row) for row in rows),
        tuple(LightGroup(*group) for group in groups),
        LightProbes(origin, spacing, arrays["probes"].astype(np.float16)),
        float(about["exposure"]),
    )
