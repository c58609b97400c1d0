"""The built-in avoidance at work: robots told only to go ahead, in rooms with real walls."""

import itertools
import math
import runpy
from pathlib import Path

import numpy as np
import pytest
import shapely

import mjsim
from mjsim.algorithms.constant import ConstantCommand
from mjsim.algorithms.waypoints import Waypoints
from mjsim.exchange import clutter_world
from mjsim.report.coverage import coverage
from mjsim.world import load_checked, parse_world, solid

ROOT = Path(__file__).parents[2]
ROOM = "mjsim: 1\nwalls:\n  - {points: [[0, 0], [8, 0], [8, 6], [0, 6]], closed: true}\n"
SCOUT = "robots: [{name: scout, preset: pioneer3dx, at: [1.5, 3]}]\n"


def drive(world, seconds, *, navigator=None, avoidance=True, seed=1):
    """Return where all robots were at every tick, (robots, n, 3), and how many bumps there were."""
    poses, bumps = [], 0
    with mjsim.Simulation(world, seed=seed) as sim:
        drivers = {
            name: mjsim.Driver(navigator=navigator or ConstantCommand(forward=0.7), avoidance=avoidance)
            for name in sim.robots
        }
        for tick in itertools.islice(mjsim.ticks(sim, drivers), round(seconds / sim.dt)):
            poses.append([pose.as_array() for pose in tick.truth.values()])
            bumps += sum(event.kind == "bump" for order in tick.orders.values() for event in order.events)
    return np.array(poses).transpose(1, 0, 2), bumps


@pytest.mark.slow
def test_told_only_to_go_ahead_it_bumps_into_nothing_and_comes_about():
    world = clutter_world((12.0, 10.0), seed=3)
    (poses,), bumps = drive(world, 24.0)
    assert bumps == 0
    assert shapely.distance(solid(world), shapely.points(poses[:, :2])).min() > 0.22
    assert coverage(world, poses[:, :2], radius=0.22) > 0.12
    # It never waits: in 2 s it has moved or turned.
    moved = np.hypot(*(poses[50:] - poses[:-50])[:, :2].T) + np.abs((poses[50:] - poses[:-50])[:, 2])
    assert moved.min() > 0.05


@pytest.mark.slow
def test_with_the_avoidance_off_it_bumps_and_stays_within_the_walls():
    world = clutter_world((12.0, 10.0), seed=3)
    (poses,), bumps = drive(world, 15.0, avoidance=False)
    assert bumps >= 1
    assert np.hypot(*(poses[-1] - poses[-125])[:2]) < 0.05
    free = shapely.box(0.0, 0.0, 12.0, 10.0).difference(solid(world))
    assert shapely.contains_xy(free, *poses[:, :2].T).all()


@pytest.mark.slow
def test_a_corridor_with_a_closed_end_is_left_again():
    corridor = "obstacles: [{box: [4, 0.1, 1], at: [4, 3.5]}, {box: [4, 0.1, 1], at: [4, 2.5]}, "
    world = parse_world(ROOM + corridor + "{box: [0.1, 1.1, 1], at: [6, 3]}]\n" + SCOUT)
    (poses,), bumps = drive(world, 22.0)
    assert bumps == 0
    assert poses[:, 0].max() > 5.0
    assert poses[-1, 0] < 2.0 or abs(poses[-1, 1] - 3.0) > 0.6


def test_a_doorway_of_80_cm_is_passed():
    wall = "  - {points: [[4, 0], [4, 6]], openings: [{segment: 0, at: 2.6, width: 0.8}]}\n"
    (poses,), bumps = drive(parse_world(ROOM + wall + SCOUT), 8.0)
    assert bumps == 0
    assert poses[-1, 0] > 5.0


@pytest.mark.slow
def test_waypoints_behind_a_thing_are_reached_around_it():
    world = parse_world(ROOM + "obstacles: [{box: [0.5, 1.6, 1], at: [4, 3.1]}]\n" + SCOUT)
    (poses,), bumps = drive(world, 24.0, navigator=Waypoints([[6.8, 3]], speed=0.5))
    assert bumps == 0
    np.testing.assert_allclose(poses[-1, :2], [6.8, 3], atol=0.1)


@pytest.mark.slow
def test_two_robots_in_one_room_do_not_bump_into_each_other():
    two = "robots:\n  - {name: a, preset: pioneer3dx, at: [1.5, 3]}\n"
    two += "  - {name: b, preset: pioneer3dx, at: [6.5, 3.1], heading_deg: 180}\n"
    _, bumps = drive(parse_world(ROOM + two), 15.0)
    assert bumps == 0


@pytest.mark.parametrize("angle", [180, 140, 100])
def test_two_robots_that_would_meet_in_the_middle_stop_in_time(angle):
    away = 1.6 * np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
    two = "robots:\n  - {name: a, preset: pioneer3dx, at: [2.4, 3]}\n"
    two += f"  - {{name: b, preset: pioneer3dx, at: {(np.array([4.0, 3.0]) - away).tolist()}, heading_deg: {angle}}}\n"
    poses, bumps = drive(parse_world(ROOM + two), 3.0)
    assert bumps == 0
    assert np.hypot(*(poses[0] - poses[1])[:, :2].T).min() < 1.0


@pytest.mark.slow
def test_a_thing_that_comes_and_goes_across_the_way_is_let_pass():
    walker = "obstacles: [{cylinder: [0.25, 1.5], at: [4, 0.6], path: {points: [[4, 5.4]], speed: 0.4}}]\n"
    _, bumps = drive(parse_world(ROOM + walker + SCOUT), 12.0)
    assert bumps == 0


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["f1tenth", "robotino", "husky", "turtlebot3_burger"])
def test_other_drives_turn_away_from_a_wall_that_they_head_for(preset):
    world = parse_world(ROOM + SCOUT.replace("pioneer3dx", preset).replace("1.5, 3", "5, 3.2"))
    speed = 0.2 if preset == "turtlebot3_burger" else 0.7
    (poses,), bumps = drive(world, 3.0 / speed + 2.0, navigator=ConstantCommand(forward=speed))
    assert bumps == 0
    assert abs(poses[-1, 2]) > math.radians(30)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["youbot", "forklift"])
def test_a_long_robot_gets_out_of_corners_and_bumps_into_nothing(preset):
    corners = [[3, 0], [9, 0], [12, 3], [12, 9], [9, 12], [3, 12], [0, 9], [0, 3]]
    things = (
        "{cylinder: [0.35, 1.2], at: [8, 6]}, {cylinder: [0.35, 1.2], at: [4, 6]}, {box: [3.2, 0.3, 0.35], at: [6, 6]}"
    )
    hall = f"mjsim: 1\nwalls: [{{points: {corners}, closed: true}}]\nobstacles: [{things}]\n"
    robot = f"robots: [{{name: scout, preset: {preset}, at: [9.5, 9], heading_deg: -120}}]\n"
    (poses,), bumps = drive(parse_world(hall + robot), 18.0)
    assert bumps == 0
    # In no 10 s does it stay within half a metre.
    ways = np.lib.stride_tricks.sliding_window_view(poses[:, :2], 250, axis=0)
    assert np.ptp(ways, axis=-1).sum(axis=-1).min() > 0.5


def test_the_shipped_world_is_the_one_that_new_makes_with_a_camera_for_people():
    shipped, made = load_checked(ROOT / "worlds" / "avoidance.yaml"), clutter_world((12.0, 10.0), seed=3)
    assert shipped.obstacles == made.obstacles
    assert shipped.walls == made.walls
    assert shipped.robots[0].at == made.robots[0].at
    assert shipped.run.drivers == made.run.drivers


@pytest.mark.slow
def test_the_class_on_the_page_keeps_its_distance(tmp_path):
    page = (ROOT / "docs" / "avoidance.md").read_text(encoding="utf-8")
    code = page.split("```python\n")[1].split("```")[0]
    (tmp_path / "my_avoidance.py").write_text(code)
    slow = runpy.run_path(str(tmp_path / "my_avoidance.py"))["SlowDown"](distance=0.6)
    (poses,), bumps = drive(parse_world(ROOM + SCOUT), 16.0, avoidance=slow)
    assert bumps == 0
    # The wall's face is at 7.95 m, the rim at 0.22 m.
    assert 7.95 - 0.22 - poses[-1, 0] > 0.02
    assert poses[-1, 0] > 7.0
