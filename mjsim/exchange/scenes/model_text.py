"""Writes solids as an MJCF model with OBJ meshes beside it."""

from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from mjsim.exchange.drawings import Indices
from mjsim.exchange.scenes.scene_solids import SceneSolid
from mjsim.geometry import Array
from mjsim.models import pose_keys

MAX_TRIANGLES = 20_000
"""A mesh with more becomes its convex hull."""
USUAL = "#8a6f4d"


def model_files(solids: Sequence[SceneSolid], *, moves: bool) -> tuple[str, dict[str, bytes]]:
    """Return the text of an MJCF model, and its meshes by file name.

    Args:
        solids: In the frame of the model.
        moves: Whether the model can be pushed: then it is one body with a mass.
    """
    root = Element("mujoco")
    SubElement(root, "compiler", angle="radian")
    asset = Element("asset")
    body = SubElement(SubElement(root, "worldbody"), "body")
    files: dict[str, bytes] = {}
    for number, solid in enumerate(solids):
        geom = SubElement(body, "geom", {key: _text(values) for key, values in pose_keys(solid.pose).items()})
        geom.set("rgba", _text([*(int((solid.color or USUAL)[k : k + 2], 16) / 255 for k in (1, 3, 5)), 1.0]))
        if solid.kind == "mesh":
            name = f"part{number}"
            files[f"{name}.obj"] = _obj(*_bounded(solid.vertices, solid.faces))
            mesh = SubElement(asset, "mesh", name=name, file=f"{name}.obj")
            if not moves:
                mesh.set("inertia", "shell")
            geom.set("type", "mesh")
            geom.set("mesh", name)
        else:
            geom.set("type", solid.kind)
            geom.set("size", _text(solid.half[[0, 2]] if solid.kind == "cylinder" else solid.half))
    if len(asset):
        root.insert(1, asset)
    indent(root)
    return tostring(root, encoding="unicode") + "\n", files


def _bounded(vertices: Array, faces: Indices) -> tuple[Array, Indices]:
    """Return a mesh, or its convex hull if it has many triangles."""
    from scipy.spatial import ConvexHull

    if len(faces) <= MAX_TRIANGLES:
        return vertices, faces
    hull = ConvexHull(vertices)
    kept = {corner: place for place, corner in enumerate(hull.vertices.tolist())}
    corners = vertices[hull.vertices]
    turned = np.array([[kept[corner] for corner in face] for face in hull.simplices.tolist()])
    a, b, c = (corners[turned[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - corners.mean(axis=0)) < 0.0
    turned[inward] = turned[inward][:, ::-1]
    return corners, turned


def _obj(vertices: Array, faces: Indices) -> bytes:
    """Return a mesh as Wavefront OBJ."""
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return ("\n".join(lines) + "\n").encode()


def _text(numbers: Sequence[float] | Array) -> str:
    return " ".join(f"{round(float(number), 6) + 0.0:g}" for number in numbers)
