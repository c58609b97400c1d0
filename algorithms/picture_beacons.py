"""Recognising flat pictures of known size in a camera's image, and measuring where they hang."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture

from .picture_alignment import (
    Alignment,
    ImagePyramid,
    Template,
    align,
    apply_homography,
    make_pyramid,
    make_templates,
    quadrilateral_area,
    search_near,
    template_corners,
)
from .picture_features import Candidate, find_candidates, image_features, make_bank
from .planar_pose import PlanarPose, fit_pose, image_from_plane

NEEDED_CORRELATION = 0.8
"""Of a picture with its image, for it to be reported."""
MOST_TILT_DEG = 68.0
"""Between the line of sight and the picture's normal."""
LEAST_SIDE = 20.0
"""Of a picture in the image, the root of its area [px]."""


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

    def search(self, view: "View", *, known: Collection[str] = ()) -> list[FoundPicture]:
        """Return the pictures found in a view without any idea of where they are, leaving out the known ones."""
        found = []
        for candidate in find_candidates(self._bank, image_features(view.gray)):
            if self._names[candidate.picture] in known:
                continue
            picture = self._confirm(candidate, view)
            if picture is not None:
                found.append(picture)
        return found

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
        return self._measure(index, align(self._templates[index], view.pyramid, near, coarse=True), view)

    def _confirm(self, candidate: Candidate, view: "View") -> FoundPicture | None:
        homography, _ = cv2.findHomography(candidate.plane, candidate.image, cv2.RANSAC, 3.0, maxIters=500)
        if homography is None or not self._plausible(candidate.picture, np.asarray(homography), view.intrinsics):
            return None
        templates = self._templates[candidate.picture]
        return self._measure(
            candidate.picture, align(templates, view.pyramid, np.asarray(homography), coarse=True), view
        )

    def _plausible(self, index: int, homography: Array, intrinsics: Intrinsics) -> bool:
        """Tell whether a homography shows the picture from its front, not too small and not too much aslant."""
        corners = template_corners(self._templates[index][-1])
        depth = corners @ homography[2, :2] + homography[2, 2]
        if np.min(depth * np.sign(depth[0])) <= 0.0:
            return False
        seen = apply_homography(homography, corners)
        turns = np.roll(seen, -1, axis=0) - seen
        after = np.roll(turns, -1, axis=0)
        convex = np.all(turns[:, 0] * after[:, 1] - turns[:, 1] * after[:, 0] > 0.0)
        if not convex or quadrilateral_area(seen) < LEAST_SIDE**2:
            return False
        inside = np.clip(seen, 0.0, (intrinsics.width - 1.0, intrinsics.height - 1.0))
        return quadrilateral_area(inside) > 0.3 * quadrilateral_area(seen)

    def _measure(self, index: int, alignment: Alignment | None, view: "View") -> FoundPicture | None:
        """Return the picture with its pose when it fits its image, else None."""
        if alignment is None or alignment.correlation < NEEDED_CORRELATION:
            return None
        if not self._plausible(index, alignment.homography, view.intrinsics):
            return None
        corners = apply_homography(alignment.homography, template_corners(self._templates[index][-1]))
        pose = fit_pose(corners, alignment.information, self._sizes[index], view.intrinsics)
        sight = pose.position / np.linalg.norm(pose.position)
        if pose.position[2] <= 0.0 or pose.rotation[:, 2] @ sight < np.cos(np.radians(MOST_TILT_DEG)):
            return None
        fitted = apply_homography(
            image_from_plane(pose.rotation, pose.position, view.intrinsics),
            template_corners(self._templates[index][-1]),
        )
        detection = Detection(self._names[index], pose.position, pose.covariance[:3, :3], fitted)
        return FoundPicture(detection, pose, alignment.correlation)


class View:
    """A camera's image, with what is made of it only once."""

    def __init__(self, image: Picture, intrinsics: Intrinsics) -> None:
        """Take an RGB image, shape (height, width, 3)."""
        self.intrinsics = intrinsics
        self.gray = _gray(image)
        self.pyramid: ImagePyramid = make_pyramid(self.gray)


def _gray(picture: Picture) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
