"""Evidence that odometry is rougher than its data sheet."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.algorithms.estimation.rough_odometry import MAX_GAIN, ROUGH, RoughOdometry
from mjsim.interface import Sighting

R = np.diag([0.02, 0.01]) ** 2
Q = np.diag([0.02, 0.01, 0.01]) ** 2
LANDMARKS = np.array([(3.0, 1.0), (1.0, -2.0), (-2.0, 2.0)])


def sighting_of(landmark, pose, noise=(0.0, 0.0)):
    z = range_bearing(pose, landmark[None])[0][0] + noise
    return Sighting(0.0, "post", *z.tolist(), R)


def test_the_evidence_of_one_sighting_is_the_ratio_of_its_densities():
    rough, pose, F = RoughOdometry(), np.array([0.3, -0.2, 0.4]), np.array([[1.0, 0, 0.2], [0, 1, 0.1], [0, 0, 1]])
    rough.move(F, Q)
    rough.see(pose, LANDMARKS[0], sighting_of(LANDMARKS[0], pose, noise=(0.05, -0.02)))
    H = range_bearing(pose, LANDMARKS[:1])[1][0]
    stated, more = (multivariate_normal(cov=H @ (scale * Q) @ H.T + 2.0 * R) for scale in (1.0, ROUGH))
    expected = more.logpdf([0.05, -0.02]) - stated.logpdf([0.05, -0.02])
    assert rough.evidence == pytest.approx(expected, rel=1e-9)
    assert rough.odds == pytest.approx(0.1 * np.exp(expected))


def test_one_wrong_sighting_decides_nothing():
    rough, pose = RoughOdometry(), np.zeros(3)
    rough.move(np.eye(3), Q)
    rough.see(pose, LANDMARKS[0], sighting_of(LANDMARKS[0], pose, noise=(3.0, 0.0)))
    assert rough.evidence == MAX_GAIN


@pytest.mark.parametrize(("scale", "is_rough"), [(1.0, False), (ROUGH, True)])
def test_noise_of_odometry_is_told_from_the_stated(scale, is_rough):
    rng, rough = np.random.default_rng(4), RoughOdometry()
    for tick in range(60):
        # The graph is where sightings say; since then odometry has erred.
        rough.move(np.eye(3), Q)
        truth = rng.multivariate_normal(np.zeros(3), scale * Q)
        landmark = LANDMARKS[tick % 3]
        rough.see(np.zeros(3), landmark, sighting_of(landmark, truth, noise=rng.multivariate_normal(np.zeros(2), R)))
        rough._covariances[:], rough._offsets[:] = 0.0, 0.0
    assert (rough.evidence > 3.0) if is_rough else (rough.evidence < -1.0)
