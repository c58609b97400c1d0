"""The reaction to a bump and the built-in avoidance, apart from physics."""

import math

import numpy as np
import pytest

from mjsim.geometry import Pose
from mjsim.interface import Command, Observation, Odometry, WheelCommand
from mjsim.safety import RingAvoidance, react_to_bump
from mjsim.safety.footprint import Footprint
from mjsim.safety.hits import Hits
from tests.robots import pioneer

ROBOT = pioneer(prior=Pose(0.0, 0.0, 0.0))


def test_a_free_robot_does_what_it_is_told():
    command = Command(0.5, 0.0, 0.3)
    assert react_to_bump(command, ()) is command


@pytest.mark.parametrize("bearing", [0.0, 1.2, -1.2])
def test_what_is_touched_ahead_stops_the_way_ahead_and_leaves_turning(bearing):
    assert react_to_bump(Command(0.5, 0.0, 0.3), (bearing,)) == Command(0.0, 0.0, 0.3)


@pytest.mark.parametrize("bearing", [np.pi, 2.0, -2.0, np.pi / 2])
def test_what_is_touched_behind_or_at_the_side_leaves_the_way_ahead_free(bearing):
    assert react_to_bump(Command(0.5, 0.0, 0.0), (bearing,)) == Command(0.5, 0.0, 0.0)


def test_a_robot_that_touches_ahead_can_back_off():
    assert react_to_bump(Command(-0.3, 0.0, 0.0), (0.1,)) == Command(-0.3, 0.0, 0.0)


def test_wheel_speeds_lose_only_the_part_that_drives_on():
    assert react_to_bump(WheelCommand((5.0, 3.0)), (0.0,)) == WheelCommand((1.0, -1.0))
    assert react_to_bump(WheelCommand((-5.0, -3.0)), (0.0,)) == WheelCommand((-5.0, -3.0))


AHEAD = Command(0.7)


def drive(boxes, *, seconds, command=AHEAD, start=(0.0, 0.0, 0.0), dt=0.04, reach=2.0):
    """Move a kinematic robot through axis-parallel boxes (n, 4) with the avoidance; return poses (k, 3)."""
    boxes = np.asarray(boxes, dtype=float)
    avoidance = RingAvoidance()
    avoidance.start(ROBOT, np.random.default_rng(0))
    pose, moved, poses = Pose(*start), Pose(0.0, 0.0, 0.0), []
    angles = np.arange(16) * np.pi / 8
    for tick in range(round(seconds / dt)):
        directions = np.stack([np.cos(pose.heading + angles), np.sin(pose.heading + angles)], axis=-1)
        starts = np.array([pose.x, pose.y]) + ROBOT.radius * directions
        with np.errstate(divide="ignore"):
            low, high = ((boxes[:, k : k + 2] - starts[:, None]) / directions[:, None] for k in (0, 2))
        enter, leave = np.minimum(low, high).max(axis=-1), np.maximum(low, high).min(axis=-1)
        hits = np.where((enter <= leave) & (leave > 0.0), np.maximum(enter, 0.0), np.inf).min(axis=1)
        ranges = np.where(hits <= reach, hits, np.inf)
        seen = Observation(tick * dt, dt, Odometry(moved.x, moved.y, moved.heading, np.zeros((3, 3))), proximity=ranges)
        told = avoidance.adjust(command, seen)
        moved = Pose(0.0, 0.0, told.turn * dt / 2) @ Pose(told.forward * dt, 0.0, told.turn * dt / 2)
        pose = pose @ moved
        poses.append(pose.as_array())
    return np.array(poses)


def clearance(poses, boxes):
    """Return the distance from the rim to the nearest box over the whole way [m]."""
    boxes = np.asarray(boxes, dtype=float)
    x, y = poses[:, 0, None], poses[:, 1, None]
    dx = np.maximum(np.maximum(boxes[:, 0] - x, x - boxes[:, 2]), 0.0)
    dy = np.maximum(np.maximum(boxes[:, 1] - y, y - boxes[:, 3]), 0.0)
    return float(np.hypot(dx, dy).min()) - ROBOT.radius


ROOM = [(-3, -3, 3, -2.9), (-3, 2.9, 3, 3), (-3, -3, -2.9, 3), (2.9, -3, 3, 3)]


def test_an_open_floor_leaves_the_command_as_it_is():
    poses = drive([(50, 50, 51, 51)], seconds=4.0)
    np.testing.assert_allclose(poses[-1], [0.7 * 4.0, 0.0, 0.0], atol=1e-9)


@pytest.mark.slow
def test_told_only_to_go_ahead_in_a_room_it_never_touches_and_never_rests():
    boxes = [*ROOM, (1.0, 0.6, 1.4, 1.0), (-1.5, -1.8, -1.2, -0.9)]
    poses = drive(boxes, seconds=60.0, start=(-2.0, 0.5, 0.3))
    assert clearance(poses, boxes) > 0.03
    driven = np.hypot(*np.diff(poses[:, :2], axis=0).T).sum()
    assert driven > 0.35 * 60.0 * 0.7
    assert np.ptp(poses[-500:, 0]) > 1.0


def test_it_gets_out_of_a_dead_end():
    pocket = [(0.0, -0.6, 1.5, -0.5), (0.0, 0.5, 1.5, 0.6), (1.4, -0.6, 1.5, 0.6)]
    poses = drive(pocket, seconds=20.0, start=(-0.5, 0.0, 0.0))
    assert clearance(poses, pocket) > 0.03
    assert poses[:, 0].max() > 0.5
    assert poses[-1, 0] < 0.0


def test_turning_on_the_spot_is_never_changed():
    boxes = [(0.3, -1.0, 0.4, 1.0)]
    poses = drive(boxes, seconds=1.0, command=Command(0.0, 0.0, 1.0))
    np.testing.assert_allclose(poses[-1], [0.0, 0.0, 1.0], atol=1e-9)


def test_it_backs_off_with_an_eye_on_what_is_behind():
    boxes = [(-1.5, -1.0, -1.4, 1.0)]
    poses = drive(boxes, seconds=6.0, command=Command(-0.5))
    assert clearance(poses, boxes) > 0.03
    assert math.isclose(poses[0, 0], -0.02, abs_tol=1e-6)


def test_what_a_ray_finds_ahead_leaves_it_room_to_stop_whichever_way_it_turns():
    avoidance = RingAvoidance()
    avoidance.start(ROBOT, np.random.default_rng(0))
    ring, still = np.full(16, np.inf), Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    ring[2] = 0.25
    told = avoidance.adjust(AHEAD, Observation(0.0, 0.04, still, proximity=ring))
    assert 0.1 < told.forward < 0.7
    # At half of what its brakes could do, along the ray at 45 degrees.
    stops = (told.forward * math.cos(math.pi / 4)) ** 2 / (2.0 * 0.5 * ROBOT.max_acceleration)
    assert stops <= 0.6 * 0.25


CAR = pioneer(
    radius=0.48,
    max_curvature=1.35,
    outline=np.array([[-0.125, -0.155], [0.455, -0.155], [0.455, 0.155], [-0.125, 0.155]]),
)


def test_a_robot_that_is_not_round_stops_turning_when_a_side_would_swing_into_what_it_touches():
    # Touched at the left of its nose, left of the middle: turning left presses, turning right leaves.
    side = math.atan2(0.155, 0.3)
    assert react_to_bump(Command(0.0, turn=0.5), (side,), CAR) == Command()
    assert react_to_bump(Command(0.0, turn=-0.5), (side,), CAR) == Command(turn=-0.5)
    # A round robot presses nowhere when it turns.
    assert react_to_bump(Command(0.0, turn=0.5), (side,), ROBOT) == Command(turn=0.5)


def test_what_neighbouring_rays_hit_is_joined_where_the_body_could_not_pass_between():
    ring, still = np.full(16, np.inf), Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    ring[[0, 1, 8, 10]] = 0.3
    hits = Hits(np.full(16, 0.2), join=0.31)
    hits.see(Observation(0.0, 0.04, still, proximity=ring))
    points = hits.within(1.0)
    first, second = np.array([0.5, 0.0]), 0.5 * np.array([math.cos(math.pi / 8), math.sin(math.pi / 8)])
    for share in (0.25, 0.5, 0.75):
        assert np.hypot(*(points - (first + share * (second - first))).T).min() < 1e-12
    # Rays 8 and 10 are not neighbours: behind it only what they hit themselves is known.
    assert set(map(tuple, points[points[:, 0] < 0.0].round(3))) == {(-0.5, 0.0), (-0.354, -0.354)}


def test_a_footprint_has_the_slenderness_of_its_body():
    assert Footprint(ROBOT).slender == 1.0
    assert Footprint(CAR).width == pytest.approx(0.31)
    assert Footprint(CAR).slender == pytest.approx(0.48 / 0.155)


def test_wheels_with_rollers_lose_only_the_part_that_presses():
    # Four mecanum wheels of 0.05 m, levers of 0.4 m: rows forward, left, turn.
    matrix = np.array([[1, 1, 1, 1], [-1, 1, 1, -1], [-2.5, 2.5, -2.5, 2.5]]) * 0.05 / 4
    robot = pioneer(max_left=0.5, twist_from_wheels=matrix)
    slanted = WheelCommand((0.0, 8.0, 8.0, 0.0))
    np.testing.assert_allclose(matrix @ slanted.speeds, [0.2, 0.2, 0.0])
    assert react_to_bump(slanted, (np.pi,), robot) is slanted
    stopped = react_to_bump(slanted, (np.pi / 2,), robot)
    np.testing.assert_allclose(stopped.speeds, 0.0, atol=1e-12)


def test_a_car_with_no_way_ahead_backs_off_and_turns_no_sharper_than_it_can():
    avoidance = RingAvoidance()
    avoidance.start(CAR, np.random.default_rng(0))
    ahead = np.full(16, np.inf)
    ahead[[15, 0, 1]] = 0.1
    still = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3)))
    told = avoidance.adjust(Command(0.7), Observation(0.0, 0.04, still, proximity=ahead))
    assert told.forward < -0.2
    assert abs(told.turn) <= 1.35 * abs(told.forward) + 1e-9


def test_a_robot_told_to_go_sideways_slips_past_what_stands_there_and_rests_before_a_wall():
    avoidance = RingAvoidance()
    avoidance.start(pioneer(max_left=0.5), np.random.default_rng(0))
    still, ring = Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))), np.full(16, np.inf)
    assert avoidance.adjust(Command(left=0.4), Observation(0.0, 0.04, still, proximity=ring)) == Command(left=0.4)
    ring[3] = 0.15
    past = avoidance.adjust(Command(left=0.4), Observation(0.04, 0.04, still, proximity=ring))
    assert past.left > 0.1
    assert past.forward < -0.05
    ring[1:8] = 0.1
    rests = avoidance.adjust(Command(left=0.4), Observation(0.08, 0.04, still, proximity=ring))
    assert math.hypot(rests.forward, rests.left) < 0.05
