"""How well a picture can be recognised: the smallest size in an image at which it is found, or why it is not."""

import math
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.interface import Intrinsics, Picture

from .picture_beacons import PictureBeacons, PreparedImage
from .picture_gauge import MIN_SIDE, gray_of
from .picture_likeness import repeats
from .picture_templates import SLIMMEST, Gray
from .planar_pose import image_from_plane, rotation_of

SMALLEST, RATIO, STEPS = MIN_SIDE, 1.2, 13
"""Sizes in an image that are tried [px]: the first, the ratio of successive ones, and their number."""
YAWS_DEG = -25.0, 5.0
"""Directions from which a picture must be found at a size."""
FOCAL = 554.0
"""Focal length of the views [px]."""
MARGIN = 20
"""Width of the wall shown around the picture in a view [px]."""
WALL = 200
"""Gray of the wall."""
NOISE = 2.0
"""Noise of a view, standard deviation on a 0 to 255 scale."""
FINER = 2
"""Pixels of the picture that are averaged to one of a view, in each direction."""
TOO_LIKE = 0.9
"""Maximum share of a picture's features that another may explain; more similar ones are confused at some distance."""
FAINT, CONTRAST_SIDE = 1.0, 64
"""Contrast below which a picture counts as plain [gray values per pixel], and the long side at which it is measured
[px]; the shipped posters have 21 and more."""
ONE_WAY = 0.05
"""Contrast in one direction relative to that in the other, below which a picture counts as striped."""


@dataclass(frozen=True, slots=True)
class PictureQuality:
    """How well a picture can be recognised among others."""

    least_side: float
    """Smallest size in an image at which it is recognised, the root of its area [px]; infinite if it never is."""
    fault: str | None
    """What is wrong with it; None for a good one."""
    like: tuple[str, float] | None
    """An earlier picture with which it can be confused, and the share of it that the other explains, at most 1."""


def picture_qualities(pictures: Mapping[str, Picture]) -> dict[str, PictureQuality]:
    """Return how well each picture can be recognised by `PictureBeacons` that search for all of them, by name.

    Views of each are drawn in several sizes and searched by the recogniser itself.

    Args:
        pictures: RGB, shape (height, width, 3), by name.
    """
    grays = {name: _bounded(gray_of(picture)) for name, picture in pictures.items()}
    finder = PictureBeacons(
        {name: (_colored(gray), math.sqrt(gray.shape[1] / gray.shape[0])) for name, gray in grays.items()}
    )
    order, like = list(pictures), dict[str, tuple[str, float]]()
    for one, other, share in finder.alike:
        first, second = sorted((one, other), key=order.index)
        if share > TOO_LIKE:
            like.setdefault(second, (first, share))
    qualities: dict[str, PictureQuality] = {}
    for name, gray in grays.items():
        side = math.inf
        if finder.is_searched(name):
            side = _least_side(finder, name, gray)
        elif name in like:
            side = qualities[like[name][0]].least_side
        qualities[name] = PictureQuality(side, _fault(gray, side), like.get(name))
    return qualities


def _fault(gray: Gray, side: float) -> str | None:
    """Return what is wrong with a picture of a minimum size [px]."""
    longer, shorter = max(gray.shape), min(gray.shape)
    if longer > SLIMMEST * shorter:
        return (
            f"is {longer / shorter:.0f} times as long as it is wide; use one that is at most {SLIMMEST} times as long"
        )
    least, most = _contrasts(gray)
    if most < FAINT:
        return "is of one colour or nearly so; use one with clear shapes all over it"
    if least < ONE_WAY * most:
        return "changes in one direction only, like stripes; use one with shapes all over it"
    if repeats(gray):
        return "repeats itself, so that its parts cannot be told apart; use one that is different everywhere"
    if math.isinf(side):
        return "has too few details or too little contrast; use one with many clear shapes"
    return None


def _contrasts(gray: Gray) -> tuple[float, float]:
    """Return the contrast in the directions in which a picture changes least and most [gray values per pixel].

    References:
        Shi, Tomasi, Good Features to Track, CVPR 1994: the eigenvalues of the structure tensor.
    """
    size = [max(8, round(extent * CONTRAST_SIDE / max(gray.shape))) for extent in reversed(gray.shape)]
    small = np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), dtype=float)
    slopes = np.stack([slope.ravel() for slope in np.gradient(small)])
    least, most = np.sqrt(np.maximum(np.linalg.eigvalsh(slopes @ slopes.T / small.size), 0.0))
    return float(least), float(most)


def _least_side(finder: PictureBeacons, name: str, gray: Gray) -> float:
    sides = (SMALLEST * RATIO ** np.arange(STEPS)).tolist()
    slanted, front = YAWS_DEG
    first = bisect_left(sides, True, key=lambda side: _is_found(finder, name, gray, side, slanted))
    return next((side for side in sides[first:] if _is_found(finder, name, gray, side, front)), math.inf)


def _colored(gray: Gray) -> Picture:
    """Return an RGB picture of gray values."""
    return np.repeat(gray[..., None], 3, axis=2)


def _bounded(gray: Gray) -> Gray:
    """Return a picture without details finer than the largest view shows."""
    scale = FINER * SMALLEST * RATIO ** (STEPS - 1) / math.sqrt(gray.size)
    if scale >= 1.0 or min(gray.shape) * scale < 1.0:
        return gray
    return np.asarray(cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _is_found(finder: PictureBeacons, name: str, gray: Gray, side: float, yaw_deg: float) -> bool:
    """Return whether a picture of one square metre is found at a size in the image [px]."""
    rows, columns = gray.shape
    width, height = (
        round(side * extent) + 2 * MARGIN for extent in (math.sqrt(columns / rows), math.sqrt(rows / columns))
    )
    camera = Intrinsics(width, height, FOCAL, FOCAL, (width - 1) / 2, (height - 1) / 2)
    view = PreparedImage(_drawn(gray, side, camera, yaw_deg), camera)
    return bool(finder.search(view, only=name))


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
    return _colored(noisy.astype(np.uint8))
