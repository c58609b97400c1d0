"""FastSLAM 1.0 as the textbook has it: particles over the trajectory, each with a small Kalman filter per landmark.

Given the trajectory, landmarks are independent of each other, so no covariance grows with the map. Sightings
state their landmark (known correspondence); those without a name are ignored. All particles are computed at once: the
first axis of each array counts them.
"""

from collections.abc import Hashable, Mapping

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, Odometry, RobotInfo, Sighting


class TextbookFastSlam:
    """Estimates the pose and a map of named landmarks.

    It is overconfident, as the book's is: after some resampling all particles descend from one (Bailey, Nieto, Nebot,
    Consistency of the FastSLAM Algorithm, ICRA 2006).

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 13.1; low variance sampling, table 4.4, where the
        effective number of particles falls below half of them.
    """

    def __init__(self, *, particles: int = 100) -> None:
        """Set the number of particles.

        Raises:
            ValueError: `particles` is below 1.
        """
        if particles < 1:
            raise ValueError(f"particles is {particles}; it must be at least 1")
        self.M = particles

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Draw the first poses from the robot's prior; the maps are empty."""
        self.rng = rng
        prior = np.asarray(robot.prior_covariance, dtype=float)
        self.poses = rng.multivariate_normal(robot.prior.as_array(), prior, self.M, method="svd")
        self.weights = np.full(self.M, 1.0 / self.M)
        self.mu: dict[str, Array] = {}
        self.Sigma: dict[str, Array] = {}
        """Each landmark's mean (M, 2) and covariance (M, 2, 2), one for each particle."""

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        self.sample(seen.odometry)
        for z in seen.sightings:
            if z.name in self.mu:
                self.correct(z, z.name)
            elif z.name is not None:
                self.add(z, z.name)
        if 1.0 / np.sum(self.weights**2) < 0.5 * self.M:
            self.resample()
        return self.belief()

    def sample(self, u: Odometry) -> None:
        """Move each particle by odometry with an error of its own: line 4 of the table."""
        forward, left, turn = self.rng.multivariate_normal(
            [u.forward, u.left, u.turn], u.covariance, self.M, method="svd"
        ).T
        c, s = np.cos(self.poses[:, 2]), np.sin(self.poses[:, 2])
        self.poses += np.stack([c * forward - s * left, s * forward + c * left, turn], axis=1)

    def correct(self, z: Sighting, name: str) -> None:
        """Weight each particle by a sighting and correct its landmark by it: lines 11 to 17."""
        mu, Sigma = self.mu[name], self.Sigma[name]
        dx, dy = (mu - self.poses[:, :2]).T
        q = dx**2 + dy**2
        r = np.sqrt(q)
        H = np.stack([np.stack([dx / r, dy / r], axis=1), np.stack([-dy / q, dx / q], axis=1)], axis=1)
        bearing = np.arctan2(dy, dx) - self.poses[:, 2]
        nu = np.stack([z.range - r, wrap_angles(z.bearing - bearing)], axis=1)
        Q = H @ Sigma @ H.transpose(0, 2, 1) + z.covariance
        K = Sigma @ H.transpose(0, 2, 1) @ np.linalg.inv(Q)
        self.mu[name] = mu + np.einsum("mij,mj->mi", K, nu)
        self.Sigma[name] = (np.eye(2) - K @ H) @ Sigma
        squared = np.einsum("mi,mij,mj->m", nu, np.linalg.inv(Q), nu)
        logs = np.log(self.weights) - 0.5 * (squared + np.log(np.linalg.det(Q)))
        # At least the smallest double: a weight of 0 has no logarithm.
        self.weights = np.maximum(np.exp(logs - logs.max()), 1e-300)
        self.weights /= self.weights.sum()

    def add(self, z: Sighting, name: str) -> None:
        """Put a landmark into each map, where its particle sees it: lines 7 to 9."""
        direction = self.poses[:, 2] + z.bearing
        c, s = np.cos(direction), np.sin(direction)
        # The derivative of the landmark's place by the sighting: the inverse of H.
        G = np.stack([np.stack([c, -z.range * s], axis=1), np.stack([s, z.range * c], axis=1)], axis=1)
        self.mu[name] = self.poses[:, :2] + z.range * np.stack([c, s], axis=1)
        self.Sigma[name] = G @ z.covariance @ G.transpose(0, 2, 1)

    def resample(self) -> None:
        """Draw particles by weight, with one random number for all: table 4.4."""
        steps = (np.arange(self.M) + self.rng.uniform()) / self.M
        drawn = np.minimum(np.searchsorted(np.cumsum(self.weights), steps), self.M - 1)
        self.poses = self.poses[drawn]
        self.mu = {name: mu[drawn] for name, mu in self.mu.items()}
        self.Sigma = {name: Sigma[drawn] for name, Sigma in self.Sigma.items()}
        self.weights = np.full(self.M, 1.0 / self.M)

    def belief(self) -> Estimate:
        """Return mean and covariance of the poses and of each landmark over the particles."""
        w, best = self.weights, self.poses[np.argmax(self.weights)]
        # Headings are averaged as differences from one of them.
        off = self.poses - best
        off[:, 2] = wrap_angles(off[:, 2])
        mean = w @ off
        landmarks: dict[Hashable, tuple[Array, Array]] = {}
        for name, mu in self.mu.items():
            middle = w @ mu
            spread = (w * (mu - middle).T) @ (mu - middle)
            landmarks[name] = (middle, spread + np.einsum("m,mij->ij", w, self.Sigma[name]))
        return Estimate(Pose.from_array(best + mean), (w * (off - mean).T) @ (off - mean), landmarks)
