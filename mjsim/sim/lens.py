"""Lens distortion: a precomputed table with the position of each pixel in an undistorted picture."""

import math

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Intrinsics, Picture
from mjsim.world import Camera, Lens

WIDEST = math.tan(math.radians(80.0))
"""What is farther from the axis is not drawn: black, as outside of the circle of a fisheye."""
LONGEST_SIDE = 3072
"""Of a straight picture [px]."""


def intrinsics_of(camera: Camera) -> Intrinsics:
    """Return the calibration of a camera with square pixels, its middle in the middle of the picture.

    References:
        The pinhole camera, f = (width / 2) / tan(fov / 2); pixel centres at whole numbers put the middle at
        (width - 1) / 2. With a lens, what is at half the field of view is still at the edge.
    """
    lens, edge = camera.lens, np.array([[math.tan(math.radians(camera.fov_deg) / 2), 0.0]])
    focal = camera.width / 2 / float((edge if lens is None else lens.bend(edge))[0, 0])
    kind: str = "pinhole"
    distortion: tuple[float, ...] = ()
    if lens is not None:
        kind, distortion = ("fisheye", lens.fisheye) if lens.fisheye is not None else ("brown", lens.brown or ())
    return Intrinsics(
        width=camera.width,
        height=camera.height,
        fx=focal,
        fy=focal,
        cx=(camera.width - 1) / 2,
        cy=(camera.height - 1) / 2,
        lens=kind,
        distortion=distortion,
    )


class BentView:
    """The straight picture that a camera with a lens is made of, and how it is bent."""

    def __init__(self, intrinsics: Intrinsics, lens: Lens) -> None:
        """Make the table.

        Args:
            intrinsics: Of the camera.
            lens: That is before it.
        """
        v, u = np.mgrid[: intrinsics.height, : intrinsics.width].reshape(2, -1)
        bent = np.stack([(u - intrinsics.cx) / intrinsics.fx, (v - intrinsics.cy) / intrinsics.fy], axis=-1)
        straight = lens.straighten(bent)
        seen = np.abs(straight).max(axis=1) <= WIDEST  # NaN is not.
        half = np.abs(straight[seen]).max(axis=0, initial=0.1)
        # As fine as the camera's own pixels in the middle, where that is not too large.
        focal = min(intrinsics.fx, LONGEST_SIDE / 2 / float(half.max()) - 1.0)
        self.width, self.height = (2 * math.ceil(focal * float(side)) + 2 for side in half)
        """Of the straight picture [px]."""
        self.fov_y_deg = math.degrees(2 * math.atan(self.height / 2 / focal))
        """Vertical field of view of the straight picture."""
        shape = intrinsics.height, intrinsics.width
        places = straight * focal + [(self.width - 1) / 2, (self.height - 1) / 2]
        places[~seen] = -10.0
        x, y = places.astype(np.float32).T
        self._x, self._y = x.reshape(shape), y.reshape(shape)
        self._seen = seen.reshape(shape)
        self._nearest = tuple(np.rint(np.where(seen, each, 0.0)).astype(int).reshape(shape) for each in places.T)

    def bend(self, picture: Picture) -> Picture:
        """Return the picture behind the lens; black where nothing is seen."""
        bent = cv2.remap(picture, self._x, self._y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=0)
        return np.asarray(bent, dtype=np.uint8)

    def bend_depth(self, depth: Array) -> Array:
        """Return the depth behind the lens, that of the nearest pixel; +inf where nothing is seen."""
        x, y = self._nearest
        return np.where(self._seen, depth[y, x], np.inf)

    def bend_instances(self, instances: NDArray[np.int32]) -> NDArray[np.int32]:
        """Return the instances behind the lens, that of the nearest pixel; -1 where nothing is seen."""
        x, y = self._nearest
        return np.where(self._seen, instances[y, x], np.int32(-1))
