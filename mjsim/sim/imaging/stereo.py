"""Depth as a stereo camera measures it: quantised disparities with correlated errors, and holes."""

import math

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import Intrinsics, Picture
from mjsim.sim.imaging.pixel_noise import PixelNoise
from mjsim.world import Stereo

MIN_EDGE_SLOPE = 1.0
"""Change of the slope of disparities from pixel to pixel that is an edge, not a surface [px]."""
UNITS_PER_SIGMA = 4096.0
"""Units of whole numbers in which errors of disparities are drawn, per standard deviation."""


class StereoDepth:
    """Errors of the depth from two pictures; the camera's own is the left one, as in most such devices.

    The disparity of a point at depth z is f b / z. Matching averages over a window, so errors within it are correlated.
    It fails where the window shows no texture, two surfaces, a surface at a grazing angle, or one that the second
    camera does not see.

    References:
        Keselman et al., Intel RealSense stereoscopic depth cameras, CVPR workshops 2017; Grunnet-Jepsen, Sweetser,
        Woodfill, Best-known methods for tuning Intel RealSense D400 depth cameras, 2018: RMS error z^2 s / (f b) with
        s the error of a disparity; Scharstein, Szeliski, A taxonomy of dense two-frame stereo, IJCV 47, 2002, section
        3: windows and occlusion.
    """

    def __init__(self, stereo: Stereo, intrinsics: Intrinsics, stream: Generator) -> None:
        """Make the tables.

        Args:
            stereo: Stereo depth of the world file.
            intrinsics: Intrinsics of the camera, without a lens.
            stream: Random stream.
        """
        self._stereo, self._shape = stereo, (intrinsics.height, intrinsics.width)
        self._drawn = tuple(side + stereo.window - 1 for side in self._shape)
        self._scale = intrinsics.fx * stereo.baseline
        self._focal = intrinsics.fx
        # The mean of n x n independent errors has 1 / n of their deviation.
        self._noise = PixelNoise(UNITS_PER_SIGMA, stream)
        self._error_scale = stereo.subpixel * stereo.window / UNITS_PER_SIGMA
        columns = (np.arange(intrinsics.width) - intrinsics.cx) / intrinsics.fx
        rows = (np.arange(intrinsics.height) - intrinsics.cy) / intrinsics.fy
        self._x, self._y = (each.astype(np.float32) for each in (columns[None, :], rows[:, None]))
        self._rays = (1.0 + self._x**2 + self._y**2).astype(np.float32)
        self._columns = np.arange(intrinsics.width, dtype=np.float32)[None, :]
        self._limit = math.cos(math.radians(stereo.steepest_deg)) ** 2

    @property
    def deviation(self) -> float:
        """Standard deviation at 1 m [m]; it grows with the square of the distance."""
        return self._stereo.subpixel / self._scale

    def measured(self, depth: Array, picture: Picture) -> Array:
        """Return the depth that is measured, NaN in holes, shape (height, width) [m].

        Args:
            depth: True depth, +inf for no surface, of that shape [m].
            picture: The picture that is matched, without noise.
        """
        inverse = np.reciprocal(depth, dtype=np.float32, casting="unsafe")
        true = inverse * np.float32(self._scale)
        disparity = true + self._errors()
        if self._stereo.step:
            step = np.float32(self._stereo.step)
            disparity = np.rint(disparity / step) * step
        found = np.full(self._shape, np.inf)
        np.divide(self._scale, disparity, out=found, where=disparity > 0.0)
        found[self._holes(true, inverse, picture)] = np.nan
        return found

    def pass_over(self) -> None:
        """Draw the random numbers of a picture that was not requested."""
        self._noise.draw(self._drawn)

    def _errors(self) -> NDArray[np.float32]:
        """Return errors of the disparities, correlated within a window, shape (height, width) [px]."""
        drawn = np.zeros(self._drawn, dtype=np.int16)
        self._noise.add_to(drawn)
        half = self._stereo.window // 2
        smooth = cv2.boxFilter(drawn, cv2.CV_32F, (self._stereo.window, self._stereo.window))
        inside = np.asarray(smooth, dtype=np.float32)[half : half + self._shape[0], half : half + self._shape[1]]
        return inside * np.float32(self._error_scale)

    def _holes(
        self, disparity: NDArray[np.float32], inverse: NDArray[np.float32], picture: Picture
    ) -> NDArray[np.bool_]:
        holes = self._at_edges(disparity) | self._grazing(inverse) | occluded(disparity, self._columns)
        if self._stereo.texture:
            holes |= self._plain(inverse, picture)
        return holes

    def _at_edges(self, disparity: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Return where a window shows two surfaces: on a plane, disparities have the same slope everywhere."""
        bends = np.abs(cv2.Laplacian(disparity, cv2.CV_32F, ksize=1)) > MIN_EDGE_SLOPE
        around = np.ones((self._stereo.window // 2 * 2 + 1,) * 2, dtype=np.uint8)
        return np.asarray(cv2.dilate(bends.view(np.uint8), around), dtype=np.uint8).view(np.bool_)

    def _grazing(self, inverse: NDArray[np.float32]) -> NDArray[np.bool_]:
        """Return where the normal is nearly perpendicular to the line of sight.

        On a plane n x = c, 1 / z = (n_x x/z + n_y y/z + n_z) / c: its derivatives are the normal.
        """
        across = cv2.Sobel(inverse, cv2.CV_32F, 1, 0, ksize=1, scale=0.5 * self._focal)
        down = cv2.Sobel(inverse, cv2.CV_32F, 0, 1, ksize=1, scale=0.5 * self._focal)
        ahead = inverse - self._x * across - self._y * down
        squares = across * across + down * down + ahead * ahead
        return np.asarray(inverse * inverse < np.float32(self._limit) * self._rays * squares, dtype=bool)

    def _plain(self, inverse: NDArray[np.float32], picture: Picture) -> NDArray[np.bool_]:
        """Return where a window shows too little contrast, with that of the projector."""
        grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY)
        side = (self._stereo.window, self._stereo.window)
        mean = np.asarray(cv2.boxFilter(grey, cv2.CV_32F, side))
        contrast = np.asarray(cv2.sqrBoxFilter(grey, cv2.CV_32F, side)) - mean * mean
        if self._stereo.projector:
            contrast += np.square(np.float32(self._stereo.projector) * inverse * inverse)
        return np.asarray(contrast < np.float32(self._stereo.texture**2), dtype=bool)


def occluded(disparity: NDArray[np.float32], columns: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return where the second camera, to the right, sees something nearer, or where its picture has ended.

    Args:
        disparity: Shape (height, width) [px].
        columns: Columns of the pixels, shape (1, width).
    """
    other = columns - disparity
    # A pixel to the right that appears to the left in the second picture is in front.
    first = np.minimum.accumulate(other[:, ::-1], axis=1)[:, ::-1]
    hidden = other < -0.5
    hidden[:, :-1] |= other[:, :-1] > first[:, 1:]
    return np.asarray(hidden, dtype=bool)
