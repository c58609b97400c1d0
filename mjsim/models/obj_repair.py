"""Repair of OBJ files that MuJoCo rejects: flat ones, and those with normals at only some faces."""

import re
from collections.abc import Sequence
from itertools import islice

import numpy as np

from mjsim.models.mesh_files import FLAT, SPECK_FACES, speck_tips

SAMPLE = 1000
"""Number of corners that are examined first."""
_CORNER = re.compile(rb"^[ \t]*v[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\S+)", re.MULTILINE)
_PICTURED = re.compile(rb"^[ \t]*vt[ \t]", re.MULTILINE)
_FACE = re.compile(rb"^[ \t]*f[ \t].*", re.MULTILINE)
_BARE_FACE = re.compile(rb"^[ \t]*f(?:[ \t]+-?\d+(?:/-?\d*)?)+[ \t\r]*$", re.MULTILINE)
_NORMALS = re.compile(rb"^[ \t]*vn[ \t].*", re.MULTILINE)
_NORMAL = re.compile(rb"(\d)(?:(/-?\d+)/|//)-?\d+(?!\S)")
"""A corner of a face with a normal: the last digit of its index, its texture coordinates, and the normal."""


def mended_obj(data: bytes) -> bytes:
    """Return an OBJ with a speck if it is flat, and without normals if some faces have none."""
    data = _with_volume(data)
    if b"vn" not in data or not _BARE_FACE.search(data):
        return data
    return _NORMALS.sub(b"", _FACE.sub(lambda face: _NORMAL.sub(rb"\1\2", face[0]), data))


def _with_volume(data: bytes) -> bytes:
    """Return an OBJ, with a speck in its middle if all its corners lie in a plane: MuJoCo requires a volume."""
    sample = [corner.groups() for corner in islice(_CORNER.finditer(data), SAMPLE)]
    try:
        # For most meshes, the first corners show that they are not flat.
        if not (_is_flat(sample) and _is_flat(found := _CORNER.findall(data))):
            return data
    except ValueError:
        return data  # Faults are reported when it is checked.
    lines = ["", *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in speck_tips(np.array(found, dtype=float)))]
    place = "/1" if _PICTURED.search(data) else ""
    lines += ["f " + " ".join(f"{len(found) + 1 + tip}{place}" for tip in face) for face in SPECK_FACES]
    return data + "\n".join(lines).encode() + b"\n"


def _is_flat(words: Sequence[tuple[bytes, ...]]) -> bool:
    """Return whether corners lie in a plane; raises ValueError for anything that is not a number."""
    corners = np.array(words, dtype=float)
    if len(corners) < 3 or not np.isfinite(corners).all():
        return False
    extents = np.linalg.svd(corners - corners.mean(axis=0), compute_uv=False)
    return bool(extents[2] <= FLAT * extents[0])
