"""Features of a camera's pictures as rays, with their depth where the camera measures it."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from mjsim.geometry import Array
from mjsim.interface import CameraFrame, Intrinsics, RobotInfo, SensorInfo

LEVELS, SCALE = 4, 1.25
"""Levels of the image pyramid, and the scale from one to the next."""
PATCH = 31
"""Size of the patch that a feature describes, in pixels of its level."""
THRESHOLD = 5
"""Contrast of a corner, on a 0 to 255 scale."""
DETECTED, APART, CELL = 4, 4.0, 40.0
"""Number of corners found for each feature; distance of two features, and size of the cells over which they are spread
[px]."""
BESIDE = 5
"""A feature closer than this to the edge of a nearer surface is not used: its surroundings change as the robot moves
[px]."""
PIXEL = 0.6
"""Standard deviation of the place of a feature, in pixels of its level."""
EDGE, SMOOTH = 0.1, 0.015
"""Difference of inverse depths at an edge: relative, and constant [1/m]."""
DEPTH_NOISE = 0.003
"""Standard deviation of inverse depths [1/m] in addition to that of the data sheet."""
NO_DEPTH = 1e3
"""Standard deviation of an inverse depth that was not measured [1/m]."""


@dataclass(frozen=True, slots=True, eq=False)
class PicturePoints:
    """The features of one picture."""

    rays: Array
    """Place of each in the picture, and its inverse depth, 0 if not measured: (x / z, y / z, 1 / z) in the camera's
    optical frame, shape (n, 3) [1, 1, 1/m]."""
    noise: Array
    """Standard deviation of each of these numbers, shape (n, 3)."""
    descriptors: NDArray[np.uint64]
    """Shape (n, 4), 256 bits each."""

    def __len__(self) -> int:
        """Return the number of features."""
        return len(self.rays)


class PointCamera:
    """Finds the features of one camera's pictures.

    References:
        Rublee, Rabaud, Konolige, Bradski, ORB: An efficient alternative to SIFT or SURF, ICCV 2011.
    """

    def __init__(self, robot: RobotInfo, name: str | None, *, features: int) -> None:
        """Find the camera.

        Args:
            robot: Data sheet of the robot.
            name: Name of the camera; None for the first.
            features: Maximum number of features in a picture.

        Raises:
            ValueError: It has no such camera, or the intrinsics of the camera are unknown.
        """
        cameras = {key: sensor for key, sensor in robot.sensors.items() if sensor.kind == "camera"}
        if not cameras or name not in (None, *cameras):
            wanted = f" '{name}'" if name else ""
            raise ValueError(f"robot '{robot.name}' has no camera{wanted}; it has {', '.join(cameras) or 'none'}")
        self.name = name or next(iter(cameras))
        self.robot_from_camera: Array = cameras[self.name].robot_from_sensor
        """Shape (4, 4) [m]."""
        self._intrinsics = _known(self.name, cameras[self.name])
        self._depth_noise = np.hypot(cameras[self.name].noise.get("depth", 0.0), DEPTH_NOISE)
        self._farthest = (cameras[self.name].range or (0.0, np.inf))[1]
        self._count = features
        self._orb = cv2.ORB.create(
            DETECTED * features, SCALE, LEVELS, PATCH, 0, 2, cv2.ORB_HARRIS_SCORE, PATCH, THRESHOLD
        )
        lens, corners = self._intrinsics, np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
        edges = straight(corners * (lens.width - 1, lens.height - 1), lens)
        self.extent = edges.min(axis=0), edges.max(axis=0)
        """Smallest and largest (x / z, y / z) of the corners of a picture, shape (2,) each."""

    def find(self, frame: CameraFrame) -> PicturePoints:
        """Return the features of a picture."""
        gray = cv2.cvtColor(frame.image, cv2.COLOR_RGB2GRAY)
        keypoints = self._orb.detect(gray)
        if keypoints:
            chosen = spread_out(
                np.asarray(cv2.KeyPoint.convert(keypoints)),
                np.array([each.response for each in keypoints]),
                count=self._count,
            )
            keypoints, descriptors = self._orb.compute(gray, [keypoints[k] for k in chosen])
        if not keypoints:
            return PicturePoints(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 4), dtype=np.uint64))
        pixels = np.asarray(cv2.KeyPoint.convert(keypoints), dtype=float)
        sizes = np.array([each.size for each in keypoints]) / PATCH
        # Pixel centres are at whole numbers on each level; OpenCV scales corners.
        pixels += 0.5 * (sizes[:, None] - 1.0)
        lens = frame.intrinsics
        rays, noise = np.empty((len(pixels), 3)), np.empty((len(pixels), 3))
        rays[:, :2] = straight(pixels, lens)
        noise[:, :2] = PIXEL * sizes[:, None] / (lens.fx, lens.fy)
        rays[:, 2], noise[:, 2] = 0.0, NO_DEPTH
        found = PicturePoints(rays, noise, np.ascontiguousarray(descriptors).view(np.uint64))
        if frame.depth is None:
            return found
        inverse, spread, behind = inverse_depths(frame.depth, pixels, farthest=self._farthest)
        known = np.isfinite(inverse)
        rays[known, 2], noise[known, 2] = inverse[known], np.hypot(self._depth_noise, spread[known])
        return PicturePoints(rays[~behind], noise[~behind], found.descriptors[~behind])


def spread_out(pixels: Array, responses: Array, *, count: int) -> NDArray[np.intp]:
    """Return the indices of the strongest of some features, about `count`, evenly over the picture.

    Args:
        pixels: Places, shape (n, 2) [px].
        responses: Strength of each, shape (n,).
        count: How many.

    References:
        Mur-Artal, Montiel, Tardos (2015), section V.A: a grid of cells with a bounded number of corners each.
    """
    order = np.argsort(-responses, kind="stable")
    places = pixels[order] // APART
    order = order[np.sort(np.unique(places[:, 0] * 65536.0 + places[:, 1], return_index=True)[1])]
    places = pixels[order] // CELL
    cells = places[:, 0] * 65536.0 + places[:, 1]
    within = np.empty(len(order), dtype=np.intp)
    for cell in np.unique(cells):
        members = np.flatnonzero(cells == cell)
        within[members] = np.arange(len(members))
    # The strongest of each cell first, then the second of each, and so on.
    return order[np.argsort(within, kind="stable")[:count]]


def _known(name: str, sensor: SensorInfo) -> Intrinsics:
    """Return the calibration of a camera."""
    if sensor.intrinsics is None:
        raise ValueError(f"the calibration of camera '{name}' is not known; give its intrinsics")
    return sensor.intrinsics


def straight(pixels: Array, lens: Intrinsics) -> Array:
    """Return (x / z, y / z) of pixels (n, 2) in the optical frame, without the distortion of the lens, shape (n, 2)."""
    if lens.lens == "pinhole":
        return np.asarray((pixels - (lens.cx, lens.cy)) / (lens.fx, lens.fy))
    undistort = cv2.fisheye.undistortPoints if lens.lens == "fisheye" else cv2.undistortPoints
    return np.asarray(undistort(pixels[:, None], lens.matrix(), np.array(lens.coefficients())), dtype=float)[:, 0]


def inverse_depths(depth: Array, pixels: Array, *, farthest: float) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return the inverse depths of the 3 x 3 pixels about each of some places.

    Args:
        depth: Depth along the optical axis, shape (height, width) [m].
        pixels: Places, shape (n, 2) [px].
        farthest: Maximum depth that the camera measures [m].

    Returns:
        inverse: Their mean, or at an edge that of the nearest; NaN where a depth is not known, shape (n,).
        deviation: Standard deviation of it beyond the measured range, else 0, shape (n,).
        behind: Whether each is behind an edge nearby, shape (n,).
    """
    height, width = depth.shape
    columns, rows = np.rint(pixels).astype(int).T
    columns, rows = np.clip(columns, 1, width - 2), np.clip(rows, 1, height - 2)
    inverse = np.zeros(depth.shape, dtype=np.float32)
    np.divide(1.0, depth, out=inverse, where=depth > 0.0, casting="same_kind")
    nearest = cv2.dilate(inverse, np.ones((2 * BESIDE + 1, 2 * BESIDE + 1), dtype=np.uint8))[rows, columns]
    around = np.arange(-1, 2)
    patches = depth[rows[:, None, None] + around[:, None], columns[:, None, None] + around].reshape(-1, 9)
    beyond = patches == np.inf
    parts = 1.0 / np.where(patches > 0.0, np.where(beyond, 2.0 * farthest, patches), np.nan)
    mean, most = parts.mean(axis=1), parts.max(axis=1)
    found = np.where(most - mean > EDGE * mean + SMOOTH, most, mean)
    behind = nearest - found > 2.0 * (EDGE * found + SMOOTH)
    return found, np.where(beyond.any(axis=1), 0.5 / farthest, 0.0), behind
