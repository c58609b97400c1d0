"""Small files of robots and meshes for tests."""

import struct
from xml.etree import ElementTree as ET

import numpy as np

SHAPE = '<collision><geometry><box size="1 1 1"/></geometry></collision>'
GOOD = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


def binary(triangles: np.ndarray) -> bytes:
    records = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")])
    records["c"] = triangles
    return bytes(80) + struct.pack("<I", len(triangles)) + records.tobytes()


def urdf(links: str, joints: str = "") -> ET.Element:
    return ET.fromstring(f'<robot name="r">{links}{joints}</robot>')


def link(name: str, mass: str | None = None, inertia: str = "", more: str = "") -> str:
    inertial = "" if mass is None else f'<inertial><mass value="{mass}"/>{inertia}</inertial>'
    return f'<link name="{name}">{inertial}{more}</link>'
