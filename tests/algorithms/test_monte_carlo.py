"""Monte Carlo localization in a room whose scans are worked out by shapely, and in the maze."""

import dataclasses
import itertools
from pathlib import Path

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.algorithms.monte_carlo import MonteCarloLocalization, systematic_resample_with
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import BeaconInfo, Observation, Odometry, Scan, SensorInfo, Sighting, WorldMap
from mjsim.world import with_settings
from tests.robots import pioneer

MAZE = Path(__file__).parents[2] / "worlds" / "maze.yaml"
CORNERS = np.array([(0, 0), (10, 0), (10, 4), (6, 4), (6, 7), (0, 7)], dtype=float)
POST = np.array([(2, 3), (3, 3), (3, 3.5), (2, 3.5)], dtype=float)
WALLS = np.concatenate([np.stack([ring, np.roll(ring, -1, axis=0)], axis=1) for ring in (CORNERS, POST)])
MAP = WorldMap(segments=WALLS, beacons={})
FACES = shapely.MultiLineString([face.tolist() for face in WALLS])
NOISE = np.diag([0.01, 0.001, 0.01]) ** 2
LIDAR = SensorInfo(kind="lidar", robot_from_sensor=np.eye(4), rate_hz=5.0, range=(0.05, 12.0))


def scan_from(pose, rng, beams=90, faces=FACES):
    angles = np.linspace(-np.pi, np.pi, beams, endpoint=False)
    ranges = []
    for angle in angles + pose.heading:
        ray = shapely.LineString([(pose.x, pose.y), (pose.x + 20 * np.cos(angle), pose.y + 20 * np.sin(angle))])
        met = shapely.get_coordinates(ray.intersection(faces))
        ranges.append(np.hypot(*(met - (pose.x, pose.y)).T).min() + rng.normal(0, 0.01))
    return Scan(0.0, np.array(ranges), -np.pi, 2 * np.pi / beams, 0.05, 12.0)


def started(prior, spread, map=MAP, **settings):
    estimator = MonteCarloLocalization(particles=3000, **settings)
    estimator.take_map(map)
    info = dataclasses.replace(pioneer(), prior=prior, prior_covariance=spread, sensors={"scan": LIDAR})
    estimator.start(info, {}, np.random.default_rng(0))
    return estimator


def drive(estimator, pose, steps, rng):
    """Drive in a circle that stays in the room; return the true pose and the last belief."""
    for step in range(steps):
        moved = Pose(0.05, 0.0, 0.06)
        pose = pose @ moved
        told = np.array([moved.x, 0.0, moved.heading]) + rng.normal(0, np.sqrt(np.diag(NOISE)))
        scans = {"scan": scan_from(pose, rng)} if step % 5 == 0 else {}
        belief = estimator.update(Observation(0.04 * step, 0.04, Odometry(*told, NOISE), scans=scans))
    return pose, belief


def apart(pose, belief):
    return np.hypot(pose.x - belief.pose.x, pose.y - belief.pose.y)


@pytest.mark.slow
def test_from_the_prior_it_follows_the_robot():
    rng = np.random.default_rng(2)
    pose, belief = drive(started(Pose(4, 2, 0), np.diag([0.2, 0.2, 0.1]) ** 2), Pose(4.1, 1.9, 0.05), 100, rng)
    assert apart(pose, belief) < 0.05
    assert abs(wrap_angle(pose.heading - belief.pose.heading)) < np.radians(2.0)


@pytest.mark.slow
def test_from_anywhere_it_finds_where_it_is_and_needs_fewer_particles_then():
    rng = np.random.default_rng(3)
    estimator = started(Pose(0, 0, 0), np.zeros((3, 3)), start="global")
    pose, belief = drive(estimator, Pose(8.0, 1.2, 0.0), 100, rng)
    assert apart(pose, belief) < 0.1
    assert len(estimator._particles) < 1000


@pytest.mark.slow
def test_a_robot_that_was_carried_away_says_that_it_is_lost_and_is_found_again():
    rng = np.random.default_rng(4)
    estimator = started(Pose(4, 2, 0), np.diag([0.1, 0.1, 0.1]) ** 2)
    drive(estimator, Pose(4.0, 2.0, 0.0), 60, rng)
    assert not estimator.lost()
    pose, belief = drive(estimator, Pose(1.2, 5.2, -1.6), 11, rng)  # three scans
    assert estimator.lost()
    off = pose.as_array() - belief.pose.as_array()
    assert off @ np.linalg.solve(belief.covariance, off) < 16.3  # 99.9 % of chi-square
    pose, belief = drive(estimator, pose, 200, rng)
    assert apart(pose, belief) < 0.1
    assert not estimator.lost()


@pytest.mark.slow
def test_one_beacon_tells_which_half_of_a_room_that_looks_alike_from_both():
    corners = np.array([(0, 0), (6, 0), (6, 4), (0, 4)], dtype=float)
    walls = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    lion = BeaconInfo("lion", None, 0.3, 0.3, pose=Pose(5.9, 3.0, np.pi), center=1.0)
    pose, found = Pose(2.0, 1.5, 0.3), []
    angles = np.linspace(-np.pi, np.pi, 60, endpoint=False) + pose.heading
    # From inside a rectangle a ray meets the nearer of the two walls that it runs towards.
    x = np.where(np.cos(angles) > 0, 6 - pose.x, -pose.x) / np.cos(angles)
    y = np.where(np.sin(angles) > 0, 4 - pose.y, -pose.y) / np.sin(angles)
    scan = Scan(0.0, np.minimum(x, y), -np.pi, 2 * np.pi / 60, 0.05, 12.0)
    look = Sighting(0.0, "lion", np.hypot(3.9, 1.5), np.arctan2(1.5, 3.9) - 0.3, np.diag([0.05, 0.02]) ** 2)
    for seed in range(3):
        estimator = MonteCarloLocalization(particles=1000, start="global")
        estimator.take_map(WorldMap(segments=walls, beacons={}))
        info = dataclasses.replace(pioneer(), prior=Pose(0, 0, 0), sensors={"scan": LIDAR})
        estimator.start(info, {"lion": lion}, np.random.default_rng(seed))
        for _ in range(5):
            still = Odometry(0.0, 0.0, 0.0, NOISE)
            belief = estimator.update(Observation(0.0, 0.04, still, scans={"scan": scan}, sightings=(look,)))
        found.append(apart(pose, belief))
    assert max(found) < 0.15


def test_resampling_draws_in_proportion_and_repeats_with_the_same_stream():
    weights = np.array([0.5, 0.25, 0.125, 0.125])
    drawn = systematic_resample_with(np.repeat(weights / 100, 100), np.random.default_rng(5))
    np.testing.assert_allclose(np.bincount(drawn // 100) / 400, weights, atol=0.01)
    again = systematic_resample_with(np.repeat(weights / 100, 100), np.random.default_rng(5))
    np.testing.assert_array_equal(drawn, again)


@pytest.mark.slow
def test_resampling_is_filterpys():
    from filterpy.monte_carlo import systematic_resample

    rng = np.random.default_rng(6)
    for number in (1, 2, 7, 300):
        weights = rng.dirichlet(np.full(number, 0.3))
        drawn = systematic_resample_with(weights, np.random.default_rng(number))
        np.random.seed(int(np.random.default_rng(number).integers(2**32)))  # noqa: NPY002, filterpy draws from there
        np.testing.assert_array_equal(drawn, systematic_resample(weights))


def test_particles_without_weight_leave_nothing_and_rounding_leads_to_the_last_one():
    rng = np.random.default_rng(0)
    assert systematic_resample_with(np.array([0.0, 1.0, 0.0]), rng).tolist() == [1, 1, 1]
    assert systematic_resample_with(np.zeros(3), rng).tolist() == [2, 2, 2]


def test_an_unknown_map_and_a_missing_lidar_are_errors():
    with pytest.raises(ValueError, match="map: known"):
        MonteCarloLocalization().take_map(None)
    estimator = MonteCarloLocalization(lidar="scan")
    estimator.take_map(MAP)
    with pytest.raises(ValueError, match="no lidar 'scan'"):
        estimator.start(pioneer(), {}, np.random.default_rng(0))


@pytest.mark.slow
def test_walls_between_cells_do_not_pull_the_belief_aside():
    # Mean NEES was 6.4, and the error 16 mm, when walls were drawn in whole cells of the grid.
    maze = with_settings(mjsim.load_world(MAZE), ["robots.theseus.odometry.noise={distance: 0.01, turn: 0.01}"])
    driver = mjsim.Driver(
        estimator=MonteCarloLocalization(lidar="scan"),
        navigator=Waypoints([(1.8, 0.6), (1.8, 1.8), (0.6, 1.8), (0.6, 3), (3, 3)], speed=0.4, lookahead=0.35),
    )
    errors, nees = [], []
    with mjsim.Simulation(maze, seed=1) as sim:
        for tick in itertools.takewhile(lambda tick: tick.time < 9, mjsim.ticks(sim, {"theseus": driver})):
            belief = tick.orders["theseus"].estimate
            off = belief.pose.as_array() - tick.truth["theseus"].as_array()
            off[2] = wrap_angle(float(off[2]))
            errors.append(np.hypot(*off[:2]))
            nees.append(off @ np.linalg.solve(belief.covariance, off))
    assert np.mean(errors) < 0.01
    assert np.mean(nees) < 4.0
    assert np.max(nees) < 25.0


def test_a_robot_that_stands_does_not_become_surer_by_looking_again():
    rng, pose = np.random.default_rng(5), Pose(4.1, 1.9, 0.05)
    estimator, sure = started(Pose(4, 2, 0), np.diag([0.2, 0.2, 0.1]) ** 2), []
    looked = scan_from(pose, rng)
    for tick in range(40):
        rest = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
        belief = estimator.update(Observation(0.04 * tick, 0.04, rest, scans={"scan": looked}))
        sure.append(np.sqrt(np.diag(belief.covariance)))
    assert (sure[-1] > 0.7 * sure[0]).all()


def box(x, y):
    """Return the walls of a box of 1 m."""
    return np.array(
        [[(x + a, y + b), (x + c, y + d)] for a, b, c, d in [(0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0)]],
        dtype=float,
    )


@pytest.mark.slow
def test_things_moved_in_a_hall_that_looks_alike_from_two_sides_do_not_lead_astray():
    """Turned by 180 degrees the hall fits as well as it does, and with three boxes elsewhere neither does so."""
    hall = np.array([(0, 0), (12, 0), (12, 8), (0, 8)], dtype=float)
    walls = np.stack([hall, np.roll(hall, -1, axis=0)], axis=1)
    known = WorldMap(np.concatenate([walls, box(3, 2), box(8, 5), box(3, 5), box(8, 2)]), beacons={})
    moved = np.concatenate([walls, box(5, 1), box(7, 6), box(2, 6.5), box(9, 0.5)])
    faces, rng, pose = (
        shapely.MultiLineString([face.tolist() for face in moved]),
        np.random.default_rng(4),
        Pose(5, 4, 0),
    )
    estimator = started(pose, np.diag([0.02, 0.02, 0.01]) ** 2, map=known)
    for tick in range(60):
        step = Pose(0.04, 0.0, 0.04)
        pose = pose @ step
        told = np.array([step.x, 0.0, step.heading]) + rng.normal(0, np.sqrt(np.diag(NOISE)))
        seen = {"scan": scan_from(pose, rng, 60, faces)}
        belief = estimator.update(Observation(0.1 * tick, 0.1, Odometry(*told, NOISE), scans=seen))
        assert apart(pose, belief) < 0.3
