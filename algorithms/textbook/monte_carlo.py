"""Monte Carlo localization as the textbook has it: particles on a known map, weighted by a scan and by beacons.

The world must say `map: known`. All particles are computed at once: the first axis of each array counts them.
"""

from collections.abc import Mapping

import cv2
import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, Odometry, RobotInfo, Scan, Sighting, WorldMap

CELL = 0.05
"""Size of the cells in which the distance to the nearest wall is looked up [m]."""
SIGMA_HIT = 0.1
"""Standard deviation of a beam's end from its wall: noise, and errors of the map [m]."""
Z_RAND = 0.1
"""Probability that a beam ends on something that is not in the map."""
BEAMS = 12
"""Beams used of a scan. More make it overconfident: the errors of neighbouring beams are not independent."""


class TextbookMonteCarlo:
    """Estimates the pose on a known map; it starts at the prior.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 8.2 (MCL), 6.3 (likelihood field of a scan), 6.4
        (likelihood of a landmark), 4.4 (low variance sampling, where the effective number of particles falls below
        half of them).
    """

    def __init__(self, *, particles: int = 500) -> None:
        """Set the number of particles.

        Raises:
            ValueError: `particles` is below 1.
        """
        if particles < 1:
            raise ValueError(f"particles is {particles}; it must be at least 1")
        self.M = particles

    def take_map(self, map: WorldMap | None) -> None:
        """Draw the walls on a grid and compute each cell's distance to the nearest; called before `start`.

        Raises:
            ValueError: The map is unknown, or has no walls.
        """
        if map is None or not len(map.segments):
            raise ValueError("there is no map of walls; write 'map: known' under 'run' of a world that has some")
        self.corner = map.segments.min(axis=(0, 1)) - 2.0
        size = np.ceil((map.segments.max(axis=(0, 1)) + 2.0 - self.corner) / CELL).astype(int)
        free = np.ones((size[1], size[0]), dtype=np.uint8)
        for first, last in np.rint((map.segments - self.corner) / CELL - 0.5).astype(int):
            cv2.line(free, first.tolist(), last.tolist(), 0)
        self.distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * CELL

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Draw the first particles from the robot's prior."""
        self.rng = rng
        prior = np.asarray(robot.prior_covariance, dtype=float)
        self.poses = rng.multivariate_normal(robot.prior.as_array(), prior, self.M, method="svd")
        self.weights = np.full(self.M, 1.0 / self.M)
        self.robot_from_sensor = {name: sensor.robot_from_sensor for name, sensor in robot.sensors.items()}
        self.landmarks = {name: info.pose.as_array()[:2] for name, info in catalogue.items() if info.pose is not None}

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry, scans and sightings."""
        self.sample(seen.odometry)
        for name, scan in seen.scans.items():
            self.weigh(self.scan_log_likelihood(scan, self.robot_from_sensor[name]))
        for z in seen.sightings:
            if z.name in self.landmarks:
                self.weigh(self.landmark_log_likelihood(z, self.landmarks[z.name]))
        if 1.0 / np.sum(self.weights**2) < 0.5 * self.M:
            self.resample()
        return self.belief()

    def sample(self, u: Odometry) -> None:
        """Move each particle by odometry with an error of its own: line 4 of table 8.2."""
        forward, left, turn = self.rng.multivariate_normal(
            [u.forward, u.left, u.turn], u.covariance, self.M, method="svd"
        ).T
        c, s = np.cos(self.poses[:, 2]), np.sin(self.poses[:, 2])
        self.poses += np.stack([c * forward - s * left, s * forward + c * left, turn], axis=1)

    def scan_log_likelihood(self, scan: Scan, robot_from_sensor: Array) -> Array:
        """Return how well a scan's ends lie on walls, seen from each particle, shape (M,): table 6.3."""
        ends = scan.points()
        ends = ends[np.linspace(0, len(ends) - 1, min(BEAMS, len(ends))).astype(int)]
        # In the robot's frame, then from each particle in the map's, shape (M, beams).
        x, y = robot_from_sensor[:2, :2] @ ends.T + robot_from_sensor[:2, 3:]
        c, s = np.cos(self.poses[:, 2:]), np.sin(self.poses[:, 2:])
        column = (self.poses[:, :1] + c * x - s * y - self.corner[0]) / CELL
        row = (self.poses[:, 1:2] + s * x + c * y - self.corner[1]) / CELL
        rows, columns = self.distance.shape
        d = self.distance[np.clip(row.astype(int), 0, rows - 1), np.clip(column.astype(int), 0, columns - 1)]
        return np.asarray(np.log((1.0 - Z_RAND) * np.exp(-0.5 * (d / SIGMA_HIT) ** 2) + Z_RAND).sum(axis=1))

    def landmark_log_likelihood(self, z: Sighting, landmark: Array) -> Array:
        """Return how well a sighting of a known beacon fits each particle, shape (M,): table 6.4."""
        dx, dy = (landmark - self.poses[:, :2]).T
        nu = np.stack([z.range - np.hypot(dx, dy), wrap_angles(z.bearing - np.arctan2(dy, dx) + self.poses[:, 2])], 1)
        return np.asarray(-0.5 * np.einsum("mi,ij,mj->m", nu, np.linalg.inv(z.covariance), nu))

    def weigh(self, log_likelihood: Array) -> None:
        """Multiply the weights by a likelihood: line 5 of table 8.2."""
        # At least the smallest double: weights must not all become 0.
        self.weights = np.maximum(self.weights * np.exp(log_likelihood - log_likelihood.max()), 1e-300)
        self.weights /= self.weights.sum()

    def resample(self) -> None:
        """Draw particles by weight, with one random number for all: table 4.4."""
        steps = (np.arange(self.M) + self.rng.uniform()) / self.M
        self.poses = self.poses[np.minimum(np.searchsorted(np.cumsum(self.weights), steps), self.M - 1)]
        self.weights = np.full(self.M, 1.0 / self.M)

    def belief(self) -> Estimate:
        """Return mean and covariance of the poses over the particles."""
        w, best = self.weights, self.poses[np.argmax(self.weights)]
        # Headings are averaged as differences from one of them.
        off = self.poses - best
        off[:, 2] = wrap_angles(off[:, 2])
        mean = w @ off
        return Estimate(Pose.from_array(best + mean), (w * (off - mean).T) @ (off - mean))
