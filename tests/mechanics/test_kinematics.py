"""Poses and Jacobians of arms against another toolbox, plain products of matrices and differences."""

import numpy as np
import pytest

from mjsim.mechanics import Arm, inverted, placed, rpy_of
from tests.mechanics.arms import TABLES, UP6_ROWS, arm_of, golden, plain_frames

ROUNDING = 1e-12
"""[m, rad]; a dozen products of doubles near 1."""
IN_METRES = np.array([1e-3] * 3 + [1.0] * 3)[:, None]
"""The toolbox had the UP6 in millimetres; rotations are the same."""


def in_metres(poses):
    poses = poses.copy()
    poses[..., :3, 3] /= 1000.0
    return poses


@pytest.mark.parametrize(("name", "file"), [("UP6", "up6"), ("Puma 560", "puma560")])
def test_poses_and_jacobians_are_those_of_another_toolbox(name, file):
    arm, known = arm_of(name), golden(file)
    poses, scale = (in_metres(known["fkine"]), IN_METRES) if file == "up6" else (known["fkine"], 1.0)
    np.testing.assert_allclose(arm.fkine(known["q"]), poses, atol=ROUNDING)
    np.testing.assert_allclose(arm.jacob0(known["q"]), scale * known["jacob0"], atol=ROUNDING)
    if "jacobe" in known:
        np.testing.assert_allclose(arm.jacobe(known["q"]), scale * known["jacobe"], atol=ROUNDING)


def test_the_flange_of_the_up6_is_where_its_maker_draws_it_at_zero():
    np.testing.assert_allclose(arm_of("UP6").fkine(np.zeros(6))[:3, 3], [0.850, 0.0, -0.735], atol=ROUNDING)


@pytest.mark.parametrize("name", TABLES)
def test_the_chain_is_the_plain_product_of_its_matrices(name):
    arm = arm_of(name)
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (1000, arm.n))
    plain = np.array([plain_frames(name, values) for values in q])
    posture = arm.posture(q)
    np.testing.assert_allclose(posture.links, plain, atol=ROUNDING)
    np.testing.assert_allclose(arm.fkine(q), plain[:, -1], atol=ROUNDING)


@pytest.mark.parametrize("name", TABLES)
def test_jacobians_match_central_differences(name):
    arm, step = arm_of(name), 1e-6
    q = np.random.default_rng(2).uniform(-2.0, 2.0, (20, arm.n))
    jacobian, poses = arm.jacob0(q), arm.fkine(q)
    for joint, offset in enumerate(np.eye(arm.n) * step):
        slope = (arm.fkine(q + offset) - arm.fkine(q - offset)) / (2 * step)
        spin = slope[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], -1, -2)
        turned = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=-1)
        np.testing.assert_allclose(jacobian[:, :3, joint], slope[:, :3, 3], atol=1e-8)
        np.testing.assert_allclose(jacobian[:, 3:, joint], turned, atol=1e-8)


def test_base_and_tool_stand_before_and_behind_the_chain():
    base, tool = np.eye(4), np.eye(4)
    base[:3] = [[0, -1, 0, 2], [1, 0, 0, 1], [0, 0, 1, 0.5]]
    tool[:3, 3] = [0.0, 0.0, 0.1]
    bare, arm = arm_of("UP6"), Arm.from_dh(UP6_ROWS, unit="mm", base=base, tool=tool)
    q = np.random.default_rng(3).uniform(-2.0, 2.0, (10, 6))
    np.testing.assert_allclose(arm.fkine(q), base @ bare.fkine(q) @ tool, atol=ROUNDING)


def test_any_leading_axes_are_kept():
    arm = arm_of("with a slide")
    q = np.random.default_rng(4).uniform(-1.0, 1.0, (4, 5, 3))
    assert arm.fkine(q).shape == (4, 5, 4, 4)
    np.testing.assert_array_equal(arm.jacob0(q)[2, 3], arm.jacob0(q[2, 3]))
    np.testing.assert_array_equal(arm.rne(q, q, q)[1, 4], arm.rne(q[1, 4], q[1, 4], q[1, 4]))
    np.testing.assert_array_equal(arm.rne(q, q[0, 0], 0 * q[0, 0])[1, 4], arm.rne(q[1, 4], q[0, 0], np.zeros(3)))


def test_a_posture_of_another_arm_is_refused_in_one_sentence():
    with pytest.raises(ValueError, match=r"^q has shape \(3,\); its last axis must have 6, one for each joint$"):
        arm_of("UP6").fkine([0.0, 0.0, 0.0])


def test_a_picture_shows_each_posture_and_names_the_arm():
    arm = Arm.from_dh(UP6_ROWS, unit="mm", name="up6")
    figure = arm.plot(np.linspace(np.zeros(6), np.full(6, 0.5), 3))
    (axes,) = figure.axes
    assert axes.get_title() == "up6"
    way = next(line for line in axes.lines if len(line.get_data_3d()[0]) == 3)
    np.testing.assert_allclose(np.array(way.get_data_3d()).T[-1], arm.fkine(np.full(6, 0.5))[:3, 3])


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2, 1.57, 0.3])
def test_roll_pitch_and_yaw_give_back_their_rotation_also_straight_up_and_down(pitch):
    there = placed((0.0, 0.0, 0.0), (0.3, 0.2, 0.1))
    for roll, yaw in ((0.0, 0.7), (0.4, 0.0), (-2.0, 1.0)):
        # There and back, rounded: at a right angle the cosine of the pitch is noise of about 1e-16.
        pose = inverted(there) @ (there @ placed((0.0, 0.0, 0.0), (roll, pitch, yaw)))
        np.testing.assert_allclose(placed((0.0, 0.0, 0.0), rpy_of(pose)), pose, atol=1e-12)
