"""Finds pictures in a camera's image without a prior of their pose: binary features, matching and voting.

References:
    Rublee, Rabaud, Konolige, Bradski, ORB: an efficient alternative to SIFT or SURF, ICCV 2011.
    Morel, Yu, ASIFT, SIAM Journal on Imaging Sciences 2(2), 2009, for features of rotated views.
    Lowe, Distinctive Image Features, IJCV 60(2), 2004, section 7, for the votes.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array

Gray = NDArray[np.uint8]

TEMPLATE_SIDE = 150
"""Long side of a picture when its features are extracted [px]."""
VIEWS_DEG = {0.0: 90, -48.0: 65, 48.0: 65}
"""Rotations about the vertical axis at which features of a picture are extracted -> number of features."""
IMAGE_FEATURES = 900
ENLARGE = 1.5
"""Enlargement of the camera's image before features are extracted, so that distant pictures are found."""
RIM, RIM_GRAY = 18, 220.0
"""Width of the border around a picture, which keeps features near its edge [px], and its gray."""
LIKELY_BITS = 12
"""Two descriptors are compared in full if at most this many of their first 64 bits differ."""
MATCH_BITS = 64
"""Maximum number of the 256 bits that differ in a match."""
CHUNK = 32
"""Rows compared at a time, so that the result stays in the processor's cache."""
VOTES = 6
"""Matches that must agree on a picture's place."""


@dataclass(frozen=True, slots=True, eq=False)
class Features:
    """Features of an image or of many pictures, one row each."""

    descriptors: NDArray[np.uint64]
    """Shape (n, 4)."""
    points: Array
    """Positions, shape (n, 2); pixels of the image, or metres in the plane of the picture."""
    angles: Array
    """Direction [deg]."""
    sizes: Array
    """Diameter of the patch [px of the image, or of the rotated view]."""

    def only(self, chosen: NDArray[np.bool_] | NDArray[np.intp]) -> "Features":
        """Return the chosen rows."""
        return Features(self.descriptors[chosen], self.points[chosen], self.angles[chosen], self.sizes[chosen])


@dataclass(frozen=True, slots=True, eq=False)
class Bank:
    """Features of all pictures that are searched for."""

    features: Features
    owners: NDArray[np.intp]
    """Index of the picture of each feature."""
    to_middle: Array
    """Vector from the feature to the picture's center in its view, shape (n, 2) [px of that view]."""
    front: NDArray[np.bool_]
    """Whether that view is from the front."""

    def of(self, pictures: NDArray[np.bool_]) -> "Bank":
        """Return the features of the chosen pictures."""
        return self.only(pictures[self.owners])

    def only(self, chosen: NDArray[np.bool_]) -> "Bank":
        """Return the chosen rows."""
        return Bank(self.features.only(chosen), self.owners[chosen], self.to_middle[chosen], self.front[chosen])


@dataclass(frozen=True, slots=True, eq=False)
class PictureCandidate:
    """A picture that may be in the image."""

    picture: int
    plane: Array
    """Points in the plane of the picture, shape (n, 2) [m]."""
    image: Array
    """The same points in the image, shape (n, 2) [px]."""


def make_bank(pictures: Sequence[tuple[Gray, float]]) -> Bank:
    """Return the features of gray pictures of given widths [m], each seen from the front and from both sides."""
    parts = [
        _view_features(index, gray, width, yaw_deg, count)
        for index, (gray, width) in enumerate(pictures)
        for yaw_deg, count in VIEWS_DEG.items()
    ]
    return Bank(
        Features(
            np.concatenate([np.zeros((0, 4), dtype=np.uint64), *(part.features.descriptors for part in parts)]),
            np.concatenate([np.zeros((0, 2)), *(part.features.points for part in parts)]),
            np.concatenate([np.zeros(0), *(part.features.angles for part in parts)]),
            np.concatenate([np.zeros(0), *(part.features.sizes for part in parts)]),
        ),
        np.concatenate([np.zeros(0, dtype=np.intp), *(part.owners for part in parts)]),
        np.concatenate([np.zeros((0, 2)), *(part.to_middle for part in parts)]),
        np.concatenate([np.zeros(0, dtype=bool), *(part.front for part in parts)]),
    )


def image_features(gray: Gray) -> Features:
    """Return the features of a camera's image."""
    large = np.asarray(cv2.resize(gray, None, fx=ENLARGE, fy=ENLARGE, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)
    found = _detect(large, IMAGE_FEATURES, levels=8)
    # Pixel centres are at whole numbers in both images.
    points = (found.points + 0.5) / ENLARGE - 0.5
    return Features(found.descriptors, points, found.angles, found.sizes / ENLARGE)


def find_candidates(bank: Bank, image: Features, *, of_each: bool = False) -> list[PictureCandidate]:
    """Return the pictures for which enough matches agree on place, size and direction; at most one place each.

    Args:
        bank: Features of the pictures.
        image: Features of the image.
        of_each: Match a feature of the image with the nearest one of every picture, not only with the nearest of all.
    """
    owners = bank.owners if of_each else None
    rows, entries = match(image.descriptors, bank.features.descriptors, owners)
    scales = image.sizes[rows] / bank.features.sizes[entries]
    turns = np.radians(image.angles[rows] - bank.features.angles[entries])
    x, y = bank.to_middle[entries].T * scales
    c, s = np.cos(turns), np.sin(turns)
    middles = image.points[rows] + np.stack([c * x - s * y, s * x + c * y], axis=1)
    candidates = []
    for picture in np.flatnonzero(np.bincount(bank.owners[entries], minlength=1) >= VOTES):
        mine = np.flatnonzero(bank.owners[entries] == picture)
        agreeing = mine[_largest_agreement(middles[mine], scales[mine], turns[mine])]
        if len(agreeing) >= VOTES:
            plane, places = bank.features.points[entries[agreeing]], image.points[rows[agreeing]]
            candidates.append(PictureCandidate(int(picture), plane, places))
    return candidates


def match(
    rows: NDArray[np.uint64], entries: NDArray[np.uint64], owners: NDArray[np.intp] | None = None
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of similar descriptors: for each row at most its nearest entry, or its nearest of each owner.

    Comparing the first 64 bits leaves one pair in a thousand to compare in full.
    """
    first_rows, first_entries = np.ascontiguousarray(rows[:, :1]), np.ascontiguousarray(entries[:, 0])
    candidates = [np.zeros(0, dtype=np.intp)]
    for start in range(0, len(rows), CHUNK):
        bits_apart = np.bitwise_count(first_rows[start : start + CHUNK] ^ first_entries)
        candidates.append(np.flatnonzero(bits_apart <= LIKELY_BITS) + start * len(entries))
    row, entry = np.divmod(np.concatenate(candidates), max(len(entries), 1))
    bits = np.bitwise_count(rows[row] ^ entries[entry]).sum(axis=1, dtype=np.intp)
    group = row if owners is None else row * (owners.max(initial=0) + 1) + owners[entry]
    order = np.lexsort((entry, bits, group))
    order = order[bits[order] <= MATCH_BITS]
    first = order[np.unique(group[order], return_index=True)[1]]
    return row[first], entry[first]


def _largest_agreement(middles: Array, scales: Array, turns: Array) -> NDArray[np.intp]:
    """Return the largest set of matches that agree with a single match."""
    distances = np.linalg.norm(middles[:, None] - middles[None], axis=2)
    # A quarter of the picture's size, according to the larger of the two matches.
    close = distances < 0.25 * TEMPLATE_SIDE * np.maximum(scales[:, None], scales[None])
    similar = np.abs(np.log(scales[:, None] / scales[None])) < np.log(1.8)
    turned = np.cos(turns[:, None] - turns[None]) > np.cos(np.radians(30.0))
    agree = close & similar & turned
    return np.flatnonzero(agree[np.argmax(agree.sum(axis=1))])


def _detect(gray: Gray, count: int, *, levels: int) -> Features:
    orb = cv2.ORB.create(count, 1.25, levels, 16, 0, 2, cv2.ORB_HARRIS_SCORE, 31, 20)
    keypoints, descriptors = orb.detectAndCompute(gray, None)
    if not keypoints:
        return Features(np.zeros((0, 4), dtype=np.uint64), np.zeros((0, 2)), np.zeros(0), np.zeros(0))
    return Features(
        np.ascontiguousarray(descriptors).view(np.uint64),
        np.array([keypoint.pt for keypoint in keypoints]),
        np.array([keypoint.angle for keypoint in keypoints]),
        np.array([keypoint.size for keypoint in keypoints]),
    )


def _view_features(picture: int, gray: Gray, width: float, yaw_deg: float, count: int) -> Bank:
    """Return the features of one picture seen under a yaw angle."""
    scale = TEMPLATE_SIDE / max(gray.shape)
    small = cv2.resize(gray, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    view_from_small = _turned_view(small.shape[1], small.shape[0], np.radians(yaw_deg))
    h, w = small.shape
    outline = np.array([[[-0.5, -0.5], [w - 0.5, -0.5], [w - 0.5, h - 0.5], [-0.5, h - 0.5]]])
    corners = cv2.perspectiveTransform(outline, view_from_small)[0]
    shift = np.eye(3)
    shift[:2, 2] = RIM - corners.min(axis=0)
    view_from_small = shift @ view_from_small
    extent = np.ceil(corners.max(axis=0) - corners.min(axis=0) + 2 * RIM).astype(int).tolist()
    view = cv2.warpPerspective(
        small, view_from_small, extent, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(RIM_GRAY,)
    )
    found = _detect(np.asarray(view, dtype=np.uint8), count, levels=6)
    middle = cv2.perspectiveTransform(np.array([[[(w - 1) / 2.0, (h - 1) / 2.0]]]), view_from_small)[0]
    in_small = found.points
    if len(found.points):
        in_small = cv2.perspectiveTransform(found.points[None], np.linalg.inv(view_from_small))[0]
    plane = (in_small - ((w - 1) / 2.0, (h - 1) / 2.0)) * (width / w)
    features = Features(found.descriptors, plane, found.angles, found.sizes)
    owners, front = np.full(len(plane), picture, dtype=np.intp), np.full(len(plane), yaw_deg == 0.0)
    return Bank(features, owners, middle - found.points, front)


def _turned_view(width: int, height: int, yaw: float) -> Array:
    """Return the homography from a picture [px] to its view turned by yaw, from 2.2 times its size away."""
    c, s, away = np.cos(yaw), np.sin(yaw), 2.2 * max(width, height)
    return np.array(
        [
            [away * c, 0.0, -away * c * width / 2.0],
            [0.0, away, -away * height / 2.0],
            [s, 0.0, away - s * width / 2.0],
        ]
    )
