"""Paths of joints and tools: another toolbox's, ends, derivatives, and what is refused."""

import numpy as np
import pytest

from mjsim.mechanics import ctraj, jtraj
from tests.mechanics.arms import PARAMETERS, arm_of, golden


def test_the_quintic_is_that_of_another_toolbox():
    known = golden("up6")
    q, qd, qdd = jtraj(PARAMETERS["up6"]["q0"], PARAMETERS["up6"]["q1"], known["t"])
    np.testing.assert_allclose(q, known["jtraj_q"], atol=1e-12)
    np.testing.assert_allclose(qd, known["jtraj_qd"], atol=1e-12)
    np.testing.assert_allclose(qdd, known["jtraj_qdd"], atol=1e-12)
    along = arm_of("UP6").fkine(q[::10])
    np.testing.assert_allclose(along[:, :3, 3], known["fkine_along"][:, :3, 3] / 1000.0, atol=1e-12)


def test_rates_at_the_ends_are_those_asked_for():
    t = np.linspace(2.0, 5.0, 3001)
    q, qd, qdd = jtraj([0.0, 1.0], [2.0, -1.0], t, qd0=[0.5, 0.0], qd1=-0.3)
    np.testing.assert_allclose(q[[0, -1]], [[0.0, 1.0], [2.0, -1.0]], atol=1e-12)
    np.testing.assert_allclose(qd[[0, -1]], [[0.5, 0.0], [-0.3, -0.3]], atol=1e-12)
    np.testing.assert_allclose(qdd[[0, -1]], 0.0, atol=1e-11)
    # Central differences at 1 ms err with the third derivative, some 5 per s^3.
    np.testing.assert_allclose(np.gradient(q, t, axis=0)[1:-1], qd[1:-1], atol=1e-5)
    np.testing.assert_allclose(np.gradient(qd, t, axis=0)[1:-1], qdd[1:-1], atol=1e-5)


def test_several_paths_at_a_time_are_each_its_own():
    first, last = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 4, 3))
    q, _, _ = jtraj(first, last, 11)
    assert q.shape == (4, 11, 3)
    np.testing.assert_array_equal(q[2], jtraj(first[2], last[2], 11)[0])


def test_a_tool_goes_straight_and_turns_about_one_axis():
    arm = arm_of("UP6")
    first, last = arm.fkine([[0.1, 0.4, 0.2, 0.3, 0.5, 0.1], [-0.8, 0.2, 0.6, -0.3, 0.9, 1.5]])
    poses = ctraj(first, last, np.linspace(0.0, 3.0, 31))
    np.testing.assert_allclose(poses[[0, -1]], [first, last], atol=1e-12)
    way = poses[:, :3, 3] - first[:3, 3]
    line = last[:3, 3] - first[:3, 3]
    np.testing.assert_allclose(np.cross(way, line), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], -1, -2), np.eye(3) + np.zeros((31, 3, 3)), atol=1e-12
    )
    turns = poses[1:, :3, :3] @ np.swapaxes(poses[:-1, :3, :3], -1, -2)
    axes = np.stack(
        [turns[:, 2, 1] - turns[:, 1, 2], turns[:, 0, 2] - turns[:, 2, 0], turns[:, 1, 0] - turns[:, 0, 1]], -1
    )
    axes = axes / np.linalg.norm(axes, axis=-1, keepdims=True)
    np.testing.assert_allclose(axes, axes[[15]] + np.zeros_like(axes), atol=1e-9)


def test_a_half_turn_is_made_and_not_lost():
    half = np.diag([-1.0, -1.0, 1.0, 1.0])
    poses = ctraj(np.eye(4), half, 5)
    np.testing.assert_allclose(poses[-1], half, atol=1e-12)
    np.testing.assert_allclose(np.abs(poses[2, :3, :3]), [[0, 1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize("times", [[0.0], [0.0, 0.0], [1.0, 0.5], [0.0, np.nan], 1])
def test_times_that_do_not_increase_are_refused(times):
    with pytest.raises(ValueError, match=r"^t must hold at least two finite times"):
        jtraj([0.0], [1.0], times)
