"""Objects in the binary form of MRPT, one value after the other.

An object is a byte with the length of its class's name and the highest bit set, the name, a byte with the version, its
fields in the order in which they are written (little-endian), and the byte 0x88. Fields may be objects.
"""

import struct
from dataclasses import dataclass

import numpy as np

from mjsim.geometry import Array
from mjsim.logs.files import MAX_NUMBER

MAX_LENGTH = 10_000
"""Maximum length of a text, and number of elements of a matrix."""


@dataclass(slots=True)
class MrptBytes:
    """Reads values in sequence."""

    data: bytes
    place: int = 0

    def take(self, form: str) -> tuple[float, ...]:
        """Return values of a form of `struct`.

        Raises:
            struct.error: The data end before.
        """
        values = struct.unpack_from(f"<{form}", self.data, self.place)
        self.place += struct.calcsize(f"<{form}")
        return values

    def array(self, kind: str, count: int) -> Array:
        """Return an array of numbers, shape (count,)."""
        size = np.dtype(kind).itemsize * count
        if self.place + size > len(self.data):
            raise struct.error("the array is truncated")
        found = np.frombuffer(self.data, dtype=kind, count=count, offset=self.place)
        self.place += size
        return found

    def text(self) -> str:
        """Return a text."""
        length = int(self.take("I")[0])
        if length > MAX_LENGTH:
            raise struct.error("the text is too long")
        return bytes(self.array("u1", length).astype(np.uint8)).decode(errors="replace")

    def head(self) -> tuple[str, int]:
        """Return class, without namespace, and version of an object."""
        length = int(self.take("B")[0]) & 0x7F
        name = bytes(self.array("u1", length).astype(np.uint8)).decode(errors="replace")
        return name.rpartition("::")[2], int(self.take("B")[0])

    def pose(self) -> Array:
        """Return a pose in 2-D or 3-D that is an object, shape (4, 4) [m]."""
        from scipy.spatial.transform import Rotation

        name, version = self.head()
        pose = np.eye(4)
        if name == "CPose2D":
            x, y, heading = self.take("3d" if version else "3f")
            pose[:2, 3] = x, y
            pose[:3, :3] = Rotation.from_euler("z", heading).as_matrix()
        elif name == "CPose3D" and version == 3:
            pose[:3, 3], turn = self.take("3d"), self.take("9d")
            pose[:3, :3] = np.reshape(turn, (3, 3))
        elif name == "CPose3D" and version == 2:
            pose[:3, 3], (w, x, y, z) = self.take("3d"), self.take("4d")
            pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
        elif name == "CPose3D" and version < 2:
            pose = self.matrix()
        else:
            raise struct.error("a pose of another class or version")
        self.take("B")
        if pose.shape != (4, 4) or not (np.abs(pose) <= MAX_NUMBER).all():
            raise struct.error("a pose is not finite")
        if not np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-3):
            raise struct.error("a pose is not a rotation")
        return pose

    def matrix(self) -> Array:
        """Return a matrix that is an object."""
        name, _ = self.head()
        rows, columns = (int(value) for value in self.take("2I"))
        if rows * columns > MAX_LENGTH:
            raise struct.error("a matrix is too large")
        kind = "<f8" if name == "CMatrixD" else "<f4"
        found = self.array(kind, rows * columns).astype(float).reshape(rows, columns)
        self.take("B")
        return found
