"""Scans that are laid on one another, and graphs of poses, on cases whose answer is known."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.algorithms.estimation.pose_graph import PoseGraph, step_between
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.scans.scan_matching import WallField, align
from mjsim.algorithms.scans.scan_search import hypotheses, match_pose
from mjsim.algorithms.scans.scan_walls import Surface, joined, surface_of
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Pose, wrap_angle

CORNERS = [(0, 0), (6, 0), (6, 3), (4, 3), (4, 5), (0, 5)]
SPREAD = 1e-4 * np.eye(3)
ROOM = shapely.LinearRing(CORNERS)


def scan_points(pose, beams=240, noise=0.0, seed=0):
    """Return where beams all around meet the room, in the frame of the pose."""
    angles = np.linspace(-np.pi, np.pi, beams, endpoint=False)
    far = np.stack([np.cos(angles + pose.heading), np.sin(angles + pose.heading)], axis=-1) * 20 + (pose.x, pose.y)
    rays = shapely.linestrings(np.stack([np.broadcast_to((pose.x, pose.y), far.shape), far], axis=1))
    reach = shapely.distance(shapely.intersection(rays, ROOM), shapely.Point(pose.x, pose.y))
    reach = reach + np.random.default_rng(seed).normal(0, noise, beams)
    return reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def surface_at(pose, **keys):
    return surface_of(scan_points(pose, **keys))


def test_walls_are_evenly_spaced_and_face_the_robot():
    pose = Pose(2, 2, 0.4)
    surface = surface_at(pose)
    # The room has 22 m of wall; near corners no line goes through the neighbours.
    assert 180 < len(surface.points) <= 220
    assert (np.sum(surface.points * surface.normals, axis=1) < 0.0).all()
    seen = surface.moved(pose.as_array())
    assert np.mean(np.abs(seen.normals).max(axis=1) > 0.999) > 0.96
    assert shapely.distance(shapely.points(seen.points), ROOM).max() < 0.03


def test_noise_of_a_centimetre_turns_no_normal_by_much():
    surface = surface_at(Pose(2, 2, 0.4), noise=0.01).moved(np.array([2, 2, 0.4]))
    assert np.quantile(np.degrees(np.arccos(np.abs(surface.normals).max(axis=1))), 0.9) < 5.0


def test_two_scans_are_laid_on_each_other_to_millimetres():
    one, other = Pose(2, 2, 0.3), Pose(2.4, 2.3, 0.5)
    step = step_between(one.as_array(), other.as_array())
    guess = step + np.array([0.12, -0.1, 0.08])
    (match,) = align(WallField(surface_at(one)), surface_at(other), guess, np.diag([1.0, 1.0, 1.0]), guess[None])
    np.testing.assert_allclose(match.pose, step, atol=0.004)
    assert match.share > 0.9


def test_from_afar_the_search_finds_the_place_that_the_alignment_alone_does_not():
    one, other = Pose(2, 2, 0.3), Pose(2.3, 2.2, 0.4)
    step = step_between(one.as_array(), other.as_array())
    guess, weak = step + np.array([1.5, -1.3, 0.9]), np.diag([0.1, 0.1, 1.0])
    field, scan = WallField(surface_at(one)), surface_at(other)
    (alone,) = align(field, scan, guess, weak, guess[None])
    assert np.abs(alone.pose - step).max() > 0.2
    best = hypotheses(field, scan, guess, weak, np.array([2.0, 2.0, 1.2]))[0]
    np.testing.assert_allclose(best.pose, step, atol=0.01)


def test_what_odometry_does_not_allow_is_believed_only_where_nothing_else_fits():
    one, other = Pose(2, 2, 0.3), Pose(2.3, 2.2, 0.4)
    step = step_between(one.as_array(), other.as_array())
    sure = np.diag([0.02, 0.02, 0.01]) ** 2
    slipped = step + np.array([0.5, 0.3, 0.25])
    laid = match_pose(surface_at(other), surface_at(one), slipped, sure)
    np.testing.assert_allclose(laid.pose, step, atol=0.01)
    # Scans of other rooms tell nothing: odometry stands, and is less sure.
    elsewhere = replace(surface_at(one), points=surface_at(one).points + 30.0)
    laid = match_pose(surface_at(other), elsewhere, slipped, sure)
    np.testing.assert_array_equal(laid.pose, slipped)
    assert (np.diag(laid.covariance) > np.diag(sure)).all()


def test_a_small_slip_does_not_pull_a_scan_off_the_walls():
    one, other = Pose(2, 2, 0.3), Pose(2.3, 2.2, 0.4)
    step = step_between(one.as_array(), other.as_array())
    # A few elements, and odometry that is sure of its turn: both together would end half-way.
    seen = surface_at(other, noise=0.01)
    few = Surface(seen.points[::8], seen.normals[::8], seen.noise[::8])
    slipped = step + np.array([0.12, 0.03, 0.05])
    laid = match_pose(few, surface_at(one, noise=0.01), slipped, np.diag([0.03, 0.03, 0.007]) ** 2)
    np.testing.assert_allclose(laid.pose, step, atol=0.005)


def comb(beams=181):
    """Return a scan of a corridor with niches every 0.8 m: moved by that, it looks the same."""
    niches = [
        (x, y)
        for k in range(-12, 13)
        for x, y in ((0.8 * k, 1), (0.8 * k + 0.4, 1), (0.8 * k + 0.4, 1.4), (0.8 * k + 0.8, 1.4))
    ]
    upper = np.array([(x, y) for x, y in niches])
    dense = [np.linspace(a, b, 9)[:-1] for a, b in itertools.pairwise(upper)]
    return np.concatenate(dense)


def test_a_corridor_that_repeats_itself_makes_the_answer_unsure_not_wrong():
    wall = surface_of(comb())
    scan = Surface(wall.points[60:-60], wall.normals[60:-60], wall.noise[60:-60])
    laid = match_pose(scan, wall, np.array([0.37, 0.0, 0.0]), np.diag([0.3, 0.05, 0.05]) ** 2)
    assert abs(laid.pose[0]) < 0.05 or abs(laid.pose[0] - 0.8) < 0.05
    assert np.sqrt(laid.covariance[0, 0]) > 0.2
    assert np.sqrt(laid.covariance[1, 1]) < 0.05


def test_along_a_bare_corridor_the_guess_decides():
    angles = np.linspace(-np.pi, np.pi, 360, endpoint=False)
    reach = np.minimum(1.0 / np.maximum(np.abs(np.sin(angles)), 1e-9), 6.0)
    points = np.stack([reach * np.cos(angles), reach * np.sin(angles)], axis=-1)[reach < 5.9]
    wall = surface_of(points)
    laid = match_pose(wall, joined([wall] * 6), np.array([0.25, 0.05, 0.02]), np.diag([0.1, 0.1, 0.1]) ** 2)
    assert laid.pose[0] == pytest.approx(0.25, abs=0.05)
    np.testing.assert_allclose(laid.pose[1:], 0.0, atol=0.005)
    assert laid.covariance[0, 0] > 50 * laid.covariance[1, 1]
    # Odometry is off as far as the last scan; a match on six scans as their mean, whose errors even out.
    np.testing.assert_allclose(laid.lasting[0, 0], laid.covariance[0, 0], rtol=0.1)
    np.testing.assert_allclose(laid.lasting[1, 1], laid.covariance[1, 1] / 3.5**2, rtol=0.1)


def test_errors_of_matches_on_the_last_six_scans_add_up_as_the_lasting_part_says():
    # One dimension, in units of the error of a match: each place is the mean of the last six as their scans show them.
    rng = np.random.default_rng(0)
    off = np.zeros((200, 400))
    for k in range(1, len(off)):
        off[k] = off[max(0, k - 6) : k].mean(axis=0) + rng.normal(size=off.shape[1])
    gained = (off[150:].var(axis=1).mean() - off[50:100].var(axis=1).mean()) / 100
    room = surface_at(Pose(2, 2, 0.3))
    laid = match_pose(room, joined([room] * 6), np.zeros(3), np.eye(3))
    np.testing.assert_allclose(np.diag(laid.lasting), gained * np.diag(laid.covariance), rtol=0.2)
    # On the walls of one scan there is nothing to average over.
    laid = match_pose(room, room, np.zeros(3), np.eye(3))
    np.testing.assert_allclose(np.diag(laid.lasting), np.diag(laid.covariance), rtol=0.3)


def test_a_scan_is_laid_on_the_mean_of_the_last_six_not_on_one_of_them():
    # Each of the six scans is a little off; the matched one is exact.
    room, off = surface_at(Pose(2, 2, 0.3)), np.array([0.02, -0.01, 0.015, 0.0, 0.005, 0.03])
    walls = joined([room.moved(np.array([error, -error, 0.0])) for error in off])
    laid = match_pose(room, walls, np.zeros(3), np.eye(3))
    np.testing.assert_allclose(laid.pose, [off.mean(), -off.mean(), 0.0], atol=0.002)


def test_without_a_match_the_systematic_error_of_odometry_counts_once():
    step, noise, doubt = np.array([0.3, 0.0, 0.0]), np.diag([0.02, 0.02, 0.01]) ** 2, np.diag([0.05, 0.0, 0.02]) ** 2
    room = surface_at(Pose(2, 2, 0.3))
    elsewhere = replace(room, points=room.points + 30.0)
    laid, known = match_pose(room, elsewhere, step, noise, systematic=doubt), match_pose(room, elsewhere, step, noise)
    np.testing.assert_array_equal(laid.pose, step)
    # What the pose shares with all others is told by `follows`; its own part is as if that were known.
    np.testing.assert_array_equal(laid.follows, np.eye(3))
    np.testing.assert_allclose(laid.own, known.own)
    np.testing.assert_allclose(laid.lasting, known.lasting)
    np.testing.assert_allclose(laid.covariance, known.covariance + doubt)


def test_an_error_along_a_corridor_lasts_if_one_scan_alone_shows_the_edge_that_tells_it():
    wall, edge = np.column_stack([np.linspace(-4, 4, 400), np.full(400, 1.0)]), np.array([[4.0, 1.0], [4.0, 0.0]])
    edge = edge[:1] + np.linspace(0, 1, 50)[:, None] * (edge[1:] - edge[:1])
    scan, bare = surface_of(np.concatenate([wall, edge])), surface_of(wall)
    noise = np.diag([0.1, 0.1, 0.1]) ** 2
    seldom = match_pose(scan, joined([scan] + [bare] * 5), np.zeros(3), noise)
    often = match_pose(scan, joined([scan] * 6), np.zeros(3), noise)
    assert seldom.lasting[0, 0] > 5.0 * often.lasting[0, 0]
    np.testing.assert_allclose(seldom.lasting[1, 1], often.lasting[1, 1], rtol=0.3)


def test_an_element_at_an_edge_counts_less_than_one_on_a_straight_wall():
    wall, jamb = (
        np.column_stack([np.linspace(-2, 0, 200), np.ones(200)]),
        np.column_stack([np.zeros(9), 1.01 + np.arange(9) / 100]),
    )
    surface = surface_of(np.concatenate([wall, jamb]))
    straight = np.abs(surface.normals[:, 1]) > 0.999
    assert surface.noise[straight & (surface.points[:, 0] < -0.5)].max() < 0.001
    assert not straight.all()
    assert surface.noise[~straight].min() > 0.005


def weighted_graph(errors):
    """Return five poses on a line and a loop, steps that err by `errors` (5, 3), every other one weighed too high."""
    graph = PoseGraph(np.zeros((1, 3)))
    for k in range(1, 5):
        graph.add_pose(np.array([k, 0.0, 0.0]))
        graph.add_step(k - 1, k, np.array([1.0, 0.0, 0.0]) + errors[k], 1e4 * 25.0 ** (k % 2) * np.eye(3), SPREAD)
    graph.add_step(0, 4, np.array([4.0, 0.0, 0.0]) + errors[0], np.linalg.inv(SPREAD))
    graph.solve()
    return graph


def test_the_covariance_is_that_of_what_steps_err_by_whatever_their_weights():
    graph, P = weighted_graph(np.zeros((5, 3))), np.zeros((3, 3))
    for error in np.eye(15).reshape(15, 5, 3):
        slope = (weighted_graph(1e-4 * error).poses[4] - weighted_graph(-1e-4 * error).poses[4]) / 2e-4
        P += SPREAD[0, 0] * np.outer(slope, slope)
    np.testing.assert_allclose(graph.covariance(4), P, rtol=1e-4, atol=1e-9)
    assert P[2, 2] > 1.1 * graph.covariances([4])[2, 2]


def test_a_ring_of_noisy_steps_is_bent_until_it_closes():
    rng = np.random.default_rng(1)
    number, sigma = 60, np.array([0.02, 0.02, 0.01])
    angles = np.linspace(0, 2 * np.pi, number)
    truth = np.column_stack([5 * np.cos(angles), 5 * np.sin(angles), angles + np.pi / 2])
    information = np.diag(1 / sigma**2)
    graph, pose = PoseGraph(truth[:1]), Pose.from_array(truth[0])
    for k in range(number - 1):
        step = step_between(truth[k], truth[k + 1]) + rng.normal(0, sigma)
        pose = pose @ Pose.from_array(step)
        graph.add_pose(pose.as_array())
        graph.add_step(k, k + 1, step, information)
    drift = np.hypot(*(graph.poses[-1] - truth[-1])[:2])
    graph.add_step(number - 1, 0, step_between(truth[-1], truth[0]), np.diag(1 / np.array([0.01, 0.01, 0.005]) ** 2))
    open_covariance = graph.covariance(number // 2)
    graph.solve()
    assert np.hypot(*(graph.poses[-1] - truth[-1])[:2]) < 0.03 < 0.2 * drift
    errors = graph.poses - truth
    errors[:, 2] = [wrap_angle(float(error)) for error in errors[:, 2]]
    # Half-way around it is least sure, and about as wrong as it says.
    assert errors[number // 2] @ np.linalg.solve(open_covariance, errors[number // 2]) < 12.0
    assert np.trace(graph.covariance(number // 2)) > np.trace(graph.covariance(number - 1))


def test_a_loop_that_contradicts_all_others_is_given_up():
    poses = np.column_stack([np.arange(10.0), np.zeros(10), np.zeros(10)])
    graph = PoseGraph(poses.copy())
    for k in range(9):
        graph.add_step(k, k + 1, step_between(poses[k], poses[k + 1]), 1e4 * np.eye(3))
    graph.add_step(0, 9, step_between(poses[0], poses[9]), 1e4 * np.eye(3))
    graph.add_step(1, 8, np.array([2.0, 3.0, 1.0]), 1e4 * np.eye(3))
    graph.solve(rounds=20)
    assert graph.drop_misfits(100.0) == 1
    graph.solve()
    np.testing.assert_allclose(graph.poses, poses, atol=1e-6)


def test_the_covariance_of_a_step_is_that_of_the_way_between():
    poses = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    graph, sigma = PoseGraph(poses), np.array([0.1, 0.2, 1e-4])
    for k in range(4):
        graph.add_step(k, k + 1, np.array([1.0, 0.0, 0.0]), np.diag(1 / sigma**2))
    one, other = graph.step_covariances([1, 3], 4)
    np.testing.assert_allclose(np.diag(one)[:2], 3 * sigma[:2] ** 2, rtol=1e-3)
    np.testing.assert_allclose(np.diag(other)[:2], sigma[:2] ** 2, rtol=1e-3)


def test_the_first_pose_stays_and_steps_that_agree_move_nothing():
    poses = np.array([(0, 0, 0), (1, 0, 0.5), (1.5, 0.5, 1.0)])
    graph = PoseGraph(poses)
    for k in range(2):
        graph.add_step(k, k + 1, step_between(poses[k], poses[k + 1]), np.eye(3))
    assert graph.solve() < 1e-20
    np.testing.assert_allclose(graph.poses, poses, atol=1e-9)


RING = """
mjsim: 1
name: ring
walls:
  - {points: [[0, 0], [9, 0], [9, 7], [0, 7]], closed: true}
  - {points: [[2.5, 2], [6.5, 2], [6.5, 5], [2.5, 5]], closed: true}
obstacles: [{box: [0.4, 0.6, 1.0], at: [0.3, 3]}, {box: [0.6, 0.4, 1.0], at: [5, 6.7], heading_deg: 20}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1.3, 1]
    drive: {noise: {speed: 0.02, turn: 0.03}}
    odometry: {noise: {distance: 0.02, turn: 0.04}}
    sensors:
      - {lidar: scan, at: [0.1, 0, 0.3], beams: 180, fov_deg: 360, range: [0.05, 8], rate_hz: 5, noise: {range: 0.01}}
"""


@pytest.mark.slow
def test_more_than_a_lap_of_a_ring_is_driven_with_loops_closed_and_centimetres_of_error():
    estimator = LidarSlam()
    corners = [(8, 1), (8, 6), (1.2, 6), (1.2, 1)]
    with mjsim.Simulation(mjsim.parse_world(RING), seed=2) as sim:
        driver = mjsim.Driver(estimator=estimator, navigator=Waypoints(corners, laps=2, speed=0.6))
        errors, truths, drift = [], [], 0.0
        for tick in mjsim.ticks(sim, {"scout": driver}):
            truth, belief = tick.truth["scout"], tick.orders["scout"].estimate.pose
            errors.append(np.hypot(truth.x - belief.x, truth.y - belief.y))
            truths.append(truth.as_array())
            reckoned = tick.orders["scout"].dead_reckoning
            drift = max(drift, np.hypot(truth.x - reckoned.x, truth.y - reckoned.y))
            if tick.time > 65:
                break
    assert estimator.loops > 0
    assert np.mean(errors) < 0.06
    final = np.array([pose.as_array() for _, pose in estimator.path()])
    assert len(final) == len(truths)
    assert np.hypot(*(final - truths)[:, :2].T).mean() < 0.06
    assert drift > 3 * np.max(errors)
    assert (estimator.grid(cell=0.1).log_odds > 0).sum() > 300


@pytest.mark.slow
def test_a_scan_that_arrives_late_belongs_to_where_it_was_taken():
    errors = []
    for latency in (0, 5):
        estimator, truth = LidarSlam(), []
        late = RING.replace("rate_hz: 5,", f"rate_hz: 5, latency: {latency},")
        with mjsim.Simulation(mjsim.parse_world(late), seed=2) as sim:
            estimator.start(sim.robots["scout"], {}, np.random.default_rng(0))
            for _ in range(200):
                estimator.update(sim.sense("scout"))
                truth.append(sim.truths()["scout"].as_array())
                sim.apply("scout", mjsim.Command(0.5, 0.0, 0.3))
                sim.step()
        path = np.array([pose.as_array() for _, pose in estimator.path()])
        errors.append(np.hypot(*(path - truth)[:, :2].T).mean())
    # 0.2 s late, a robot at 0.5 m/s is 0.1 m farther on.
    assert errors[1] < errors[0] + 0.01


@pytest.mark.slow
@pytest.mark.parametrize("worse", [0.0, 5.0])
def test_between_scans_the_heading_is_as_uncertain_as_scans_have_shown_odometry_to_be(worse):
    estimator, rng, errors, variances = LidarSlam(), np.random.default_rng(0), [], []
    with mjsim.Simulation(mjsim.parse_world(RING), seed=2) as sim:
        estimator.start(sim.robots["scout"], {}, np.random.default_rng(0))
        for _ in range(750):
            seen = sim.sense("scout")
            # The data sheet of odometry may know nothing of an error five times as large.
            turn = seen.odometry.turn + worse * np.sqrt(seen.odometry.covariance[2, 2]) * rng.normal()
            belief = estimator.update(replace(seen, odometry=replace(seen.odometry, turn=turn)))
            errors.append(wrap_angle(belief.pose.heading - sim.truths()["scout"].heading))
            variances.append(belief.covariance[2, 2])
            sim.apply("scout", mjsim.Command(0.0, 0.0, 0.6))
            sim.step()
    # 60 scans in the map after the first 5 s: a standard deviation is known to 10 %, steps are not independent.
    assert 0.65 < np.sqrt(np.mean(np.square(errors[125:])) / np.mean(variances[125:])) < 1.35


@pytest.mark.slow
def test_the_final_path_comes_to_the_next_scan_without_a_jump():
    estimator, truth = LidarSlam(), []
    with mjsim.Simulation(mjsim.parse_world(RING), seed=2) as sim:
        estimator.start(sim.robots["scout"], {}, np.random.default_rng(0))
        for _ in range(100):
            seen = sim.sense("scout")
            # Odometry misses a fifth of the way.
            odometry = replace(seen.odometry, forward=0.8 * seen.odometry.forward)
            estimator.update(replace(seen, odometry=odometry))
            truth.append(sim.truths()["scout"].as_array())
            sim.apply("scout", mjsim.Command(0.5, 0.0, 0.0))
            sim.step()
    path = np.array([pose.as_array() for _, pose in estimator.path()])
    steps, true_steps = (np.hypot(*np.diff(poses[:, :2], axis=0).T)[40:80] for poses in (path, np.array(truth)))
    assert np.abs(steps - true_steps).max() < 0.01
