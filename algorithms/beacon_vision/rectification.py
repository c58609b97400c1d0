"""Rectifies images of a camera with lens distortion to those of a pinhole camera."""

from dataclasses import replace

import cv2
import numpy as np

from mjsim.interface import CameraFrame, Intrinsics, Picture


class Rectifier:
    """Rectifies the images of one camera; pixels outside the distorted image are black."""

    def __init__(self, intrinsics: Intrinsics) -> None:
        """Compute the lookup table, as OpenCV does from a calibration.

        Args:
            intrinsics: Intrinsics of the camera.

        Raises:
            ValueError: The lens model is unknown.
        """
        if intrinsics.lens not in ("pinhole", "brown", "fisheye"):
            raise ValueError(f"no lens '{intrinsics.lens}'; there are pinhole, brown and fisheye")
        self.intrinsics = replace(intrinsics, lens="pinhole", distortion=())
        """Intrinsics of the rectified images: same focal length and principal point."""
        self._maps: tuple[Picture, Picture] | None = None
        if intrinsics.lens != "pinhole":
            module = cv2.fisheye if intrinsics.lens == "fisheye" else cv2
            K, D, size = intrinsics.matrix(), np.array(intrinsics.distortion), (intrinsics.width, intrinsics.height)
            x, y = module.initUndistortRectifyMap(K, D, np.eye(3), K, size, cv2.CV_32FC1)
            self._maps = (np.asarray(x), np.asarray(y))

    def straight(self, frame: CameraFrame) -> CameraFrame:
        """Return a frame with its image rectified, without depth and instances, which are not rectified."""
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
