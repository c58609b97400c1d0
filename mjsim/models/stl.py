"""Converts STL files to what MuJoCo reads: binary, with a bounded number of triangles."""

import re

import numpy as np

from mjsim.geometry import Array

MAX_TRIANGLES = 60_000
"""Maximum number of triangles of a mesh; it is simplified until it has no more."""
HEAD = 80
FINEST = 400
"""Number of cells along the longest side of a mesh in the first simplification."""
COARSER = 0.75
"""Factor on the number of cells in each further one."""
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attributes", "<u2")])
_NUMBER = rb"([-+0-9.eE]{1,32})"
_VERTEX = re.compile(rb"vertex\s+" + _NUMBER + rb"\s+" + _NUMBER + rb"\s+" + _NUMBER)


def tidy_stl(data: bytes) -> bytes:
    """Return an STL file in binary form with a bounded number of triangles; unchanged if it already is one.

    Data that is not an STL file is returned unchanged.
    """
    triangles = _triangles(data)
    if triangles is None or (len(triangles) <= MAX_TRIANGLES and _is_binary(data)):
        return data
    cells = float(FINEST)
    while len(triangles) > MAX_TRIANGLES:
        triangles = _coarser(triangles, cells)
        cells *= COARSER
    records = np.zeros(len(triangles), dtype=_RECORD)
    records["corners"] = triangles
    return b"".ljust(HEAD) + len(triangles).to_bytes(4, "little") + records.tobytes()


def _is_binary(data: bytes) -> bool:
    count = int.from_bytes(data[HEAD : HEAD + 4], "little")
    return len(data) == HEAD + 4 + count * _RECORD.itemsize


def _triangles(data: bytes) -> Array | None:
    """Return the corners of all triangles, shape (n, 3, 3); None where there are none."""
    if _is_binary(data):
        records = np.frombuffer(data, dtype=_RECORD, offset=HEAD + 4)
        return np.asarray(records["corners"], dtype=float)
    if not data.lstrip().startswith(b"solid"):
        return None
    try:
        corners = np.array(_VERTEX.findall(data), dtype=np.bytes_).astype(float)
    except ValueError:
        return None
    return corners.reshape(-1, 3, 3) if len(corners) and len(corners) % 3 == 0 else None


def _coarser(triangles: Array, cells: float) -> Array:
    """Return triangles with corners merged per cell, without those of zero area, shape (m, 3, 3)."""
    corners = triangles.reshape(-1, 3)
    size = max(float(np.ptp(corners, axis=0).max()) / cells, 1e-12)
    keys = np.floor((corners - corners.min(axis=0)) / size).astype(np.int64)
    _, owners = np.unique(keys, axis=0, return_inverse=True)
    owners = owners.ravel()
    counts = np.bincount(owners)
    middles = np.column_stack([np.bincount(owners, weights=corners[:, axis]) / counts for axis in range(3)])
    faces = owners.reshape(-1, 3)
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return np.asarray(middles[np.unique(faces[whole], axis=0)])
