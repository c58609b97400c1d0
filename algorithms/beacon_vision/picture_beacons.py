"""Recognises flat pictures of known size in a camera's image, and measures their poses."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture

from .picture_features import PictureCandidate, find_candidates, image_features, make_bank
from .picture_gauge import FoundPicture, PictureGauge, PreparedImage, gray_of
from .picture_likeness import Likeness, equal_pictures, likenesses
from .picture_templates import quadrilateral_area
from .planar_pose import image_from_plane

CLEAR = 0.02
"""Margin by which a picture must explain its image better than any other."""
SMALLER_PART = 0.7
"""Area, relative to this picture's, below which another picture is a part of this one and is discarded."""

__all__ = ["FoundPicture", "PictureBeacons", "PreparedImage"]


class PictureBeacons:
    """Finds pictures of a catalogue in a camera's image and measures their poses.

    `detect` searches a whole image; `search` does the same and gives complete poses; `track` searches for one picture
    near a predicted pose, at a tenth of the cost.
    """

    def __init__(self, pictures: Mapping[str, tuple[Picture, float]]) -> None:
        """Prepare the detector.

        Args:
            pictures: RGB picture, shape (height, width, 3), and its width [m], by name.
        """
        grays = {name: (gray_of(picture), width) for name, (picture, width) in pictures.items()}
        gauges = {name: PictureGauge(name, gray, width) for name, (gray, width) in grays.items()}
        self._equal = equal_pictures({name: grays[name][0] for name, gauge in gauges.items() if gauge.templates})
        # Only the first of equal pictures is searched for, so that it is not mistaken for a third, similar one.
        self._names = tuple(self._equal)
        self._gauges = {name: gauges[name] for name in self._names}
        searched = [grays[name] for name in self._names]
        self._bank = make_bank(searched)
        self._likenesses: dict[str, list[Likeness]] = {name: [] for name in self._names}
        for each in likenesses(searched, self._bank, [gauge.templates for gauge in self._gauges.values()]):
            self._likenesses[self._names[each.shown]].append(each)

    @property
    def alike(self) -> list[tuple[str, str, float]]:
        """Pairs of pictures that can be confused, and the share of one that the other explains, at most 1."""
        equal = [(first, name, 1.0) for first, group in self._equal.items() for name in group[1:]]
        found = [each for likenesses in self._likenesses.values() for each in likenesses]
        return equal + [(self._names[each.shown], self._names[each.taken], each.explained) for each in found]

    def is_searched(self, name: str) -> bool:
        """Return whether a picture can be found: it is not plain, and not equal to an earlier one."""
        return name in self._gauges

    def detect(self, image: Picture, intrinsics: Intrinsics) -> list[Detection]:
        """Return the pictures in an RGB image, in the order of the catalogue."""
        return [found.detection for found in self.search(PreparedImage(image, intrinsics))]

    def search(
        self, view: PreparedImage, *, known: Sequence[FoundPicture] = (), only: str | None = None
    ) -> list[FoundPicture]:
        """Return pictures found in a whole view, without known ones and those that can be mistaken for others.

        Args:
            view: The image.
            known: Pictures in it that are known.
            only: Search for this picture alone, even if it can be mistaken for others.
        """
        features = image_features(view.gray)
        fresh = np.ones(len(features.points), dtype=bool)
        for picture in known:
            fresh &= ~_inside(picture.detection.corners, features.points)
        unknown = np.ones(len(self._names), dtype=bool)
        ours = [picture.detection.name for picture in known if picture.detection.name in self._gauges]
        unknown[[self._names.index(name) for name in ours]] = False
        if only is not None:
            unknown &= np.array([name == only for name in self._names])
        candidates = find_candidates(self._bank.of(unknown), features.only(fresh))
        found = (self._confirm(candidate, view) for candidate in candidates)
        return [picture for picture in found if picture is not None and (only or self._is_it(picture, view))]

    def track(self, name: str, rotation: Array, position: Array, view: PreparedImage) -> FoundPicture | None:
        """Return a picture near a predicted pose in the camera's frame, or None if it is not visible.

        Args:
            name: Name of the picture.
            rotation: camera_from_picture as predicted, shape (3, 3).
            position: Its centre as predicted, shape (3,) [m].
            view: The image.
        """
        return self._gauges[name].near(rotation, position, view)

    def _confirm(self, candidate: PictureCandidate, view: PreparedImage) -> FoundPicture | None:
        homography, _ = cv2.findHomography(candidate.plane, candidate.image, cv2.RANSAC, 3.0, maxIters=500)
        if homography is None:
            return None
        return self._gauges[self._names[candidate.picture]].at(np.asarray(homography), view)

    def _is_it(self, found: FoundPicture, view: PreparedImage) -> bool:
        """Return whether no other picture explains the same place about as well."""
        name, own = found.detection.name, quadrilateral_area(found.detection.corners)
        if len(self._equal[name]) > 1:
            return False
        for likeness in self._likenesses[name]:
            image_from_own = image_from_plane(found.pose.rotation, found.pose.position, view.intrinsics)
            gauge = self._gauges[self._names[likeness.taken]]
            other = gauge.at(image_from_own @ likeness.shown_from_taken, view)
            # One that is a part of this picture explains less.
            larger = other is not None and quadrilateral_area(other.detection.corners) > SMALLER_PART * own
            if other is not None and larger and other.explained > found.explained - CLEAR:
                return False
        return True


def _inside(corners: Array, points: Array) -> NDArray[np.bool_]:
    """Return which points, shape (n, 2), are inside corners that are clockwise in the image, shape (4, 2)."""
    inside = np.ones(len(points), dtype=bool)
    for start, stop in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        (dx, dy), away = stop - start, points - start
        inside &= dx * away[:, 1] - dy * away[:, 0] > 0.0
    return inside
