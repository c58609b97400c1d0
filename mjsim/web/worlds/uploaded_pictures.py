"""Uploaded pictures, validated by decoding and re-encoding them; and thumbnails."""

import re
import unicodedata
from collections.abc import Sequence
from pathlib import PurePosixPath

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.errors import printable
from mjsim.models import bounded, picture_size, upright
from mjsim.modules import judge_images
from mjsim.output import write_new
from mjsim.sentences import Sentence
from mjsim.web.server import RefusedError
from mjsim.web.worlds.folder import Folder
from mjsim.web.worlds.items import Json
from mjsim.web.worlds.world_files import free_name, source_of
from mjsim.world import World, read_asset

MAX_BYTES = 20_000_000
"""Maximum size of an uploaded picture [bytes]."""
MAX_SIDE = 2048
"""Maximum width or height that is kept [px]: no camera gets closer to a poster."""
JPEG_QUALITY = 92
"""JPEG quality, 0 to 100."""
MAX_SMALL = 1024
ROWS_AT_ONCE = 256
"""Rows of a picture that are converted at once."""
_ODD = re.compile(r"[^\w.-]+")

WIDTH = 0.6
"""Width of a beacon that is placed on the page [m]."""

Pixels = NDArray[np.uint8]


def bring_picture(folder: Folder, data: bytes, *, name: str, world: str | None) -> Json:
    """Write a picture beside a world, under an unused name.

    Args:
        folder: Folder of the studio.
        data: The uploaded picture.
        name: Its original name.
        world: World beside which to write it; by default in the folder of the studio.

    Returns:
        `path` relative to the world, and `file` relative to the folder of the studio.

    Raises:
        RefusedError: It is not a picture, or cannot be written.
    """
    name = unicodedata.normalize("NFC", PurePosixPath(name.replace("\\", "/")).name)
    pixels = bounded(decoded(data, name=f"'{printable(name)[:80]}'"), MAX_SIDE)
    kind = ".png" if data.startswith(b"\x89PNG") else ".jpg"
    place = source_of(folder, world or "").folder or folder.root
    stem = _ODD.sub("-", PurePosixPath(name).stem).strip("-.") or "picture"
    data = encoded(pixels, kind)
    try:
        with folder.writing:
            path = place / free_name(place, f"{stem[:60]}{kind}")
            write_new(path, data)
    except OSError as error:
        raise RefusedError(
            409, Sentence("'{stem}{kind}' cannot be written: {strerror}", stem[:60], kind, error.strerror)
        ) from None
    return {"path": path.name, "file": folder.name(path)}


def judged_pictures(world: World, images: Sequence[str]) -> Json:
    """Return how well pictures that may be added to a world are recognised, by path: `distance` [m] and `fault`."""
    faults = {image: fault for image in images if (fault := _unreadable(world, image)) is not None}
    found = judge_images(world, [image for image in images if image not in faults], width=WIDTH)
    judged = {image: {"distance": round(each.distance, 1), "fault": each.fault} for image, each in found.items()}
    return {**judged, **{image: {"distance": 0.0, "fault": fault} for image, fault in faults.items()}}


def _unreadable(world: World, image: str) -> str | None:
    """Return why a picture cannot be read, without reading all of it; None if it can."""
    try:
        picture_size(world.read_asset(image))
    except ValueError as error:
        return str(error)
    return None


def small_picture(folder: Folder, path: str, *, size: int, world: str | None) -> bytes:
    """Return a thumbnail, as JPEG, of a picture in the folder of a world, in the studio's, or shipped with mjsim.

    Args:
        folder: Folder of the studio.
        path: Path as named by a world.
        size: Maximum length of its longer side [px].
        world: The world that names it.

    Raises:
        RefusedError: The picture does not exist.
    """
    try:
        data = read_asset(path, source_of(folder, world or ""))
    except ValueError as error:
        raise RefusedError(404, str(error)) from None
    return encoded(bounded(decoded(data), max(16, min(size, MAX_SMALL))), ".jpg")


def decoded(data: bytes, *, name: str = "this") -> Pixels:
    """Return the pixels of a PNG or JPEG, in BGR order, with transparent pixels white; `name` is for messages.

    Raises:
        RefusedError: It is neither, is damaged, or would be too large.
    """
    try:
        # The size is read from the header, before anything is decompressed.
        picture_size(data)
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED | cv2.IMREAD_ANYCOLOR)
    except ValueError as error:
        raise RefusedError(415, Sentence("{name} {error}", name, error)) from None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise RefusedError(415, Sentence("{name} is a damaged picture; save it again", name))
    return upright(_plain(np.asarray(pixels)), data)


def encoded(pixels: Pixels, kind: str) -> bytes:
    """Return pixels encoded as '.png' or '.jpg'."""
    done, data = cv2.imencode(kind, pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY] if kind == ".jpg" else [])
    assert done, "eight bits and three colours can always be written"
    return data.tobytes()


def _plain(pixels: NDArray[np.generic]) -> Pixels:
    """Return a picture with 8 bits and three channels."""
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)  # type: ignore[operator]
    plain = np.asarray(pixels, dtype=np.uint8)
    if plain.ndim == 2:
        return np.asarray(cv2.cvtColor(plain, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    if plain.shape[2] == 4:
        blended: Pixels = np.empty((*plain.shape[:2], 3), dtype=np.uint8)
        # In parts: as floating-point numbers all of it would take a dozen times the memory.
        for first in range(0, len(plain), ROWS_AT_ONCE):
            part = plain[first : first + ROWS_AT_ONCE]
            alpha = part[..., 3:].astype(np.float32) / 255.0
            blended[first : first + ROWS_AT_ONCE] = part[..., :3] * alpha + 255.0 * (1.0 - alpha)
        return blended
    return plain
