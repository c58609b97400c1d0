"""Aligns a picture with its image to sub-pixel accuracy, and decides whether it is visible.

The picture is compared with the image pixel by pixel, at a size at which both show the same detail. A homography
is refined by Gauss-Newton on the picture's own gradients, with gain, offset and a slope of the light as unknowns.

References:
    Baker, Matthews, Lucas-Kanade 20 Years On, IJCV 56(3), 2004: the inverse compositional algorithm.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

from ..estimation.inverses import inverse_of
from .picture_templates import (
    BLOCK,
    LEVELS,
    TILES,
    Gray,
    ImagePyramid,
    PictureTemplate,
    apply_homography,
    corners_by_correction,
    quadrilateral_area,
    shift,
)

Mask = NDArray[np.bool_]

REACH = 7
"""Search radius around a predicted place, in pixels of the smallest template."""
STEPS = 8
"""Maximum number of Gauss-Newton steps for one template."""
MIN_SEEN = 0.6
"""Minimum visible part of a picture, 0 to 1."""
TILE_MISFIT = 0.4
"""Energy of a tile's difference, relative to the picture's contrast, above which it counts as occluded."""
NEEDED_CORRELATION = 0.8
"""Minimum correlation of a picture with its image."""
STRIDE = 0.8
"""Damping factor of Gauss-Newton steps: gradients of the smoothed picture are a fifth too small, steps too large."""
LEVEL_FROM_IMAGE = [np.array([[0.5**level], [0.5**level], [1.0]]) for level in range(LEVELS)]
"""Factors that scale a homography into the image to each level of its pyramid."""
BEFORE = shift(-REACH, -REACH)
SAME_PIXELS = 0.01
"""Correction below which the set of visible pixels stays the same: it changes by much less than one pixel."""
SETTLED = 1e-3
"""Correction at convergence, relative to half the picture's size; the remaining error is a tenth of it."""


@dataclass(frozen=True, slots=True, eq=False)
class Alignment:
    """Alignment of a picture with the image."""

    homography: Array
    """Homography from the plane of the picture [m] to the image [px], shape (3, 3)."""
    covariance: Array
    """Covariance of the corners (u, v) in turn, estimated from the residuals, shape (8, 8) [px^2]."""
    correlation: float
    """Correlation of the visible part with the picture, at most 1."""
    seen: float
    """Visible part of the picture, 0 to 1."""
    pixel: float
    """Side of a pixel of the template that was used, in the image [px]."""

    @property
    def explained(self) -> float:
        """How much of the image the picture explains, at most 1."""
        return self.correlation * self.seen


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """The last Gauss-Newton step."""

    homography: Array
    values: NDArray[np.float32]
    """Values of the image at the template's inner pixels."""
    left: NDArray[np.float32]
    """Residuals, 0 for ignored pixels."""
    seen: Mask | None
    """Which pixels are used; None for all."""
    inverse: Array
    """Inverse of the matrix of the normal equations, shape (12, 12)."""
    solution: Array
    """Eight parameters of the homography times gain, then gain, offset and two slopes."""
    settled: bool
    """Whether it has converged."""


def search_near(templates: tuple[PictureTemplate, ...], image: ImagePyramid, homography: Array) -> Array:
    """Return a predicted homography, shifted to the best fit of the smallest template near it."""
    template = templates[0]
    rows, columns = template.gray.shape
    from_pixel = homography @ template.plane_from_pixel
    from_around, size = from_pixel @ BEFORE, (columns + 2 * REACH, rows + 2 * REACH)
    around = _sample(image, _level(image, from_around, size), from_around, size)
    fit = cv2.matchTemplate(around, template.gray, cv2.TM_CCOEFF_NORMED)
    _, _, _, (x, y) = cv2.minMaxLoc(fit)
    dx, dy = _peak(fit[y, max(x - 1, 0) : x + 2].tolist()), _peak(fit[max(y - 1, 0) : y + 2, x].tolist())
    return np.asarray(from_pixel @ shift(x + dx - REACH, y + dy - REACH) @ template.pixel_from_plane)


def align(
    templates: tuple[PictureTemplate, ...], image: ImagePyramid, homography: Array, *, whole: bool = False
) -> Alignment | None:
    """Return the refined alignment of a picture near an initial guess, or None if it is not visible.

    Args:
        templates: Templates of the picture.
        image: Image of the camera.
        homography: Initial guess, from the plane of the picture [m] to the image [px], shape (3, 3).
        whole: Require all of it to be visible.
    """
    found = _align_from(templates, image, homography, whole)
    if found is not None:
        return found
    # The smallest template corrects a guess that is too far off for the template of the right size.
    rough = _refine(templates[0], image, homography, hidden=None)
    return None if rough is None else _align_from(templates, image, rough.homography, whole)


def _align_from(
    templates: tuple[PictureTemplate, ...], image: ImagePyramid, homography: Array, whole: bool
) -> Alignment | None:
    """Return the alignment of a picture by the template of its size in the image; None if it is not visible."""
    template = templates[_fitting(templates, homography)]
    fit = _refine(template, image, homography, hidden=None)
    if fit is None or not fit.settled:
        return None
    hidden = _hidden_tiles(template, fit)
    if hidden.any():
        fit = _refine(template, image, fit.homography, hidden=hidden)
    if fit is None or not fit.settled:
        return None
    found = _judge(template, fit)
    if found.correlation < NEEDED_CORRELATION:
        return None
    partly = fit.seen is not None
    return None if partly and (whole or not template.is_measurable(fit.inverse)) else found


def _peak(values: list[float]) -> float:
    """Return the maximum of the parabola through three values, relative to the middle one; 0 for two, at an edge."""
    if len(values) < 3:
        return 0.0
    before, top, after = values
    bend = before - 2.0 * top + after
    return 0.0 if bend >= 0.0 else 0.5 * (before - after) / bend


def _fitting(templates: tuple[PictureTemplate, ...], homography: Array) -> int:
    """Return the index of the template nearest in size to the picture in the image."""
    corners = templates[0].corners
    area = max(quadrilateral_area(apply_homography(homography, corners)), 1.0)
    side = math.sqrt(area / quadrilateral_area(corners)) * 2.0 / templates[0].unit
    return min(range(len(templates)), key=lambda index: abs(math.log(templates[index].side / side)))


def _level(image: ImagePyramid, image_from_pixel: Array, size: tuple[int, int]) -> int:
    """Return the level of the image with the same detail as a template of a size [px]."""
    # At the middle a pixel covers an area of det H / w^3: the determinant of the homography's derivative.
    g, h, i = image_from_pixel[2].tolist()
    w = g * size[0] / 2.0 + h * size[1] / 2.0 + i
    return image.level(abs(cv2.determinant(image_from_pixel)) / w**3)


def _sample(image: ImagePyramid, level: int, image_from_pixel: Array, size: tuple[int, int]) -> Gray:
    """Return a level of the image sampled at the pixels of a template of a size [px]."""
    mapping = image_from_pixel * LEVEL_FROM_IMAGE[level]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    sampled = cv2.warpPerspective(image.image(level), mapping, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(sampled, dtype=np.uint8)


def _refine(template: PictureTemplate, image: ImagePyramid, homography: Array, *, hidden: Mask | None) -> _Fit | None:
    """Return the last step of the iteration; None if the picture is lost."""
    plane_from_inner = template.plane_from_inner
    level = _level(image, homography @ plane_from_inner, template.inner_size)
    change = math.inf
    for _ in range(STEPS):
        image_from_inner = homography @ plane_from_inner
        values = _sample(image, level, image_from_inner, template.inner_size).reshape(-1).astype(np.float32)
        if change > SAME_PIXELS:
            seen = _seen(template, image.size, image_from_inner, hidden)
            found = _equations(template, seen)
            if found is None:
                return None
            design, inverse = found
        solution = inverse @ (design @ (values if seen is None else values[seen]))
        gain = float(solution[8])
        if gain < 0.1:
            return None
        p = [STRIDE * min(max(value / gain, -0.3), 0.3) for value in solution[:8].tolist()]
        homography = homography @ cv2.invert(_correction(p, template.unit))[1]
        change = max(map(abs, p))
        settled = change < SETTLED
        if settled:
            break
    left = values - solution.astype(np.float32) @ template.design
    if seen is not None:
        left *= seen
    return _Fit(homography / homography[2, 2], values, left, seen, inverse, solution, settled)


def _equations(template: PictureTemplate, seen: Mask | None) -> tuple[NDArray[np.float32], Array] | None:
    """Return the design matrix of visible pixels and the inverse of its normal matrix; None if there are too few."""
    if seen is None:
        return template.design, template.inverse
    if np.count_nonzero(seen) < MIN_SEEN * len(seen):
        return None
    design = template.design[:, seen]
    inverse = inverse_of((design @ design.T).astype(float))
    return None if inverse is None else (design, inverse)


def _correction(p: list[float], unit: float) -> Array:
    """Return a correction, eight numbers in unit coordinates [1/m], as a homography of the plane [m], shape (3, 3)."""
    a, b, c, d, e, f, g, h = p
    return np.array([[1.0 + a, b, c / unit], [d, 1.0 + e, f / unit], [g * unit, h * unit, 1.0]])


def _seen(
    template: PictureTemplate, size: tuple[int, int], image_from_inner: Array, hidden: Mask | None
) -> Mask | None:
    """Return which inner pixels are inside the image and not occluded; None if all are."""
    columns, rows = template.inner_size
    shown = None if hidden is None else ~hidden[template.tiles]
    # Distances from the edges of the image, times the depth, are linear in the pixels of the template.
    x, y, w = image_from_inner * np.sign(image_from_inner[2] @ (columns / 2.0, rows / 2.0, 1.0))
    edges = [edge.tolist() for edge in (x - w, y - w, (size[0] - 2.0) * w - x, (size[1] - 2.0) * w - y)]
    if min(min(c, c + a * columns) + min(0.0, b * rows) for a, b, c in edges) >= 0.0:
        return shown
    inside: Mask = np.ones((rows, columns), dtype=bool)
    for a, b, c in edges:
        inside &= np.add.outer(np.arange(rows) * b + c, np.arange(columns) * a) >= 0.0
    return inside.ravel() if shown is None else inside.ravel() & shown


def _hidden_tiles(template: PictureTemplate, fit: _Fit) -> Mask:
    """Return for each tile whether it is occluded, shape (TILES^2,)."""
    left = fit.left
    limit = TILE_MISFIT * fit.solution[8] ** 2 * template.contrast
    if float(left @ left) < limit * template.least_pixels:
        return np.zeros(TILES**2, dtype=bool)
    return np.asarray(np.bincount(template.tiles, weights=left**2, minlength=TILES**2) > limit * template.tile_pixels)


def _judge(template: PictureTemplate, fit: _Fit) -> Alignment:
    """Return the alignment of the last step, with its covariance and correlation.

    References:
        Liang, Zeger, Biometrika 73(1), 1986: covariance of a fit with errors that are correlated within blocks.
    """
    values, own = fit.values, template.own
    if fit.seen is not None:
        values, own = values[fit.seen], own[fit.seen]
    left = np.zeros((len(template.blocks), BLOCK**2, 1), dtype=np.float32)
    left.ravel()[template.places] = fit.left
    # Block by block: large products of thin matrices would wake all threads of the linear algebra.
    pulls = fit.inverse[:8] @ np.matmul(template.blocks, left)[..., 0].T
    correction = pulls @ pulls.T / fit.solution[8] ** 2
    D = corners_by_correction(template, fit.homography)
    seen_area = quadrilateral_area(apply_homography(fit.homography, template.corners))
    return Alignment(
        homography=fit.homography,
        covariance=D @ correction @ D.T,
        correlation=_correlation(values, own),
        seen=len(own) / len(template.own),
        pixel=float(np.sqrt(max(seen_area, 1.0) / template.gray.size)),
    )


def _correlation(one: NDArray[np.float32], other: NDArray[np.float32]) -> float:
    """Return the correlation of two rows of values, from -1 to 1."""
    a, b = one - one.sum() / len(one), other - other.sum() / len(other)
    return float(a @ b / np.sqrt(max(float(a @ a) * float(b @ b), 1e-9)))
