"""Lens distortion: a precomputed table with the position of each pixel in an undistorted picture."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Intrinsics, Picture
from mjsim.world import Camera, Lens

WIDEST = math.tan(math.radians(80.0))
"""Pixels farther from the axis are black, as outside the circle of a fisheye."""
LONGEST_SIDE = 3072
"""Maximum side of the undistorted picture [px]."""


def intrinsics_of(camera: Camera) -> Intrinsics:
    """Return the calibration of a camera with square pixels and the principal point at the centre of the picture.

    Pixel centres are at integers, so the centre is at (width - 1) / 2.
    """
    lens = camera.lens
    kind: str = "pinhole"
    distortion: tuple[float, ...] = ()
    if lens is not None:
        kind, distortion = ("fisheye", lens.fisheye) if lens.fisheye is not None else ("brown", lens.brown or ())
    return Intrinsics(
        width=camera.width,
        height=camera.height,
        fx=camera.focal,
        fy=camera.focal,
        cx=(camera.width - 1) / 2,
        cy=(camera.height - 1) / 2,
        lens=kind,
        distortion=distortion,
    )


class BentView:
    """The undistorted picture for a camera with a lens, and its distortion."""

    def __init__(self, intrinsics: Intrinsics, lens: Lens) -> None:
        """Compute the table.

        Args:
            intrinsics: Calibration of the camera.
            lens: Its lens.
        """
        v, u = np.mgrid[: intrinsics.height, : intrinsics.width].reshape(2, -1)
        bent = np.stack([(u - intrinsics.cx) / intrinsics.fx, (v - intrinsics.cy) / intrinsics.fy], axis=-1)
        straight = lens.straighten(bent)
        seen = np.abs(straight).max(axis=1) <= WIDEST  # NaN is not.
        half = np.abs(straight[seen]).max(axis=0, initial=0.1)
        # As fine as the camera's own pixels at the centre, unless that is too large.
        focal = min(intrinsics.fx, LONGEST_SIDE / 2 / float(half.max()) - 1.0)
        self.width, self.height = (2 * math.ceil(focal * float(side)) + 2 for side in half)
        """Size of the undistorted picture [px]."""
        self.fov_y_deg = math.degrees(2 * math.atan(self.height / 2 / focal))
        """Vertical field of view of the undistorted picture [deg]."""
        shape = intrinsics.height, intrinsics.width
        places = straight * focal + [(self.width - 1) / 2, (self.height - 1) / 2]
        places[~seen] = -10.0
        x, y = places.astype(np.float32).T
        self._x, self._y = x.reshape(shape), y.reshape(shape)
        self._seen = seen.reshape(shape)
        self._nearest = tuple(np.rint(np.where(seen, each, 0.0)).astype(int).reshape(shape) for each in places.T)

    def bend(self, picture: Picture) -> Picture:
        """Return the distorted picture; black where the lens sees nothing."""
        bent = cv2.remap(picture, self._x, self._y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        return np.asarray(bent, dtype=np.uint8)

    def bend_depth(self, depth: Array) -> Array:
        """Return the distorted depth, taken from the nearest pixel; +inf where the lens sees nothing."""
        x, y = self._nearest
        return np.where(self._seen, depth[y, x], np.inf)

    def bend_instances(self, instances: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the distorted instances, taken from the nearest pixel; -1 where the lens sees nothing."""
        x, y = self._nearest
        return np.where(self._seen, instances[y, x], np.int32(-1))
