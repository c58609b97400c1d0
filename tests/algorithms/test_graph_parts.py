"""Parts of GraphSlam: the frame that is held, sightings that wait, and the factors of odometry and sightings."""

import dataclasses

import numpy as np
import pytest

from mjsim.algorithms.estimation.ekf_models import range_bearing
from mjsim.algorithms.estimation.graph_refinement import Displacement, moved_path, sound_sightings
from mjsim.algorithms.estimation.held_frame import UNSURE, HeldFrame
from mjsim.algorithms.estimation.look_checks import NEEDED, LookChecks
from mjsim.algorithms.estimation.pose_graph import compose
from mjsim.algorithms.estimation.recent_motion import RecentMotion
from mjsim.interface import Odometry, Sighting

TRACK = np.array([(0.1 * k, 0.02 * k * k, 0.03 * k) for k in range(20)])
R = np.diag([0.05, np.radians(1.0)]) ** 2
TURN = np.array([0.3, -0.2, 0.4])
"""A solution that has learnt better turns and shifts all poses by this."""


def held(deviation, shift=TURN):
    """Tell a track pose by pose, the last one after the solution has turned by `shift`."""
    frame = HeldFrame(TRACK[0])
    for n in range(2, len(TRACK)):
        frame.add(TRACK[:n], deviation)
    turned = np.array([compose(shift, pose) for pose in TRACK])
    frame.add(turned, deviation)
    return frame, turned[-1]


def test_what_is_told_stays_where_it_was_while_the_turn_of_the_map_is_unsure():
    frame, pose = held(2.0 * UNSURE)
    np.testing.assert_allclose(frame.pose(pose), TRACK[-1], atol=1e-9)
    place, _ = frame.landmark(compose(TURN, np.array([1.0, 2.0, 0.0]))[:2], np.eye(2))
    np.testing.assert_allclose(place, (1.0, 2.0), atol=1e-9)


def test_many_places_are_held_as_each_is():
    frame, _ = held(2.0 * UNSURE)
    means, spreads = np.array([(1.0, 2.0), (-3.0, 0.5)]), np.array([np.diag([0.1, 0.2]), [[0.3, 0.1], [0.1, 0.2]]])
    for mean, spread, place, covariance in zip(means, spreads, *frame.places(means, spreads), strict=True):
        alone = frame.landmark(mean, spread)
        np.testing.assert_allclose(place, alone[0], atol=1e-12)
        np.testing.assert_allclose(covariance, alone[1], atol=1e-12)


def test_a_frame_that_is_not_released_stays_when_the_heading_is_known_later():
    frame = HeldFrame(TRACK[0], release=False)
    for n in range(2, len(TRACK)):
        frame.add(TRACK[:n], 2.0 * UNSURE)
    turned = np.array([compose(TURN, pose) for pose in TRACK])
    frame.add(turned, 0.5 * UNSURE)
    np.testing.assert_allclose(frame.pose(turned[-1]), TRACK[-1], atol=1e-9)


def test_a_certain_solution_is_reported_unchanged():
    frame, pose = held(0.5 * UNSURE)
    np.testing.assert_array_equal(frame.pose(pose), pose)
    np.testing.assert_allclose(frame.pose_covariance(pose, np.eye(3)), np.eye(3), atol=1e-12)


def test_the_covariance_of_a_held_pose_has_how_far_it_is_held_from_the_solution():
    frame, pose = held(2.0 * UNSURE)
    off = TRACK[-1] - pose
    covariance = frame.pose_covariance(pose, 1e-4 * np.eye(3))
    np.testing.assert_allclose(covariance, 1e-4 * np.eye(3) + np.outer(off, off), atol=1e-9)
    # A squared distance of one in the direction of the shift: it is no outlier by itself.
    assert off @ np.linalg.solve(covariance, off) == pytest.approx(1.0, abs=1e-3)


def test_a_path_is_displaced_when_sightings_tell():
    # Carried away before tick 12, and found at tick 16; one of the sightings that failed is older.
    truth, landmark = TRACK.copy(), np.array([3.0, 1.0])
    truth[12:] = [compose(np.array([0.5, 1.0, 0.7]), pose) for pose in TRACK[12:]]
    failed = []
    for tick in range(10, 16):
        z, _, _ = range_bearing(truth[tick], landmark[None])
        failed.append((tick, Sighting(0.1 * tick, "a", *z[0].tolist(), R)))
    told = np.concatenate([TRACK[:16], truth[16:]])
    displaced = Displacement(16, 15, np.zeros(3), np.zeros((3, 4)), failed)
    np.testing.assert_allclose(moved_path(told, TRACK[16], displaced, {"a": landmark}), truth, atol=1e-9)
    # Where the sightings do not fail, it stays.
    there = {"a": np.array([30.0, 1.0])}
    np.testing.assert_array_equal(moved_path(told, TRACK[16], displaced, there)[:10], TRACK[:10])


def test_sightings_from_elsewhere_leave_a_graph_but_for_those_of_new_landmarks():
    def seen(number, name):
        return number, look(name, 0.1 * number)

    graph = [seen(1, "a"), seen(3, "a"), seen(3, "b"), seen(4, "new"), seen(4, "a")]
    assert sound_sightings(graph, 3, {"a", "new"}) == [graph[0], graph[2], graph[3]]


def look(name, bearing):
    return Sighting(0.0, name, 3.0, bearing, R)


def checked():
    """Checks of a robot that knows its pose, with a landmark that is old; and its way, at rest."""
    checks, recent = LookChecks(), RecentMotion()
    checks.begin("post")
    for _ in range(NEEDED):
        assert checks.agrees(np.zeros(3), np.array([3.0, 0.0]), look("post", 0.0))
    recent.move(Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))), 0.1)
    return checks, recent


def test_a_look_that_is_not_where_the_map_has_it_waits_until_others_agree_with_it():
    checks, recent = checked()
    strange = look("post", 0.5)
    assert not checks.agrees(np.zeros(3), np.array([3.0, 0.0]), strange)
    assert checks.wait(4, strange, recent, 0.1) == []
    assert checks.wait(5, look("post", -0.5), recent, 0.1) == []  # agrees with nothing
    assert checks.wait(6, strange, recent, 0.1) == []
    assert [number for number, _ in checks.wait(7, strange, recent, 0.1)] == [4, 6, 7]
    assert checks.wait(8, strange, recent, 0.1) == []  # those have gone into the graph


def test_after_a_turn_that_is_unsure_the_same_look_is_expected():
    checks, _ = checked()
    checks.move(np.eye(3), np.diag([0.01, 0.01, 0.2]) ** 2)
    assert checks.agrees(np.zeros(3), np.array([3.0, 0.0]), look("post", 0.5))
    # It has told the heading.
    assert not checks.agrees(np.zeros(3), np.array([3.0, 0.0]), look("post", 0.5))


def test_a_new_landmark_does_not_tell_the_heading_with_which_it_entered_the_map():
    checks, _ = checked()
    checks.move(np.eye(3), np.diag([0.01, 0.01, 0.2]) ** 2)
    checks.begin("new")
    for _ in range(20):
        assert checks.agrees(np.zeros(3), np.array([0.0, 3.0]), look("new", np.pi / 2))
    assert checks.agrees(np.zeros(3), np.array([3.0, 0.0]), look("post", 0.5))
    # Now that it was seen beside the old one, both tell the heading.
    assert checks.agrees(np.zeros(3), np.array([0.0, 3.0]), look("new", np.pi / 2))
    checks.move(np.eye(3), np.diag([0.01, 0.01, 0.2]) ** 2)
    assert checks.agrees(np.zeros(3), np.array([0.0, 3.0]), look("new", np.pi / 2))
    assert not checks.agrees(np.zeros(3), np.array([3.0, 0.0]), look("post", 0.5))


def test_the_first_look_at_a_landmark_is_outvoted_by_the_next_two():
    checks, recent = LookChecks(), RecentMotion()
    recent.move(Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))), 0.1)
    checks.begin("post")
    assert checks.is_young("post")
    assert checks.wait(1, look("post", 0.5), recent, 0.1) == []
    assert len(checks.wait(2, look("post", 0.5), recent, 0.1)) == 2


def test_looks_are_forgotten_that_nothing_agreed_with_for_long():
    checks, recent = checked()
    strange = dataclasses.replace(look("post", 0.5))
    for time in (0.1, 20.0, 40.0, 60.0):
        recent.move(Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))), time)
        assert checks.wait(1, strange, recent, time) == []


def test_the_derivatives_of_the_factor_of_odometry_match_central_differences():
    gtsam = pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.estimation.graph_factors import leg_factor

    rng, step = np.random.default_rng(0), 1e-6
    one, other, common = gtsam.symbol("x", 0), gtsam.symbol("x", 1), gtsam.symbol("e", 0)
    for _ in range(20):
        first, second = rng.uniform(-2.0, 2.0, (2, 3))
        moved, slopes, errors = rng.uniform(-1.0, 1.0, 3), rng.uniform(-1.0, 1.0, (3, 4)), rng.uniform(-0.1, 0.1, 4)
        factor = leg_factor(gtsam, (one, other, common), moved, np.eye(3), slopes)

        def off(delta, factor=factor, first=first, second=second, errors=errors):
            values = gtsam.Values()
            values.insert(one, gtsam.Pose2(*first).retract(delta[:3]))
            values.insert(other, gtsam.Pose2(*second).retract(delta[3:6]))
            values.insert(common, errors + delta[6:])
            linear = factor.linearize(values)
            return np.array(linear.getA()), -np.array(linear.getb())

        A, _ = off(np.zeros(10))
        for column, offset in enumerate(np.eye(10) * step):
            slope = (off(offset)[1] - off(-offset)[1]) / (2 * step)
            np.testing.assert_allclose(slope, A[:, column], atol=1e-6)


def test_the_derivatives_of_the_factor_of_a_look_match_central_differences():
    gtsam = pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.estimation.graph_factors import shared_sighting_factor, sighting_factor

    rng, step = np.random.default_rng(1), 1e-6
    at, place, common = gtsam.symbol("x", 0), gtsam.symbol("l", 0), gtsam.symbol("r", 0)
    loss = gtsam.noiseModel.mEstimator.Huber.Create(1e6)  # so large that all residuals count in full
    for _ in range(20):
        pose, landmark, errors = rng.uniform(-2.0, 2.0, 3), rng.uniform(3.0, 4.0, 2), rng.uniform(-0.1, 0.1, 3)
        seen = dataclasses.replace(look("post", 0.5), range=2.0)
        factor = shared_sighting_factor(gtsam, (at, place, common), seen, np.eye(2), loss)

        def off(delta, factor=factor, pose=pose, landmark=landmark, errors=errors):
            values = gtsam.Values()
            values.insert(at, gtsam.Pose2(*pose).retract(delta[:3]))
            values.insert(place, landmark + delta[3:5])
            values.insert(common, errors + delta[5:])
            linear = factor.linearize(values)
            return np.array(linear.getA()), -np.array(linear.getb())

        A, _ = off(np.zeros(8))
        for column, offset in enumerate(np.eye(8) * step):
            slope = (off(offset)[1] - off(-offset)[1]) / (2 * step)
            np.testing.assert_allclose(slope, A[:, column], atol=1e-6)

        # Without errors it is gtsam's own.
        values = gtsam.Values()
        values.insert(at, gtsam.Pose2(*pose))
        values.insert(place, landmark)
        values.insert(common, np.zeros(3))
        own = sighting_factor(gtsam, (at, place), seen, np.diag([0.1, 0.2]), loss)
        ours = shared_sighting_factor(gtsam, (at, place, common), seen, np.diag([0.1, 0.2]), loss)
        assert ours.error(values) == pytest.approx(own.error(values), rel=1e-9)


def test_one_factor_of_a_pose_is_those_of_odometry_and_of_each_look_with_its_robust_loss():
    gtsam = pytest.importorskip("gtsam", reason="an extra")
    from mjsim.algorithms.estimation.graph_factors import (
        HUBER,
        PoseSightings,
        leg_factor,
        pose_factor,
        shared_sighting_factor,
    )

    rng = np.random.default_rng(2)
    keys = gtsam.symbol("x", 0), gtsam.symbol("x", 1), gtsam.symbol("e", 0)
    ranges, posts = gtsam.symbol("r", 0), [gtsam.symbol("l", number) for number in (0, 1, 0)]
    # The second look is an outlier; the third is of the first landmark again.
    looks = [dataclasses.replace(look("post", bearing), range=3.0) for bearing in (0.3, 1.5, 0.2)]
    spreads = [np.array([[0.02, 0.003], [0.003, 0.01]])] * len(looks)
    leg = rng.uniform(-0.1, 0.1, 3), np.diag([0.01, 0.02, 0.03]), rng.uniform(-1.0, 1.0, (3, 4))
    values = gtsam.Values()
    for key, pose in zip(keys, rng.uniform(-0.2, 0.2, (2, 3)), strict=False):
        values.insert(key, gtsam.Pose2(*pose))
    values.insert(keys[2], rng.uniform(-0.1, 0.1, 4))
    values.insert(ranges, np.array([0.05, 0.02, -0.03]))
    for key, place in zip(posts[:2], ((2.8, 1.0), (1.0, 2.8)), strict=True):
        values.insert(key, np.array(place))

    apart, one = gtsam.NonlinearFactorGraph(), gtsam.NonlinearFactorGraph()
    apart.add(leg_factor(gtsam, keys, *leg))
    loss = gtsam.noiseModel.mEstimator.Huber.Create(HUBER)
    for key, seen, spread in zip(posts, looks, spreads, strict=True):
        apart.add(shared_sighting_factor(gtsam, (keys[1], key, ranges), seen, spread, loss))
    one.add(pose_factor(gtsam, keys, leg, PoseSightings(ranges, posts, looks, spreads)))
    (A, b), (B, c) = (graph.linearize(values).hessian() for graph in (apart, one))
    np.testing.assert_allclose(B, A, atol=1e-9 * np.abs(A).max())
    np.testing.assert_allclose(c, b, atol=1e-9 * np.abs(b).max())


def test_the_joint_covariance_of_a_held_frame_has_those_of_its_parts():
    frame, pose = held(2.0 * UNSURE)
    points, root = np.array([[1.0, 2.0], [-3.0, 0.5]]), np.random.default_rng(0).normal(0, 0.1, (7, 7))
    P = root @ root.T
    joint = frame.joint_covariance(pose, points, P)
    np.testing.assert_allclose(joint[:3, :3], frame.pose_covariance(pose, P[:3, :3]), atol=1e-12)
    for k, point in enumerate(points):
        part = slice(3 + 2 * k, 5 + 2 * k)
        np.testing.assert_allclose(joint[part, part], frame.landmark(point, P[part, part])[1], atol=1e-12)
    # Across parts: by the derivatives of what is reported, and the differences to the solution.
    step = 1e-6
    turned = np.zeros((7, 7))
    turned[:3, :3] = np.array([(frame.pose(pose + d) - frame.pose(pose - d)) / (2 * step) for d in step * np.eye(3)]).T
    for k in range(2):
        ends = [[frame.landmark(points[k] + sign * d, np.eye(2))[0] for sign in (1, -1)] for d in step * np.eye(2)]
        moved = [one - other for one, other in ends]
        turned[3 + 2 * k : 5 + 2 * k, 3 + 2 * k : 5 + 2 * k] = np.array(moved).T / (2 * step)
    off = np.concatenate([frame.pose(pose) - pose, *(frame.landmark(p, np.eye(2))[0] - p for p in points)])
    np.testing.assert_allclose(joint, turned @ P @ turned.T + np.outer(off, off), atol=1e-6)
