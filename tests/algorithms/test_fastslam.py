"""FastSLAM: islands of particles, what they learn of odometry, and how honest their covariance is."""

import dataclasses

import numpy as np
import pytest

from mjsim.algorithms.fastslam import ISLAND, FastSlam
from mjsim.bench.slam_rooms import ROOMS, scores_in_room
from tests.algorithms.test_slam_estimators import ring_run
from tests.algorithms.test_slam_rooms import brief


@pytest.mark.slow
def test_what_a_population_no_longer_shows_the_difference_between_islands_does():
    """Landmarks far away; one population of 200 particles has a mean NEES of 12 in this drive."""
    score = scores_in_room(brief(ROOMS["far"], 30), {"fast": FastSlam(particles=200)}, seed=1)["fast"]
    assert 0.5 < score.nees < 5.0  # 3 is ideal
    assert score.error < 0.04


class Misled:
    """Gives an estimator odometry that tells ways too long."""

    def __init__(self, estimator, scale):
        self._estimator, self._scale = estimator, scale
        self.start = estimator.start

    def update(self, seen):
        moved = dataclasses.replace(seen.odometry, forward=seen.odometry.forward * self._scale)
        return self._estimator.update(dataclasses.replace(seen, odometry=moved))


@pytest.mark.slow
def test_an_error_of_odometry_is_learnt():
    slam = FastSlam(systematic=0.1)
    ring_run(Misled(slam, 1.25), 1)
    # Ways are told 1.25 times too long, so 0.2 of them has to go.
    assert slam.systematic_errors[0] == pytest.approx(-0.2, abs=0.07)
    # The islands that do not learn count no more.
    assert slam._shares()[slam._exact].sum() < 0.05
    without = FastSlam(systematic=np.inf)
    ring_run(Misled(without, 1.25), 1, steps=50)
    np.testing.assert_allclose(without.systematic_errors, 0.0, atol=1e-12)


def test_islands_that_learn_errors_of_odometry_and_those_that_do_not_count_by_what_they_expected():
    slam = FastSlam(particles=4 * ISLAND)
    ring_run(slam, 1, steps=6)
    slam._evidence = 0.0
    np.testing.assert_allclose(slam._shares(), slam._weights, atol=1e-12)
    likelihoods = np.array([0.2, 0.4, 0.1, 0.1])  # of a look, by island
    slam._compare(np.log(likelihoods) - 500.0)
    assert slam._shares()[slam._exact].sum() == pytest.approx(0.3 / (0.3 + 0.1))
    assert slam._shares().sum() == pytest.approx(1.0)


class Disturbed:
    """Moves the first island away once."""

    def __init__(self, estimator, tick):
        self._estimator, self._left, self.start = estimator, tick, estimator.start
        self.farthest = []

    def update(self, seen):
        self._left -= 1
        if self._left == 0:
            self._estimator._poses[:ISLAND, :2] += (3.0, 0.0)
        belief = self._estimator.update(seen)
        poses = self._estimator._poses.reshape(-1, ISLAND, 3).mean(axis=1)
        self.farthest.append(np.hypot(*(poses - np.median(poses, axis=0))[:, :2].T).max())
        return belief


@pytest.mark.slow
def test_an_island_that_is_lost_becomes_a_copy_of_one_that_is_not():
    slam = Disturbed(FastSlam(), 100)
    ring_run(slam, 2)
    assert slam.farthest[99] > 2.0
    assert slam.farthest[-1] < 0.3


def test_there_is_a_whole_number_of_particles_on_each_island():
    with pytest.raises(ValueError, match="at least 2"):
        FastSlam(particles=1)
    for particles in (2, 19, 50, 61):
        _, belief, _ = ring_run(FastSlam(particles=particles), 3, steps=6)
        assert np.linalg.eigvalsh(belief.covariance)[0] > 0.0
