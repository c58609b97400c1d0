"""Uploaded pictures, checked by decoding and encoded again; and thumbnails to choose from."""

import re
from pathlib import PurePosixPath

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.models import picture_size
from mjsim.web.answers import RefusedError
from mjsim.web.files import free_name, source_of
from mjsim.web.folder import Folder
from mjsim.web.items import Json
from mjsim.world import read_asset, write_new

MOST_BYTES = 20_000_000
"""Of a picture that is brought."""
LARGEST = 2048
"""Width or height that is kept [px]: no camera comes nearer to a poster."""
QUALITY = 92
"""Of JPEG, of 100."""
LARGEST_SMALL = 1024
_ODD = re.compile(r"[^A-Za-z0-9_.-]+")

Pixels = NDArray[np.uint8]


def bring_picture(folder: Folder, data: bytes, *, name: str, world: str | None) -> Json:
    """Write a picture beside a world, under a name that is free.

    Args:
        folder: Of the studio.
        data: The picture as it was sent.
        name: That it had.
        world: Beside which it goes; by default into the folder of the studio.

    Returns:
        `path` as the world names it, and `file`, its path from the folder of the studio.

    Raises:
        RefusedError: It is no picture, or cannot be written.
    """
    pixels = _within(decoded(data), LARGEST)
    kind = ".png" if data.startswith(b"\x89PNG") else ".jpg"
    place = source_of(folder, world or "").folder or folder.root
    stem = _ODD.sub("-", PurePosixPath(name.replace("\\", "/")).stem).strip("-.") or "picture"
    data = encoded(pixels, kind)
    try:
        with folder.writing:
            path = place / free_name(place, f"{stem[:60]}{kind}")
            write_new(path, data)
    except OSError as error:
        raise RefusedError(409, f"'{stem[:60]}{kind}' cannot be written: {error.strerror}") from None
    return {"path": path.name, "file": folder.name(path)}


def small_picture(folder: Folder, path: str, *, size: int, world: str | None) -> bytes:
    """Return a picture of a world's folder, of the studio's, or of those that come with mjsim, made small; a JPEG.

    Args:
        folder: Of the studio.
        path: As a world names it.
        size: Of its longer side at most [px].
        world: That names it.

    Raises:
        RefusedError: The picture does not exist.
    """
    try:
        data = read_asset(path, source_of(folder, world or ""))
    except ValueError as error:
        raise RefusedError(404, str(error)) from None
    return encoded(_within(decoded(data), max(16, min(size, LARGEST_SMALL))), ".jpg")


def decoded(data: bytes) -> Pixels:
    """Return the pixels of a PNG or a JPEG, blue first, what is transparent white.

    Raises:
        RefusedError: It is neither, it is broken, or it would be too large.
    """
    try:
        # Told from its head, before anything is unpacked.
        picture_size(data)
        pixels = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED | cv2.IMREAD_ANYCOLOR)
    except ValueError as error:
        raise RefusedError(415, f"this {error}") from None
    except cv2.error:
        pixels = None
    if pixels is None:
        raise RefusedError(415, "this is a broken picture; make it again")
    return _plain(np.asarray(pixels))


def encoded(pixels: Pixels, kind: str) -> bytes:
    """Return pixels as a file, '.png' or '.jpg'."""
    done, data = cv2.imencode(kind, pixels, [cv2.IMWRITE_JPEG_QUALITY, QUALITY] if kind == ".jpg" else [])
    assert done, "eight bits and three colours can always be written"
    return data.tobytes()


def _plain(pixels: NDArray[np.generic]) -> Pixels:
    """Return a picture with eight bits and three colours."""
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)  # type: ignore[operator]
    plain = np.asarray(pixels, dtype=np.uint8)
    if plain.ndim == 2:
        return np.asarray(cv2.cvtColor(plain, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    if plain.shape[2] == 4:
        alpha = plain[..., 3:].astype(np.float32) / 255.0
        return np.asarray(plain[..., :3] * alpha + 255.0 * (1.0 - alpha), dtype=np.uint8)
    return plain


def _within(pixels: Pixels, largest: int) -> Pixels:
    """Return a picture whose sides are no longer than so many pixels."""
    height, width = pixels.shape[:2]
    scale = largest / max(height, width)
    if scale >= 1.0:
        return pixels
    size = max(1, round(width * scale)), max(1, round(height * scale))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
