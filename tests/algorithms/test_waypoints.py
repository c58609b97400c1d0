"""The waypoint navigator on a robot that moves exactly as it is told."""

import math

import numpy as np
import pytest

from mjsim.algorithms.waypoints import Waypoints, cut_at_corners, look_ahead
from mjsim.geometry import Array, Pose
from mjsim.interface import Estimate, Observation, Odometry, RobotInfo
from tests.robots import pioneer

DT = 0.04


def robot_at(pose: Pose) -> RobotInfo:
    return pioneer(max_turn=math.radians(100), max_turn_acceleration=math.radians(300), dt=DT, prior=pose)


def drive(navigator: Waypoints, pose: Pose, seconds: float, *, lag: float = 0.0, error: float = 0.0) -> Array:
    """Return rows (x, y, heading, forward, turn) of a unicycle that knows where it is, up to an error.

    Exact along arcs. The lag [s] is that of its drive to a new command, the error [m] white noise on what it believes.
    """
    robot, rng = robot_at(pose), np.random.default_rng(0)
    navigator.start(robot, None, rng)
    forward = turn = 0.0
    rows = []
    for k in range(round(seconds / DT)):
        still = Observation(time=k * DT, dt=DT, odometry=Odometry(0.0, 0.0, 0.0, np.zeros((3, 3))))
        x, y = pose.as_array()[:2] + rng.normal(0.0, error, 2)
        command = navigator.command(still, Estimate(pose=Pose(x, y, pose.heading), covariance=np.zeros((3, 3))))
        share = DT / (DT + lag)
        forward += share * (command.forward - forward)
        turn += share * (command.turn - turn)
        half = 0.5 * turn * DT
        chord = forward * DT * math.sin(half) / half if half else forward * DT
        pose = pose @ Pose(chord * math.cos(half), chord * math.sin(half), turn * DT)
        rows.append((pose.x, pose.y, pose.heading, command.forward, command.turn))
    return np.array(rows)


def distance_from(path: list[tuple[float, float]], points: Array) -> Array:
    """Return the distance of each point from a polyline [m]."""
    a, b = np.array(path[:-1]), np.array(path[1:])
    share = np.sum((points[:, None] - a) * (b - a), axis=2) / np.sum((b - a) ** 2, axis=1)
    feet = a + np.clip(share, 0.0, 1.0)[..., None] * (b - a)
    return np.asarray(np.hypot(*np.moveaxis(points[:, None] - feet, -1, 0)).min(axis=1))


def test_a_straight_line_is_driven_straight_at_the_speed_asked_for():
    rows = drive(Waypoints([[5, 0]], speed=0.5), Pose(0, 0, 0), 20)
    assert np.abs(rows[:, 1]).max() < 1e-9
    middle = (rows[:, 0] > 1) & (rows[:, 0] < 4)
    np.testing.assert_allclose(rows[middle, 3], 0.5)


@pytest.mark.parametrize("lag", [0.0, 0.1])
def test_a_square_is_followed_within_15_cm_and_ends_at_its_last_point(lag):
    rows = drive(Waypoints([[4, 0], [4, 4], [0, 4], [0, 0]], tolerance=0.15), Pose(0, 0, 0.5), 60, lag=lag)
    square = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)]
    assert distance_from(square, rows[:, :2]).max() < 0.15
    assert np.hypot(*rows[-1, :2]) < 0.1


def test_gentle_corners_are_rounded_without_stopping():
    path = [(0.0, 0.0), (3.0, 0.0), (6.0, 2.0), (9.0, 2.0)]
    rows = drive(Waypoints(path[1:]), Pose(0, 0, 0), 18)
    assert distance_from(path, rows[:, :2]).max() < 0.12
    on_the_way = (rows[:, 0] > 0.5) & (rows[:, 0] < 8.0)
    assert rows[on_the_way, 3].min() > 0.5


def test_it_stands_still_at_the_end_even_when_the_belief_moves_on():
    rows = drive(Waypoints([[2, 0]]), Pose(0, 0, 0), 30, error=0.03)
    assert np.all(rows[250:, 3:] == 0.0)
    assert np.hypot(rows[-1, 0] - 2.0, rows[-1, 1]) < 0.15


def test_a_robot_that_looks_the_wrong_way_turns_on_the_spot_first():
    rows = drive(Waypoints([[3, 0]]), Pose(0, 0, math.pi - 0.01), 20)
    turning = rows[:, 3] == 0.0
    first = int(np.argmin(turning))
    assert np.hypot(*rows[first - 1, :2]) < 1e-6
    assert abs(rows[first - 1, 2]) < 0.15
    assert rows[:, 4].max() <= math.radians(100)


def test_two_laps_pass_every_point_twice():
    points = [[3, 0], [3, 2], [0, 2], [0, 0]]
    rows = drive(Waypoints(points, laps=2), Pose(0, 0, 0), 70)
    for x, y in points[:3]:
        near = np.hypot(rows[:, 0] - x, rows[:, 1] - y) < 0.35
        assert np.sum(np.diff(near.astype(int)) == 1) == 2
    assert np.hypot(*rows[-1, :2]) < 0.1


@pytest.mark.parametrize(
    "wrong", [{"points": []}, {"points": [[1, 2]], "laps": 0}, {"points": [[1, 2]], "speed": -1.0}]
)
def test_a_path_that_cannot_be_is_refused(wrong):
    with pytest.raises(ValueError, match=r"points|laps|speed"):
        Waypoints(**wrong)


CORNER = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0]])


@pytest.mark.parametrize(
    ("position", "along", "expected"),
    [
        # The nearest point of the path, what is one metre further along it, and what is left of its seven.
        ([1.0, 0.5], 0.5, (1.0, [2.0, 0.0], 6.0)),
        ([3.5, 0.2], 2.0, (3.5, [4.0, 0.5], 3.5)),
        # It goes neither back nor farther than two metres at once.
        ([1.0, 0.5], 1.5, (1.5, [2.5, 0.0], 5.5)),
        ([4.2, 2.0], 1.0, (3.0, [4.0, 0.0], 4.0)),
        # Behind the end the last line goes on.
        ([4.0, 2.6], 6.0, (6.6, [4.0, 3.6], 0.4)),
        ([4.0, 9.0], 6.0, (7.0, [4.0, 4.0], 0.0)),
    ],
)
def test_it_steers_for_the_point_that_is_a_lookahead_further_along_the_path(position, along, expected):
    told = look_ahead(CORNER, np.array(position), along, 1.0)
    for one, other in zip(told, expected, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


def test_a_path_is_cut_where_it_turns_by_more_than_is_sharp():
    path = np.array([[0, 0], [1, 0], [1, 0], [2, 0.5], [2, 2], [0, 2], [1, 2.1]], dtype=float)
    pieces = cut_at_corners(path, math.radians(80))
    # 27, 63, 90 degrees, and back by 174.
    assert [piece.tolist() for piece in pieces] == [
        [[0, 0], [1, 0], [2, 0.5], [2, 2]],
        [[2, 2], [0, 2]],
        [[0, 2], [1, 2.1]],
    ]


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[1.0, math.nan]], r"^points are \[\[1.0, nan\]\]; they must be finite numbers$"),
        ([[math.inf, 1.0]], "they must be finite numbers"),
        ([[1.0, 2.0, 3.0]], r"^points has shape \(1, 3\); it must be a list of \[x, y\]$"),
    ],
)
def test_points_of_another_shape_or_not_finite_are_refused(points, message):
    with pytest.raises(ValueError, match=message):
        Waypoints(points)
