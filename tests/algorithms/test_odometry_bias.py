"""What odometry errs by all the time is learnt from scans, as far as they tell."""

import numpy as np

from mjsim.algorithms.scans.odometry_bias import OdometryBias
from mjsim.geometry import wrap_angle

BEFORE = np.diag([0.02, 0.02, 0.01]) ** 2
"""Covariance of a step by odometry [m^2, rad^2]."""
GAIN, TURN = 1.1, np.radians(-0.3)
"""Odometry tells ways that are too long, and turns by this for each second [rad/s]."""


def drive(bias, scans, *, steps, slip=0.0, turn=TURN):
    """Let it learn from steps of 0.3 m, with scans of some covariance fused with odometry."""
    rng = np.random.default_rng(1)
    for k in range(steps):
        true = np.array([0.3, 0.0, 0.2 if k % 3 == 0 else 0.0])
        told = true * (GAIN, 1.0, 1.0) + (0.0, 0.0, 0.4 * turn) + rng.normal(0.0, np.sqrt(np.diag(BEFORE)) / 10)
        told[2] += slip * (k % 7 == 3)
        guess = bias.corrected(told, 0.4)
        before = BEFORE + bias.step_covariance(told, 0.3, 0.4)
        after = np.linalg.inv(np.linalg.inv(scans) + np.linalg.inv(before))
        off = true - guess
        off[2] = wrap_angle(float(off[2]))
        correction = after @ np.linalg.inv(scans) @ off
        bias.learn(told, 0.3, 0.4, correction, BEFORE, after)


def test_a_gain_and_a_drift_of_odometry_are_learnt():
    bias = OdometryBias()
    drive(bias, 1e-6 * np.eye(3), steps=300)
    told = np.array([0.33, 0.0, 0.4 * TURN])
    np.testing.assert_allclose(bias.corrected(told, 0.4), [0.3, 0.0, 0.0], atol=0.003)
    assert abs(bias.errors[0] - (1.0 - 1.0 / GAIN)) < 3.0 * np.sqrt(bias.covariance[0, 0])


def test_where_scans_tell_nothing_along_the_way_the_gain_stays_unknown():
    bias = OdometryBias()
    drive(bias, np.diag([1e6, 1e-6, 1e-6]), steps=300)
    assert abs(bias.errors[0]) < 0.01
    assert np.sqrt(bias.covariance[0, 0]) > 0.03
    assert abs(bias.corrected(np.array([0.3, 0.0, 0.4 * TURN]), 0.4)[2]) < 0.001


def test_slips_teach_nothing():
    bias, without = OdometryBias(), OdometryBias()
    drive(bias, 1e-6 * np.eye(3), steps=300, slip=0.5)
    drive(without, 1e-6 * np.eye(3), steps=300)
    straight = np.array([0.33, 0.0, 0.4 * TURN])
    np.testing.assert_allclose(bias.corrected(straight, 0.4), without.corrected(straight, 0.4), atol=0.004)


def test_no_motion_is_corrected_to_no_motion():
    bias = OdometryBias()
    drive(bias, 1e-6 * np.eye(3), steps=50)
    np.testing.assert_array_equal(bias.corrected(np.zeros(3), 0.0), np.zeros(3))


def test_a_turn_of_two_degrees_a_second_is_learnt_and_taken_for_no_slip():
    bias = OdometryBias()
    drive(bias, 1e-6 * np.eye(3), steps=20, turn=np.radians(2.0))
    straight = np.array([0.33, 0.0, 0.4 * np.radians(2.0)])
    assert abs(bias.corrected(straight, 0.4)[2]) < 0.1 * straight[2]


def test_where_the_lidar_is_mounted_is_learnt_from_turns():
    bias, rng, arm = OdometryBias(), np.random.default_rng(2), np.array([0.2, -0.05])
    for k in range(60):
        turn = rng.uniform(-0.3, 0.3) * (k % 2)
        c, s = np.cos(turn), np.sin(turn)
        told = np.array([0.3, 0.0, turn]) + rng.normal(0.0, 0.002, 3)
        true = told + np.array([[c - 1.0, -s], [s, c - 1.0], [0.0, 0.0]]) @ arm
        guess, before = bias.corrected(told, 0.4), BEFORE + bias.step_covariance(told, 0.3, 0.4)
        after = np.linalg.inv(1e6 * np.eye(3) + np.linalg.inv(before))
        correction = after @ (1e6 * np.eye(3)) @ (true - guess)
        bias.learn(told, 0.3, 0.4, correction, BEFORE, after)
    np.testing.assert_allclose(bias.errors[4:], arm, atol=0.02)
    turned = np.array([0.0, 0.0, 0.5])
    ahead = [(np.cos(0.5) - 1.0) * 0.2 + np.sin(0.5) * 0.05, np.sin(0.5) * 0.2 - (np.cos(0.5) - 1.0) * 0.05]
    np.testing.assert_allclose(bias.corrected(turned, 0.4)[:2], ahead, atol=0.01)


def test_turns_that_odometry_only_seems_to_make_do_not_show_that_turns_are_told_too_large():
    bias, rng = OdometryBias(), np.random.default_rng(3)
    for _ in range(300):
        told, true = np.array([0.3, 0.0, rng.normal(0.0, 0.03)]), np.array([0.3, 0.0, 0.0])
        before = np.diag([0.02, 0.02, 0.03]) ** 2
        guess, by_both = bias.corrected(told, 0.4), before + bias.step_covariance(told, 0.3, 0.4)
        after = np.linalg.inv(1e6 * np.eye(3) + np.linalg.inv(by_both))
        correction = after @ (1e6 * np.eye(3)) @ (true - guess)
        bias.learn(told, 0.3, 0.4, correction, before, after)
    assert abs(bias.errors[1]) < 0.03
