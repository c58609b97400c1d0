"""Monte Carlo localization on a known map, from a lidar, odometry, and sightings of beacons, if any.

The world must say `map: known`. In a symmetric room a lidar cannot resolve the ambiguity; one sighting of a beacon can.
Particles are moved by odometry, weighted by how well the scan fits the map, and resampled. They start anywhere (`start:
global`) or at the prior, and recover after the robot has been kidnapped.
"""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from mjsim.geometry import Array, Pose, wrap_angle, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Shown, ShownPoints, Sighting, WorldMap

from .scans.distance_grid import DistanceGrid
from .scans.level_scan import LevelLidar, LevelScan

FAST, SLOW, LOSING = 0.3, 0.03, 0.0005
"""Weight of the newest scan in the fast average of the likelihood, and in the slow one when scans fit better or worse
than it: after being lost for a minute, the robot still knows how well scans normally fit."""
SEARCHED = 1.0
"""Minimum time between two searches for other poses [s]."""
BETTER = 3.0
"""Logarithm of the ratio by which another pose must explain a scan better than the belief does before particles go
there: with less, rooms that look alike from two places, or moved furniture, mislead it."""
LOST = 0.25
"""The robot is lost when scans fit worse than usual by this measure, from 0 to 1."""
CANDIDATES = 20000
"""Number of candidate poses for relocated particles."""
SEARCHERS = 300
"""Number of particles relocated when the robot is completely lost."""
COARSE = np.array([0.1, 0.05])
"""Minimum standard deviations of a sighting's range and bearing [m, rad]."""
BROAD = 0.25
"""Standard deviation of a beam's end from its wall for candidate poses, so that approximate ones are found [m]."""
SHARP = 16.0
"""Number of independent beams that a scan counts for when detecting that the robot is lost, and for relocation."""
SPACING, LEVER = 0.01, 0.5
"""Distance between scans for independent information, with turns converted by a lever arm [m]."""
FLOOR = 1e-8
"""Minimum covariance of the belief: 0.1 mm and 0.1 mrad, by which robots settle on the floor [m^2, rad^2]."""
BIN = np.array([0.5, 0.5, np.radians(15.0)])
"""Size of the bins of KLD-sampling [m, m, rad]."""


class MonteCarloLocalization:
    """Estimates the pose with particles: augmented MCL, with a number of particles adapted to the spread.

    New particles, at the start or when scans fit worse than before, are not placed at random: they are drawn from
    several random poses according to the likelihood of the scan.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), tables 8.2 and 8.3 (augmented MCL), 6.3 (likelihood
        field). Fox, Adapting the Sample Size in Particle Filters through KLD-Sampling, IJRR 22(12), 2003, eq. 7.
        Lenser, Veloso, Sensor Resetting Localization for Poorly Modelled Mobile Robots, ICRA 2000.
    """

    def __init__(
        self,
        *,
        lidar: str | None = None,
        start: Literal["prior", "global"] = "prior",
        particles: int = 5000,
        beams: int = 40,
        sigma: float = 0.08,
        random: float = 0.05,
        weight: float = 12.0,
        odometry_scale: float = 1.5,
        show: int = 0,
    ) -> None:
        """Set the rules.

        Args:
            lidar: Name of the lidar; None for the first.
            start: Whether to start from the prior, or anywhere inside the walls.
            particles: Largest number of particles; a converged belief needs far fewer.
            beams: Number of beams used per scan.
            sigma: Standard deviation of a beam's end from its wall: noise, and errors of the map [m].
            random: Probability that a beam ends on something that is not in the map.
            weight: Number of independent beams that a scan counts for; the errors of neighbouring beams are correlated,
                and so are those of the next scan from nearly the same place: a scan from the same place as the last one
                counts for none. Larger values make the belief overconfident.
            odometry_scale: Factor on the standard deviation of odometry.
            show: Number of particles shown with each scan, and the scan itself; 0: none.
        """
        if start not in ("prior", "global"):
            raise ValueError(f"start is {start!r}; it must be 'prior' or 'global'")
        if particles < 100 or beams < 1:
            raise ValueError(f"particles is {particles} and beams {beams}; give at least 100 and 1")
        self._lidar, self._start, self._max_particles, self._beams = lidar, start, particles, beams
        self._sigma, self._random, self._weight, self._scale = sigma, random, weight, odometry_scale
        if show < 0:
            raise ValueError(f"show is {show}; it must be at least 0")
        self._show, self._shown = show, tuple[Shown, ...]()
        self._field: DistanceGrid | None = None

    def take_map(self, map: WorldMap | None) -> None:
        """Get the walls; called before `start`.

        Raises:
            ValueError: The map is unknown, or has no walls.
        """
        if map is None:
            raise ValueError("there is no map; write 'map: known' under 'run' of the world")
        self._field = DistanceGrid.from_segments(map.segments, cell=0.025, finer=5)

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Draw the initial particles.

        Raises:
            ValueError: There is no map, or the robot has no such lidar.
        """
        if self._field is None:
            self.take_map(None)
        self._scans = LevelLidar(robot, self._lidar)
        self._rng = rng
        self._beacons = {name: info.pose.as_array()[:2] for name, info in catalogue.items() if info.pose is not None}
        self._places = self._known_field().largest_region(robot.radius)
        x, y = np.var(self._places, axis=0)
        self._unknown = np.diag([x, y, np.pi**2 / 3.0])
        self._slow = self._fast = 0.0
        self._misfit, self._searched = 0.0, -np.inf
        self._moved = np.inf
        self._nowhere = self._start == "global"
        if self._nowhere:
            self._particles = self._anywhere(self._max_particles)
        else:
            self._particles = rng.multivariate_normal(
                robot.prior.as_array(), np.asarray(robot.prior_covariance), self._max_particles, method="svd"
            )
        self._weights = np.full(self._max_particles, 1.0 / self._max_particles)

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and, when one is due, its scan."""
        self._move(seen)
        scan = self._scans.update(seen)
        points = self._points(scan) if scan is not None else np.zeros((0, 2))
        sightings = [sighting for sighting in seen.sightings if sighting.name in self._beacons]
        if len(points) or sightings:
            self._weigh(points, sightings, seen.time)
            self._shown = self._picture(points) if self._show else ()
        return self._belief()

    def lost(self) -> bool:
        """Return whether scans fit much worse than usual where the particles are."""
        return self._misfit > LOST

    def _known_field(self) -> DistanceGrid:
        assert self._field is not None
        return self._field

    def _anywhere(self, number: int) -> Array:
        """Return poses anywhere inside the walls, shape (number, 3)."""
        places = self._places[self._rng.integers(len(self._places), size=number)]
        within = self._rng.uniform(-0.5, 0.5, (number, 2)) * self._known_field().cell
        return np.column_stack([places + within, self._rng.uniform(-np.pi, np.pi, number)])

    def _move(self, seen: Observation) -> None:
        """Move each particle by odometry with random noise."""
        moved, P = seen.odometry, self._particles
        self._moved += np.hypot(moved.forward, moved.left) + LEVER * abs(moved.turn)
        root = np.linalg.cholesky(moved.covariance * self._scale**2 + 1e-12 * np.eye(3))
        steps = (moved.forward, moved.left, moved.turn) + self._rng.standard_normal(P.shape) @ root.T
        c, s = np.cos(P[:, 2]), np.sin(P[:, 2])
        P[:, 0] += c * steps[:, 0] - s * steps[:, 1]
        P[:, 1] += s * steps[:, 0] + c * steps[:, 1]
        P[:, 2] += steps[:, 2]

    def _weigh(self, points: Array, sightings: list[Sighting], time: float) -> None:
        """Weight the particles by scan and sightings, and resample them if few of them carry the weight."""
        if self._nowhere:
            self._particles, self._nowhere = self._likely_places(points, sightings, len(self._particles)), False
        by_beam = self._scan_fit(self._particles, points, self._sigma)
        # A robot at rest repeats the same errors, so its scans are weighted by the distance moved, unless it is lost.
        new = 1.0 if 1.5 * self._fast < self._slow else min(1.0, self._moved / SPACING)
        self._moved = 0.0 if len(points) else self._moved
        fit = new * self._weight * by_beam + self._sighting_fit(self._particles, sightings)
        self._weights = self._weights * np.exp(fit - np.max(fit)) + 1e-300
        self._weights /= self._weights.sum()
        if len(points):
            self._misfit = self._misfitting(SHARP * by_beam)
        found = np.zeros((0, 3))
        if len(points) and self._misfit > 0.0 and time >= self._searched + SEARCHED:
            self._searched = time
            found = self._better_places(points, sightings, float(self._weights @ by_beam))
        if len(found) or 1.0 / np.sum(self._weights**2) < 0.5 * len(self._weights):
            self._draw(found)

    def _misfitting(self, by_scan: Array) -> float:
        """Return how much worse than usual scans fit, from 0 to 1."""
        # Weighted: particles that were just relocated do not show how lost the belief is.
        mean = float(self._weights @ np.exp(by_scan))
        self._fast += (FAST if self._fast else 1.0) * (mean - self._fast)
        self._slow += ((SLOW if mean > self._slow else LOSING) if self._slow else 1.0) * (mean - self._slow)
        return max(0.0, 1.0 - 1.5 * self._fast / self._slow)

    def _points(self, scan: LevelScan) -> Array:
        """Return the ends of some beams, in the robot's frame, shape (n, 2) [m]."""
        points = scan.points()
        return np.asarray(points[np.linspace(0, len(points) - 1, min(self._beams, len(points))).astype(int)])

    def _scan_fit(self, poses: Array, points: Array, sigma: float) -> Array:
        """Return the mean log-likelihood of a beam of a scan, with ends (n, 2), from poses (k, 3), shape (k,)."""
        if not len(points):
            return np.zeros(len(poses))
        c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
        x, y = points.T
        ends = np.stack([poses[:, 0, None] + c * x - s * y, poses[:, 1, None] + s * x + c * y], axis=-1)
        return log_likelihood(self._known_field(), ends, sigma=sigma, random=self._random)

    def _sighting_fit(self, poses: Array, sightings: list[Sighting]) -> Array:
        """Return the logarithm of the likelihood of sightings of known beacons from poses (k, 3), shape (k,).

        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 6.4, with a probability of wrong sightings.
        """
        total = np.zeros(len(poses))
        for sighting in sightings:
            dx, dy = (self._beacons[sighting.name or ""] - poses[:, :2]).T
            ranges, bearings = np.hypot(dx, dy) - sighting.range, np.arctan2(dy, dx) - poses[:, 2] - sighting.bearing
            # The resolution of the particles bounds the standard deviation from below.
            variances = np.diag(sighting.covariance) + COARSE**2
            squared = ranges**2 / variances[0] + wrap_angles(bearings) ** 2 / variances[1]
            total += np.log((1.0 - self._random) * np.exp(-0.5 * squared) + self._random)
        return total

    def _better_places(self, points: Array, sightings: list[Sighting], by_beam: float) -> Array:
        """Return poses (k, 3) that explain a scan and sightings much better than the belief, given its fit by beam."""
        poses = self._likely_places(points, sightings, max(1, int(self._misfit * SEARCHERS)))
        gained = SHARP * (self._scan_fit(poses, points, self._sigma) - by_beam)
        gained += self._sighting_fit(poses, sightings) - self._weights @ self._sighting_fit(self._particles, sightings)
        return np.asarray(poses[gained > BETTER])

    def _draw(self, found: Array) -> None:
        """Draw particles by weight, as many as their spread needs, and add those found elsewhere (k, 3)."""
        resampled = self._particles[systematic_resample_with(self._weights, self._rng)]
        number = self._needed(resampled)
        self._particles = (
            resampled[self._rng.permutation(len(resampled))[:number]] if number < len(resampled) else resampled
        )
        self._weights = np.full(len(self._particles), 1.0 / len(self._particles))
        if len(found):
            # The previous particles keep most of the weight until a scan supports the new ones.
            self._particles = np.concatenate([self._particles, found])
            share = 0.5 * self._misfit
            self._weights = np.append((1.0 - share) * self._weights, np.full(len(found), share / len(found)))

    def _likely_places(self, points: Array, sightings: list[Sighting], number: int) -> Array:
        """Return poses that are likely given a scan and sightings, shape (number, 3).

        They are drawn from many with a broad likelihood, then optimised while it narrows: with a sharp likelihood, a
        wrong pose that fits by chance would immediately outweigh one that is nearly right.
        """
        tried = self._anywhere(CANDIDATES)
        fit = SHARP * self._scan_fit(tried, points, BROAD) + self._sighting_fit(tried, sightings)
        odds = np.exp(fit - np.max(fit))
        poses = tried[self._rng.choice(len(tried), size=number, p=odds / odds.sum())]
        for sigma in np.geomspace(BROAD, self._sigma, 5).tolist():
            steps = self._rng.normal(0.0, 0.5 * sigma, (number, 12, 3))
            steps[:, 0] = 0.0
            perturbed = (poses[:, None] + steps).reshape(-1, 3)
            fit = SHARP * self._scan_fit(perturbed, points, sigma) + self._sighting_fit(perturbed, sightings)
            poses = perturbed.reshape(number, 12, 3)[np.arange(number), fit.reshape(number, 12).argmax(axis=1)]
        return np.asarray(poses)

    def _needed(self, particles: Array) -> int:
        """Return the number of particles that keeps the histogram's error below 0.02 with 99 % (KLD-sampling)."""
        bins = len(np.unique(_bins(particles)))
        if bins < 2:
            return 200
        part = 2.0 / (9.0 * (bins - 1))
        needed = (bins - 1) / (2.0 * 0.02) * (1.0 - part + np.sqrt(part) * 2.3263) ** 3
        return int(np.clip(needed, 200, self._max_particles))

    def _belief(self) -> Estimate:
        """Return the mean of the particles around the most likely pose, and the covariance of all about it."""
        P, w = self._particles, self._weights
        _, index = np.unique(_bins(P), return_inverse=True)
        heaviest = index == np.argmax(np.bincount(index, weights=w))
        mean = _mean(P[heaviest], w[heaviest])
        core = np.all(np.abs(_differences(P, mean)) < 2.0 * BIN, axis=1)
        mean = _mean(P[core], w[core])
        differences = _differences(P, mean)
        covariance = (differences * w[:, None]).T @ differences + FLOOR * np.eye(3)
        # Badly fitting scans mean that the robot may be anywhere else.
        covariance = (1.0 - self._misfit) * covariance + self._misfit * self._unknown
        return Estimate(Pose.from_array(mean), covariance, show=self._shown)

    def _picture(self, points: Array) -> tuple[Shown, ...]:
        """Return shown items: some of the particles, and the ends of a scan (n, 2) from the estimated pose."""
        few = self._particles[:: -(-len(self._particles) // self._show), :2]
        scan = ShownPoints(name="scan as believed", frame="estimate", points=points, size=0.06, color="#2f9e44")
        return (ShownPoints(name="particles", points=few, size=0.04, color="#e8590c"), scan)


def log_likelihood(field: DistanceGrid, points: Array, *, sigma: float, random: float) -> Array:
    """Return the mean log-likelihood of the ends of a scan's beams, given a map.

    Args:
        field: Distances to the map's walls.
        points: Ends of beams in the map's frame, shape (..., beams, 2) [m].
        sigma: Standard deviation of an end's distance from its wall [m].
        random: Probability that a beam ends anywhere.

    Returns:
        Shape (...); 0 for a scan that fits perfectly.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 6.3: the likelihood field.
    """
    hit_likelihood = np.exp(-0.5 * (field.at(points) / sigma) ** 2)
    return np.asarray(np.log((1.0 - random) * hit_likelihood + random).mean(axis=-1))


def systematic_resample_with(weights: Array, rng: Generator) -> Array:
    """Return the index of the particle that each new one copies, by systematic resampling, shape (n,).

    Args:
        weights: Weights of the particles, shape (n,); their sum is 1.
        rng: Draws one number.

    References:
        Thrun, Burgard, Fox, Probabilistic Robotics (2005), table 4.4, the low variance sampler.
    """
    # The stream of NumPy's older generator, with which runs were recorded.
    offset = np.random.RandomState(int(rng.integers(2**32))).random_sample()
    places = (offset + np.arange(len(weights))) / len(weights)
    return np.asarray(np.minimum(np.searchsorted(np.cumsum(weights), places, side="right"), len(weights) - 1))


def _bins(poses: Array) -> NDArray[np.int64]:
    """Return a number for each pose (n, 3), equal for poses in the same bin."""
    headings = np.column_stack([poses[:, :2], wrap_angles(poses[:, 2])])
    columns, rows, turns = np.floor(headings / BIN).astype(np.int64).T
    return np.asarray((columns * 2**20 + rows) * 2**6 + turns)


def _mean(poses: Array, weights: Array) -> Array:
    """Return the weighted mean of poses (n, 3) that lie close together."""
    mean = poses[0] + weights @ _differences(poses, poses[0]) / weights.sum()
    mean[2] = wrap_angle(float(mean[2]))
    return np.asarray(mean)


def _differences(poses: Array, mean: Array) -> Array:
    """Return differences of poses (n, 3) from one pose, headings in [-pi, pi)."""
    differences = poses - mean
    differences[:, 2] = wrap_angles(differences[:, 2])
    return differences
