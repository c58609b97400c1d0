"""The geoms of an abstract scene as one array, so that many are changed at once."""

import ctypes
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

_FIELDS = {
    "type": (np.int32, 0),
    "dataid": (np.int32, 4),
    "objtype": (np.int32, 8),
    "objid": (np.int32, 12),
    "matid": (np.int32, 20),
    "texid": (np.int32, 24),
    "texcoord": (np.int32, 32),
    "rgba": ((np.float32, 4), 100),
    "emission": (np.float32, 116),
}
"""Type of each field in use, and its place in `mjvGeom` [byte]."""
_SIZE = 252
"""Size of an `mjvGeom` [byte]."""
GEOM = np.dtype(
    {
        "names": list(_FIELDS),
        "formats": [kind for kind, _ in _FIELDS.values()],
        "offsets": [place for _, place in _FIELDS.values()],
        "itemsize": _SIZE,
    }
)


def geoms_of(scene: mujoco.MjvScene) -> NDArray[Any]:
    """Return the memory of all geoms that a scene may hold, as records; valid as long as the scene exists."""
    first = scene.geoms[0].rgba.__array_interface__["data"][0] - _FIELDS["rgba"][1]
    memory = (ctypes.c_ubyte * (_SIZE * scene.maxgeom)).from_address(first)
    return np.frombuffer(memory, dtype=GEOM)


def mesh_geom(dataid: int) -> NDArray[Any]:
    """Return the record of a white mesh with a number, without an object, shape (1,)."""
    record = np.zeros(1, dtype=GEOM)
    record["type"], record["dataid"] = mujoco.mjtGeom.mjGEOM_MESH, dataid
    record["objtype"], record["objid"], record["matid"], record["texid"] = mujoco.mjtObj.mjOBJ_UNKNOWN, -1, -1, -1
    record["rgba"] = 1.0
    return record


def as_bytes(records: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the same memory as rows of bytes; copying records leaves out the fields that have no name here."""
    return records.view(np.uint8).reshape(-1, _SIZE)


def same_layout(scene: mujoco.MjvScene) -> bool:
    """Return whether `geoms_of` reads the geoms of a scene, at least two, as MuJoCo itself does."""
    addresses = [geom.rgba.__array_interface__["data"][0] for geom in scene.geoms[:2]]
    if len(addresses) < 2 or addresses[1] - addresses[0] != _SIZE:
        return False
    # Memory is read only where the distance between two geoms is as expected.
    records = geoms_of(scene)[: scene.ngeom]
    return all(
        np.array_equal(records[name], [getattr(geom, name) for geom in scene.geoms[: scene.ngeom]]) for name in _FIELDS
    )
