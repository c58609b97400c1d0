"""When a robot counts as lost, and how it is found, against counts, least squares and exact poses."""

import math
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares

from mjsim.algorithms import EkfSlam, FastSlam
from mjsim.algorithms.estimation.recent_motion import MEMORY, RecentMotion
from mjsim.algorithms.estimation.relocation import ANY_HEADING, Relocation, fitted, pose_from_sightings
from mjsim.algorithms.estimation.unseen_landmarks import UnseenLandmarks
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Estimate, Observation, Odometry, Sighting
from tests.algorithms.test_recovery import DT, HUNG, R, looks_from
from tests.robots import pioneer

PLACES = {name: np.array(place) for name, place in HUNG.items()}
GATE = 13.8


def recorded(relocation, text, *, step=0.1, start=0.0, name="r1"):
    """Record sightings: x fails, o agrees."""
    for tick, letter in enumerate(text):
        look = Sighting(start + step * tick, name, 2.0, 0.0, R)
        relocation.record(name, look, GATE + 0.1 if letter == "x" else 5.9, gate=GATE)
    return relocation.lost


@pytest.mark.parametrize(
    ("text", "step", "lost"),
    [
        ("xxxx", 0.5, False),
        ("xxxxx", 0.25, True),
        ("xxxxx", 0.24, False),
        ("xxxxxxxx", 0.01, False),
        ("xxxxxxxxx", 0.01, True),
        ("oxxoxxoxxoxx", 0.3, False),
        ("oxxoxxoxxxxx", 0.01, True),
        ("oooooxxxxoxxxx", 0.25, False),
        ("xxxxooxxxxoox", 0.3, False),
    ],
)
def test_a_robot_is_lost_after_nine_failures_of_twelve_or_five_in_a_row_over_a_second(text, step, lost):
    assert recorded(Relocation(), text, step=step) == lost


def test_the_gate_is_stricter_while_a_robot_is_lost_and_two_landmarks_must_agree():
    relocation = Relocation()
    relocation.record("r1", Sighting(0.0, "r1", 2.0, 0.0, R), GATE, gate=GATE)
    assert recorded(relocation, "x" * 8, step=0.01) is False
    assert recorded(relocation, "x") is True
    for _ in range(12):
        relocation.record("r1", Sighting(1.0, "r1", 2.0, 0.0, R), 6.1, gate=GATE)
    assert relocation.lost
    assert recorded(relocation, "o" * 12)
    assert not recorded(relocation, "o", name="r2")
    # Of twelve, four that fail are too many.
    recorded(relocation, "x" * 12)
    assert recorded(relocation, "ooooxxxx", name="r1")
    assert recorded(relocation, "o" * 8, name="r2")
    assert not recorded(relocation, "o", name="r2")


def test_a_pose_between_points_is_that_of_least_squares():
    rng = np.random.default_rng(0)
    seen = rng.normal(0.0, 3.0, (6, 2))
    pose = np.array([1.0, -2.0, 2.5])
    hung = Pose(*pose).transform(seen) + rng.normal(0.0, 0.3, (6, 2))
    exact = least_squares(lambda p: (Pose(*p).transform(seen) - hung).ravel(), pose).x
    np.testing.assert_allclose(fitted(seen, hung), exact, atol=1e-6)


def test_a_pose_explains_seven_tenths_of_the_sightings_by_pairs_that_are_apart():
    pose = np.array([1.0, -0.5, 2.0])
    looks, names = looks_from(pose, 0.0), list(HUNG)
    wrong = [Sighting(0.0, name, 1.0 + 3.0 * k, -2.0 + 1.7 * k, R) for k, name in enumerate(names)]
    for count, found in ((4, False), (5, True)):
        mixed = [*looks[:count], *wrong[count:]]
        assert (pose_from_sightings(names, mixed, PLACES) is not None) == found
    near = {"a": np.array([2.0, 0.0]), "b": np.array([2.0, 0.49])}
    for height, found in ((0.49, False), (0.51, True)):
        near["b"] = np.array([2.0, height])
        pair = [Sighting(0.0, name, float(np.hypot(*at)), math.atan2(*at[::-1]), R) for name, at in near.items()]
        assert (pose_from_sightings(["a", "b"], pair, near) is not None) == found
    # What is off by three standard deviations of its range, or of its bearing at its range, disagrees.
    far, exact = PLACES["r1"] - pose[:2], [replace(look, covariance=1e-8 * np.eye(2)) for look in looks]
    ahead = far / np.hypot(*far)
    for spread, away in (
        (np.diag([0.05**2, 0.0]), 0.15 * ahead),
        (np.diag([0.0, 0.02**2]), 0.06 * far[::-1] * (-1, 1)),
    ):
        for share, agrees in ((0.97, True), (1.03, False)):
            moved = PLACES | {"r1": PLACES["r1"] + share * away}
            mixed = [exact[0], replace(exact[1], covariance=spread), *exact[2:]]
            assert ("r1" in pose_from_sightings(names, mixed, moved).sightings) == agrees


def test_a_lost_robot_is_found_by_steady_sightings_of_the_last_seconds_as_if_taken_now():
    step, motion, relocation = Pose(0.05, 0.01, 0.08), RecentMotion(), Relocation()
    pose = Pose(0.4, -0.2, 0.3)
    for tick in range(1, 141):
        pose = pose @ step
        motion.move(Odometry(step.x, step.y, step.heading, 1e-8 * np.eye(3)), DT * tick)
        now = DT * tick
        for look in looks_from(pose.as_array(), now) if tick % 5 == 0 else ():
            # One stands elsewhere, one flickers, one was seen long ago, one is on no map.
            if look.name == "r2":
                look = Sighting(now, "r2", look.range + 1.0, look.bearing, R)
            if look.name == "r3" and tick // 10 % 2:
                look = Sighting(now, "r3", look.range + 1.0, look.bearing, R)
            if look.name != "r5" or tick < 21:
                relocation.record(look.name, look, 100.0, gate=GATE)
    relocation.record("unknown", Sighting(now, "unknown", 1.0, 0.0, R), 100.0, gate=GATE)
    assert relocation.lost
    assert now - 2.0 > MEMORY
    found = relocation.find(motion, now, PLACES)
    np.testing.assert_allclose(found.pose[:2], [pose.x, pose.y], atol=1e-6)
    assert wrap_angle(found.pose[2] - pose.heading) == pytest.approx(0.0, abs=1e-6)
    assert set(found.sightings) == {"r0", "r1", "r4"}
    for look in looks_from(pose.as_array(), now):
        if look.name in found.sightings:
            assert found.sightings[look.name].range == pytest.approx(look.range)
    # It is on trial: the third failure is the ninth.
    assert not relocation.lost
    assert not recorded(relocation, "xx", start=now, step=0.01)
    assert recorded(relocation, "x", start=now)


def test_what_failed_before_sightings_agreed_again_says_nothing():
    relocation, looks = Relocation(), looks_from(np.array([1.0, -0.5, 2.0]), 0.0)
    for look in looks[:2]:
        relocation.record(look.name, look, 100.0, gate=GATE)
    assert relocation.find(RecentMotion(), 0.0, PLACES) is not None
    for look in looks[:2]:
        relocation.record(look.name, look, 100.0, gate=GATE)
    relocation.record("r1", looks[1], 1.0, gate=GATE)
    assert relocation.find(RecentMotion(), 0.0, PLACES) is None


def test_the_belief_of_a_lost_robot_keeps_what_is_known_of_the_map():
    relocation, joint = Relocation(), np.arange(25.0).reshape(5, 5)
    belief = Estimate(pose=Pose(1.0, 2.0, 0.5), covariance=np.eye(3), joint_covariance=joint + joint.T + 99 * np.eye(5))
    anywhere, seen = np.diag([100.0, 100.0, ANY_HEADING]), observed()
    assert relocation.reported(belief, seen) is belief
    recorded(relocation, "x" * 5, name="gone", step=0.3)
    lost = relocation.reported(belief, seen)
    np.testing.assert_array_equal(lost.covariance, anywhere)
    np.testing.assert_array_equal(lost.joint_covariance[:3, :3], anywhere)
    np.testing.assert_array_equal(lost.joint_covariance[3:, 3:], belief.joint_covariance[3:, 3:])
    assert not lost.joint_covariance[:3, 3:].any()
    recorded(relocation, "xx", name="r0")
    recorded(relocation, "x", name="gone")
    about = relocation.covariance(belief.pose.as_array(), PLACES)
    angles = np.linspace(-math.pi, math.pi, 720, endpoint=False)
    circle = PLACES["r0"] + 2.0 * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    mean = ((circle - (1.0, 2.0)) ** 2).sum(axis=1).mean() / 2
    np.testing.assert_allclose(about, np.diag([mean, mean, np.mean(angles**2)]), rtol=1e-4)


@pytest.mark.parametrize("wrong_before", [0, 10])
def test_the_covariance_is_that_of_a_mixture_of_here_and_elsewhere_by_what_failed_sightings_say(wrong_before):
    relocation, covariance = Relocation(), 1e-4 * np.eye(3)
    recorded(relocation, "oooooooxoo" * 10 if wrong_before else "o" * 100, name="gone")
    belief = Estimate(pose=Pose(1.0, 2.0, 0.5), covariance=covariance, joint_covariance=np.pad(covariance, (0, 2)))
    assert relocation.reported(belief, observed()) is belief
    # Bayes: one look in a hundred was expected to be wrong, and the same number were right since; odds of 1 in 10,000
    # for a robot that is elsewhere, where all are wrong.
    wrong = (1 + wrong_before) / 200
    for count in (1, 2, 3):
        for _ in range(2):  # Two sightings of one look tell no more than one.
            relocation.record("gone", Sighting(99.0 + 0.1 * count, "gone", 2.0, 0.0, R), 1e3, gate=GATE)
        odds = 1e-4 / wrong**count
        elsewhere = odds / (1.0 + odds)
        assert relocation.elsewhere == pytest.approx(elsewhere)
        expected = (1.0 - elsewhere) * covariance + elsewhere * np.diag([100.0, 100.0, ANY_HEADING])
        told = relocation.reported(belief, observed())
        np.testing.assert_allclose(told.covariance, expected)
        np.testing.assert_allclose(told.joint_covariance[:3, :3], expected)
        np.testing.assert_array_equal(told.joint_covariance[3:], (1.0 - elsewhere) * belief.joint_covariance[3:])
    recorded(relocation, "o", name="gone")
    assert relocation.reported(belief, observed()) is belief


def test_a_look_that_misses_nearly_or_that_agrees_in_part_says_nothing():
    relocation, elsewhere = Relocation(), []
    for time, distance in [(0.0, 1.0), (0.0, 1e3), (0.1, 3.9 * GATE), (0.1, 1.1 * GATE), (0.2, 1.1 * GATE), (0.3, 1e3)]:
        relocation.record("r1", Sighting(time, "r1", 2.0, 0.0, R), distance, gate=GATE)
        elsewhere.append(relocation.elsewhere)
    assert elsewhere[:4] == [0.0] * 4
    odds = 1e-4 / np.array([1 / 101, (1 / 101) ** 3])
    np.testing.assert_allclose(elsewhere[4:], odds / (1.0 + odds))


def test_a_silence_ends_with_any_sighting():
    assert suspicious(x=0.4)
    assert not suspicious(x=0.4, interrupted=True)


def test_a_silence_is_as_rare_as_the_innocent_ones_before_it():
    unseen, belief = UnseenLandmarks(), Estimate(Pose(0.0, 0.0, 0.3), 1e-6 * np.eye(3), {"a": (np.array([3, 0]), R)})
    near = replace(belief, landmarks={"a": (np.array([3.0, 0.0]), R)})
    for distance, bearing in ((1.0, 0.9), (5.0, -0.9), (3.0, -0.3)):
        unseen.look(near, observed(Sighting(0.0, "a", distance, bearing, R)))
    for ticks in [1] * 40 + [2] * 9 + [5] * 2:
        assert unseen.rarity == 1.0
        for _ in range(ticks):
            unseen.look(near, observed())
        unseen.agree()
    assert unseen.rarity == 1.0
    for rarity in (1.0, 12 / 52, 3 / 52, 3 / 52, 3 / 52, 1 / 52):
        unseen.look(near, observed())
        assert unseen.rarity == pytest.approx(rarity)


def observed(*sightings):
    return Observation(time=0.0, dt=DT, odometry=Odometry(0.0, 0.0, 0.0, np.eye(3)), sightings=sightings)


def suspicious(
    *, heading=-0.3, agreed=50, other_reason=0.0, blank=0.7, x=0.0, interrupted=False, expected=("close", "near", "far")
):
    """Return whether it is evidence that a robot that has seen three landmarks from the origin sees none at (x, 0)."""
    unseen = UnseenLandmarks()
    places = {"close": np.array([1.2, 0.2]), "near": np.array([3.0, 0.5]), "far": np.array([5.0, 5.0])}

    def belief(x, heading):
        landmarks = {name: (place, np.eye(2)) for name, place in places.items() if name in expected}
        return Estimate(Pose(x, 0.0, heading), 1e-4 * np.eye(3), landmarks)

    def wait(seconds, x, heading):
        for _ in range(round(seconds / DT)):
            unseen.look(belief(x, heading), observed())

    for name, (ahead, left) in places.items():
        look = Sighting(0.0, name, math.hypot(ahead, left), math.atan2(left, ahead), R)
        unseen.look(belief(0.0, 0.0), observed(look))
    wait(other_reason, 0.0, -0.3)
    for _ in range(agreed):
        unseen.agree()
    wait(blank, x, heading)
    if interrupted:
        unseen.look(belief(x, heading), observed(Sighting(0.0, "wrong", 2.0, 0.0, R)))
        wait(0.5 * blank, x, heading)
    return unseen.suspicious


def test_no_landmark_where_some_were_seen_is_evidence_that_the_robot_is_elsewhere():
    assert suspicious(x=0.4)
    assert not suspicious(x=0.4, blank=0.5)
    # Nothing is expected nearer than any was seen, outside of the field of view, where nothing was seen from, or before
    # it is known what is seen.
    assert suspicious(x=0.4, expected=["near"])
    assert not suspicious(x=0.4, expected=["close"])
    assert not suspicious(heading=0.3)
    assert not suspicious(x=1.1)
    assert not suspicious(agreed=49)
    # Detectors miss, and people pass.
    assert not suspicious(other_reason=0.5, blank=0.9)
    assert suspicious(other_reason=0.5, blank=1.2)


def test_the_way_since_a_time_is_that_between_two_poses_and_its_covariance_that_of_the_steps():
    motion, poses, rng = RecentMotion(), [Pose(0.0, 0.0, 0.0)], np.random.default_rng(0)
    for tick in range(1, 150):
        step = Pose(*rng.normal(0.0, (0.1, 0.03, 0.3)))
        poses.append(poses[-1] @ step)
        motion.move(Odometry(step.x, step.y, step.heading, np.diag([0.1, 0.2, 0.3])), DT * tick)
    now = DT * 149
    for tick in (149, 140, 60, 51):
        way, covariance = motion.since(DT * tick)
        expected = (poses[tick].inverse() @ poses[-1]).as_array()
        np.testing.assert_allclose(way[:2], expected[:2], atol=1e-9)
        assert wrap_angle(way[2] - expected[2]) == pytest.approx(0.0, abs=1e-9)
        np.testing.assert_allclose(covariance, (149 - tick) * np.diag([0.1, 0.2, 0.3]), atol=1e-9)
    (one, known), (other, more), (middle, half) = (motion.at(DT * tick) for tick in (100, 101, 100.25))
    np.testing.assert_allclose(middle[:2], 0.75 * one[:2] + 0.25 * other[:2])
    assert wrap_angle(middle[2] - one[2]) == pytest.approx(0.25 * wrap_angle(other[2] - one[2]))
    np.testing.assert_allclose(half, 0.75 * known + 0.25 * more)
    # What is older than is remembered is the oldest pose.
    np.testing.assert_allclose(motion.at(1.0)[0], motion.at(now - MEMORY - 0.2)[0])


def test_the_velocity_of_an_arc_is_that_of_its_wheels():
    motion = RecentMotion()
    for tick in range(1, 30):
        # Exact steps on a circle: chord and half of the turn.
        turn = 0.08
        chord = 0.05 * math.sin(turn / 2) / (turn / 2)
        step = (chord * math.cos(turn / 2), chord * math.sin(turn / 2), turn)
        motion.move(Odometry(*step, np.eye(3)), DT * tick)
    ahead, left, rate = motion.velocity(0.5)
    assert rate == pytest.approx(0.8)
    assert left == pytest.approx(0.0, abs=0.01)
    assert ahead == pytest.approx(0.5 * math.sin(0.2) / 0.2, rel=0.01)


@pytest.mark.parametrize("make", [EkfSlam, partial(EkfSlam, jacobians="standard"), FastSlam])
def test_a_robot_that_was_carried_away_is_where_its_map_explains_what_it_sees(make):
    slam, home, there = make(), np.array([0.5, 0.2, 0.3]), np.array([-0.8, 1.1, -1.9])
    slam.start(pioneer(prior=Pose(*home)), {}, np.random.default_rng(0))
    still, rng = Odometry(0.0, 0.0, 0.0, 1e-8 * np.eye(3)), np.random.default_rng(1)
    for tick in range(1, 19):
        looks = tuple(looks_from(home if tick <= 6 else there, DT * tick, rng))
        belief = slam.update(Observation(time=DT * tick, dt=DT, odometry=still, sightings=looks))
    assert math.hypot(belief.pose.x - there[0], belief.pose.y - there[1]) < 0.15
    assert abs(wrap_angle(belief.pose.heading - there[2])) < 0.05
    assert belief.covariance[2, 2] < 0.1
