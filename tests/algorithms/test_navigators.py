"""Navigators that drive a robot through real physics, by what it senses."""

import math
import os
import pty
import sys
import termios

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.algorithms.constant import ConstantCommand
from mjsim.algorithms.explore import Explore
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.algorithms.occupancy import OccupancyGrid, OccupancyMapping
from mjsim.algorithms.path_tracking import PathTracking
from mjsim.algorithms.paths.trajectories import SplinePath
from mjsim.algorithms.teleop import Teleop
from mjsim.algorithms.wall_follow import WallFollow
from mjsim.algorithms.wander import Wander

ROOMS = """
mjsim: 1
name: rooms
walls:
  - {points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true}
  - {points: [[4, 0], [4, 5]], openings: [{segment: 0, at: 3.2, width: 1.2}]}
obstacles: [{box: [0.8, 0.8, 1.0], at: [2, 3.6]}]
robots:
  - name: scout
    preset: pioneer3dx
    odometry: {noise: {distance: 0, turn: 0}}
    at: [1, 1]
    sensors: [{lidar: scan, at: [0.1, 0, 0.3], beams: 180, fov_deg: 360, range: [0.05, 10], rate_hz: 5}]
run: {map: known}
"""


def drive(navigator, seconds, *, text=ROOMS, estimator=None, avoidance=False, until=lambda: False):
    """Drive for a time, or until something holds; return true poses (n, 3) and the number of bumps."""
    with mjsim.Simulation(mjsim.parse_world(text), seed=1) as sim:
        driver = mjsim.Driver(navigator=navigator, estimator=estimator, avoidance=avoidance)
        poses, bumps = [], 0
        for tick in mjsim.ticks(sim, {"scout": driver}):
            if tick.time > seconds or until():
                break
            poses.append(tick.truth["scout"].as_array())
            bumps += sum(event.kind == "bump" for event in tick.orders["scout"].events)
    return np.array(poses), bumps


@pytest.mark.slow
def test_it_goes_to_a_goal_in_the_other_room_and_stops_there():
    poses, bumps = drive(GoToGoal([7, 1]), 40.0)
    assert np.hypot(*(poses[-1, :2] - (7, 1))) < 0.25
    assert np.hypot(*(poses[-1] - poses[-25])[:2]) < 0.01
    assert bumps == 0


def test_goals_that_are_no_numbers_are_refused():
    with pytest.raises(ValueError, match="finite"):
        GoToGoal([[7, np.nan]])


def test_its_planned_path_is_shown_beside_what_the_estimator_shows(tmp_path):
    with mjsim.Simulation(mjsim.parse_world(ROOMS)) as sim:
        driver = mjsim.Driver(navigator=GoToGoal([7, 1]))
        run = mjsim.run(sim, drivers={"scout": driver}, seconds=0.12, record=tmp_path / "run.mcap")
    (path,) = run.robots["scout"].shown[-1]
    assert (path.name, path.frame) == ("planned path", "world")
    np.testing.assert_allclose(path.points[[0, -1], :2], [[1, 1], [7, 1]], atol=0.1)
    # It leads through the doorway.
    assert shapely.LineString(path.points[:, :2]).crosses(shapely.LineString([(4, 3.2), (4, 4.4)]))


@pytest.mark.slow
def test_a_constant_twist_drives_a_circle():
    poses, bumps = drive(ConstantCommand(forward=0.3, turn=0.5), 15.0, text=ROOMS.replace("at: [1, 1]", "at: [6, 2]"))
    radii = np.hypot(*(poses[125:, :2] - (6.0, 2.6)).T)
    np.testing.assert_allclose(radii, 0.6, atol=0.05)  # it gathers speed first, which moves the middle
    assert bumps == 0
    with pytest.raises(ValueError, match="must be finite"):
        ConstantCommand(forward=math.nan)


@pytest.mark.slow
def test_where_there_is_no_way_it_goes_as_near_to_its_goal_as_it_gets():
    shut = ROOMS.replace(", openings: [{segment: 0, at: 3.2, width: 1.2}]", "")
    poses, bumps = drive(GoToGoal([7, 1]), 6.0, text=shut)
    # The wall is at 4 m, the rim of the robot at 0.22 m.
    assert 3.3 < poses[:, 0].max() < 3.72
    assert bumps == 0


@pytest.mark.slow
def test_it_follows_the_wall_at_its_distance_all_around():
    room = ROOMS.split("  - {points: [[4")[0] + "robots" + ROOMS.split("robots")[1]
    poses, bumps = drive(WallFollow(side="right", distance=0.4), 85.0, text=room)
    inner = shapely.box(0.06, 0.06, 7.94, 4.94).exterior
    settled = poses[400:]
    apart = shapely.distance(shapely.points(settled[:, :2]), inner) - 0.22
    assert bumps == 0
    assert abs(np.median(apart) - 0.4) < 0.05
    # It turned around the room, with the wall at the right counter-clockwise.
    around = np.unwrap(np.arctan2(settled[:, 1] - 2.5, settled[:, 0] - 4.0))
    assert around[-1] - around[0] > 1.5 * math.pi


@pytest.mark.slow
def test_it_follows_a_block_around_its_outer_corners():
    block = (
        ROOMS.split("walls:")[0]
        + """walls:
  - {points: [[0, 0], [9, 0], [9, 8], [0, 8]], closed: true}
  - {points: [[3, 3], [6, 3], [6, 5], [3, 5]], closed: true}
robots: [{name: scout, preset: pioneer3dx, at: [3.4, 2.3], odometry: {noise: {distance: 0, turn: 0}}}]
"""
    )
    poses, bumps = drive(WallFollow(side="left", distance=0.4), 48.0, text=block)
    apart = shapely.distance(shapely.points(poses[100:, :2]), shapely.box(2.95, 2.95, 6.05, 5.05)) - 0.22
    assert bumps == 0
    assert np.abs(apart - 0.4).max() < 0.12
    around = np.unwrap(np.arctan2(poses[:, 1] - 4.0, poses[:, 0] - 4.5))
    assert around[-1] - around[0] > 2 * math.pi


@pytest.mark.slow
def test_exploring_sees_both_rooms_and_knows_when_it_is_done():
    navigator = Explore()
    _, bumps = drive(navigator, 90.0, until=lambda: navigator.done)
    assert bumps == 0
    assert navigator.done
    distances = navigator.grid.distances()
    free = shapely.box(0.2, 0.2, 7.8, 4.8).difference(
        shapely.union_all([shapely.box(3.8, 0, 4.2, 5), shapely.box(1.5, 3.1, 2.5, 4.1)])
    )
    known = navigator.grid.log_odds[tuple(distances.cells(points_in(free)).T)]
    assert np.mean(known < 0) > 0.97


def points_in(shape, number=400):
    points = np.random.default_rng(0).uniform(*np.array(shape.bounds).reshape(2, 2), (3 * number, 2))
    return points[shapely.contains_xy(shape, *points.T)][:number]


@pytest.mark.slow
def test_wandering_covers_much_of_the_room_and_the_grid_of_odds_holds_the_walls_where_they_are():
    mapper = OccupancyMapping(cell=0.05)
    poses, bumps = drive(Wander(), 60.0, estimator=mapper, avoidance=True)
    assert len(np.unique(np.floor(poses[:, :2]), axis=0)) > 10
    assert bumps == 0
    walls = shapely.union_all(
        [
            shapely.box(-0.06, -0.06, 8.06, 5.06) - shapely.box(0.06, 0.06, 7.94, 4.94),
            shapely.box(1.6, 3.2, 2.4, 4.0),
            shapely.box(3.94, 0, 4.06, 3.2),
            shapely.box(3.94, 4.4, 4.06, 5),
        ]
    )
    occupied = np.argwhere(mapper.grid.log_odds > 2.0)
    centres = mapper.grid.distances().centres(occupied)
    assert len(centres) > 250
    assert np.quantile(shapely.distance(shapely.points(centres), walls), 0.95) < 0.1


def test_a_beam_that_ends_is_not_free_and_one_that_returns_nothing_is_free_to_its_end():
    grid = OccupancyGrid(cell=0.1, farthest=3.0)
    scan = mjsim.Scan(0.0, np.array([1.0, np.inf, -np.inf]), 0.0, math.pi / 2, 0.1, 2.0)
    grid.add(mjsim.Pose(0.05, 0.05, 0.0), scan)
    cells = grid.distances().cells(np.array([(0.55, 0.05), (1.05, 0.05), (1.55, 0.05), (0.05, 1.75), (-0.55, 0.05)]))
    np.testing.assert_array_equal(np.sign(grid.log_odds[tuple(cells.T)]), [-1, 1, 0, -1, 0])


@pytest.mark.slow
@pytest.mark.parametrize("controller", ["lqr", "linearisation"])
def test_a_curve_is_followed_within_centimetres(controller):
    points = [(2, 1), (3, 2.5), (3.2, 4), (2.5, 4.4)]
    poses, bumps = drive(PathTracking(points, controller=controller), 40.0)
    path = SplinePath([(1, 1), *points])
    curve = path.at(np.linspace(0, path.length, 2000))
    apart = np.hypot(*np.moveaxis(poses[:, None, :2] - curve, -1, 0)).min(axis=1)
    assert apart.max() < 0.05
    assert np.hypot(*(poses[-1, :2] - points[-1])) < 0.06
    assert bumps == 0


def test_keys_drive_and_the_terminal_is_put_back(monkeypatch):
    ours, theirs = pty.openpty()

    class Typed(Teleop):
        """Somebody types as soon as it listens."""

        def start(self, robot, map, rng):
            super().start(robot, map, rng)
            os.write(ours, b"ww\x1b[Aa")

    with os.fdopen(theirs) as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        before = termios.tcgetattr(theirs)
        navigator = Typed(speed=0.5, turn_deg=50)
        poses, _ = drive(navigator, 2.0)
        # Three steps of five ahead, one of five to the left.
        assert np.sum(np.hypot(*np.diff(poses[:, :2], axis=0).T)) == pytest.approx(0.3 * 2.0, abs=0.12)
        assert poses[-1, 2] == pytest.approx(math.radians(10) * 2.0, abs=0.06)
        assert termios.tcgetattr(theirs) != before
        del navigator
        assert termios.tcgetattr(theirs) == before
    os.close(ours)


def test_without_a_terminal_the_keyboard_is_told_to_be_missing(monkeypatch, tmp_path):
    (tmp_path / "nothing").touch()
    with (tmp_path / "nothing").open() as stream:
        monkeypatch.setattr(sys, "stdin", stream)
        with pytest.raises(mjsim.ModuleFault, match="not a terminal"):
            drive(Teleop(), 1.0)
