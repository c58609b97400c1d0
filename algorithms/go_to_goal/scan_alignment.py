"""Aligns scans with obstacles seen before, to correct dead reckoning."""

import math

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Odometry

from .obstacle_map import ObstacleMap

BEAMS = 240
"""Number of points that are used."""
FAR, NEAR = 0.3, 0.08
"""Points farther than this from all obstacles are new; points nearer than this count in full [m]."""
SLIPS = 4.0
"""Factor on the covariance of odometry, for wheels that slip more than usual."""
DEVIATION = 0.04
"""Standard deviation of the distance of a point: errors of cells and neighbouring beams are shared [m]."""
ROUNDS = 6
FEWEST, MATCHED = 12, 0.75
"""Fewer points near obstacles correct nothing. If a smaller share of these then counts in full, they are other points
nearby, such as the far sides of posts: in BARN worlds and rooms such alignments only made headings worse."""

SURE = 16.3
"""Corrections with a larger squared Mahalanobis distance are wrong, as among moving things: 99.9 % of correct ones are
smaller (chi-square, three degrees of freedom). With 10, skids were not corrected in BARN worlds."""
FITTING, BETTER, MANY = 0.95, 0.25, 120
"""A robot that is pushed or skids sideways moves farther than its wheels measure. A larger correction is accepted too
if at least this share of the points then count in full, if less than this share of their misfit remains, and if at
least so many points count."""


class ScanAlignment:
    """Dead reckoning that is corrected where scans meet obstacles seen before.

    References:
        Kohlbrecher, von Stryk, Meyer, Klingauf, A Flexible and Scalable SLAM System with Full 3D Motion Estimation,
        SSRR 2011, section IV: Gauss-Newton on a grid; here on distances, with odometry as the prior.
    """

    def __init__(self, prior: Pose) -> None:
        """Start at a pose."""
        self.pose = prior
        """Corrected pose."""
        self._covariance: Array = np.zeros((3, 3))

    def move(self, odometry: Odometry) -> None:
        """Add the motion of a tick."""
        self.pose = self.pose @ Pose(odometry.forward, odometry.left, odometry.turn)
        self._covariance = self._covariance + SLIPS * odometry.covariance

    def align(self, points: Array, map: ObstacleMap) -> None:
        """Correct the pose by a scan.

        Args:
            points: Points in the robot frame, shape (n, 2) [m].
            map: Obstacles, in the frame of the pose.
        """
        points = points[:: 1 + len(points) // BEAMS]
        if len(points) < FEWEST:
            return
        weight = np.asarray(np.linalg.inv(self._covariance + np.diag([1e-6, 1e-6, 1e-6])), dtype=float)
        start, spread, best, pose = self.pose, self._covariance, math.inf, self.pose
        misfits = list[float]()
        for _ in range(ROUNDS):
            distance, slope = map.slope(pose.transform(points))
            if np.count_nonzero(distance < FAR) < FEWEST:
                break
            moved = (start.inverse() @ pose).as_array()
            # On a thin wall the slope vanishes: a step may lead away again.
            misfit = float((distance**2 / (1.0 + (distance / NEAR) ** 2)).sum()) / DEVIATION**2
            cost = misfit + float(moved @ weight @ moved)
            if cost >= best:
                break
            misfits.append(misfit)
            best, self.pose = cost, pose
            step, H = _step(points, distance, slope, pose.heading, weight, moved)
            if pose is start:
                self._covariance = np.asarray(np.linalg.inv(H), dtype=float)
            pose = pose @ Pose.from_array(step)
        x, y = self.pose.transform(points).T
        apart = map.at(x, y)
        moved = (start.inverse() @ self.pose).as_array()
        near = np.count_nonzero(apart < NEAR)
        fits = near >= max(FITTING * len(points), MANY) and misfits[-1] < BETTER * misfits[0]
        is_sure = fits or float(moved @ weight @ moved) <= SURE
        if near < MATCHED * np.count_nonzero(apart < FAR) or not is_sure:
            self.pose, self._covariance = start, spread


def _step(
    points: Array, distance: Array, slope: Array, heading: float, weight: Array, moved: Array
) -> tuple[Array, Array]:
    """Return the Gauss-Newton step in the robot frame, shape (3,), and the information, shape (3, 3).

    Args:
        points: Robot frame, shape (n, 2) [m].
        distance: From obstacles, shape (n,) [m].
        slope: Its derivatives by x and y, shape (n, 2).
        heading: Heading of the robot [rad].
        weight: Information of odometry, shape (3, 3).
        moved: Correction so far, shape (3,).
    """
    c, s = math.cos(heading), math.sin(heading)
    (x, y), (by_x, by_y) = points.T, slope.T
    ahead, left = c * by_x + s * by_y, c * by_y - s * by_x
    J = np.stack([ahead, left, x * left - y * ahead], axis=-1)
    robust = np.where(distance < FAR, 1.0 / (1.0 + (distance / NEAR) ** 2) / DEVIATION**2, 0.0)
    H = (J * robust[:, None]).T @ J + weight
    return np.linalg.solve(H, -(J.T @ (robust * distance) + weight @ moved)), H
