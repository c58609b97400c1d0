"""Recognising flat pictures of known size in a camera's image, and measuring where they hang."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture

from .picture_alignment import align, search_near
from .picture_features import Candidate, find_candidates, image_features, make_bank
from .picture_templates import Gray, ImagePyramid, Template, apply_homography, make_templates, quadrilateral_area
from .planar_pose import PlanarPose, fit_pose, image_from_plane

MOST_TILT_DEG = 68.0
"""Between the line of sight and the picture's normal."""
LEAST_SIDE = 20.0
"""Of a picture in the image, the root of its area [px]."""

CORNER_FLOOR = 0.006
"""What no number of pixels averages away, standard deviation of each coordinate of a corner [pixels compared]."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundPicture:
    """A picture that was found, with its whole pose."""

    detection: Detection
    pose: PlanarPose
    correlation: float
    """With its image, at most 1."""


class PictureBeacons:
    """Finds pictures of a catalogue in a camera's image and measures where they are.

    `detect` looks at an image with no idea of where the pictures are; `search` gives their whole poses, and
    `track` looks for one picture where it should be, which costs a tenth.
    """

    def __init__(self, pictures: Mapping[str, tuple[Picture, float]]) -> None:
        """Prepare to look for pictures.

        Args:
            pictures: RGB picture, shape (height, width, 3), and its width [m], by name.
        """
        self._names = tuple(pictures)
        grays = [(_gray(picture), width) for picture, width in pictures.values()]
        self._sizes = [(width, width * gray.shape[0] / gray.shape[1]) for gray, width in grays]
        self._bank = make_bank(grays)
        self._templates: list[tuple[Template, ...]] = [make_templates(gray, width) for gray, width in grays]

    def detect(self, image: Picture, intrinsics: Intrinsics) -> list[Detection]:
        """Return the pictures that are seen in an RGB image, in the order of the catalogue."""
        return [found.detection for found in self.search(View(image, intrinsics))]

    def search(self, view: "View", *, known: Sequence[FoundPicture] = ()) -> list[FoundPicture]:
        """Return pictures found in a view with no idea of where they are, leaving out those that are known."""
        features = image_features(view.gray)
        fresh = np.ones(len(features.points), dtype=bool)
        for picture in known:
            fresh &= ~_inside(picture.detection.corners, features.points)
        unknown = np.ones(len(self._names), dtype=bool)
        unknown[[self._names.index(picture.detection.name) for picture in known]] = False
        candidates = find_candidates(self._bank.of(unknown), features.only(fresh))
        found = (self._confirm(candidate, view) for candidate in candidates)
        return [picture for picture in found if picture is not None]

    def track(self, name: str, rotation: Array, position: Array, view: "View") -> FoundPicture | None:
        """Return a picture that should be near a pose in the camera's frame, or None when it is not there.

        Args:
            name: Of the picture.
            rotation: camera_from_picture as predicted, shape (3, 3).
            position: Its middle as predicted, shape (3,) [m].
            view: Where to look.
        """
        index = self._names.index(name)
        homography = image_from_plane(rotation, position, view.intrinsics)
        if not self._plausible(index, homography, view.intrinsics):
            return None
        near = search_near(self._templates[index], view.pyramid, homography)
        return self._measure(index, near, view, guess=(rotation, position))

    def _confirm(self, candidate: Candidate, view: "View") -> FoundPicture | None:
        homography, _ = cv2.findHomography(candidate.plane, candidate.image, cv2.RANSAC, 3.0, maxIters=500)
        if homography is None or not self._plausible(candidate.picture, np.asarray(homography), view.intrinsics):
            return None
        return self._measure(candidate.picture, np.asarray(homography), view)

    def _plausible(self, index: int, homography: Array, intrinsics: Intrinsics) -> bool:
        """Tell whether a homography shows the picture's front, not too small, and enough of it in the image."""
        corners = self._templates[index][0].corners
        depth = corners @ homography[2, :2] + homography[2, 2]
        if depth.max() * depth.min() <= 0.0:
            return False
        seen = apply_homography(homography, corners)
        area = quadrilateral_area(seen)
        if area < LEAST_SIDE**2:
            return False
        inside = np.clip(seen, 0.0, (intrinsics.width - 1.0, intrinsics.height - 1.0))
        return quadrilateral_area(inside) > 0.5 * area

    def _measure(
        self, index: int, homography: Array, view: "View", *, guess: tuple[Array, Array] | None = None
    ) -> FoundPicture | None:
        """Return the picture with its pose when it lies in the image near a homography, else None."""
        alignment = align(self._templates[index], view.pyramid, homography)
        if alignment is None or not self._plausible(index, alignment.homography, view.intrinsics):
            return None
        outline = self._templates[index][0].corners
        covariance = alignment.covariance + (CORNER_FLOOR * alignment.pixel) ** 2 * np.eye(8)
        pose = fit_pose(
            apply_homography(alignment.homography, outline),
            covariance,
            self._sizes[index],
            view.intrinsics,
            guess=guess,
        )
        sight = pose.position / np.linalg.norm(pose.position)
        if pose.position[2] <= 0.0 or pose.rotation[:, 2] @ sight < np.cos(np.radians(MOST_TILT_DEG)):
            return None
        fitted = apply_homography(image_from_plane(pose.rotation, pose.position, view.intrinsics), outline)
        detection = Detection(self._names[index], pose.position, pose.covariance[:3, :3], fitted)
        return FoundPicture(detection, pose, alignment.correlation)


class View:
    """A camera's image, with what is made of it only once."""

    def __init__(self, image: Picture, intrinsics: Intrinsics) -> None:
        """Take an RGB image, shape (height, width, 3)."""
        self.intrinsics = intrinsics
        self.gray = _gray(image)
        self.pyramid: ImagePyramid = ImagePyramid(self.gray)


def _gray(picture: Picture) -> Gray:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)


def _inside(corners: Array, points: Array) -> NDArray[np.bool_]:
    """Return which points, shape (n, 2), are inside corners given clockwise as seen, shape (4, 2)."""
    inside = np.ones(len(points), dtype=bool)
    for start, stop in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        (dx, dy), away = stop - start, points - start
        inside &= dx * away[:, 1] - dy * away[:, 0] > 0.0
    return inside
