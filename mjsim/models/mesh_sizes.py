"""Determines the size of a mesh from its file before MuJoCo reads it."""

import re

from mjsim.sentences import Sentence

MAX_CORNERS = 200_000
"""Maximum number of corners of a mesh; an STL has three per triangle."""
_VERTEX = re.compile(rb"^[ \t]*v[ \t]", re.MULTILINE)
_STL_HEAD, _STL_TRIANGLE = 84, 50
_MSH_HEAD = 16


def check_mesh(path: str, data: bytes) -> None:
    """Check that a file can be a mesh of acceptable size.

    Args:
        path: File name; the suffix determines the format.
        data: An OBJ, a binary STL, or MuJoCo's own MSH.

    Raises:
        ValueError: It is not a mesh, or has too many corners; the message names the file.
    """
    count = {"obj": _obj_corners, "stl": _stl_corners, "msh": _msh_corners}[path.rpartition(".")[2].lower()](data)
    if count is None:
        raise ValueError(Sentence("'{path}' cannot be read as a mesh; export it again as OBJ or binary STL", path))
    if count <= 3:
        raise ValueError(
            Sentence("'{path}' cannot be read as a mesh: it has {count} corners; export it again", path, count)
        )
    if count > MAX_CORNERS:
        raise ValueError(
            Sentence(
                "'{path}' has {count} corners; a mesh has 4 to {max_corners}, simplify it", path, count, MAX_CORNERS
            )
        )


def _obj_corners(data: bytes) -> int:
    return sum(1 for _ in _VERTEX.finditer(data))


def _stl_corners(data: bytes) -> int | None:
    triangles = int.from_bytes(data[80:_STL_HEAD], "little")
    return 3 * triangles if len(data) == _STL_HEAD + triangles * _STL_TRIANGLE else None


def _msh_corners(data: bytes) -> int | None:
    corners = int.from_bytes(data[:4], "little")
    return corners if len(data) >= _MSH_HEAD + 12 * corners else None
