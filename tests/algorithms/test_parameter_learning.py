"""What an arm weighs is learnt from its motors' torques."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.arm_control import believed
from mjsim.algorithms.estimation.parameter_learning import Filtered, ParameterLearner, strength
from mjsim.interface import ArmInfo, JointState

PUMA = mjsim.arm("puma560")


def info(arm, most=None):
    lower, upper = arm.limits
    names = tuple(f"joint{number}" for number in range(1, arm.n + 1))
    torque = np.array([link.max_torque for link in arm.links]) if most is None else np.full(arm.n, most)
    return ArmInfo(
        joints=names, lower=lower, upper=upper, max_velocity=np.full(arm.n, 2.0), max_torque=torque, model=arm
    )


def learnt(truth, count, *, noise=0.0, seed=3):
    """Return a learner that begins with the Puma and saw motions of another arm."""
    learner = ParameterLearner(PUMA, info(PUMA), lag=0.02, adaptation=1.0)
    rng = np.random.default_rng(seed)
    q, qd, qdd = rng.uniform(-1.0, 1.0, (3, count, 6))
    torques = truth.rne(q, qd, qdd)
    accelerations = qdd + noise * rng.normal(size=qdd.shape)
    regressors = PUMA.regressor(q, qd, qd, accelerations)
    for W, rate, faster, torque in zip(regressors, qd, accelerations, torques, strict=True):
        learner.learn(W, rate, faster, torques=torque, dt=0.004)
    return learner


def miss(learner, truth):
    """Return the mean square root of wrong torques of motions that it has not seen, by those of the Puma."""
    q, qd, qdd = np.random.default_rng(9).uniform(-1.0, 1.0, (3, 200, 6))
    Y = PUMA.regressor(q, qd, qd, qdd)
    wrong = (Y @ (learner.parameters - truth.parameters())) ** 2
    return np.sqrt(wrong.mean() / ((Y @ (PUMA.parameters() - truth.parameters())) ** 2).mean())


@pytest.mark.slow
@pytest.mark.parametrize("scale", [0.8, 1.3])
def test_torques_of_new_motions_are_right_after_two_seconds(scale):
    truth = believed(PUMA, scale)
    assert miss(learnt(truth, 500), truth) < 0.02


def test_noise_of_accelerations_does_not_spoil_what_is_learnt():
    truth = believed(PUMA, 0.8)
    assert miss(learnt(truth, 500, noise=0.5), truth) < 0.25


def test_what_is_right_stays_right():
    np.testing.assert_allclose(learnt(PUMA, 50).parameters, PUMA.parameters(), atol=1e-9)


def test_parameters_are_never_more_doubtful_than_at_the_start():
    learner = ParameterLearner(PUMA, info(PUMA), lag=0.02, adaptation=1.0)
    first = learner.covariance.copy()
    later = learnt(PUMA, 100).covariance
    assert np.linalg.eigvalsh(first - later).min() > -1e-12
    assert np.linalg.eigvalsh(later).min() > -1e-12


def test_an_arm_without_limits_of_torque_has_what_it_needs():
    found = strength(PUMA, info(PUMA, np.inf))
    assert np.isfinite(found).all()
    assert (found > 0.0).all()
    assert found[1] > 4.0 * 37.0


def test_the_motion_behind_the_first_reading_is_not_known():
    learner = ParameterLearner(PUMA, info(PUMA), lag=0.02, adaptation=1.0)
    first, second = (JointState(0.004 * k, np.full(6, 0.1 * k), np.full(6, 0.2 * k), np.zeros(6)) for k in (0, 1))
    assert learner.motion(first, 0.004) is None
    q, qd, qdd = learner.motion(second, 0.004)
    np.testing.assert_array_equal((q, qd), np.zeros((2, 6)))
    np.testing.assert_allclose(qdd, 50.0)


def test_the_first_of_filtered_arrays_counts_in_full():
    filtered = Filtered()
    (first,) = filtered.add((np.array([2.0]),), 0.1)
    (second,) = filtered.add((np.array([4.0]),), 0.1)
    assert first[0] == pytest.approx(2.0)
    assert second[0] == pytest.approx((0.9 * 2.0 + 4.0) / 1.9)
