"""Innovations prove that a robot has moved in a way that nobody stated, or that sensors err by more than stated."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.algorithms.estimation.misfit import IMPROBABLE, Misfit, improbable
from mjsim.bench import disturbed
from mjsim.bench.disturbed import CASES
from mjsim.interface import Sighting

S = np.diag([0.06, 0.02]) ** 2
GATE = 13.8


def excesses(offsets, *, looks=60, seed=0):
    """Return what innovations of k sightings with some offsets (k, 2) prove, look by look."""
    rng, misfit, found = np.random.default_rng(seed), Misfit(), []
    for look in range(looks):
        nu = np.asarray(offsets) + rng.normal(0.0, np.sqrt(np.diag(S)), (len(offsets), 2))
        sightings = [Sighting(0.2 * look, f"l{k}", 3.0, 0.0, S) for k in range(len(nu))]
        found.append(misfit.excess(0.2 * look, sightings, nu, np.array([S] * len(nu)), gate=GATE))
    return found


@pytest.mark.parametrize("freedom", [4, 10, 40, 200])
def test_the_bound_of_chance_is_that_of_chi_square(freedom):
    assert improbable(freedom) == pytest.approx(chi2.isf(norm.sf(IMPROBABLE), freedom), rel=0.05)


@pytest.mark.parametrize("seed", range(3))
def test_innovations_as_expected_prove_nothing(seed):
    assert not any(each is not None for each in excesses(np.zeros((2, 2)), looks=300, seed=seed))


def test_a_displacement_near_the_gate_is_proven_within_a_second_with_its_size():
    found = excesses([(0.18, 0.0), (0.16, 0.03)])
    first = next(look for look, each in enumerate(found) if each is not None)
    assert first <= 5
    np.testing.assert_allclose(np.sqrt(found[first][0]), np.sqrt(0.5 * (0.17**2 + 0.5 * 0.09**2)), rtol=0.3)


def test_a_landmark_that_was_moved_says_nothing_about_the_robot():
    assert not any(each is not None for each in excesses([(0.0, 0.0), (0.0, 0.0), (2.0, 0.0)]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "case", ["turns by 0.5 degrees per second", "bearings off by 2 degrees", "ranges 4 % long", "turns 10 % short"]
)
def test_a_robot_whose_sensors_err_by_more_than_stated_is_not_surely_wrong(case):
    run = disturbed.drive({"slam": EkfSlam()}, 1, room=CASES[case][0])["slam"]
    assert run.longest_wrong() < 6.0
    assert run.nees.mean() < 6.0


@pytest.mark.slow
def test_large_errors_are_never_believed_where_there_are_none():
    class Watched(EkfSlam):
        def update(self, seen):
            belief = super().update(seen)
            assert not self._rivals.is_wide
            return belief

    for seed in range(2):
        disturbed.drive({"slam": Watched()}, seed)
