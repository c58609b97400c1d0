"""EKF-SLAM as the textbook has it: one Gaussian over the robot's pose and all landmarks.

The state is mu = (x, y, theta, m_1x, m_1y, m_2x, m_2y, ...) with covariance Sigma. Sightings
state their landmark (known correspondence); those without a name are ignored.
"""

import math
from collections.abc import Hashable, Mapping

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angle
from mjsim.interface import BeaconInfo, Estimate, Observation, Odometry, RobotInfo, Sighting


class TextbookEkfSlam:
    """Estimates the pose and a map of named landmarks.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), section 10.2, table 10.1. The motion is that of odometry, in
        the robot's frame, instead of a velocity; a landmark begins with the covariance that its first sighting gives
        it, instead of a large one. Joseph form: Bar-Shalom, Li, Kirubarajan, Estimation with Applications (2001),
        eq. 5.2.3-18.
    """

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Begin at the robot's prior with an empty map."""
        self.mu = robot.prior.as_array()
        self.Sigma = np.array(robot.prior_covariance, dtype=float)
        self.first: dict[str, int] = {}
        """The row in mu of each landmark's x; that of its y is the next."""

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings, processed in sequence."""
        self.predict(seen.odometry)
        for z in seen.sightings:
            if z.name in self.first:
                self.correct(z, self.first[z.name])
            elif z.name is not None:
                self.add(z, z.name)
        landmarks: dict[Hashable, tuple[Array, Array]] = {
            name: (self.mu[j : j + 2].copy(), self.block(j)) for name, j in self.first.items()
        }
        return Estimate(Pose.from_array(self.mu[:3]), self.block(0, 3), landmarks)

    def predict(self, u: Odometry) -> None:
        """Move the robot by what its wheels measured: lines 2 to 5 of the table."""
        c, s = math.cos(self.mu[2]), math.sin(self.mu[2])
        dx, dy = c * u.forward - s * u.left, s * u.forward + c * u.left
        # G: derivative of the motion by the state. V: by the odometry.
        G, V = np.eye(len(self.mu)), np.zeros((len(self.mu), 3))
        G[0, 2], G[1, 2] = -dy, dx
        V[:3] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
        self.mu[:3] += dx, dy, u.turn
        self.mu[2] = wrap_angle(self.mu[2])
        self.Sigma = G @ self.Sigma @ G.T + V @ u.covariance @ V.T

    def correct(self, z: Sighting, j: int) -> None:
        """Correct the whole state by a sighting of the landmark at row j: lines 12 to 18 of the table."""
        size = len(self.mu)
        dx, dy = self.mu[j : j + 2] - self.mu[:2]
        q = dx**2 + dy**2
        r = math.sqrt(q)
        H = np.zeros((2, size))
        H[:, :3] = [[-dx / r, -dy / r, 0.0], [dy / q, -dx / q, -1.0]]
        H[:, j : j + 2] = [[dx / r, dy / r], [-dy / q, dx / q]]
        nu = np.array([z.range - r, wrap_angle(z.bearing - math.atan2(dy, dx) + self.mu[2])])
        K = self.Sigma @ H.T @ np.linalg.inv(H @ self.Sigma @ H.T + z.covariance)
        self.mu += K @ nu
        self.mu[2] = wrap_angle(self.mu[2])
        left = np.eye(size) - K @ H
        self.Sigma = left @ self.Sigma @ left.T + K @ z.covariance @ K.T

    def add(self, z: Sighting, name: str) -> None:
        """Add a landmark at its first sighting, with the errors of pose and sighting: lines 9 to 11."""
        self.first[name] = len(self.mu)
        c, s = math.cos(self.mu[2] + z.bearing), math.sin(self.mu[2] + z.bearing)
        # Derivatives of the landmark's place by the state and by the sighting.
        by_state, by_sighting = np.zeros((2, len(self.mu))), np.array([[c, -z.range * s], [s, z.range * c]])
        by_state[:, :3] = [[1.0, 0.0, -z.range * s], [0.0, 1.0, z.range * c]]
        own: Array = by_state @ self.Sigma @ by_state.T + by_sighting @ z.covariance @ by_sighting.T
        self.Sigma = np.block([[self.Sigma, self.Sigma @ by_state.T], [by_state @ self.Sigma, own]])
        self.mu = np.append(self.mu, self.mu[:2] + z.range * np.array([c, s]))

    def block(self, j: int, size: int = 2) -> Array:
        """Return the covariance of a part of the state, shape (size, size)."""
        return self.Sigma[j : j + size, j : j + size].copy()
