"""Converts items shown by modules to Foxglove's scene entities, with the exact values, and back."""

import base64
import json
import struct
from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Shown, ShownGrid, ShownLines, ShownPoints, ShownText, require_bounds
from mjsim.models import picture_size
from mjsim.record.json_schema import STAMP, boolean, integer, keyed, listed, number, one_of, packed, text, topic, xyz
from mjsim.record.numbers import Message, stamp_json, unpacked
from mjsim.record.numbers import packed as packed_numbers

OCCUPANCY_LEVELS = 254
"""Number of levels of a cell from free to occupied; one more value means unknown."""
TEXT_HEIGHT = 12.0
"""On the screen [px]."""
GLTF = "model/gltf-binary"
_POSE = keyed({"position": xyz("[m]"), "orientation": keyed({axis: {"type": "number"} for axis in "xyzw"})})
_COLOR = keyed({part: {"type": "number"} for part in "rgba"}, "From 0 to 1")
_NOTHING = listed(keyed({}), "None of these")
_LINES = keyed(
    {
        "type": integer("0 a line through all points, 2 every two are a line"),
        "pose": _POSE,
        "thickness": number("[m]"),
        "scale_invariant": boolean("Whether the thickness is in pixels"),
        "points": listed(xyz("[m]"), "In the frame; of points, both ends of a line as long as it is thick"),
        "color": _COLOR,
        "colors": _NOTHING,
        "indices": listed({"type": "integer"}, "None: in their order"),
    }
)
_TEXTURED = {
    "asset": {"version": "2.0"},
    "extensionsUsed": ["KHR_materials_unlit"],
    "scene": 0,
    "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
    "materials": [
        {
            "pbrMetallicRoughness": {
                "baseColorTexture": {"index": 0},
                "metallicFactor": 0.0,
                "roughnessFactor": 1.0,
            },
            "alphaMode": "BLEND",
            "doubleSided": True,
            "extensions": {"KHR_materials_unlit": {}},
        }
    ],
    "textures": [{"source": 0, "sampler": 0}],
    "samplers": [{"magFilter": 9728, "minFilter": 9728, "wrapS": 33071, "wrapT": 33071}],
    "images": [{"bufferView": 3, "mimeType": "image/png"}],
}
"""A glTF tree of one mesh with a texture, unlit, not repeated and with sharp cells, without its numbers."""
_TEXT = keyed(
    {
        "pose": _POSE,
        "billboard": boolean("Whether it always faces the viewer"),
        "font_size": number("[px]"),
        "scale_invariant": boolean("Whether the size is in pixels"),
        "color": _COLOR,
        "text": text("As it is shown"),
    }
)
_MODEL = keyed(
    {
        "pose": _POSE,
        "scale": xyz("1"),
        "color": _COLOR,
        "override_color": boolean("Whether the model's own colours are left out"),
        "url": text("Empty"),
        "media_type": text(GLTF),
        "data": packed("a rectangle with a picture of the cells", "glTF"),
    }
)
_ENTITY = keyed(
    {
        "timestamp": STAMP,
        "frame_id": text("world, R/estimate or R/base"),
        "id": text("Place in the list, and name"),
        "lifetime": keyed({"sec": {"type": "integer"}, "nsec": {"type": "integer"}}, "0: until the next message"),
        "frame_locked": boolean("Whether it moves with its frame"),
        "metadata": _NOTHING,
        **{kind: _NOTHING for kind in ("arrows", "cubes", "spheres", "cylinders", "triangles")},
        "lines": listed(_LINES, "Lines, and points as short lines"),
        "texts": listed(_TEXT, "Texts"),
        "models": listed(_MODEL, "Grids"),
    }
)
_VALUE = keyed(
    {
        "kind": one_of(("points", "lines", "grid", "text"), "Determines which other keys are present"),
        "name": text("As the module calls it"),
        "frame": one_of(("world", "estimate", "base"), "Of the numbers"),
        "color": text("#rrggbb"),
        "points": packed("x, y, z of each point [m]"),
        "size": number("Diameter of a point [m]"),
        "joined": boolean("Whether each point is joined to the next"),
        "width": number("Of a line [m]"),
        "cells": packed("PNG, first row at the top; 0 occupied to 254 free, 255 unknown", "bytes"),
        "resolution": number("Side of a cell [m]"),
        "origin": packed("x, y [m] and heading [rad] of the lower left corner"),
        "text": text("As it is shown"),
        "at": packed("x, y, z of a text [m]"),
    },
    optional=("points", "size", "joined", "width", "cells", "resolution", "origin", "text", "at"),
)
SHOW = topic(
    "foxglove.SceneUpdate",
    "Everything that the estimator shows, whenever it has changed.",
    {
        "deletions": listed(
            keyed({"timestamp": STAMP, "type": integer("1, all"), "id": text("Empty")}), "What was shown before"
        ),
        "entities": listed(_ENTITY, "One per item"),
        "shown": listed(_VALUE, "The same, exactly; cells are rounded to 1/254"),
    },
)
_UPRIGHT = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
_IDENTITY: Message = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": _UPRIGHT}


def show_message(time: float, robot: str, items: Sequence[Shown]) -> Message:
    """Return the message of the items that a module shows.

    Args:
        time: Simulated [s].
        robot: Robot whose frames the items refer to.
        items: Items in drawing order.
    """
    stamp = stamp_json(time)
    entities = []
    for k, item in enumerate(items):
        frame = "world" if item.frame == "world" else f"{robot}/{item.frame}"
        head = {"timestamp": stamp, "frame_id": frame, "id": f"{k} {item.name}", "lifetime": {"sec": 0, "nsec": 0}}
        empty: Message = {kind: [] for kind in ("metadata", "arrows", "cubes", "spheres", "cylinders", "triangles")}
        lists: Message = {"lines": [], "texts": [], "models": []}
        entities.append(head | {"frame_locked": True} | empty | lists | _primitive(item))
    return {
        "time": time,
        "deletions": [{"timestamp": stamp, "type": 1, "id": ""}],
        "entities": entities,
        "shown": [_value(item) for item in items],
    }


def shown_of(message: Message) -> tuple[Shown, ...]:
    """Return the items in a message; raises ValueError if it was not made by `show_message`."""
    items = tuple(_item(value) for value in message["shown"])
    require_bounds(items)
    return items


def grid_png(grid: ShownGrid) -> bytes:
    """Return the cells of a grid as a grey PNG: the first row has the largest y, unknown cells are 255."""
    levels = np.where(np.isnan(grid.cells), OCCUPANCY_LEVELS + 1, np.rint(OCCUPANCY_LEVELS * (1.0 - grid.cells)))
    return _png(levels.astype(np.uint8)[::-1])


def _primitive(item: Shown) -> Message:
    """Return the list of Foxglove's primitives for an item, under its key."""
    color = _color(item.color)
    if isinstance(item, ShownText):
        pose = {"position": _point(item.at.tolist()), "orientation": _UPRIGHT}
        size = {"billboard": True, "font_size": TEXT_HEIGHT, "scale_invariant": True}
        return {"texts": [{"pose": pose, **size, "color": color, "text": item.text}]}
    if isinstance(item, ShownGrid):
        pose = {"position": _point([item.origin.x, item.origin.y, 0.0]), "orientation": _turned(item.origin.heading)}
        data = base64.b64encode(_model(item)).decode()
        model = {"scale": {"x": 1.0, "y": 1.0, "z": 1.0}, "color": color, "override_color": False, "url": ""}
        return {"models": [{"pose": pose, **model, "media_type": GLTF, "data": data}]}
    assert isinstance(item, ShownPoints | ShownLines)
    if isinstance(item, ShownLines):
        points, thickness, kind = item.points, item.width, 0 if item.joined else 2
    else:
        # Foxglove has no point primitive: lines as long as thick replace its squares.
        half = np.array([0.5 * item.size, 0.0, 0.0])
        points, thickness, kind = np.hstack([item.points - half, item.points + half]).reshape(-1, 3), item.size, 2
    line = {"type": kind, "pose": _IDENTITY, "thickness": thickness, "scale_invariant": False}
    return {
        "lines": [{**line, "points": list(map(_point, points.tolist())), "color": color, "colors": [], "indices": []}]
    }


def _value(item: Shown) -> Message:
    head = {"name": item.name, "frame": item.frame, "color": item.color}
    if isinstance(item, ShownPoints):
        return {"kind": "points", **head, "points": packed_numbers(item.points), "size": item.size}
    if isinstance(item, ShownLines):
        points = packed_numbers(item.points)
        return {"kind": "lines", **head, "points": points, "joined": item.joined, "width": item.width}
    if isinstance(item, ShownText):
        return {"kind": "text", **head, "text": item.text, "at": packed_numbers(item.at)}
    assert isinstance(item, ShownGrid)
    cells, origin = base64.b64encode(grid_png(item)).decode(), packed_numbers(item.origin.as_array())
    return {"kind": "grid", **head, "cells": cells, "resolution": item.resolution, "origin": origin}


def _item(value: Message) -> Shown:
    head = {key: value[key] for key in ("name", "frame", "color")}
    if value["kind"] == "points":
        return ShownPoints(**head, points=unpacked(value["points"]).reshape(-1, 3), size=value["size"])
    if value["kind"] == "lines":
        points = unpacked(value["points"]).reshape(-1, 3)
        return ShownLines(**head, points=points, joined=value["joined"], width=value["width"])
    if value["kind"] == "text":
        return ShownText(**head, text=value["text"], at=unpacked(value["at"]))
    origin = Pose(*unpacked(value["origin"], 3).tolist())
    return ShownGrid(
        **head, cells=_cells(base64.b64decode(value["cells"])), resolution=value["resolution"], origin=origin
    )


def _cells(png: bytes) -> Array:
    picture_size(png)  # A small file may claim gigabytes: it is not decoded.
    levels = cv2.imdecode(np.frombuffer(png, dtype=np.uint8), cv2.IMREAD_GRAYSCALE)
    if levels is None:
        raise ValueError("a grid whose picture is broken")
    flipped = levels[::-1].astype(float)
    return np.where(flipped > OCCUPANCY_LEVELS, np.nan, 1.0 - np.minimum(flipped, OCCUPANCY_LEVELS) / OCCUPANCY_LEVELS)


def _model(grid: ShownGrid) -> bytes:
    """Return a rectangle textured with the cells, occupied ones in the grid's colour, as binary glTF.

    References:
        glTF 2.0, sections 3.6, 3.8 and 4.4: y is up, and images have their origin at the top left.
    """
    rows, columns = grid.cells.shape
    x, y = columns * grid.resolution, rows * grid.resolution
    corners = np.array([[0, 0, 0], [x, 0, 0], [x, 0, -y], [0, 0, -y]], dtype="<f4")
    places = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], dtype="<f4")
    order = np.array([0, 1, 2, 0, 2, 3], dtype="<u2")
    parts = [part.tobytes() for part in (corners, places, order)] + [_colored_png(grid)]
    bounds = {"min": corners.min(axis=0).tolist(), "max": corners.max(axis=0).tolist()}
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", **bounds},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
    ]
    return _binary_gltf({**_TEXTURED, "accessors": accessors}, parts)


def _binary_gltf(tree: Mapping[str, Any], parts: Sequence[bytes]) -> bytes:
    """Return a glTF tree with its buffer, of which each part is a view."""
    starts = np.cumsum([0, *(-(-len(part) // 4) * 4 for part in parts)]).tolist()
    views = [{"buffer": 0, "byteOffset": at, "byteLength": len(part)} for at, part in zip(starts, parts, strict=False)]
    tree = {**tree, "bufferViews": views, "buffers": [{"byteLength": starts[-1]}]}
    text_chunk = _aligned(json.dumps(tree, separators=(",", ":")).encode(), b" ")
    bytes_chunk = b"".join(_aligned(part, b"\0") for part in parts)
    chunks = [(b"JSON", text_chunk), (b"BIN\0", bytes_chunk)]
    body = b"".join(struct.pack("<I", len(data)) + kind + data for kind, data in chunks)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def _colored_png(grid: ShownGrid) -> bytes:
    """Return the cells as a PNG in the grid's colour, with opacity by occupancy."""
    known = ~np.isnan(grid.cells)
    share = np.where(known, grid.cells, 0.0)[::-1, :, None]
    b, g, r = (int(grid.color[k : k + 2], 16) for k in (5, 3, 1))
    solid = 255.0 + share * (np.array([b, g, r]) - 255.0)
    opacity = np.where(known, 210.0, 0.0)[::-1, :, None]
    return _png(np.rint(np.concatenate([solid, opacity], axis=2)).astype(np.uint8))


def _png(pixels: Any) -> bytes:
    _, data = cv2.imencode(".png", np.ascontiguousarray(pixels), [cv2.IMWRITE_PNG_COMPRESSION, 1])
    return data.tobytes()


def _aligned(data: bytes, filler: bytes) -> bytes:
    return data + filler * (-len(data) % 4)


def _point(place: Sequence[float]) -> Message:
    x, y, z = place
    return {"x": x, "y": y, "z": z}


def _turned(heading: float) -> Message:
    return {"x": 0.0, "y": 0.0, "z": float(np.sin(heading / 2)), "w": float(np.cos(heading / 2))}


def _color(text: str) -> Message:
    r, g, b = (int(text[k : k + 2], 16) / 255 for k in (1, 3, 5))
    return {"r": r, "g": g, "b": b, "a": 1.0}
