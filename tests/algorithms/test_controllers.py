"""Controllers on plants whose answer is known."""

import math

import numpy as np
import pytest

from mjsim.algorithms.paths.controllers import Pid, feedback_linearisation, lqr_gains, path_errors
from mjsim.geometry import Pose

DT = 0.02


def first_order(pid, target, seconds, gain=1.0, time_constant=1.0):
    """Drive x' = (gain u - x) / T towards a target; return x over time."""
    x, history = 0.0, []
    for _ in range(int(seconds / DT)):
        x += DT * (gain * pid(target - x, DT) - x) / time_constant
        history.append(x)
    return np.array(history)


def test_proportional_action_leaves_the_known_offset():
    assert first_order(Pid(4.0), 1.0, 10.0)[-1] == pytest.approx(4.0 / 5.0, rel=1e-6)


def test_integral_action_leaves_none():
    assert first_order(Pid(4.0, 2.0), 1.0, 60.0)[-1] == pytest.approx(1.0, abs=1e-6)


def test_a_long_saturation_winds_nothing_up():
    pid = Pid(4.0, 4.0, limit=1.2)
    path = first_order(pid, 1.0, 20.0)
    assert path.max() < 1.03
    wound = Pid(4.0, 4.0)
    x, worst = 0.0, 0.0
    for _ in range(1000):
        x += DT * (min(wound(1.0 - x, DT), 1.2) - x)
        worst = max(worst, x)
    assert worst > 1.05  # the same gains, cut off outside the controller, do wind up


def test_the_derivative_is_that_of_a_low_pass():
    pid = Pid(0.0, 0.0, 1.0, filter_time=0.1)
    slope = [pid(0.5 * DT * k, DT) for k in range(200)]
    assert slope[-1] == pytest.approx(0.5, rel=1e-6)
    # After one time constant a low pass is at 63 %.
    assert slope[round(0.1 / DT)] == pytest.approx(0.5 * (1 - math.exp(-1)), rel=0.12)


def test_feedback_linearisation_gives_the_point_ahead_its_velocity():
    pose, wanted, b = Pose(1.0, 2.0, 0.7), np.array([0.3, -0.2]), 0.15
    command = feedback_linearisation(pose, wanted, ahead=b)
    h = 1e-6
    moved = pose @ Pose(command.forward * h, 0.0, command.turn * h)
    points = [np.array([p.x + b * math.cos(p.heading), p.y + b * math.sin(p.heading)]) for p in (pose, moved)]
    np.testing.assert_allclose((points[1] - points[0]) / h, wanted, atol=1e-5)


def test_lqr_gains_are_those_of_the_continuous_regulator_for_short_periods():
    # For x'' = u with weights q1, q2, r: k1 = sqrt(q1/r) / v..., worked out from the Riccati equation by hand.
    v, q1, q2, r = 0.5, 4.0, 1.0, 1.0
    k1 = math.sqrt(q1 / r)
    k2 = math.sqrt(q2 / r + 2.0 * v * k1)
    np.testing.assert_allclose(lqr_gains(v, 1e-4, lateral=q1, heading=q2, effort=r), (k1, k2), rtol=1e-3)


def test_lqr_gains_are_those_to_which_a_long_horizon_leads():
    v, dt, Q, r = 0.4, 0.1, np.diag([3.0, 0.7]), 0.5
    A, B = np.array([[1.0, v * dt], [0.0, 1.0]]), np.array([[0.5 * v * dt**2], [dt]])
    P = Q
    for _ in range(2000):  # Bellman's recursion from the last step backwards
        K = np.linalg.solve(B.T @ P @ B + r, B.T @ P @ A)
        P = Q + A.T @ P @ (A - B @ K)
    np.testing.assert_allclose(lqr_gains(v, dt, lateral=3.0, heading=0.7, effort=r), K[0], rtol=1e-9)


def test_lqr_leads_a_robot_back_to_its_path():
    K, pose = lqr_gains(0.5, 0.04), Pose(0.0, 0.6, 0.8)
    for _ in range(400):
        error = path_errors(pose, np.array([pose.x, 0.0]), 0.0)
        pose = pose @ Pose(0.5 * 0.04, 0.0, float(-K @ error) * 0.04)
    assert abs(pose.y) < 1e-3
    assert abs(pose.heading) < 1e-3


def test_errors_are_positive_to_the_left_of_the_path():
    np.testing.assert_allclose(path_errors(Pose(0.0, 1.0, 0.2), np.zeros(2), 0.0), (1.0, 0.2))
    np.testing.assert_allclose(
        path_errors(Pose(-1.0, 0.0, math.pi / 2), np.zeros(2), math.pi / 2), (1.0, 0.0), atol=1e-12
    )
