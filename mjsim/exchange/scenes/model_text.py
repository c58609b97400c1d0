"""Writes solids as an MJCF model with OBJ meshes beside it."""

import re
from collections import Counter
from collections.abc import Sequence
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from mjsim.exchange.drawings import Indices
from mjsim.exchange.scenes.scene_solids import MAX_MASS, ScenePart, SceneSkin, SceneSolid, SceneThing
from mjsim.geometry import Array
from mjsim.models import pose_keys

MAX_TRIANGLES = 20_000
"""A mesh with more becomes its convex hull."""
USUAL = "#8a6f4d"
MIN_PART_MASS = 0.05
"""Minimum mass that a joint moves [kg]."""


class _Model:
    """An MJCF model being written."""

    def __init__(self) -> None:
        self.root, self.asset = Element("mujoco"), Element("asset")
        SubElement(self.root, "compiler", angle="radian")
        self.files: dict[str, bytes] = {}
        self._names: Counter[str] = Counter()
        self._count = 0

    def name(self, text: str) -> str:
        """Return a name that is unique in the model."""
        plain = re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_")[:48] or "part"
        self._names[plain] += 1
        return plain if self._names[plain] == 1 else f"{plain}_{self._names[plain]}"

    def add_geoms(
        self,
        body: Element,
        solids: Sequence[SceneSolid],
        skins: Sequence[SceneSkin],
        *,
        shell: bool,
        mass: float | None,
    ) -> None:
        """Add solids to a body.

        Args:
            body: The body.
            solids: Solids in the frame of the model.
            skins: Visible meshes instead of them, in the same frame.
            shell: Whether meshes may enclose no volume.
            mass: Mass of all together [kg]; None for that of their volumes.
        """
        hidden = {"group": "3"} if skins else {}
        for skin in skins:
            self._add_skin(body, skin)
        for solid in solids:
            geom = SubElement(
                body, "geom", hidden | {key: _text(values) for key, values in pose_keys(solid.pose).items()}
            )
            geom.set("rgba", _text([*(int((solid.color or USUAL)[k : k + 2], 16) / 255 for k in (1, 3, 5)), 1.0]))
            if mass is not None:
                geom.set("mass", f"{mass / len(solids):.6g}")
            if solid.kind == "mesh":
                name = f"part{self._count}"
                self.files[f"{name}.obj"] = _obj(*_bounded(solid.vertices, solid.faces))
                mesh = SubElement(self.asset, "mesh", name=name, file=f"{name}.obj")
                if shell:
                    mesh.set("inertia", "shell")
                geom.set("type", "mesh")
                geom.set("mesh", name)
            else:
                geom.set("type", solid.kind)
                geom.set("size", _text(solid.half[[0, 2]] if solid.kind == "cylinder" else solid.half))
            self._count += 1

    def _add_skin(self, body: Element, skin: SceneSkin) -> None:
        """Add a mesh that is seen, with its texture."""
        name = f"look{self._count}"
        self._count += 1
        self.files[f"{name}{skin.look.ending}"] = skin.look.data
        keys = {"name": name, "file": f"{name}{skin.look.ending}", "scale": _text(skin.scale), "inertia": "shell"}
        SubElement(self.asset, "mesh", keys)
        pose = {key: _text(values) for key, values in pose_keys(skin.pose).items()}
        touched = {"contype": "0", "conaffinity": "0", "mass": "0"}
        geom = SubElement(body, "geom", {"type": "mesh", "mesh": name, **touched, **pose})
        rgba = skin.look.rgba or (0.7, 0.7, 0.7, 1.0)
        if skin.look.texture is None:
            geom.set("rgba", _text(rgba))
            return
        self.files[f"{name}.png"] = skin.look.texture
        SubElement(self.asset, "texture", {"name": name, "type": "2d", "file": f"{name}.png"})
        SubElement(self.asset, "material", {"name": name, "texture": name, "rgba": _text(rgba)})
        geom.set("material", name)

    def add_part(self, outer: Element, part: ScenePart) -> None:
        """Add a part that joints move as a body with the frame of the model."""
        body = SubElement(outer, "body", name=self.name(part.name))
        for joint in part.joints:
            made = SubElement(body, "joint", name=self.name(f"{part.name}_joint"), type=joint.kind)
            made.set("pos", _text(joint.anchor))
            made.set("axis", _text(joint.axis))
            if joint.range is not None:
                made.set("limited", "true")
                made.set("range", _text(joint.range))
            for key, value in (("damping", joint.damping), ("frictionloss", joint.friction)):
                made.set(key, _text([value]))
            if joint.stiffness:
                made.set("stiffness", _text([joint.stiffness]))
                made.set("springref", _text([joint.rest]))
        mass = min(max(part.mass, MIN_PART_MASS), MAX_MASS)
        if not part.solids:
            place = _text(part.joints[0].anchor)
            SubElement(body, "inertial", pos=place, mass=_text([mass]), diaginertia=_text([MIN_PART_MASS * 0.1] * 3))
        self.add_geoms(body, part.solids, part.skins, shell=True, mass=mass)
        for inner in part.parts:
            self.add_part(body, inner)


def model_files(thing: SceneThing, *, moves: bool) -> tuple[str, dict[str, bytes]]:
    """Return the text of an MJCF model, and its meshes and pictures by file name.

    Args:
        thing: Thing in the frame of the model.
        moves: Whether the model can be pushed: then its solids are one body with a mass.
    """
    model = _Model()
    body = SubElement(SubElement(model.root, "worldbody"), "body")
    mass = thing.mass if thing.parts else None
    model.add_geoms(body, thing.solids, thing.skins, shell=not moves, mass=mass)
    for part in thing.parts:
        model.add_part(body, part)
    if len(model.asset):
        model.root.insert(1, model.asset)
    indent(model.root)
    return tostring(model.root, encoding="unicode") + "\n", model.files


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
