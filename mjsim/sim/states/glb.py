"""Exports the visible scene of a compiled world as one binary glTF 2.0 file (.glb)."""

import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import mujoco
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.light import BakedLight
from mjsim.models import quaternion_of
from mjsim.output import require_free, write_file
from mjsim.sentences import Sentence
from mjsim.sim.rendering import (
    SEEN_FROM_OUTSIDE,
    LightWeights,
    LitCorners,
    Material,
    MergedSurface,
    SolidBody,
    solid_bodies,
    used_textures,
)
from mjsim.sim.states.static_scene import StillScene
from mjsim.world import World

MAX_TRIANGLES = 4_000_000
"""Largest number of triangles of an exported scene."""
JPEG_QUALITY = 90
"""Quality of pictures that are smaller as JPEG than as PNG."""
UPRIGHT = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
"""Rotation from z up to y up, as in glTF: quaternion x, y, z, w."""
UNLIT = "KHR_materials_unlit"
"""Extension of glTF for surfaces whose colours include the light."""
_FLOAT, _SHORT, _WHOLE = 5126, 5123, 5125
_POINTS, _CORNERS = 34962, 34963


def write_glb(world: World, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write the scene of a world at the start, including robots, and return the path of the file.

    Args:
        world: The world.
        path: File name that ends in .glb.
        overwrite: Whether to replace an existing file.

    Raises:
        UsageError: The suffix is another one, the scene is too large, or the file exists or cannot be written.
    """
    path = Path(path)
    if path.suffix != ".glb":
        raise UsageError(Sentence("'{path}' ends in '{suffix}'; a binary file of glTF ends in .glb", path, path.suffix))
    require_free(path, overwrite=overwrite)
    scene = StillScene(world)
    scene.show(scene.model.qpos0)
    light = None if scene.light is None else scene.light()
    return write_file(path, glb_bytes(scene.model, scene.data, light=light), overwrite=overwrite)


def glb_bytes(
    model: mujoco.MjModel, data: mujoco.MjData, *, sparing: bool = False, light: BakedLight | None = None
) -> bytes:
    """Return the visible geoms of a model as a .glb file.

    Below a node that rotates z up to y up are a node for all static geoms and one for each moving body, under the
    names of the bodies; cameras are children of their carriers. `extras.things` of a primitive holds the names of the
    geoms that were merged into it, each with its number of triangles.

    glTF has no light maps: with baked light, static surfaces are of material KHR_materials_unlit, and divided so finely
    that the colours of their corners hold the light. Moving parts are lit by the viewer.

    Args:
        model: The model.
        data: Its state, with the poses of geoms and bodies computed.
        sparing: Whether to use fewer triangles for many people, for a view that is drawn often.
        light: The baked light of the world; None for plain light.

    Raises:
        UsageError: It has more than `MAX_TRIANGLES`.
    """
    lit = None if light is None else LitCorners(light, LightWeights(model, light).of(data))
    bodies = solid_bodies(model, data, groups=SEEN_FROM_OUTSIDE, sparing=sparing, light=lit)
    count = sum(len(surface.triangles.corners) for body in bodies for surface in body.surfaces)
    if count > MAX_TRIANGLES:
        raise UsageError(
            Sentence(
                "the scene has {count} triangles; a .glb file may have at most {max_triangles}", count, MAX_TRIANGLES
            )
        )
    return _Writer(model, data, bodies).file()


class _Writer:
    """Assembles the parts of a file."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, bodies: Sequence[SolidBody]) -> None:
        self._model, self._data, self._bodies = model, data, bodies
        self._binary = bytearray()
        self._views: list[dict[str, int]] = []
        self._accessors: list[dict[str, Any]] = []
        self._materials: dict[Material, int] = {}
        self._textures = used_textures(bodies)

    def file(self) -> bytes:
        """Return the complete file."""
        text = json.dumps(self._document(), separators=(",", ":"), allow_nan=False).encode()
        text += b" " * (-len(text) % 4)
        self._binary += bytes(-len(self._binary) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self._binary:
            chunks += struct.pack("<I4s", len(self._binary), b"BIN\0") + self._binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def _document(self) -> Mapping[str, Any]:
        """Return the JSON part of the file; glTF forbids empty lists."""
        meshes = [self._mesh(body) for body in self._bodies if body.surfaces]
        images = [self._image(texture) for texture in self._textures]
        listed = {
            "meshes": meshes,
            "materials": [self._material(*key) for key in self._materials],
            "images": images,
            "textures": [{"source": place, "sampler": 0} for place in range(len(images))],
            "samplers": [{}] if images else [],
            "cameras": [self._camera(camera) for camera in range(self._model.ncam)],
            "accessors": self._accessors,
            "bufferViews": self._views,
            "extensionsUsed": [UNLIT] if any(lit for *_, lit in self._materials) else [],
            "buffers": [{"byteLength": len(self._binary) + -len(self._binary) % 4}] if self._binary else [],
        }
        return {
            "asset": {"version": "2.0", "generator": "mjsim"},
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": self._nodes(),
            **{name: items for name, items in listed.items() if items},
        }

    def _nodes(self) -> list[dict[str, Any]]:
        """Return the rotated root, the bodies, then the cameras."""
        model, data = self._model, self._data
        carriers = {body.body: 1 + place for place, body in enumerate(self._bodies)}
        root = {"name": "scene", "rotation": UPRIGHT, "children": list(carriers.values())}
        meshes = iter(range(len(self._bodies)))
        bodies: list[dict[str, Any]] = [
            {
                "name": str(model.body(body.body).name),
                "translation": data.xpos[body.body].tolist(),
                "rotation": _xyzw(data.xquat[body.body]),
                **({"mesh": next(meshes)} if body.surfaces else {}),
            }
            for body in self._bodies
        ]
        cameras = []
        for camera in range(model.ncam):
            body = _carrier(model, int(model.cam_bodyid[camera]), carriers)
            bodies[carriers[body] - 1].setdefault("children", []).append(1 + len(bodies) + camera)
            cameras.append(self._camera_node(camera, body))
        return [root, *bodies, *cameras]

    def _camera_node(self, camera: int, body: int) -> dict[str, Any]:
        """Return the node of a camera in the frame of a body; its axes in glTF are those of MuJoCo."""
        model, data = self._model, self._data
        world_from_body = data.xmat[body].reshape(3, 3)
        quat = quaternion_of(world_from_body.T @ data.cam_xmat[camera].reshape(3, 3))
        place = world_from_body.T @ (data.cam_xpos[camera] - data.xpos[body])
        name = str(model.camera(camera).name)
        return {"name": name, "camera": camera, "translation": place.tolist(), "rotation": _xyzw(quat)}

    def _camera(self, camera: int) -> dict[str, Any]:
        model = self._model
        znear = float(model.vis.map.znear * model.stat.extent)
        fov = float(np.radians(model.cam_fovy[camera]))
        width, height = model.cam_resolution[camera].tolist()
        return {"type": "perspective", "perspective": {"yfov": fov, "aspectRatio": width / height, "znear": znear}}

    def _mesh(self, body: SolidBody) -> dict[str, Any]:
        return {"primitives": [self._primitive(surface) for surface in body.surfaces]}

    def _primitive(self, surface: MergedSurface) -> dict[str, Any]:
        shape = surface.triangles
        key = surface.texture, surface.clear, surface.lit
        attributes = {
            "POSITION": self._add(shape.points.astype(np.float32), _FLOAT, "VEC3", bounds=True),
            "NORMAL": self._add(shape.normals.astype(np.float32), _FLOAT, "VEC3"),
            "COLOR_0": self._add(_linear(surface.colors), _SHORT, "VEC4", normalized=True),
        }
        if surface.texture is not None:
            attributes["TEXCOORD_0"] = self._add(shape.places.astype(np.float32), _FLOAT, "VEC2")
        return {
            "attributes": attributes,
            "indices": self._add(shape.corners.ravel(), _WHOLE, "SCALAR", target=_CORNERS),
            "material": self._materials.setdefault(key, len(self._materials)),
            "extras": {"things": surface.things},
        }

    def _material(self, texture: int | None, clear: bool, lit: bool) -> dict[str, Any]:
        material: dict[str, Any] = {"metallicFactor": 0.0}
        if texture is not None:
            material["baseColorTexture"] = {"index": self._textures[texture]}
        clearness = {"alphaMode": "BLEND"} if clear else {}
        return {"pbrMetallicRoughness": material, **clearness, **({"extensions": {UNLIT: {}}} if lit else {})}

    def _add(
        self,
        values: NDArray[Any],
        kind: int,
        shape: str,
        *,
        target: int = _POINTS,
        bounds: bool = False,
        normalized: bool = False,
    ) -> int:
        """Add an array, and return the number of its accessor."""
        view = self._view(values.tobytes(), target=target)
        accessor = {"bufferView": view, "componentType": kind, "count": len(values), "type": shape}
        if bounds:
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        self._accessors.append(accessor | ({"normalized": True} if normalized else {}))
        return len(self._accessors) - 1

    def _view(self, data: bytes, **more: int) -> int:
        self._binary += bytes(-len(self._binary) % 4)
        self._views.append({"buffer": 0, "byteOffset": len(self._binary), "byteLength": len(data), **more})
        self._binary += data
        return len(self._views) - 1

    def _image(self, texture: int) -> dict[str, Any]:
        data, kind = _encoded(self._model, texture)
        return {"bufferView": self._view(data), "mimeType": kind}


def _encoded(model: mujoco.MjModel, texture: int) -> tuple[bytes, str]:
    """Return a picture of a model as a file, whichever is smaller, and its kind."""
    width, height, channels = (int(part[texture]) for part in (model.tex_width, model.tex_height, model.tex_nchannel))
    first = int(model.tex_adr[texture])
    picture = model.tex_data[first : first + width * height * channels].reshape(height, width, channels)
    if channels >= 3:
        picture = cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA if channels == 4 else cv2.COLOR_RGB2BGR)
    exact = cv2.imencode(".png", picture)[1].tobytes()
    if channels == 4:
        return exact, "image/png"
    short = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()
    return min((exact, "image/png"), (short, "image/jpeg"), key=lambda each: len(each[0]))


def _linear(displayed: Array) -> NDArray[np.uint16]:
    """Return colours in glTF's encoding: linear RGBA of 16 bits each (IEC 61966-2-1)."""
    rgb = displayed[:, :3]
    light = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.round(np.column_stack([light, displayed[:, 3]]).clip(0.0, 1.0) * 65535.0), dtype=np.uint16)


def _xyzw(wxyz: Array) -> list[float]:
    """Return a quaternion in the order of glTF, normalized to float precision."""
    unit = np.asarray(wxyz, dtype=float) / np.linalg.norm(wxyz)
    return [*unit[1:].tolist(), float(unit[0])]


def _carrier(model: mujoco.MjModel, body: int, carriers: Mapping[int, int]) -> int:
    """Return the nearest body at or above one that has a node of its own."""
    while body not in carriers:
        body = int(model.body_parentid[body])
    return body
