"""GoToGoal with other drives and sensors: around walls and posts that it does not know."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal

ROOM = """
mjsim: 1
walls: [{points: [[0, 0], [7, 0], [7, 5], [0, 5]], closed: true}]
obstacles:
  - {box: [0.3, 2.8, 1.0], at: [3.0, 1.4]}
  - {cylinder: [0.2, 1.0], at: [4.6, 3.0]}
robots: [{name: r, preset: PRESET, sensors: SENSORS}]
"""
LIDAR = (
    "[{lidar: scan, at: [0.05, 0, 0.4], beams: 181, fov_deg: FOV, range: [0.05, REACH], rate_hz: 12.5,"
    " noise: {range: 0.01}}]"
)
DEPTH = "[{camera: front, at: [0.15, 0, 0.35], width: 160, height: 120, fov_deg: 80, rate_hz: 12.5, depth: true}]"
CASES = {
    "a lidar of 180 degrees": ("pioneer3dx, at: [1.5, 1.2]", LIDAR.replace("FOV", "180").replace("REACH", "8")),
    "a lidar of 2 m": ("jackal, at: [1.5, 1.2]", LIDAR.replace("FOV", "360").replace("REACH", "2")),
    "rollers": ("robotino, at: [1.5, 1.2]", LIDAR.replace("FOV", "240").replace("REACH", "8")),
    "two wheels that balance": ("balancer, at: [1.5, 1.2]", LIDAR.replace("FOV", "360").replace("REACH", "8")),
    "a car that must reverse": (
        "f1tenth, at: [0.6, 1.2], heading_deg: 180",
        LIDAR.replace("FOV", "270").replace("REACH", "8"),
    ),
    "three wheels, forks first": (
        "forklift, at: [1.9, 3.5]",
        LIDAR.replace("FOV", "360").replace("REACH", "8").replace("0.05, 0, 0.4", "-1.2, 0, 0.9"),
    ),
    "a depth camera alone": ("pioneer3dx, at: [1.5, 1.2]", DEPTH),
    "proximity alone": ("pioneer3dx, at: [1.5, 1.2]", "[]"),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_it_arrives_without_a_touch_with(case):
    preset, sensors = CASES[case]
    world = mjsim.parse_world(ROOM.replace("PRESET", preset).replace("SENSORS", sensors))
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=GoToGoal([5.8, 1.2]))}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            pose = tick.truth["r"]
            # It has no estimator; dead reckoning drifts.
            if np.hypot(pose.x - 5.8, pose.y - 1.2) < 0.6:
                break
            assert tick.time < 25.0


class ClosesALoop:
    """Dead reckoning without noise, with an error that vanishes at once after 3 s."""

    def start(self, robot, catalogue, rng):
        self.pose = robot.prior

    def update(self, seen):
        moved = seen.odometry
        self.pose = self.pose @ mjsim.Pose(moved.forward, moved.left, moved.turn)
        error = mjsim.Pose(0.0, 0.0, 0.0) if seen.time > 3.0 else mjsim.Pose(0.3, -0.35, 0.15)
        return mjsim.Estimate(error @ self.pose, np.diag([0.01, 0.01, 0.01]))


@pytest.mark.slow
def test_it_arrives_without_a_touch_when_the_estimate_jumps_because_a_loop_closes():
    sensors = LIDAR.replace("FOV", "360").replace("REACH", "8")
    text = ROOM.replace("PRESET", "pioneer3dx, at: [1.5, 1.2]").replace("SENSORS", sensors)
    world = mjsim.parse_world(
        text.replace("at: [1.5, 1.2]", "odometry: {noise: {distance: 0, turn: 0}}, at: [1.5, 1.2]")
    )
    with mjsim.Simulation(world, seed=1) as sim:
        driver = mjsim.Driver(navigator=GoToGoal([5.8, 1.2]), estimator=ClosesALoop())
        for tick in mjsim.ticks(sim, {"r": driver}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            if np.hypot(tick.truth["r"].x - 5.8, tick.truth["r"].y - 1.2) < 0.2:
                break
            assert tick.time < 25.0
    assert tick.time > 5.0


@pytest.mark.slow
def test_two_that_meet_in_a_corridor_pass_each_other():
    width = 1.6
    lidar = LIDAR.replace("[0.05, 0, 0.4]", "[0.1, 0, 0.2]").replace("FOV", "360").replace("REACH", "8")
    world = mjsim.parse_world(f"""
mjsim: 1
walls: [{{points: [[0, 0], [9, 0], [9, {width}], [0, {width}]], closed: true}}]
robots:
  - {{name: a, preset: pioneer3dx, at: [1, {width / 2}], sensors: {lidar}}}
  - {{name: b, preset: pioneer3dx, at: [8, {width / 2}], heading_deg: 180, sensors: {lidar}}}
""")
    goals, arrived = {"a": [8.0, width / 2], "b": [1.0, width / 2]}, set()
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {name: mjsim.Driver(navigator=GoToGoal(goal)) for name, goal in goals.items()}):
            for name, (x, y) in goals.items():
                assert not any(event.kind == "bump" for event in tick.orders[name].events)
                if np.hypot(tick.truth[name].x - x, tick.truth[name].y - y) < 0.5:
                    arrived.add(name)
            if len(arrived) == 2:
                break
            assert tick.time < 16.0


@pytest.mark.slow
def test_two_that_meet_in_a_corridor_for_one_pass_by_its_niche():
    lidar = LIDAR.replace("[0.05, 0, 0.4]", "[0.1, 0, 0.2]").replace("FOV", "360").replace("REACH", "8")
    niche = "[10, 0], [10, 1], [5.8, 1], [5.8, 2], [4.6, 2], [4.6, 1], [0, 1]"
    world = mjsim.parse_world(f"""
mjsim: 1
walls: [{{points: [[0, 0], {niche}], closed: true}}]
robots:
  - {{name: a, preset: pioneer3dx, at: [2.5, 0.5], sensors: {lidar}}}
  - {{name: b, preset: pioneer3dx, at: [7.5, 0.5], heading_deg: 180, sensors: {lidar}}}
""")
    navigators = {"a": GoToGoal([7.5, 0.5]), "b": GoToGoal([2.5, 0.5])}
    with mjsim.Simulation(world, seed=3) as sim:
        for tick in mjsim.ticks(sim, {name: mjsim.Driver(navigator=each) for name, each in navigators.items()}):
            for order in tick.orders.values():
                assert not any(event.kind == "bump" for event in order.events)
            if all(each.is_done for each in navigators.values()):
                break
            assert tick.time < 40.0


SEES = LIDAR.replace("FOV", "360").replace("REACH", "8")


@pytest.mark.slow
def test_it_gets_through_a_door_17_cm_wider_than_its_body():
    world = mjsim.parse_world(f"""
mjsim: 1
walls:
  - {{points: [[0, 0], [8, 0], [8, 4], [0, 4]], closed: true}}
  - {{points: [[4, 0], [4, 4]], openings: [{{segment: 0, at: 1.725, width: 0.55}}]}}
robots: [{{name: r, preset: pioneer3dx, at: [1.5, 1.2], sensors: {SEES}}}]
""")
    navigator = GoToGoal([6.5, 2.8])
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=navigator)}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            if navigator.is_done:
                break
            assert tick.time < 25.0
    assert tick.truth["r"].x > 6.0


@pytest.mark.slow
def test_shut_in_it_says_why_after_5_s():
    walls = "walls: [{points: [[0, 0], [0.9, 0], [0.9, 0.9], [0, 0.9]], closed: true}]"
    text = f"mjsim: 1\n{walls}\nrobots: [{{name: r, preset: pioneer3dx, at: [0.45, 0.45], sensors: {SEES}}}]\n"
    with mjsim.Simulation(mjsim.parse_world(text), seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=GoToGoal([5.0, 0.5]))}):
            told = [event.text for event in tick.orders["r"].events if event.kind == "blocked"]
            if told:
                break
            assert tick.time < 6.0
    assert told[0].startswith("r is blocked: no path to [5, 0.5]")
    assert tick.time == pytest.approx(5.0, abs=0.2)


F1TENTH = "preset: f1tenth, at: [1, 2.5]"
TRICYCLE = (
    "at: [1, 2.5], drive: {type: tricycle, wheelbase: 0.6, driven: front, max_steer_deg: 40},"
    " body: {box: [0.9, 0.5, 0.4], at: [0.3, 0]}"
)
POST = "  - {cylinder: [0.2, 1.0], at: [3.2, 2.2]}"
BAY = "  - {box: [0.9, 0.3, 1.0], at: [2.2, 0.15]}\n  - {box: [0.9, 0.3, 1.0], at: [4.3, 0.15]}"
POSES = {
    "a car, against its direction": (F1TENTH, POST, [4.5, 2.5, 180.0]),
    "a car that parks between two boxes": ("preset: f1tenth, at: [2.6, 1]", BAY, [3.1, 0.28, 0.0]),
    "a tricycle, across": (TRICYCLE, POST, [4.5, 2.5, -90.0]),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", POSES)
def test_it_arrives_at_the_heading_of_its_goal_with(case):
    robot, obstacles, goal = POSES[case]
    world = mjsim.parse_world(f"""
mjsim: 1
walls: [{{points: [[0, 0], [7, 0], [7, 5], [0, 5]], closed: true}}]
obstacles:
{obstacles}
robots: [{{name: r, {robot}, sensors: {SEES.replace("0.05, 0, 0.4", "0.1, 0, 0.45")}}}]
""")
    navigator = GoToGoal([goal])
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=navigator)}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            if navigator.is_done:
                break
            assert tick.time < 45.0
    pose = tick.truth["r"]
    # The tolerances, and the drift of dead reckoning.
    assert math.hypot(pose.x - goal[0], pose.y - goal[1]) < 0.17
    assert abs(math.remainder(pose.heading - math.radians(goal[2]), 2 * math.pi)) < math.radians(7.0)


TWO_DOORS = """
mjsim: 1
walls:
  - {points: [[0, 0], [8, 0], [8, 5], [0, 5]], closed: true}
  - points: [[4, 0], [4, 5]]
    openings:
      - {name: near, at: 0.8, width: 1.0, door: {angle_deg: 85, locked: true}}
      - {name: far, at: 3.4, width: 1.0, door: {angle_deg: 85, locked: true}}
obstacles: [{name: cart, box: [0.5, 0.9, 1.0], at: [6, 4.3], movable: true, mass: 30}]
robots: [{name: r, preset: pioneer3dx, at: [1, 1.3], sensors: SENSORS}]
run: {events: [EVENTS]}
"""
BLOCKED_WAYS = {
    "a cart that stands in the door": ("{time: 2, move: cart, to: [4, 1.3]}", None),
    "all doors, until one opens": (
        "{time: 2, close: near}, {time: 2, close: far}, {time: 14, open: far, angle_deg: 85}",
        "no path to [7, 1.3]",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", BLOCKED_WAYS)
def test_where_its_way_is_blocked_for_ever_it_takes_another(case):
    events, reason = BLOCKED_WAYS[case]
    world, told = mjsim.parse_world(TWO_DOORS.replace("SENSORS", SEES).replace("EVENTS", events)), []
    navigator = GoToGoal([7.0, 1.3])
    with mjsim.Simulation(world, seed=1) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=navigator)}):
            assert not any(event.kind == "bump" for event in tick.orders["r"].events)
            told += [event.text for event in tick.orders["r"].events if event.kind == "blocked"]
            if navigator.is_done:
                break
            assert tick.time < 45.0
    assert tick.truth["r"].x > 6.5
    if reason is not None:
        assert reason in told[0]
