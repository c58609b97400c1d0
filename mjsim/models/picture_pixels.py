"""Picture files to arrays and back."""

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.models.picture_sizes import LYING, orientation

Picture = NDArray[np.uint8]
"""RGB picture, shape (height, width, 3), uint8."""
WHITE = 255
JPEG = b"\xff\xd8"
"""First bytes of a file whose pixels are all opaque."""


def read_picture(data: bytes) -> Picture:
    """Return the RGB picture of a PNG or JPEG file, shape (height, width, 3); transparent pixels become white.

    Raises:
        ValueError: The file is not a readable picture.
    """
    opaque = data.startswith(JPEG)
    raw = _decoded(data, cv2.IMREAD_COLOR_RGB if opaque else cv2.IMREAD_UNCHANGED)
    if raw is None:
        raise ValueError("is not a picture that can be read; use a PNG or JPEG file")
    if opaque:
        return np.asarray(raw, dtype=np.uint8)
    if raw.ndim == 3 and raw.shape[2] == 4:
        return upright(_on_white(raw), data)
    # Decode again, now with the camera's orientation (EXIF) and 8-bit colours.
    return np.asarray(_decoded(data, cv2.IMREAD_COLOR_RGB), dtype=np.uint8)


def _decoded(data: bytes, form: int) -> np.ndarray | None:
    return cv2.imdecode(np.frombuffer(data, dtype=np.uint8), form) if data else None


def upright(picture: Picture, data: bytes) -> Picture:
    """Return a picture, decoded as it was stored, turned as the EXIF data of its file say."""
    by = orientation(data)
    if by >= LYING:
        picture = picture.transpose(1, 0, 2)
    rows, columns = -1 if by in (3, 4, 7, 8) else 1, -1 if by in (2, 3, 6, 7) else 1
    return np.ascontiguousarray(picture[::rows, ::columns])


def bounded(picture: Picture, longest: int) -> Picture:
    """Return the picture with its longer side at most `longest` pixels, preserving its aspect ratio."""
    height, width = picture.shape[:2]
    factor = longest / max(height, width)
    if factor >= 1.0:
        return picture
    size = max(1, round(width * factor)), max(1, round(height * factor))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def encode_png(picture: Picture) -> bytes:
    """Return a PNG file of an RGB picture."""
    done, data = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))
    assert done
    return data.tobytes()


def _on_white(raw: np.ndarray) -> Picture:
    """Return the RGB picture of a BGRA picture on white."""
    full = 65535 if raw.dtype == np.uint16 else 255
    share = raw[..., 3:].astype(np.float32) / full
    colors = raw[..., 2::-1].astype(np.float32) * (255 / full)
    return np.asarray(np.rint(colors * share + WHITE * (1 - share)), dtype=np.uint8)
