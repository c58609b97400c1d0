"""Laying a picture over its image to a fraction of a pixel, and telling whether it is there at all.

The picture is compared with the image pixel by pixel, at a size at which both show the same detail. A homography
is refined by Gauss-Newton on the picture's own gradients, with gain, offset and a slope of the light as unknowns.

References:
    Baker, Matthews, Lucas-Kanade 20 Years On, IJCV 56(3), 2004: the inverse compositional algorithm.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

Gray32 = NDArray[np.float32]

SIDES = (32, 45, 64, 90, 128, 180)
"""Long sides of the templates of a picture [px]."""
TILES = 5
"""Tiles along a side, by which parts that are hidden are found."""
REACH = 7
"""Of the search around a predicted place, in pixels of the smallest template."""
STEPS = 6
"""Gauss-Newton steps at most for one template."""
LEAST_SEEN = 0.55
"""Share of a picture that must be seen."""
TILE_MISFIT = 0.5
"""Energy of a tile's difference, relative to the picture's contrast, above which it is taken for hidden."""


@dataclass(frozen=True, slots=True, eq=False)
class Template:
    """A picture at one size, ready to be compared."""

    gray: Gray32
    """Shape (height, width)."""
    plane_from_pixel: Array
    """From pixels of the template to [m] in the plane of the picture, shape (3, 3)."""
    unit_from_plane: Array
    """To coordinates of about -1 to 1, in which corrections are small numbers, shape (3, 3)."""
    design: Gray32
    """What changes the template: eight of homography, then gain, offset and two slopes; shape (pixels, 12)."""
    tiles: NDArray[np.intp]
    """Tile of each pixel, shape (pixels,)."""
    inner: NDArray[np.bool_]
    """All but the rim, shape (pixels,)."""


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """How a picture lies in the image."""

    homography: Array
    """From the plane of the picture [m] to the image [px], shape (3, 3)."""
    information: Array
    """Inverse covariance of the corners (u, v) in turn for unit-variance independent pixels of noise, (8, 8)."""
    correlation: float
    """Of what is seen with the picture, at most 1."""
    worst: float
    """The same of the third-worst tile that is seen."""
    seen: float
    """Share of the picture that is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class ImagePyramid:
    """A camera's image at full, half, quarter... size."""

    levels: tuple[Gray32, ...]


def make_pyramid(gray: NDArray[np.uint8]) -> ImagePyramid:
    """Return the pyramid of a gray image."""
    levels = [gray.astype(np.float32)]
    while min(levels[-1].shape) > 60:
        levels.append(np.asarray(cv2.pyrDown(levels[-1]), dtype=np.float32))
    return ImagePyramid(tuple(levels))


def make_templates(gray: NDArray[np.uint8], width: float) -> tuple[Template, ...]:
    """Return the templates of a gray picture of that width [m], from small to large."""
    return tuple(_make_template(gray, width, side) for side in SIDES)


def _make_template(gray: NDArray[np.uint8], width: float, side: int) -> Template:
    scale = side / max(gray.shape)
    columns, rows = max(8, round(gray.shape[1] * scale)), max(8, round(gray.shape[0] * scale))
    small = np.asarray(cv2.resize(gray, (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.float32)
    small = np.asarray(cv2.GaussianBlur(small, (0, 0), 0.6, borderType=cv2.BORDER_REPLICATE), dtype=np.float32)
    height = width * gray.shape[0] / gray.shape[1]
    middle = ((columns - 1) / 2.0, (rows - 1) / 2.0)
    plane_from_pixel = np.array(
        [
            [width / columns, 0.0, -middle[0] * width / columns],
            [0.0, height / rows, -middle[1] * height / rows],
            [0.0, 0.0, 1.0],
        ]
    )
    unit = 2.0 / max(width, height)
    x, y = np.meshgrid(
        (np.arange(columns) - middle[0]) * width / columns * unit, (np.arange(rows) - middle[1]) * height / rows * unit
    )
    slope_x = cv2.Sobel(small, cv2.CV_32F, 1, 0, ksize=3, scale=columns / (8.0 * width * unit))
    slope_y = cv2.Sobel(small, cv2.CV_32F, 0, 1, ksize=3, scale=rows / (8.0 * height * unit))
    pull = x * slope_x + y * slope_y
    parts = [x * slope_x, y * slope_x, slope_x, x * slope_y, y * slope_y, slope_y, -x * pull, -y * pull]
    design = np.stack([*parts, small, np.ones_like(small), x, y], axis=-1).reshape(-1, 12).astype(np.float32)
    row, column = np.divmod(np.arange(rows * columns), columns)
    rim = max(1, round(0.03 * side))
    inner = (row >= rim) & (row < rows - rim) & (column >= rim) & (column < columns - rim)
    tiles = row * TILES // rows * TILES + column * TILES // columns
    return Template(small, plane_from_pixel, np.diag([unit, unit, 1.0]), design, tiles, inner)


def search_near(templates: tuple[Template, ...], image: ImagePyramid, homography: Array) -> Array:
    """Return a predicted homography, shifted to where the smallest template fits best near it."""
    template = templates[0]
    rows, columns = template.gray.shape
    shift = np.array([[1.0, 0.0, -REACH], [0.0, 1.0, -REACH], [0.0, 0.0, 1.0]])
    around, _ = _sample(
        image, homography @ template.plane_from_pixel @ shift, (columns + 2 * REACH, rows + 2 * REACH), template
    )
    fit = cv2.matchTemplate(around, template.gray, cv2.TM_CCOEFF_NORMED)
    _, _, _, best = cv2.minMaxLoc(fit)
    moved = np.array([[1.0, 0.0, best[0] - REACH], [0.0, 1.0, best[1] - REACH], [0.0, 0.0, 1.0]])
    return np.asarray(
        homography @ template.plane_from_pixel @ moved @ np.linalg.inv(template.plane_from_pixel), dtype=float
    )


def align(templates: tuple[Template, ...], image: ImagePyramid, homography: Array, *, coarse: bool) -> Alignment | None:
    """Return the refined place of a picture, or None when it is not there.

    Args:
        templates: Of the picture.
        image: Of the camera.
        homography: First guess, from the plane of the picture [m] to the image [px], shape (3, 3).
        coarse: Whether to start with the smallest template, which mends a guess that is pixels off.
    """
    if coarse:
        rough = _refine(templates[0], image, homography)
        if rough is None:
            return None
        homography = rough.homography
    return _refine(templates[_fitting(templates, homography)], image, homography)


def quadrilateral_area(corners: Array) -> float:
    """Return the area inside corners given clockwise as seen in the image, shape (4, 2); negative when mirrored."""
    x, y = corners.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))


def apply_homography(homography: Array, points: Array) -> Array:
    """Return points mapped by a homography, shape (n, 2)."""
    mapped = points @ homography[:, :2].T + homography[:, 2]
    return np.asarray(mapped[:, :2] / mapped[:, 2:])


def template_corners(template: Template) -> Array:
    """Return the corners in the plane of the picture, from its top left clockwise, shape (4, 2) [m]."""
    rows, columns = template.gray.shape
    pixels = np.array([[-0.5, -0.5], [columns - 0.5, -0.5], [columns - 0.5, rows - 0.5], [-0.5, rows - 0.5]])
    return apply_homography(template.plane_from_pixel, pixels)


def _fitting(templates: tuple[Template, ...], homography: Array) -> int:
    """Return the index of the template nearest in size to the picture in the image."""
    corners = template_corners(templates[-1])
    area = max(quadrilateral_area(apply_homography(homography, corners)), 1.0)
    plane = quadrilateral_area(corners)
    side = np.sqrt(area / plane) * float(np.max(np.ptp(corners, axis=0)))
    return int(np.argmin(np.abs(np.log(np.array(SIDES) / side))))


def _sample(
    image: ImagePyramid, image_from_pixel: Array, size: tuple[int, int], template: Template
) -> tuple[Gray32, Array]:
    """Return the image as the template's pixels see it, and the homography from them to the pyramid's level."""
    middle = np.array([size[0] / 2.0, size[1] / 2.0])
    steps = apply_homography(image_from_pixel, middle + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
    area = abs(float(np.linalg.det(steps[1:] - steps[0])))
    level = int(np.clip(np.round(0.5 * np.log2(max(area, 1e-9))), 0, len(image.levels) - 1))
    # Pixel i of a level lies on pixel 2 i of the level below.
    mapping = np.diag([0.5**level, 0.5**level, 1.0]) @ image_from_pixel
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    sampled = cv2.warpPerspective(
        image.levels[level], mapping, size, flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=(-1.0,)
    )
    return np.asarray(sampled, dtype=np.float32), mapping


def _refine(template: Template, image: ImagePyramid, homography: Array) -> Alignment | None:
    rows, columns = template.gray.shape
    unit_from_plane = template.unit_from_plane
    plane_from_unit = np.linalg.inv(unit_from_plane)
    seen = template.inner
    hidden: NDArray[np.bool_] | None = None
    for step in range(STEPS):
        sampled, _ = _sample(image, homography @ template.plane_from_pixel, (columns, rows), template)
        values = sampled.reshape(-1)
        seen = template.inner & (values >= 0.0)
        if hidden is not None:
            seen = seen & ~hidden[template.tiles]
        if np.count_nonzero(seen) < LEAST_SEEN * np.count_nonzero(template.inner):
            return None
        design = template.design[seen]
        normal = (design.T @ design).astype(float)
        solution = np.linalg.solve(normal + 1e-6 * np.diag(np.diag(normal)), (design.T @ values[seen]).astype(float))
        gain = solution[8]
        if gain < 0.1:
            return None
        left = values - template.design @ solution.astype(np.float32)
        p = np.clip(solution[:8] / gain, -0.3, 0.3)
        moved = np.eye(3) + np.array([[p[0], p[1], p[2]], [p[3], p[4], p[5]], [p[6], p[7], 0.0]])
        homography = homography @ plane_from_unit @ np.linalg.inv(moved) @ unit_from_plane
        homography = homography / homography[2, 2]
        if step == 2:
            hidden = _hidden_tiles(template, left, seen, gain)
        if step > 2 and np.abs(p).max() < 3e-4:
            break
    return _judge(template, homography, values, seen, normal, gain, left)


def _hidden_tiles(template: Template, left: Gray32, seen: NDArray[np.bool_], gain: float) -> NDArray[np.bool_]:
    """Return for each tile whether what is seen there is something else."""
    count = np.bincount(template.tiles[seen], minlength=TILES**2)
    energy = np.bincount(template.tiles[seen], weights=left[seen] ** 2, minlength=TILES**2)
    contrast = gain**2 * float(np.var(template.gray))
    return np.asarray(energy > TILE_MISFIT * contrast * np.maximum(count, 1))


def _judge(
    template: Template,
    homography: Array,
    values: Gray32,
    seen: NDArray[np.bool_],
    normal: Array,
    gain: float,
    left: Gray32,
) -> Alignment:
    tiles, own = template.tiles[seen], template.gray.reshape(-1)[seen]
    variance = float(np.var(left[seen]))
    whole = float(np.corrcoef(values[seen], own)[0, 1])
    energy = np.bincount(tiles, weights=left[seen] ** 2, minlength=TILES**2)
    count = np.bincount(tiles, minlength=TILES**2)
    full = count > 0.5 * len(template.tiles) / TILES**2
    misfit = np.sort(energy[full] / count[full])
    worst = 1.0 - float(misfit[-3]) / (gain**2 * float(np.var(template.gray)))
    # Gain, offset and slopes are unknown as well: their share of the information goes.
    information = normal[:8, :8] - normal[:8, 8:] @ np.linalg.solve(normal[8:, 8:], normal[8:, :8])
    information = information * gain**2 / max(variance, 0.5)
    D = _corners_by_correction(template, homography)
    inverse = np.linalg.inv(D)
    return Alignment(
        homography,
        inverse.T @ information @ inverse,
        whole,
        worst,
        float(np.mean(seen[template.inner])),
    )


def _corners_by_correction(template: Template, homography: Array) -> Array:
    """Return how the corners move with the eight numbers of the correction, shape (8, 8) [px]."""
    unit = apply_homography(template.unit_from_plane, template_corners(template))
    image_from_unit = homography @ np.linalg.inv(template.unit_from_plane)
    rows = []
    for x, y in unit.tolist():
        moved = np.array([[x, y, 1, 0, 0, 0, -x * x, -x * y], [0, 0, 0, x, y, 1, -x * y, -y * y]])
        w = image_from_unit @ (x, y, 1.0)
        slope = (image_from_unit[:2, :2] - np.outer(w[:2] / w[2], image_from_unit[2, :2])) / w[2]
        rows.append(-slope @ moved)
    return np.concatenate(rows)
