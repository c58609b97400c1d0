"""Inverse kinematics: poses come back, limits are kept, and what is out of reach is said."""

import numpy as np
import pytest

from mjsim.mechanics import Arm
from mjsim.mechanics.inverse import PoseGoals
from mjsim.mechanics.inverse import _inside as inside
from tests.mechanics.arms import PUMA_ROWS, SLIDE_ROWS, TABLES, UP6_ROWS, arm_of

NANOMETRE = 1e-9


def limited(rows, degrees, **more):
    return Arm.from_dh([{**row, "range_deg": limits} for row, limits in zip(rows, degrees, strict=True)], **more)


PUMA = limited(PUMA_ROWS, [(-160, 160), (-45, 225), (-225, 45), (-110, 170), (-100, 100), (-266, 266)])
UP6 = limited(UP6_ROWS, [(-170, 170), (-90, 155), (-170, 190), (-180, 180), (-45, 225), (-360, 360)], unit="mm")


@pytest.mark.parametrize("arm", [PUMA, UP6], ids=["Puma 560", "UP6"])
def test_fifty_of_fifty_poses_come_back_within_the_limits(arm):
    lower, upper = arm.limits
    q = np.random.default_rng(5).uniform(lower, upper, (50, 6))
    poses = arm.fkine(q)
    found = arm.ikine(poses)
    assert found.converged.all()
    assert np.linalg.norm(arm.fkine(found.q)[:, :3, 3] - poses[:, :3, 3], axis=-1).max() < NANOMETRE
    np.testing.assert_allclose(arm.fkine(found.q), poses, atol=NANOMETRE)
    assert (found.q >= lower).all()
    assert (found.q <= upper).all()


@pytest.mark.parametrize("name", TABLES)
def test_the_nearest_solution_is_found_from_beside_it(name):
    arm = arm_of(name)
    q = np.random.default_rng(6).uniform(-0.4, 0.7, (50, arm.n))
    found = arm.ikine(arm.fkine(q), q0=q + 0.02)
    assert found.converged.all()
    assert np.abs(found.q - q).max() < 0.2


def test_a_pose_out_of_reach_is_not_reached_and_says_by_how_much():
    far = np.eye(4)
    far[0, 3] = 5.0
    found = PUMA.ikine(far, mask=(1, 1, 1, 0, 0, 0))
    assert not found.converged
    reach = np.linalg.norm(PUMA.fkine(found.q)[:3, 3] - far[:3, 3])
    assert found.distance == pytest.approx(reach)
    # The wrist reaches a sphere about the shoulder, 0.672 m up: a2 + |(a3, d4)| outwards and d3 beside.
    stretched = np.hypot(0.4318 + np.hypot(0.0203, 0.4318), 0.15005)
    assert reach == pytest.approx(np.hypot(5.0, 0.67183) - stretched, abs=1e-9)


def test_the_search_for_a_pose_out_of_reach_is_bounded(monkeypatch):
    rounds, solved = [], np.linalg.solve
    monkeypatch.setattr(np.linalg, "solve", lambda *given: rounds.append(1) or solved(*given))
    for place in ((1.6, 0.1, 0.5), (0.3, -1.2, 0.9), (0.0, 0.0, 1.8)):
        far = np.eye(4)
        far[:3, 3] = place
        assert not PUMA.ikine(far, np.zeros(6), mask=(1, 1, 1, 0, 0, 0)).converged
    assert len(rounds) <= 3 * 3 * 60  # three rounds of 60 steps each, not one for each of 40 tries


def test_an_arm_of_three_joints_reaches_points():
    arm = Arm.from_dh(SLIDE_ROWS)
    q = np.array([0.3, 0.4, -0.5])
    found = arm.ikine(arm.fkine(q), mask=(1, 1, 1, 0, 0, 0))
    assert found.converged
    np.testing.assert_allclose(arm.fkine(found.q)[:3, 3], arm.fkine(q)[:3, 3], atol=NANOMETRE)


def test_the_same_question_has_the_same_answer():
    pose = PUMA.fkine([2.0, 1.0, -3.0, 1.0, 1.0, 2.0])
    np.testing.assert_array_equal(PUMA.ikine(pose).q, PUMA.ikine(pose).q)


def test_what_is_no_pose_is_refused():
    with pytest.raises(ValueError, match=r"^T holds no poses; give homogeneous transforms of shape \(\.\.\., 4, 4\)$"):
        PUMA.ikine(2.0 * np.eye(4))


def _task(lower, upper, slides=0.0):
    link = {"range": [-1.0, 1.0], "slide": True} if slides else {}
    chain = Arm.from_dh([{"a": 1.0, **link}])._chain
    return PoseGoals(chain, np.array([lower]), np.array([upper]), np.eye(4)[None], np.ones(6))


@pytest.mark.parametrize(
    ("limits", "value", "wanted"),
    [
        ((-1.0, 1.0), 0.5, 0.5),
        ((-1.0, 1.0), 0.5 + 2 * np.pi, 0.5),
        ((-1.0, 1.0), 0.5 - 6 * np.pi, 0.5),
        ((-1.0, 1.0), 1.5, 1.5 - 2 * np.pi),
        ((5.0, 9.0), 0.0, 2 * np.pi),
        ((-9.0, -5.0), 0.0, -2 * np.pi),
        ((-np.inf, 1.0), 1.5, 1.5 - 2 * np.pi),
        ((-1.0, np.inf), -1.5, -1.5 + 2 * np.pi),
        ((-np.inf, np.inf), 3.5, 3.5 - 2 * np.pi),
        ((-np.inf, np.inf), -7.0, -7.0 + 2 * np.pi),
    ],
)
def test_a_joint_that_turns_is_brought_within_its_limits_by_whole_turns(limits, value, wanted):
    # What no whole turn brings within them lies at the limit.
    assert inside(_task(*limits), np.array([[value]]))[0, 0] == pytest.approx(np.clip(wanted, *limits))


def test_a_joint_that_slides_has_no_turns():
    assert inside(_task(-1.0, 1.0, slides=1.0), np.array([[0.5 + 2 * np.pi]]))[0, 0] == 1.0
    assert inside(_task(-1.0, 9.0, slides=1.0), np.array([[2 * np.pi]]))[0, 0] == pytest.approx(2 * np.pi)
