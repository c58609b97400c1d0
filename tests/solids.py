"""A file of glTF as tests look into it."""

import json
import struct


def document_of(data: bytes) -> dict:
    """Return the part of a .glb file that is JSON."""
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert (data[:4], kind) == (b"glTF", b"JSON")
    return json.loads(data[20 : 20 + size])


def names_of(data: bytes) -> list[str]:
    """Return the names of the bodies of a scene, in the order of their poses."""
    nodes = document_of(data)["nodes"]
    return [nodes[child]["name"] for child in nodes[0]["children"]]
