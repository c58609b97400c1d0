"""Pictures at several sizes, ready to be compared with a camera's image, and that image at several sizes."""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

from ..estimation.inverses import inverse_of

Gray = NDArray[np.uint8]
"""Shape (height, width)."""

SIDES = (32, 45, 64, 90, 128)
"""Long sides of the templates of a picture [px]."""
TILES = 5
"""Tiles along a side, for detecting hidden parts."""
BLOCK = 5
"""Side of the blocks within which differences from the image are assumed to be correlated [px]."""
NOISE = 3.0
"""Noise of a camera for which a template is judged, standard deviation on a 0 to 255 scale."""
MAX_NOISE = 0.25
"""Largest error of a corner by this noise, standard deviation [px of the template]. The shipped posters have 0.01 to
0.06; plain, striped and smoothly shaded pictures have 0.3 to infinity."""
LEVELS = 5
"""Levels of an image pyramid."""
SLIMMEST = 16
"""Largest ratio of the sides of a picture."""
BLUR = 0.6
"""Blur of a template, standard deviation [px]; about that of the renderer or a lens."""


@dataclass(frozen=True, slots=True, eq=False)
class PictureTemplate:
    """A picture at one size. Data per pixel leave out the rim: one value for each of the n other pixels, row by row."""

    gray: Gray
    """Shape (rows, columns)."""
    plane_from_pixel: Array
    """Transform from pixels of the template to [m] in the plane of the picture, shape (3, 3)."""
    pixel_from_plane: Array
    """The inverse."""
    unit: float
    """Factor from [m] to coordinates of -1 to 1, in which corrections are small numbers [1/m]."""
    corners: Array
    """Corners in the plane of the picture, from its top left clockwise, shape (4, 2) [m]."""
    side: int
    """Long side [px]."""
    plane_from_inner: Array
    """As `plane_from_pixel`, from pixels counted within the rim, shape (3, 3)."""
    inner_size: tuple[int, int]
    """Columns and rows without the rim."""
    own: NDArray[np.float32]
    """Value of each pixel minus their mean, shape (n,)."""
    tiles: NDArray[np.intp]
    """Tile of each pixel, shape (n,)."""
    tile_pixels: NDArray[np.intp]
    """Number of pixels of each tile, shape (TILES^2,)."""
    least_pixels: int
    """Smallest number of pixels of a tile."""
    design: NDArray[np.float32]
    """Derivatives by the eight parameters of a homography, gain, offset and two slopes, shape (12, n)."""
    places: NDArray[np.intp]
    """Place of each pixel in `blocks`, counted through blocks and their pixels, shape (n,)."""
    blocks: NDArray[np.float32]
    """The design matrix in blocks, short ones padded with 0, shape (blocks, 12, BLOCK^2)."""
    inverse: Array
    """Inverse of design @ design.T, shape (12, 12)."""
    contrast: float
    """Variance of `own`."""

    def is_measurable(self, inverse: Array) -> bool:
        """Return whether corners are accurate despite a camera's noise; plain or striped pictures fail.

        Args:
            inverse: Inverse of the normal matrix of the pixels used, shape (12, 12).
        """
        slopes = corners_by_correction(self, self.pixel_from_plane)
        variances = np.einsum("ij,jk,ik->i", slopes, inverse[:8, :8], slopes)
        return bool(NOISE**2 * variances.max() < MAX_NOISE**2)


def make_templates(gray: Gray, width: float) -> tuple[PictureTemplate, ...]:
    """Return the templates of a gray picture of a given width [m], from small to large.

    Those at which the pose of the picture cannot be measured are left out.
    """
    if max(gray.shape) > SLIMMEST * min(gray.shape):
        return ()
    templates = (_make_template(gray, width, side) for side in SIDES)
    return tuple(template for template in templates if template is not None)


def _make_template(gray: Gray, width: float, side: int) -> PictureTemplate | None:
    scale = side / max(gray.shape)
    columns, rows = max(8, round(gray.shape[1] * scale)), max(8, round(gray.shape[0] * scale))
    height = width * gray.shape[0] / gray.shape[1]
    small = np.asarray(cv2.resize(gray, (columns, rows), interpolation=cv2.INTER_AREA), dtype=np.float32)
    small = np.asarray(cv2.GaussianBlur(small, (0, 0), BLUR, borderType=cv2.BORDER_REPLICATE), dtype=np.float32)
    dx, dy = width / columns, height / rows
    x0, y0 = -(columns - 1) / 2.0 * dx, -(rows - 1) / 2.0 * dy
    plane_from_pixel = np.array([[dx, 0.0, x0], [0.0, dy, y0], [0.0, 0.0, 1.0]])
    unit = 2.0 / max(width, height)
    row, column = np.divmod(np.arange(rows * columns), columns)
    # The image's pixels on the edge are part wall.
    rim = max(1, round(0.03 * side))
    inner = np.zeros((rows, columns), dtype=bool)
    inner[rim:-rim, rim:-rim] = True
    own = small[inner]
    tiles = (row * TILES // rows * TILES + column * TILES // columns)[inner.ravel()]
    slopes = warp_slopes(small, (x0 * unit, y0 * unit), (dx * unit, dy * unit))
    design = np.ascontiguousarray(slopes[inner.ravel()].T)
    places = _block_places(rows - 2 * rim, columns - 2 * rim)
    normal = (design @ design.T).astype(float)
    inverse = inverse_of(normal)
    if inverse is None:
        return None
    w, h = width / 2.0, height / 2.0
    tile_pixels = np.bincount(tiles, minlength=TILES**2)
    template = PictureTemplate(
        gray=np.rint(small).astype(np.uint8),
        plane_from_pixel=plane_from_pixel,
        pixel_from_plane=np.linalg.inv(plane_from_pixel),
        unit=unit,
        corners=np.array([[-w, -h], [w, -h], [w, h], [-w, h]]),
        side=max(rows, columns),
        plane_from_inner=plane_from_pixel @ shift(rim, rim),
        inner_size=(columns - 2 * rim, rows - 2 * rim),
        own=own - own.mean(),
        tiles=tiles,
        tile_pixels=tile_pixels,
        least_pixels=int(tile_pixels.min()),
        design=design,
        places=places,
        blocks=_by_blocks(design, places),
        inverse=inverse,
        contrast=float(np.var(own)),
    )
    return template if template.is_measurable(inverse) else None


def warp_slopes(
    small: NDArray[np.float32], first: tuple[float, float], step: tuple[float, float]
) -> NDArray[np.float32]:
    """Return the derivatives of each pixel by homography, gain, offset and slopes, shape (pixels, 12).

    Args:
        small: The template.
        first: Its first pixel in unit coordinates.
        step: Step from pixel to pixel in unit coordinates.
    """
    rows, columns = small.shape
    x, y = np.meshgrid(first[0] + np.arange(columns) * step[0], first[1] + np.arange(rows) * step[1])
    slope_x = cv2.Sobel(small, cv2.CV_32F, 1, 0, ksize=3, scale=1.0 / (8.0 * step[0]))
    slope_y = cv2.Sobel(small, cv2.CV_32F, 0, 1, ksize=3, scale=1.0 / (8.0 * step[1]))
    pull = x * slope_x + y * slope_y
    warps = [x * slope_x, y * slope_x, slope_x, x * slope_y, y * slope_y, slope_y, -x * pull, -y * pull]
    return np.stack([*warps, small, np.ones_like(small), x, y], axis=-1).reshape(-1, 12).astype(np.float32)


def _block_places(rows: int, columns: int) -> NDArray[np.intp]:
    """Return the index of each pixel when blocks of BLOCK by BLOCK follow each other, shape (rows * columns,)."""
    row, column = np.divmod(np.arange(rows * columns), columns)
    block = row // BLOCK * -(-columns // BLOCK) + column // BLOCK
    return np.asarray(block * BLOCK**2 + row % BLOCK * BLOCK + column % BLOCK)


def _by_blocks(design: NDArray[np.float32], places: NDArray[np.intp]) -> NDArray[np.float32]:
    """Return a design, shape (12, n), as shape (blocks, 12, BLOCK^2)."""
    blocks = np.zeros((len(design), (int(places[-1]) // BLOCK**2 + 1) * BLOCK**2), dtype=np.float32)
    blocks[:, places] = design
    return np.ascontiguousarray(blocks.reshape(len(design), -1, BLOCK**2).transpose(1, 0, 2))


class ImagePyramid:
    """A camera's gray image at full, half, quarter... size, each computed on first use."""

    def __init__(self, gray: Gray) -> None:
        """Take a gray image, shape (height, width)."""
        self._levels = [gray]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the image [px]."""
        return self._levels[0].shape[1], self._levels[0].shape[0]

    def level(self, area: float) -> int:
        """Return the level whose pixels are nearest in area [px^2 of the image]."""
        return min(max(round(0.5 * math.log2(max(area, 1e-9))), 0), LEVELS - 1)

    def image(self, level: int) -> Gray:
        """Return the image halved `level` times; its pixel i lies on pixel 2 i of the level below."""
        while len(self._levels) <= level:
            self._levels.append(np.asarray(cv2.pyrDown(self._levels[-1]), dtype=np.uint8))
        return self._levels[level]


def shift(x: float, y: float) -> Array:
    """Return the homography that adds (x, y), shape (3, 3)."""
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y], [0.0, 0.0, 1.0]])


def quadrilateral_area(corners: Array) -> float:
    """Return the area inside corners, clockwise in the image, shape (4, 2); negative when mirrored."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = corners.tolist()
    return 0.5 * float((cx - ax) * (dy - by) - (dx - bx) * (cy - ay))


def apply_homography(homography: Array, points: Array) -> Array:
    """Return points mapped by a homography, shape (n, 2)."""
    return np.asarray(cv2.perspectiveTransform(points[None], homography)[0]) if len(points) else points


def corners_by_correction(template: PictureTemplate, homography: Array) -> Array:
    """Return the derivatives of the corners by the eight numbers of the correction, shape (8, 8) [px]."""
    k = template.unit
    (a, b, c), (d, e, f), (g, h, i) = homography.tolist()
    rows = []
    # Four points: plain numbers are several times faster than arrays.
    for x, y in template.corners.tolist():
        w = g * x + h * y + i
        # With respect to unit coordinates, in which a correction is a motion.
        p, q, scale = (a * x + b * y + c) / w, (d * x + e * y + f) / w, -1.0 / (w * k)
        u, v = x * k, y * k
        for along, down in (((a - p * g) * scale, (b - p * h) * scale), ((d - q * g) * scale, (e - q * h) * scale)):
            pull = -(u * along + v * down)
            rows.append([u * along, v * along, along, u * down, v * down, down, u * pull, v * pull])
    return np.array(rows)
