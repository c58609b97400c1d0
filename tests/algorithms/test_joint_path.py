"""Paths of joints and tools: ends, speeds, ways through postures, and what cannot be done."""

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.joint_path import PEAKS, JointPath, ToolPath, between, by_rate, nearest_turn
from mjsim.geometry import Pose
from mjsim.interface import ArmInfo, Estimate, JointState, Observation, Odometry
from mjsim.mechanics import Arm, jtraj
from tests.robots import pioneer

DT = 0.04
PUMA = mjsim.arm("puma560")
BELIEF = Estimate(Pose(0.0, 0.0, 0.0), np.zeros((3, 3)))


def told(arm):
    lower, upper = arm.limits
    names = tuple(f"joint{number}" for number in range(1, arm.n + 1))
    speeds = np.array([link.max_velocity for link in arm.links])
    return ArmInfo(joints=names, lower=lower, upper=upper, max_velocity=speeds, max_torque=speeds, model=arm)


def followed(path, seconds, *, arm=PUMA, start=None):
    """Return times, positions and velocities of the goals of all ticks, the arm being where it shall be."""
    path.start(pioneer(arms={"arm": told(arm)}, dt=DT), None, np.random.default_rng(0))
    q = np.zeros(arm.n) if start is None else np.asarray(start, dtype=float)
    times, goals = np.arange(round(seconds / DT) + 1) * DT, []
    for time in times.tolist():
        state = JointState(time, q, np.zeros(arm.n), np.zeros(arm.n))
        seen = Observation(time, DT, Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))), joints={"arm": state})
        goal = path.command(seen, BELIEF).joints["arm"]
        q = np.array(goal.positions)
        goals.append(goal)
    return times, np.array([goal.positions for goal in goals]), np.array([goal.velocities for goal in goals]), goals


@pytest.mark.parametrize("law", PEAKS)
def test_each_law_goes_all_the_way_and_says_its_own_speed(law):
    s = np.linspace(0.0, 1.0, 2001)
    done, speed = np.array([between(law, share) for share in s.tolist()]).T
    assert done[[0, -1]] == pytest.approx([0.0, 1.0])
    assert speed.max() == pytest.approx(PEAKS[law], rel=1e-6)
    # Central differences err with the square of 1/2000, at corners of a trapezium with it.
    np.testing.assert_allclose(np.gradient(done, s)[1:-1], speed[1:-1], atol=2e-3)


@pytest.mark.parametrize("law", ["cubic", "quintic"])
def test_rates_at_the_ends_of_a_leg_are_added_exactly(law):
    s = np.linspace(0.0, 1.0, 2001)
    first, last = np.moveaxis(np.array([by_rate(law, share) for share in s.tolist()]), 1, 0)
    np.testing.assert_allclose(first[[0, -1]], [[0, 1], [0, 0]], atol=1e-12)
    np.testing.assert_allclose(last[[0, -1]], [[0, 0], [0, 1]], atol=1e-12)
    for values, slope in (first.T, last.T):
        np.testing.assert_allclose(np.gradient(values, s)[1:-1], slope[1:-1], atol=1e-5)


def test_a_quintic_path_is_that_of_jtraj_and_holds_its_end():
    to = [45.0, -30.0, 20.0, 10.0, 40.0, -20.0]
    times, q, qd, _ = followed(JointPath(to, seconds=2.0), 3.0)
    known, rates, _ = jtraj(np.zeros(6), np.radians(to), times[:51])
    np.testing.assert_allclose(q[:51], known, atol=1e-12)
    np.testing.assert_allclose(qd[:51], rates, atol=1e-12)
    np.testing.assert_allclose(q[51:], np.radians(to) + np.zeros((25, 6)), atol=1e-12)
    assert not qd[51:].any()


def test_goals_go_on_into_each_other():
    _, q, qd, goals = followed(
        JointPath([45, -30, 20, 10, 40, -20], via_deg=[[60, 10, -60, 0, 0, 0]], seconds=4.0), 4.0
    )
    for before, after, rate in zip(goals[:-1], q[1:], qd[1:], strict=True):
        ahead = before.after(DT)
        # Half of a mean acceleration over a tick misses by a twelfth of jerk times its cube.
        np.testing.assert_allclose(ahead.positions, after, atol=1e-4)
        np.testing.assert_allclose(ahead.velocities, rate, atol=1e-12)


@pytest.mark.parametrize("law", PEAKS)
def test_a_path_passes_the_postures_on_its_way(law):
    via, to = [60.0, 10.0, -60.0, 0.0, 0.0, 0.0], [90.0, 40.0, -20.0, 10.0, 40.0, -20.0]
    _, q, qd, _ = followed(JointPath(to, via_deg=[via], seconds=[2.0, 2.0], law=law), 4.0)
    np.testing.assert_allclose(np.degrees(q[50]), via, atol=1e-9)
    np.testing.assert_allclose(np.degrees(q[100]), to, atol=1e-9)
    if law in ("cubic", "quintic"):
        # Joints that go on the same way pass at the mean of both speeds, joints that turn back stop.
        np.testing.assert_allclose(
            np.degrees(qd[50, :3]), [(60 / 2 + 30 / 2) / 2, (10 / 2 + 30 / 2) / 2, 0.0], atol=1e-9
        )


def test_without_seconds_a_path_is_as_fast_as_the_slowest_joint_may():
    path = JointPath([45, -30, 20, 10, 40, -20])
    _, _, qd, _ = followed(path, 2.0)
    fastest = np.array([link.max_velocity for link in PUMA.links])
    assert (np.abs(qd) / fastest).max() == pytest.approx(1.0, abs=0.02)


def test_the_shorter_way_round_is_taken_where_limits_let_it():
    arm = Arm.from_dh([{"a": 1}, {"a": 1, "range_deg": [-200, 200]}, {"slide": True, "range": [0, 9]}])
    start, goal = np.radians([170.0, 170.0, 0.0]), np.radians([-170.0, -170.0, 0.0])
    start[2], goal[2] = 1.0, 8.0
    np.testing.assert_allclose(np.degrees(nearest_turn(start, goal, told(arm))[:2]), [190.0, 190.0])
    assert nearest_turn(start, goal, told(arm))[2] == 8.0
    narrow = Arm.from_dh([{"a": 1, "range_deg": [-180, 180]}])
    np.testing.assert_allclose(np.degrees(nearest_turn(start[:1], goal[:1], told(narrow))), [-170.0])


def test_a_path_waits_and_goes_back_and_forth():
    _, q, qd, _ = followed(JointPath([40, 0, 0, 0, 0, 0], seconds=1.0, wait=0.4, repeat=True), 3.4)
    np.testing.assert_allclose(np.degrees(q[[0, 10, 35, 60, 85], 0]), [0, 0, 40, 0, 40], atol=1e-9)
    np.testing.assert_allclose(qd[22, 0], -qd[48, 0], atol=1e-9)


@pytest.mark.slow
def test_a_tool_goes_straight_to_its_pose():
    start = np.radians([10, 40, -100, 20, 50, 30])
    first = PUMA.fkine(start)
    to = first[:3, 3] + [-0.2, 0.15, -0.1]
    _, q, qd, _ = followed(ToolPath(to.tolist(), seconds=2.0), 2.4, start=start)
    poses = PUMA.fkine(q)
    np.testing.assert_allclose(poses[-1, :3, 3], to, atol=1e-6)
    np.testing.assert_allclose(poses[:, :3, :3], first[:3, :3] + np.zeros((len(q), 3, 3)), atol=1e-6)
    way = poses[:, :3, 3] - first[:3, 3]
    np.testing.assert_allclose(np.cross(way, to - first[:3, 3]), 0.0, atol=1e-6)
    # Rates of the joints are those that the Jacobian makes of the tool's velocity.
    speed = np.einsum("kij,kj->ki", PUMA.jacob0(q), qd)[:, :3]
    np.testing.assert_allclose(speed[1:51], np.gradient(poses[:, :3, 3], DT, axis=0)[1:51], atol=3e-3)


@pytest.mark.slow
def test_a_tool_that_cannot_follow_its_path_says_where_it_ends():
    with pytest.raises(ValueError, match=r"^the tool cannot follow its path beyond [0-9.]+ s; "):
        followed(ToolPath([3.0, 0.0, 0.5], seconds=1.0), 0.1, start=np.radians([10, 40, -100, 20, 50, 30]))


WRONG = {
    "law is 'quintik'; it must be linear, cubic, quintic, trapezoidal": {"law": "quintik"},
    "seconds is -1; it must be above 0": {"seconds": -1},
    "seconds has 2 legs; the path has 1": {"seconds": [1, 1]},
    "wait is -1; it must be 0 or more [s]": {"wait": -1},
    "joint1 cannot go to 170; it is out of its range": {"to_deg": [170, 0, 0, 0, 0, 0], "seconds": 9},
    "a posture has 2 values; arm 'arm' has 6 joints": {"to_deg": [1, 2], "seconds": 1},
    "robot 'scout' has no arm 'left'; its arms are arm": {"arm": "left"},
    "leg 1 of the path takes 0.1 s; the joints need 0.767 s for it": {"seconds": 0.1},
}


@pytest.mark.parametrize(("sentence", "keys"), WRONG.items())
def test_a_path_that_cannot_be_is_refused_in_one_sentence(sentence, keys):
    with pytest.raises(ValueError, match=r"\A.*\Z") as caught:
        followed(JointPath(**{"to_deg": [45, 0, 0, 0, 0, 0], **keys}), 0.1)
    assert str(caught.value) == sentence


def test_an_arm_without_limits_of_speed_asks_for_seconds():
    with pytest.raises(ValueError, match=r"^arm 'arm' has no speed limits; give seconds$"):
        followed(JointPath([10] * 6), 0.1, arm=mjsim.arm("motoman_up6"))
