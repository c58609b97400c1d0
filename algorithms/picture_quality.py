"""How well a picture can be recognised: the smallest size in an image at which it is found, or why it is not."""

import math
from bisect import bisect_left

import cv2
import numpy as np

from mjsim.interface import Intrinsics, Picture

from .picture_beacons import PictureBeacons
from .picture_gauge import LEAST_SIDE, gray_of
from .picture_templates import Gray
from .planar_pose import image_from_plane, rotation_of

SMALLEST, RATIO, STEPS = LEAST_SIDE, 1.2, 13
"""Sizes in an image that are tried [px]: the first, the ratio of one to the one before, and their number."""
YAWS_DEG = -25.0, 5.0
"""Directions from which a picture must be found at a size."""
FOCAL = 554.0
"""Focal length of the views [px]."""
MARGIN = 20
"""Wall around the picture in a view [px]."""
WALL = 200
"""Gray of the wall."""
NOISE = 2.0
"""Of a view, standard deviation [gray values of 255]."""
FINER = 2
"""Pixels of the picture that are averaged to one of a view, in each direction."""


def least_side(picture: Picture) -> float:
    """Return the smallest size in an image at which a picture is recognised, the root of its area [px]; or infinity.

    Views from two sides are drawn in several sizes and searched by the recogniser itself.

    Args:
        picture: RGB, shape (height, width, 3).
    """
    picture = _bounded(picture)
    rows, columns = picture.shape[:2]
    finder = PictureBeacons({"it": (picture, math.sqrt(columns / rows))})
    if not finder.searched:
        return math.inf
    gray = gray_of(picture)
    sides = (SMALLEST * RATIO ** np.arange(STEPS)).tolist()
    slanted, front = YAWS_DEG
    first = bisect_left(sides, True, key=lambda side: _is_found(finder, gray, side, slanted))
    return next((side for side in sides[first:] if _is_found(finder, gray, side, front)), math.inf)


def _bounded(picture: Picture) -> Picture:
    """Return a picture without what is finer than the largest view."""
    scale = FINER * SMALLEST * RATIO ** (STEPS - 1) / math.sqrt(picture.shape[0] * picture.shape[1])
    if scale >= 1.0 or min(picture.shape[:2]) * scale < 1.0:
        return picture
    return np.asarray(cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _is_found(finder: PictureBeacons, gray: Gray, side: float, yaw_deg: float) -> bool:
    """Return whether a picture of one square metre is found at a size in the image [px]."""
    rows, columns = gray.shape
    width, height = (
        round(side * extent) + 2 * MARGIN for extent in (math.sqrt(columns / rows), math.sqrt(rows / columns))
    )
    camera = Intrinsics(width, height, FOCAL, FOCAL, (width - 1) / 2, (height - 1) / 2)
    return bool(finder.detect(_drawn(gray, side, camera, yaw_deg), camera))


def _drawn(gray: Gray, side: float, camera: Intrinsics, yaw_deg: float) -> Picture:
    """Return the image of a picture of one square metre on a wall, without aliasing."""
    small = gray
    scale = FINER * side / math.sqrt(gray.size)
    if scale < 1.0:
        small = np.asarray(cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8)
    rows, columns = small.shape[:2]
    k = 1.0 / math.sqrt(rows * columns)
    plane_from_pixel = np.array([[k, 0.0, -k * (columns - 1) / 2], [0.0, k, -k * (rows - 1) / 2], [0.0, 0.0, 1.0]])
    rotation, position = rotation_of(np.array([0.0, math.radians(yaw_deg), 0.0])), np.array([0.0, 0.0, FOCAL / side])
    finer = np.array([[FINER, 0.0, (FINER - 1) / 2], [0.0, FINER, (FINER - 1) / 2], [0.0, 0.0, 1.0]])
    mapping = finer @ image_from_plane(rotation, position, camera) @ plane_from_pixel
    size = FINER * camera.width, FINER * camera.height
    fine = cv2.warpPerspective(small, mapping, size, borderMode=cv2.BORDER_CONSTANT, borderValue=(WALL,))
    image = cv2.resize(fine, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    noisy = np.clip(np.rint(image + np.random.default_rng(0).normal(0.0, NOISE, image.shape)), 0, 255)
    return np.repeat(noisy[..., None], 3, axis=2).astype(np.uint8)
