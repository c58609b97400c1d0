"""Square markers (ArUco and AprilTag): OpenCV decodes the identity, alignment with the picture gives the pose."""

from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from mjsim.geometry import Array
from mjsim.interface import Detection, Intrinsics, Picture

from .picture_gauge import FoundPicture, PictureGauge, PreparedImage
from .picture_templates import apply_homography
from .planar_pose import homography_between

MODULE = 12
"""Side of a module in the template [px]."""
FLOOR = 0.027
"""Standard deviation of a corner that more pixels do not reduce [px of the template]: hard edges between black and
white alias more than pictures; measured over thousands of views."""
DICTIONARIES = {
    **{f"{n}x{n}_{count}": f"DICT_{n}X{n}_{count}" for n in (4, 5, 6, 7) for count in (50, 100, 250, 1000)},
    **{f"apriltag_{name}": f"DICT_APRILTAG_{name}" for name in ("16h5", "25h9", "36h10", "36h11")},
    "original": "DICT_ARUCO_ORIGINAL",
    "mip_36h12": "DICT_ARUCO_MIP_36h12",
}
"""Name of a dictionary in world files -> name in OpenCV."""


class MarkerBeacons:
    """Finds the markers of one dictionary, all of one size.

    Detections are named by the marker's number, or by the name given for it.

    References:
        Garrido-Jurado et al., Automatic Generation and Detection of Highly Reliable Fiducial Markers under Occlusion,
        Pattern Recognition 47(6), 2014: candidates and their bits, in OpenCV.
    """

    def __init__(self, dictionary: str, width: float, *, names: Mapping[int, str] | None = None) -> None:
        """Prepare the detector.

        Args:
            dictionary: '4x4_50', 'apriltag_36h11' and so on.
            width: Width of the black square [m].
            names: Name by number; only these are reported. None for all markers, named by their numbers.

        Raises:
            ValueError: The dictionary does not exist.
        """
        if dictionary not in DICTIONARIES:
            raise ValueError(f"no dictionary '{dictionary}'; it must be one of {', '.join(DICTIONARIES)}")
        self._dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARIES[dictionary]))
        settings = cv2.aruco.DetectorParameters()
        settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
        settings.minMarkerPerimeterRate = 0.06
        settings.useAruco3Detection = False
        # Markers of other dictionaries may differ from one of these by only a bit or two: require all bits.
        settings.errorCorrectionRate = 0.0
        self._detector = cv2.aruco.ArucoDetector(self._dictionary, settings)
        self._width = width
        self._names = names
        self._gauges: dict[str, PictureGauge] = {}

    def detect(self, image: Picture, intrinsics: Intrinsics) -> list[Detection]:
        """Return the markers in an RGB image."""
        return [found.detection for found in self.search(PreparedImage(image, intrinsics))]

    def search(self, view: PreparedImage, *, known: Sequence[FoundPicture] = ()) -> list[FoundPicture]:
        """Return markers found in a whole view, leaving out known ones."""
        corners, numbers, _ = self._detector.detectMarkers(view.gray)
        taken = {picture.detection.name for picture in known}
        found: dict[str, FoundPicture] = {}
        for outline, number in zip(corners, () if numbers is None else map(int, numbers.ravel()), strict=True):
            name = str(number) if self._names is None else self._names.get(number)
            if name is None or name in taken:
                continue
            picture = self._measure(name, number, np.asarray(outline, dtype=float).reshape(4, 2), view)
            # If a number is found twice, one of the two is wrong: keep the better match.
            if picture is not None and (name not in found or found[name].explained < picture.explained):
                found[name] = picture
        return list(found.values())

    def track(self, name: str, rotation: Array, position: Array, view: PreparedImage) -> FoundPicture | None:
        """Return a marker, seen before, near a predicted pose in the camera's frame, or None.

        Args:
            name: Name of the marker.
            rotation: camera_from_picture as predicted, shape (3, 3).
            position: Its centre as predicted, shape (3,) [m].
            view: The image.
        """
        found = self._gauges[name].near(rotation, position, view)
        return None if found is None else self._without_border(found)

    def _measure(self, name: str, number: int, outline: Array, view: PreparedImage) -> FoundPicture | None:
        """Return the marker measured by its whole picture; OpenCV's corners are the initial guess."""
        half = self._width / 2.0
        square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
        if name not in self._gauges:
            self._gauges[name] = self._gauge(name, number)
        homography = homography_between(square, outline)
        found = None if homography is None else self._gauges[name].at(homography, view)
        return None if found is None else self._without_border(found)

    def _gauge(self, name: str, number: int) -> PictureGauge:
        """Make a picture of a marker with one module of white around it, as it is printed."""
        modules = int(self._dictionary.markerSize) + 2
        black = cv2.aruco.generateImageMarker(self._dictionary, number, modules * MODULE)
        printed = np.pad(np.asarray(black, dtype=np.uint8), MODULE, constant_values=255)
        return PictureGauge(name, printed, self._width * (modules + 2) / modules, floor=FLOOR)

    def _without_border(self, found: FoundPicture) -> FoundPicture:
        """Return a detection whose corners are those of the black square."""
        modules = int(self._dictionary.markerSize) + 2
        outer = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        image_from_outer = homography_between(outer, found.detection.corners)
        assert image_from_outer is not None, "it was found there"
        corners = apply_homography(image_from_outer, outer * modules / (modules + 2))
        detection = Detection(found.detection.name, found.detection.position, found.detection.covariance, corners)
        return FoundPicture(detection, found.pose, found.explained)
