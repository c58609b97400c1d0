"""The corners of meshes, read from the files that MuJoCo reads."""

import re

import numpy as np

from mjsim.geometry import Array

MOST_CORNERS = 200_000
"""Of a mesh."""
_VERTEX = re.compile(rb"^[ \t]*v[ \t]([^\r\n]*)", re.MULTILINE)
_STL_HEAD, _STL_TRIANGLE = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def mesh_corners(path: str, data: bytes) -> Array:
    """Return the corners of a mesh as its file has them, shape (n, 3).

    Args:
        path: Its name; the ending tells the format.
        data: An OBJ, a binary STL, or MuJoCo's own MSH.

    Raises:
        ValueError: It cannot be read, or it has too many corners; a sentence that names the file.
    """
    read = {"obj": _obj_corners, "stl": _stl_corners, "msh": _msh_corners}[path.rpartition(".")[2].lower()]
    try:
        corners = read(data)
    except (ValueError, IndexError):
        raise ValueError(f"'{path}' cannot be read as a mesh; export it again as OBJ or binary STL") from None
    if not 3 < len(corners) <= MOST_CORNERS:
        raise ValueError(f"'{path}' has {len(corners)} corners; a mesh has 4 to {MOST_CORNERS}, simplify it")
    return corners


def _obj_corners(data: bytes) -> Array:
    rows = _VERTEX.findall(data)
    if len(rows) > MOST_CORNERS:
        return np.zeros((len(rows), 3))
    return np.array([row.split()[:3] for row in rows], dtype=float).reshape(-1, 3)


def _stl_corners(data: bytes) -> Array:
    count = int.from_bytes(data[80:_STL_HEAD], "little")
    if len(data) != _STL_HEAD + count * _STL_TRIANGLE.itemsize:
        raise ValueError("its length does not fit")
    # Each triangle has its own three, whereas those of a mesh are shared.
    corners = np.frombuffer(data, _STL_TRIANGLE, count, _STL_HEAD)["corners"].reshape(-1, 3)
    return np.unique(corners, axis=0).astype(float)


def _msh_corners(data: bytes) -> Array:
    count = int.from_bytes(data[:4], "little")
    return np.frombuffer(data, "<f4", 3 * count, 16).reshape(-1, 3).astype(float)
