"""Pictures for the page: colours for depth and instances, and JPEG."""

import math
import zlib

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Picture
from mjsim.video import INK, PAPER, Letters

JPEG_QUALITY = 80
"""JPEG quality, 0 to 100."""
NEAR, FAR = 0.3, 12.0
"""Distances at the ends of the colour scale, which is logarithmic [m]."""
NO_HIT_COLOR = (40, 42, 48)
"""Colour of pixels that hit nothing, or something too close."""
BUILDING = {"wall": (150, 155, 164), "floor": (112, 117, 126), "ceiling": (196, 200, 206)}
"""Muted colours of the building."""
MIN_LABELLED_SHARE = 0.004
"""An instance that covers a smaller fraction of the picture is not labelled."""


def jpeg(picture: Picture) -> bytes:
    """Return an RGB picture as JPEG."""
    done, data = cv2.imencode(
        ".jpg", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    )
    assert done, "a picture of ours can always be encoded"
    return data.tobytes()


def depth_shown(depth: Array) -> Picture:
    """Return distances (height, width) [m] as colours, near ones warm, RGB."""
    finite = np.isfinite(depth)
    steps = np.log(np.clip(np.where(finite, depth, FAR), NEAR, FAR) / NEAR) / math.log(FAR / NEAR)
    shades = np.rint(255.0 * (1.0 - steps)).astype(np.uint8)
    colours = np.asarray(cv2.cvtColor(cv2.applyColorMap(shades, cv2.COLORMAP_TURBO), cv2.COLOR_BGR2RGB), dtype=np.uint8)
    colours[~finite] = NO_HIT_COLOR
    return colours


def segmentation_shown(frame: CameraFrame) -> Picture:
    """Return the object at each pixel as colours, with the names of sufficiently large ones, RGB."""
    instances = frame.segmentation
    assert instances is not None, "the camera gives instances"
    palette = np.array([NO_HIT_COLOR, *(instance_colour(name) for name in frame.instances)], dtype=np.uint8)
    picture: Picture = palette[instances + 1]
    letters, plates = Letters(), np.zeros(instances.shape, dtype=bool)
    counts = np.bincount(instances[instances >= 0].ravel(), minlength=len(frame.instances))
    for index in np.argsort(-counts).tolist():
        if counts[index] >= MIN_LABELLED_SHARE * instances.size:
            name, at = frame.instances[index].rpartition("/")[2], _middle(instances == index)
            _write_name(picture, name, at=at, letters=letters, plates=plates)
    return picture


def instance_colour(name: str) -> tuple[int, int, int]:
    """Return the colour of an instance, the same in all pictures and runs."""
    if name in BUILDING:
        return BUILDING[name]
    hue = zlib.crc32(name.encode()) % 180
    light = 150 + 70 * (zlib.crc32(name[::-1].encode()) % 2)
    red, green, blue = cv2.cvtColor(np.array([[[hue, 120, light]]], dtype=np.uint8), cv2.COLOR_HSV2RGB)[0, 0].tolist()
    return red, green, blue


def _middle(mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the pixel farthest inside a mask."""
    inside = cv2.distanceTransform(np.pad(mask.astype(np.uint8), 1), cv2.DIST_L2, 3)
    _, _, _, (x, y) = cv2.minMaxLoc(inside)
    return x - 1.0, y - 1.0


def _write_name(
    picture: Picture, name: str, *, at: tuple[float, float], letters: Letters, plates: NDArray[np.bool_]
) -> None:
    """Write a name on a plate around a pixel, unless it would cover another; `plates` holds where they are."""
    width = letters.width(name, 13) + 8
    x = round(min(max(at[0] - width / 2, 0), max(picture.shape[1] - width, 0)))
    y = round(min(max(at[1] - 9, 0), max(picture.shape[0] - 18, 0)))
    place = plates[y : y + 18, x : x + width]
    if not place.any():
        place[:] = True
        cv2.rectangle(picture, (x, y), (x + width - 1, y + 17), PAPER, -1)
        letters.write(picture, name, (x + 4, y + 13), 13, INK)
