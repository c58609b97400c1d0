"""Aligns scans with obstacles seen before, to correct dead reckoning."""

import numpy as np

from mjsim.geometry import Array, Pose
from mjsim.interface import Odometry

from .obstacle_map import ObstacleMap

BEAMS = 240
"""Number of points that are used."""
FAR, NEAR, SHRINK = 0.3, 0.1, 0.7
"""Points farther than this from all obstacles are new, in the first round and at last [m]; factor between rounds."""
SLIPS = 4.0
"""Factor on the covariance of odometry, for wheels that slip more than usual."""
STILL = 1e-3
"""Corrections smaller than this end the rounds [m, rad]."""
DEVIATION = 0.1
"""Standard deviation of the distance of a point: errors of cells and neighbouring beams are shared [m]."""
ROUNDS = 8
FEWEST = 12
"""Fewer points say nothing."""


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
        self._covariance = np.zeros((3, 3))

    def move(self, odometry: Odometry) -> None:
        """Add the motion of a tick."""
        self.pose = self.pose @ Pose(odometry.forward, odometry.left, odometry.turn)
        self._covariance = self._covariance + SLIPS * odometry.covariance

    def align(self, points: Array, map: ObstacleMap) -> None:
        """Correct the pose by a scan.

        Args:
            points: In the robot frame, shape (n, 2) [m].
            map: Obstacles, in the frame of the pose.
        """
        points = points[:: 1 + len(points) // BEAMS]
        if len(points) < FEWEST:
            return
        weight = np.linalg.inv(self._covariance + np.diag([1e-6, 1e-6, 1e-6]))
        start = self.pose
        for number in range(ROUNDS):
            far = max(FAR * SHRINK**number, NEAR)
            placed = self.pose.transform(points)
            distance, slope = map.slope(placed)
            used = distance < far
            if np.count_nonzero(used) < FEWEST:
                self.pose = start
                return
            # Derivatives by a small motion in the robot frame.
            c, s = np.cos(self.pose.heading), np.sin(self.pose.heading)
            by_x, by_y = slope[used].T
            ahead, left = c * by_x + s * by_y, c * by_y - s * by_x
            x, y = points[used].T
            J = np.stack([ahead, left, x * left - y * ahead], axis=-1)
            residual = distance[used]
            robust = 1.0 / (1.0 + (2.0 * residual / far) ** 2) / DEVIATION**2
            moved = start.inverse() @ self.pose
            H = (J * robust[:, None]).T @ J + weight
            g = J.T @ (robust * residual) + weight @ np.array([moved.x, moved.y, moved.heading])
            step = np.linalg.solve(H, -g)
            self.pose = self.pose @ Pose.from_array(step)
            if far == NEAR and np.abs(step).max() < STILL:
                break
        self._covariance = np.linalg.inv(H)
