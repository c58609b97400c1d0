"""FastSLAM 2.0: particles over the trajectory, each with its own map.

Given the trajectory, landmarks are independent; so each particle has a pose and a small Gaussian per landmark, and the
cost of a sighting does not grow with the map. All particles are moved and corrected in one vectorized step.

After many resamplings all particles descend from one, and no longer differ in what cannot be observed, such as the
heading of the map. So the particles are divided into islands, each resampled by itself: the differences between islands
show the uncertainty that the particles of one island no longer show.
"""

import math
from collections.abc import Hashable, Mapping

import numpy as np
from numpy.random import Generator

from mjsim.geometry import Array, Pose, wrap_angles
from mjsim.interface import BeaconInfo, Estimate, Observation, RobotInfo, Sighting

from .estimation.odometry_errors import COUNT, OdometryErrors
from .estimation.recent_motion import RecentMotion
from .estimation.relocation import Relocation, fitted
from .monte_carlo import systematic_resample_with
from .picture_errors import PictureErrors, each_of

GATE = 13.8
"""Gate for the squared Mahalanobis distance of a sighting: accepts 99.9 % of correct ones (chi-square, 2 degrees of
freedom)."""
ISLAND = 20
"""Number of particles of an island."""
RECENT = 0.1
"""Weight of the newest sighting in the running average of failed ones."""
LOST, SOUND = 0.5, 0.1
"""An island with more failed sightings than the first is replaced by one with fewer than the second."""
TINY = 1e-300
"""Minimum weight of a particle: the logarithm of 0 is not finite."""
DECIDED = 3.0
"""Bound of the logarithm of the Bayes factor for odometry without systematic errors: each half of the islands keeps
5 % of the weight. Errors that begin later then still count, and few particles estimate the factor poorly."""
NEWBORN = 1e-9
"""Added to the covariance of the motion, so that it is regular at rest too."""


class FastSlam:
    """Estimates the pose and a map of named beacons, and systematic errors of odometry.

    Given a trajectory, these errors have a Gaussian, with a mean for each particle and a common covariance. So few
    particles learn them poorly: half of the islands assume that there are none, and both halves are weighted by the
    likelihood of the sightings. An island that fails to explain most of its recent sightings, while others of its half
    explain theirs, is replaced by a copy of one of these; apart from that, islands of a half have equal weights.

    References:
        Montemerlo, Thrun, Koller, Wegbreit, FastSLAM 2.0: An Improved Particle Filtering Algorithm for Simultaneous
        Localization and Mapping that Provably Converges, IJCAI 2003. Thrun, Burgard, Fox, Probabilistic Robotics
        (2005), table 13.3. Schön, Gustafsson, Nordlund, Marginalized Particle Filters for Mixed Linear/Nonlinear
        State-Space Models, IEEE TSP 53(7), 2005. Vergé, Dubarry, Del Moral, Moulines, On Parallel Implementation of
        Sequential Monte Carlo Methods: The Island Particle Model, Statistics and Computing 25, 2015.
    """

    def __init__(
        self,
        *,
        particles: int = 400,
        odometry_scale: float = 1.0,
        sighting_scale: float = 1.0,
        systematic: float = 1.0,
        nod_deg: float = 0.15,
        repeat: float = 0.5,
    ) -> None:
        """Set the rules.

        Args:
            particles: Number of particles, about 20 in each island; rounded up to a multiple of the islands.
            odometry_scale: Factor on the standard deviation of odometry.
            sighting_scale: Factor on the standard deviation of sightings.
            systematic: Distance over which systematic errors of odometry are assumed to equal its noise [m]; infinite
                for none.
            nod_deg: Pitch and roll of the robot at constant speed, standard deviation; they shift all sightings of one
                picture.
            repeat: Correlated part of the variance of a camera's sightings from image to image (0 to 1), times the
                distance over which it is correlated [m].
        """
        if particles < 2:
            raise ValueError(f"particles is {particles}; it must be at least 2")
        self._islands = max(1, particles // ISLAND)
        self._number = self._islands * math.ceil(particles / self._islands)
        self._odometry_scale = odometry_scale
        self._sighting_scale = sighting_scale
        self._systematic = systematic
        self._nod, self._repeat = math.radians(nod_deg), repeat

    def start(self, robot: RobotInfo, catalogue: Mapping[str, BeaconInfo], rng: Generator) -> None:
        """Draw the first poses from the prior; the maps are empty."""
        self._rng = rng
        covariance = np.asarray(robot.prior_covariance, dtype=float)
        self._poses = rng.multivariate_normal(robot.prior.as_array(), covariance, self._number, method="svd")
        self._weights = np.full(self._number, 1.0 / self._number)
        self._index: dict[str, int] = {}
        self._means = np.zeros((self._number, 16, 2))
        self._covariances = np.zeros((self._number, 16, 2, 2))
        self._proposals = np.zeros((self._number, 3, 3))
        self._odometry_errors = OdometryErrors(self._systematic)
        self._errors, self._error_covariance = np.zeros((self._number, COUNT)), np.zeros((COUNT, COUNT))
        halves = 0 if math.isinf(self._systematic) else self._islands // 2
        self._exact_islands = np.arange(self._islands) < halves
        self._exact = np.repeat(self._exact_islands, self._number // self._islands)
        self._part, self._evidence = halves / self._islands, 0.0
        self._failures = np.zeros(self._islands)
        self._picture_errors = PictureErrors(robot, nod=self._nod, repeat=self._repeat)
        self._recent, self._relocation = RecentMotion(), Relocation()

    def update(self, seen: Observation) -> Estimate:
        """Return the belief after this tick's odometry and sightings."""
        moved = seen.odometry
        self._recent.move(moved, seen.time)
        self._picture_errors.move(moved, seen.sightings)
        noises = each_of(self._picture_errors.covariance(seen.sightings, scale=self._sighting_scale))
        looks = list(zip(seen.sightings, noises, strict=True))
        known = [(sighting, R) for sighting, R in looks if sighting.name in self._index]
        covariance = moved.covariance * self._odometry_scale**2
        delay = float(self._weights @ self._errors[:, 3]) / (1.0 - self._part)
        control, slopes, gained = self._odometry_errors.step(moved, covariance, seen.dt, delay=delay)
        self._error_covariance += np.diag(gained)
        self._move(np.array([moved.forward, moved.left, moved.turn]), control, covariance, slopes, known)
        if self._relocation.lost:
            self._relocate(seen.time)
        else:
            for sighting, R in looks:
                if sighting.name is not None and sighting.name not in self._index:
                    self._add(sighting, R)
            if known:
                self._resample()
        return self._relocation.reported(self._belief(), seen)

    def lost(self) -> bool:
        """Return whether nearly all recent sightings contradict the map, or expected sightings are missing."""
        return self._relocation.doubted

    @property
    def systematic_errors(self) -> Array:
        """Estimated systematic errors of odometry, shape (4,): those of `EkfSlam.systematic_errors`."""
        return np.asarray(self._shares() @ self._errors)

    def _move(
        self, told: Array, control: Array, covariance: Array, slopes: Array, looks: list[tuple[Sighting, Array]]
    ) -> None:
        """Sample each pose from the distribution given odometry and sightings, weight it, and correct its map."""
        before, steps = self._poses, np.where(self._exact[:, None], told, control + self._errors @ slopes.T)
        expected = _compounded(before, steps)
        covariance = covariance + NEWBORN * np.eye(3)
        learning = covariance + slopes @ self._error_covariance @ slopes.T
        c, s = np.cos(self._poses[:, 2]), np.sin(self._poses[:, 2])
        G = np.zeros((self._number, 3, 3))
        G[:, 0, 0], G[:, 0, 1], G[:, 1, 0], G[:, 1, 1], G[:, 2, 2] = c, -s, s, c, 1.0
        P = G @ np.where(self._exact[:, None, None], covariance, learning) @ G.transpose(0, 2, 1)
        mean, log_weights = expected.copy(), np.zeros(self._number)
        for sighting, R in looks:
            i = self._index[sighting.name or ""]
            nu, H, H_landmark = particle_innovations(mean, self._means[:, i], sighting)
            Q = R + H_landmark @ self._covariances[:, i] @ H_landmark.transpose(0, 2, 1)
            S = Q + H @ P @ H.transpose(0, 2, 1)
            solved = np.linalg.solve(S, nu[..., None])[..., 0]
            distance = np.sum(nu * solved, axis=1)
            self._relocation.record(sighting.name, sighting, float(np.median(distance)), gate=GATE)
            if self._relocation.lost:
                continue
            good = distance < GATE
            failed = self._islands * self._by_island(self._weights * ~good).sum(axis=1)
            self._failures += RECENT * (failed - self._failures)
            K = P @ H.transpose(0, 2, 1) @ np.linalg.inv(S)
            mean += np.where(good[:, None], (K @ nu[..., None])[..., 0], 0.0)
            P = np.where(good[:, None, None], P - K @ H @ P, P)
            # A particle that cannot explain the sighting is weighted as if the sighting lay at the gate.
            log_weights -= 0.5 * (np.minimum(distance, GATE) + np.log(np.linalg.det(S)))
        self._proposals = P
        root = np.linalg.cholesky(0.5 * (P + P.transpose(0, 2, 1)) + 1e-15 * np.eye(3))
        self._poses = mean + (root @ self._rng.standard_normal((self._number, 3, 1)))[..., 0]
        self._poses[:, 2] = wrap_angles(self._poses[:, 2])
        self._learn(np.einsum("nji,nj->ni", G, self._poses - before) - steps, learning, slopes)
        weights = self._by_island(np.log(np.maximum(self._weights, TINY)) + log_weights)
        highest = weights.max(axis=1, keepdims=True)
        weights = np.exp(weights - highest)
        total = weights.sum(axis=1, keepdims=True)
        if looks and self._part:
            self._compare((highest + np.log(total))[:, 0])
        self._weights = (weights / total).ravel() / self._islands
        for sighting, R in () if self._relocation.lost else looks:
            self._correct(sighting, R)

    def _compare(self, logs: Array) -> None:
        """Add the evidence of sightings, given the logarithm of their likelihood on each island."""
        likelihoods = np.exp(logs - logs.max()) + TINY
        exact = likelihoods[self._exact_islands].mean()
        gained = math.log(exact / likelihoods[~self._exact_islands].mean())
        self._evidence = min(max(self._evidence + gained, -DECIDED), DECIDED)

    def _shares(self) -> Array:
        """Return the weights of the particles, with islands weighted by the probability of their assumption, (n,)."""
        if not self._part:
            return self._weights
        chance = 1.0 / (1.0 + math.exp(-self._evidence))
        shares = self._weights * ((1.0 - chance) / (1.0 - self._part))
        shares[self._exact] = self._weights[self._exact] * (chance / self._part)
        return shares

    def _relocate(self, time: float) -> None:
        """Move each particle of a lost robot to where its map explains the sightings, once they determine a pose."""
        shares = self._shares()
        places = {name: shares @ self._means[:, i] for name, i in self._index.items()}
        found = self._relocation.find(self._recent, time, places)
        if found is None:
            return
        seen = np.array([self._looked(sighting) for sighting in found.sightings.values()]).transpose(1, 0, 2)
        hung = self._means[:, np.array([self._index[name] for name in found.sightings])]
        self._poses = np.array([fitted(own, places) for own, places in zip(seen, hung, strict=True)])
        self._weights = np.full(self._number, 1.0 / self._number)
        self._failures[:] = 0.0

    def _looked(self, sighting: Sighting) -> Array:
        """Return a sighting in the frame of each particle, with an error of its own, shape (n, 2) [m]."""
        mean = sighting.range, sighting.bearing
        r, b = self._rng.multivariate_normal(mean, sighting.covariance, self._number, method="svd").T
        return np.stack([r * np.cos(b), r * np.sin(b)], axis=-1)

    def _learn(self, off: Array, covariance: Array, slopes: Array) -> None:
        """Update the systematic errors of odometry with the sampled steps: a Kalman update for each particle.

        Args:
            off: Sampled minus expected steps in the robot's frame, shape (n, 3).
            covariance: Covariance of the steps by odometry, with that of the errors, shape (3, 3).
            slopes: Derivative of the step by the errors, shape (3, 4).
        """
        off[:, 2] = wrap_angles(off[:, 2])
        K = np.linalg.solve(covariance, slopes @ self._error_covariance).T
        self._errors = self._errors + np.where(self._exact[:, None], 0.0, off @ K.T)
        self._error_covariance = self._error_covariance - K @ slopes @ self._error_covariance

    def _correct(self, sighting: Sighting, R: Array) -> None:
        """Correct a landmark in each particle's map: a Kalman update of two states."""
        i = self._index[sighting.name or ""]
        nu, _, H = particle_innovations(self._poses, self._means[:, i], sighting)
        P = self._covariances[:, i]
        S = R + H @ P @ H.transpose(0, 2, 1)
        K = P @ H.transpose(0, 2, 1) @ np.linalg.inv(S)
        good = np.einsum("ni,ni->n", nu, np.linalg.solve(S, nu[..., None])[..., 0]) < GATE
        self._means[good, i] += (K @ nu[..., None])[good, :, 0]
        self._covariances[good, i] = (P - K @ S @ K.transpose(0, 2, 1))[good]

    def _add(self, sighting: Sighting, R: Array) -> None:
        """Add a landmark to each map, where its particle sees it."""
        i = len(self._index)
        self._index[sighting.name or ""] = i
        if i == self._means.shape[1]:
            self._means = np.concatenate([self._means, np.zeros_like(self._means)], axis=1)
            self._covariances = np.concatenate([self._covariances, np.zeros_like(self._covariances)], axis=1)
        direction = self._poses[:, 2] + sighting.bearing
        c, s = np.cos(direction), np.sin(direction)
        J = np.stack([np.stack([c, -sighting.range * s], -1), np.stack([s, sighting.range * c], -1)], axis=-2)
        self._means[:, i] = self._poses[:, :2] + sighting.range * np.stack([c, s], axis=-1)
        self._covariances[:, i] = J @ R @ J.transpose(0, 2, 1)

    def _resample(self) -> None:
        """Resample each island in which few particles have most of the weight; replace lost islands."""
        weights = self._islands * self._by_island(self._weights)
        drawn = np.arange(self._number).reshape(self._islands, -1)
        exact = self._exact_islands
        for island in np.flatnonzero(self._failures > LOST).tolist():
            sound = np.flatnonzero((self._failures < SOUND) & (exact == exact[island]))
            if not len(sound):
                continue
            copied = int(self._rng.choice(sound))
            drawn[island], weights[island] = drawn[copied], weights[copied]
            self._failures[island] = self._failures[copied]
        size = weights.shape[1]
        for island in np.flatnonzero(1.0 / np.sum(weights**2, axis=1) < 0.5 * size).tolist():
            drawn[island] = drawn[island, systematic_resample_with(weights[island], self._rng)]
            weights[island] = 1.0 / size
        rows = drawn.ravel()
        self._poses, self._means, self._errors = self._poses[rows], self._means[rows], self._errors[rows]
        self._covariances, self._proposals = self._covariances[rows], self._proposals[rows]
        self._weights = weights.ravel() / self._islands

    def _by_island(self, values: Array) -> Array:
        """Return values of particles (n,) by island, shape (islands, particles of each)."""
        return values.reshape(self._islands, -1)

    def _belief(self) -> Estimate:
        """Return mean and covariance over the particles, of the pose and of each landmark.

        A particle represents the Gaussian that it was drawn from: if one has nearly all of the weight, the spread of
        the others says nothing about the error of that one.
        """
        w = self._shares()
        differences = self._poses - self._poses[np.argmax(w)]
        differences[:, 2] = wrap_angles(differences[:, 2])
        offset = w @ differences
        centred = differences - offset
        landmarks: dict[Hashable, tuple[Array, Array]] = {}
        for name, i in self._index.items():
            mean = w @ self._means[:, i]
            deviations = self._means[:, i] - mean
            covariance = np.einsum("n,nij->ij", w, self._covariances[:, i]) + (deviations * w[:, None]).T @ deviations
            landmarks[name] = (mean, covariance)
        pose = Pose.from_array(self._poses[np.argmax(w)] + offset)
        within = np.einsum("n,nij->ij", w, self._proposals)
        return Estimate(pose, (centred * w[:, None]).T @ centred + within + 1e-12 * np.eye(3), landmarks)


def _compounded(poses: Array, steps: Array) -> Array:
    """Return poses (n, 3), each moved by a step (forward, left, turn), (n, 3)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    forward, left, turn = steps.T
    return np.stack(
        [poses[:, 0] + c * forward - s * left, poses[:, 1] + s * forward + c * left, poses[:, 2] + turn], axis=-1
    )


def particle_innovations(poses: Array, landmarks: Array, sighting: Sighting) -> tuple[Array, Array, Array]:
    """Return nu (n, 2) and the derivatives of the measurement by pose (n, 2, 3) and landmark (n, 2, 2)."""
    dx, dy = (landmarks - poses[:, :2]).T
    squared = dx**2 + dy**2
    distance = np.sqrt(squared)
    H = np.zeros((len(poses), 2, 2))
    H[:, 0, 0], H[:, 0, 1], H[:, 1, 0], H[:, 1, 1] = dx / distance, dy / distance, -dy / squared, dx / squared
    turned = np.broadcast_to(np.array([[0.0], [-1.0]]), (len(poses), 2, 1))
    bearing = wrap_angles(sighting.bearing - (np.arctan2(dy, dx) - poses[:, 2]))
    return np.stack([sighting.range - distance, bearing], axis=-1), np.concatenate([-H, turned], axis=2), H
