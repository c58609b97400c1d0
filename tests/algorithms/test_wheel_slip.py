"""Wheels that turn without moving the robot, against scans of a room computed point by point."""

import math

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.algorithms.go_to_goal.range_views import RangeView
from mjsim.algorithms.go_to_goal.wheel_slip import WheelSlip
from mjsim.geometry import Pose
from mjsim.interface import Odometry
from tests.algorithms.test_goals_by_drive import SEES

STEP = 2 * math.pi / 180


def scan(pose, length, width):
    """Return the view from a pose in a rectangle about the origin."""
    bearings = pose.heading + STEP * (np.arange(180) + 0.123)
    c, s = np.cos(bearings), np.sin(bearings)
    along = np.where(c > 0, 0.5 * length - pose.x, -0.5 * length - pose.x) / c
    across = np.where(s > 0, 0.5 * width - pose.y, -0.5 * width - pose.y) / s
    ranges = np.minimum(along, across)
    return RangeView("scan", Pose(0.0, 0.0, 0.0), 0.123 * STEP, STEP, np.where(ranges < 4.0, ranges, np.inf), 4.0)


def driven(slip, pose, *, forward, turn, share, length=6.0, began=0.0):
    """Drive with wheels of which a share moves the robot; return where it is and what was held at each tick."""
    held, believed = [], pose
    for tick in range(40):
        pose = pose @ Pose(share * forward, 0.0, share * turn)
        believed = believed @ Pose(forward, 0.0, turn)
        view, now = scan(pose, length, 3.0), began + 0.1 * tick
        slip.update(believed, Odometry(forward, 0.0, turn, np.zeros((3, 3))), [view], now)
        held.append(slip.held)
    return pose, held


@pytest.mark.parametrize(("forward", "turn"), [(0.04, 0.0), (0.0, 0.05), (-0.03, 0.02)])
def test_wheels_that_slip_are_noticed_and_released_when_the_robot_moves(forward, turn):
    slip, start = WheelSlip(), Pose(-1.0, 0.2, 0.3)
    place, held = driven(slip, start, forward=forward, turn=turn, share=1.0)
    assert held == [None] * 40
    _, held = driven(slip, place, forward=forward, turn=turn, share=0.0, began=4.0)
    assert held[-1] is not None
    assert slip.lasts(7.9) > 2.9
    assert math.hypot(held[-1].x - place.x, held[-1].y - place.y) < 0.3
    assert driven(slip, place, forward=forward, turn=turn, share=1.0, began=8.0)[1][-1] is None


def test_wheels_slip_since_they_explain_the_scans_less_than_a_stop():
    slip, place = WheelSlip(), Pose(-1.0, 0.2, 0.3)
    # The body rocks while the wheels turn: scans differ, then stay the same.
    for tick in range(40):
        rocking = Pose(0.0, 0.0, 0.1 * (tick % 8 > 3)) if tick < 20 else Pose(0.0, 0.0, 0.0)
        view = scan(place @ rocking, 6.0, 3.0)
        slip.update(place, Odometry(0.04, 0.0, 0.0, np.zeros((3, 3))), [view], 0.1 * tick)
    assert slip.held is not None
    assert slip.lasts(3.9) > 3.4


def test_in_a_corridor_without_ends_nothing_is_known():
    _, held = driven(WheelSlip(), Pose(0.0, 0.2, 0.0), forward=0.04, turn=0.0, share=1.0, length=60.0)
    assert held == [None] * 40


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_robot_that_fell_over_an_edge_and_spins_its_wheels_says_so_within_5_s(seed):
    world = mjsim.parse_world(f"""
mjsim: 1
walls: [{{points: [[0, 0], [10, 0], [10, 5], [0, 5]], closed: true}}]
obstacles:
  - {{ramp: [3, 2, 0.25], at: [4, 2.5]}}
  - {{box: [1.5, 2, 0.25], at: [6.25, 2.5]}}
robots: [{{name: r, preset: pioneer3dx, at: [1, 2.5], sensors: {SEES}}}]
""")
    rest, since, navigator = None, 0.0, GoToGoal([8.5, 2.5])
    with mjsim.Simulation(world, seed=seed) as sim:
        for tick in mjsim.ticks(sim, {"r": mjsim.Driver(navigator=navigator)}):
            pose = tick.truth["r"]
            if rest is None or math.hypot(pose.x - rest.x, pose.y - rest.y) > 0.15:
                rest, since = pose, tick.time
            if "the wheels turn, but the sensors see no motion" in (navigator.blocked() or ""):
                break
            assert tick.time < since + 5.0
