"""Finds pictures that can be mistaken for others that look like them, or for shifted copies of themselves.

This needs only the pictures, before any image is seen. In an image, a picture that was found is then compared only
with the few that look like it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from mjsim.geometry import Array

from .picture_alignment import MIN_SEEN, NEEDED_CORRELATION, align
from .picture_features import RIM, RIM_GRAY, TEMPLATE_SIDE, Bank, PictureCandidate, find_candidates
from .picture_templates import Gray, ImagePyramid, PictureTemplate, apply_homography

REPEAT_SIDE = 64
"""Long side of a picture that is compared with itself [px]."""
COMPARED = 90, 8
"""Maximum and minimum number of features of a picture that are compared with those of others."""
MAX_COMPARISONS = 1e8
"""Number of comparisons of descriptors above which fewer features are used: a fraction of a second."""


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """A picture that looks like all or part of another one."""

    shown: int
    """Index of the picture."""
    taken: int
    """Index of the picture for which it can be mistaken."""
    shown_from_taken: Array
    """Homography between their planes, shape (3, 3) [m]."""
    explained: float
    """Share of the image that it explains, as in an alignment, at most 1."""


def repeats(gray: Gray) -> bool:
    """Return whether a picture looks like itself when it is shifted.

    That is: in an image of it, a shifted one would be accepted as partly hidden.
    """
    scale = REPEAT_SIDE / max(gray.shape)
    size = max(2, round(gray.shape[1] * scale)), max(2, round(gray.shape[0] * scale))
    small = np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA), dtype=float)
    correlation = correlation_by_shift(small)
    # A peak other than that at no shift; the slope of that one is no peak.
    highest = cv2.dilate(correlation, np.ones((3, 3)))
    peaks = np.argwhere((correlation >= highest) & (correlation > NEEDED_CORRELATION))
    apart = np.abs(peaks - np.array(correlation.shape) // 2).max(axis=1, initial=0) > 2
    return bool(apart.any())


def correlation_by_shift(small: Array) -> Array:
    """Return the correlation of a picture with itself shifted; 0 where too little of both overlaps.

    References:
        Lewis, Fast Normalized Cross-Correlation, 1995: the product by a Fourier transform, sums over the overlap by
        running sums.
    """
    rows, columns = small.shape
    values = small - small.mean()
    size = 2 * rows, 2 * columns
    product = np.fft.fftshift(np.fft.irfft2(np.abs(np.fft.rfft2(values, size)) ** 2, size))[1:, 1:]
    count = np.maximum(_sums_over_overlap(np.ones_like(small)), 1.0)
    own, own_squares = _sums_over_overlap(values), _sums_over_overlap(values**2)
    # The overlap in the shifted picture is the one for the opposite shift.
    other, other_squares = own[::-1, ::-1], own_squares[::-1, ::-1]
    # A plain overlap correlates with nothing.
    floor = 1e-3 * float((values**2).mean()) * count + 1e-6
    variances = np.maximum(own_squares - own**2 / count, floor), np.maximum(other_squares - other**2 / count, floor)
    correlation = (product - own * other / count) / np.sqrt(variances[0] * variances[1])
    return np.where(count >= MIN_SEEN * rows * columns, correlation, 0.0)


def _sums_over_overlap(values: Array) -> Array:
    """Return the sum of the values that overlap a shifted copy, by shift: (2 rows - 1, 2 columns - 1)."""
    for _ in range(values.ndim):  # along one axis, then along the other
        sums = np.cumsum(values, axis=0)
        values = np.concatenate([sums, sums[-1] - sums[:-1]]).T
    return values


def equal_pictures(grays: Mapping[str, Gray]) -> dict[str, list[str]]:
    """Return the names of equal pictures by the first of them; a picture without an equal is alone."""
    groups: dict[tuple[tuple[int, ...], bytes], list[str]] = {}
    for name, gray in grays.items():
        groups.setdefault((gray.shape, gray.tobytes()), []).append(name)
    return {names[0]: names for names in groups.values()}


def likenesses(
    pictures: Sequence[tuple[Gray, float]], bank: Bank, templates: Sequence[tuple[PictureTemplate, ...]]
) -> list[Likeness]:
    """Return which pictures can be taken for which others.

    Args:
        pictures: In gray, with their widths [m].
        bank: Their features.
        templates: Their templates, at least one each.
    """
    found: dict[tuple[int, int], Likeness] = {}
    for shown, (gray, width) in enumerate(pictures):
        view, view_from_shown = _view_of(gray, width)
        for candidate in _similar(shown, bank, view_from_shown):
            taken = candidate.picture
            rough, _ = cv2.findHomography(candidate.plane, candidate.image, cv2.RANSAC, 3.0)
            alignment = None if rough is None else align(templates[taken], view, np.asarray(rough))
            if alignment is not None:
                shown_from_taken = np.asarray(np.linalg.inv(view_from_shown) @ alignment.homography)
                found[shown, taken] = Likeness(shown, taken, shown_from_taken, alignment.explained)
    # If one is a part of the other, it is found in the other, not the other way round.
    for (shown, taken), each in list(found.items()):
        back = Likeness(taken, shown, np.asarray(np.linalg.inv(each.shown_from_taken)), each.explained)
        found.setdefault((taken, shown), back)
    return [found[pair] for pair in sorted(found)]


def _view_of(gray: Gray, width: float) -> tuple[ImagePyramid, Array]:
    """Return an image of a picture from the front, and the homography from its plane [m], shape (3, 3)."""
    scale = TEMPLATE_SIDE / max(gray.shape)
    small = cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    view = cv2.copyMakeBorder(small, RIM, RIM, RIM, RIM, cv2.BORDER_CONSTANT, value=(RIM_GRAY,))
    rows, columns = small.shape
    k, x, y = columns / width, (columns - 1) / 2.0 + RIM, (rows - 1) / 2.0 + RIM
    return ImagePyramid(np.asarray(view, dtype=np.uint8)), np.array([[k, 0.0, x], [0.0, k, y], [0.0, 0.0, 1.0]])


def _similar(shown: int, bank: Bank, view_from_shown: Array) -> list[PictureCandidate]:
    """Return other pictures that share features with one, at the same places; only views from the front count."""
    count = int(bank.owners.max()) + 1
    most, least = COMPARED
    compared = int(np.clip(MAX_COMPARISONS / (np.count_nonzero(bank.front) * count), least, most))
    mine = np.flatnonzero((bank.owners == shown) & bank.front)
    chosen = mine[np.unique(np.linspace(0, len(mine) - 1, compared).astype(int))] if len(mine) else mine
    points = apply_homography(view_from_shown, bank.features.points[chosen])
    view = replace(bank.features.only(chosen), points=points)
    return find_candidates(bank.only((bank.owners != shown) & bank.front), view, of_each=True)
