"""Measures the pose of one known flat picture whose position in the image is roughly known."""

from dataclasses import dataclass

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture

from .picture_alignment import align, search_near
from .picture_likeness import repeats
from .picture_templates import Gray, ImagePyramid, apply_homography, make_templates, quadrilateral_area
from .planar_pose import PlanarPose, fit_pose, image_from_plane, picture_corners

MAX_TILT_DEG = 68.0
"""Largest angle between the line of sight and the picture's normal."""
MIN_SIDE = 20.0
"""Smallest size of a picture in the image: the square root of its area [px]."""
CORNER_FLOOR = 0.006
"""Error of a picture's corners that does not average out over pixels, standard deviation of each coordinate
[pixels compared]; measured over thousands of views."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundPicture:
    """A picture that was found, with its whole pose."""

    detection: Detection
    pose: PlanarPose
    explained: float
    """How much of the image it explains, at most 1: its correlation times its visible part."""


class PreparedImage:
    """A camera's image with the data that is computed from it only once."""

    def __init__(self, image: Picture, intrinsics: Intrinsics) -> None:
        """Take an RGB image, shape (height, width, 3)."""
        self.intrinsics = intrinsics
        self.gray = gray_of(image)
        self.pyramid: ImagePyramid = ImagePyramid(self.gray)


class PictureGauge:
    """Compares one picture with an image and measures its pose."""

    def __init__(self, name: str, gray: Gray, width: float, *, floor: float = CORNER_FLOOR) -> None:
        """Make templates of a picture.

        Args:
            name: Name in its detections.
            gray: Shape (height, width).
            width: Width of the printed picture [m].
            floor: Error that does not average out over pixels, standard deviation of a corner [pixels compared].
        """
        self.name = name
        self._floor = floor
        self._size = width, width * gray.shape[0] / gray.shape[1]
        self._outline = picture_corners(*self._size)[:, :2]
        self.templates = make_templates(gray, width)
        """From small to large; empty for a picture that is plain or striped, which is never found."""
        # A shifted copy would be mistaken for a partly hidden picture.
        self._whole = repeats(gray)

    def near(self, rotation: Array, position: Array, view: PreparedImage) -> FoundPicture | None:
        """Return the picture when it is near a pose in the camera's frame, else None.

        Args:
            rotation: camera_from_picture as predicted, shape (3, 3).
            position: Its predicted center, shape (3,) [m].
            view: Image to search.
        """
        homography = image_from_plane(rotation, position, view.intrinsics)
        if not self._plausible(homography, view.intrinsics):
            return None
        guess = rotation, position
        found = self._measured(homography, view, guess=guess)
        if found is None:
            found = self._measured(search_near(self.templates, view.pyramid, homography), view, guess=guess)
        return found

    def at(self, homography: Array, view: PreparedImage) -> FoundPicture | None:
        """Return the picture with its pose when it lies in the image near a homography, else None.

        Args:
            homography: Homography from the picture's plane [m] to the image [px], shape (3, 3).
            view: Image to search.
        """
        return self._measured(homography, view) if self._plausible(homography, view.intrinsics) else None

    def _measured(
        self, homography: Array, view: PreparedImage, *, guess: tuple[Array, Array] | None = None
    ) -> FoundPicture | None:
        """Return the picture near a homography; its pose is fitted from a guess, (3, 3) and (3,), if given."""
        alignment = align(self.templates, view.pyramid, homography, whole=self._whole)
        if alignment is None or not self._plausible(alignment.homography, view.intrinsics):
            return None
        covariance = alignment.covariance + (self._floor * alignment.pixel) ** 2 * np.eye(8)
        corners = apply_homography(alignment.homography, self._outline)
        pose = fit_pose(corners, covariance, self._size, view.intrinsics, guess=guess)
        if pose is None:
            return None
        sight = pose.position / np.linalg.norm(pose.position)
        if pose.position[2] <= 0.0 or pose.rotation[:, 2] @ sight < np.cos(np.radians(MAX_TILT_DEG)):
            return None
        fitted = apply_homography(image_from_plane(pose.rotation, pose.position, view.intrinsics), self._outline)
        detection = Detection(self.name, pose.position, pose.covariance[:3, :3], fitted)
        return FoundPicture(detection, pose, alignment.explained)

    def _plausible(self, homography: Array, intrinsics: Intrinsics) -> bool:
        """Return whether a homography shows the picture's front, large enough, and enough of it in the image."""
        corners = self._outline
        depths = (corners @ homography[2, :2] + homography[2, 2]).tolist()
        if not self.templates or not max(depths) * min(depths) > 0.0:
            return False
        seen = apply_homography(homography, corners)
        area = quadrilateral_area(seen)
        if not area >= MIN_SIDE**2:
            return False
        inside = np.minimum(np.maximum(seen, 0.0), (intrinsics.width - 1.0, intrinsics.height - 1.0))
        return quadrilateral_area(inside) > 0.5 * area


def gray_of(picture: Picture) -> Gray:
    """Return an RGB picture in gray, shape (height, width)."""
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
