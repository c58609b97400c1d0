"""Pictures made straight again: what a camera with a lens sees, as a pinhole would have seen it."""

from dataclasses import replace

import cv2
import numpy as np

from mjsim.interface import CameraFrame, Intrinsics, Picture


class Rectifier:
    """Straightens the pictures of one camera; what the pinhole sees beyond the lens's picture is black."""

    def __init__(self, intrinsics: Intrinsics) -> None:
        """Make the table, as OpenCV makes it from a calibration.

        Args:
            intrinsics: Of the camera.

        Raises:
            ValueError: The lens is of a kind that nobody knows.
        """
        if intrinsics.lens not in ("pinhole", "brown", "fisheye"):
            raise ValueError(f"no lens '{intrinsics.lens}'; there are pinhole, brown and fisheye")
        self.intrinsics = replace(intrinsics, lens="pinhole", distortion=())
        """Of the straight pictures: the same focal length and middle."""
        self._maps: tuple[Picture, Picture] | None = None
        if intrinsics.lens != "pinhole":
            module = cv2.fisheye if intrinsics.lens == "fisheye" else cv2
            K, D, size = intrinsics.matrix(), np.array(intrinsics.distortion), (intrinsics.width, intrinsics.height)
            x, y = module.initUndistortRectifyMap(K, D, np.eye(3), K, size, cv2.CV_32FC1)
            self._maps = (np.asarray(x), np.asarray(y))

    def straight(self, frame: CameraFrame) -> CameraFrame:
        """Return a frame with its picture straight, and without depth and instances, which stay bent."""
        if self._maps is None:
            return frame
        picture = cv2.remap(frame.image, *self._maps, cv2.INTER_LINEAR, borderValue=0)
        return replace(
            frame,
            image=np.asarray(picture, dtype=np.uint8),
            intrinsics=self.intrinsics,
            depth=None,
            segmentation=None,
        )
