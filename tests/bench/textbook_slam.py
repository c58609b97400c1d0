"""EKF-SLAM as the textbook has it, in plain NumPy: what the estimators of `mjsim.algorithms` are measured beside.

It shares no line with them. Names of landmarks are known, so nothing is gated; each sighting counts from the first.
"""

import math
from collections.abc import Mapping

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose
from mjsim.interface import BeaconInfo, Estimate, Observation, Odometry, RobotInfo, Sighting


class TextbookSlam:
    """Estimates the pose and a map of named beacons.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 10.2, table 10.1; a landmark begins with the
        covariance that its first sighting gives it. Joseph form: Bar-Shalom, Li, Kirubarajan (2001), eq. 5.2.3-18.
    """

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self.mean = np.array([robot.prior.x, robot.prior.y, robot.prior.heading])
        self.P = np.array(robot.prior_covariance, dtype=float)
        self.rows: dict[str, int] = {}

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings, taken one after the other."""
        self.predict(seen.odometry)
        for sighting in seen.sightings:
            if sighting.name is not None:
                if sighting.name not in self.rows:
                    self.add(sighting)
                else:
                    self.correct(sighting)
        landmarks = {
            name: (self.mean[j : j + 2].copy(), self.P[j : j + 2, j : j + 2].copy()) for name, j in self.rows.items()
        }
        return Estimate(Pose(*self.mean[:3].tolist()), self.P[:3, :3].copy(), landmarks)

    def predict(self, moved: Odometry) -> None:
        """Move the robot by what its wheels measured; whole matrices, as the book writes them."""
        c, s = math.cos(self.mean[2]), math.sin(self.mean[2])
        dx, dy = c * moved.forward - s * moved.left, s * moved.forward + c * moved.left
        F, G = np.eye(len(self.mean)), np.zeros((len(self.mean), 3))
        F[0, 2], F[1, 2] = -dy, dx
        G[:3] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        self.mean[:3] += dx, dy, moved.turn
        self.mean[2] = wrapped(self.mean[2])
        self.P = F @ self.P @ F.T + G @ moved.covariance @ G.T

    def correct(self, sighting: Sighting) -> None:
        """Correct all of the state by a sighting of a landmark that is in it."""
        j, size = self.rows[sighting.name or ""], len(self.mean)
        dx, dy = self.mean[j : j + 2] - self.mean[:2]
        q = dx**2 + dy**2
        r = math.sqrt(q)
        H = np.zeros((2, size))
        H[:, :3] = [[-dx / r, -dy / r, 0.0], [dy / q, -dx / q, -1.0]]
        H[:, j : j + 2] = [[dx / r, dy / r], [-dy / q, dx / q]]
        nu = np.array([sighting.range - r, wrapped(sighting.bearing - math.atan2(dy, dx) + self.mean[2])])
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + sighting.covariance)
        self.mean += K @ nu
        self.mean[2] = wrapped(self.mean[2])
        left = np.eye(size) - K @ H
        self.P = left @ self.P @ left.T + K @ sighting.covariance @ K.T

    def add(self, sighting: Sighting) -> None:
        """Put a landmark into the state where its first sighting has it, with the errors of pose and sighting."""
        size, direction = len(self.mean), self.mean[2] + sighting.bearing
        c, s, r = math.cos(direction), math.sin(direction), sighting.range
        by_state, by_sighting = np.zeros((2, size)), np.array([[c, -r * s], [s, r * c]])
        by_state[:, :3] = [[1.0, 0.0, -r * s], [0.0, 1.0, r * c]]
        own: Array = by_state @ self.P @ by_state.T + by_sighting @ sighting.covariance @ by_sighting.T
        self.P = np.block([[self.P, self.P @ by_state.T], [by_state @ self.P, own]])
        self.mean = np.append(self.mean, [self.mean[0] + r * c, self.mean[1] + r * s])
        self.rows[sighting.name or ""] = size


def wrapped(angle: float) -> float:
    """Return an angle in [-pi, pi) [rad]."""
    return (float(angle) + math.pi) % (2.0 * math.pi) - math.pi
