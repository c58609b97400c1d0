"""Parts of GoToGoal: obstacles remembered, the body as discs, costs to go, things that move, aligned scans, motions."""

import math

import numpy as np
import pytest

from mjsim.algorithms.go_to_goal.body_discs import BodyDiscs
from mjsim.algorithms.go_to_goal.cost_to_go import UNREACHED, Planner, time_per_metre
from mjsim.algorithms.go_to_goal.go_to_goal import GoToGoal
from mjsim.algorithms.go_to_goal.moving_things import MovingThings, grouped
from mjsim.algorithms.go_to_goal.obstacle_map import ObstacleMap
from mjsim.algorithms.go_to_goal.obstacle_memory import ObstacleMemory
from mjsim.algorithms.go_to_goal.path_integral import STEP, MotionPrices, PathIntegral
from mjsim.algorithms.go_to_goal.range_views import RangeView, smoothed
from mjsim.algorithms.go_to_goal.recovery import Attempt, Recovery, Toward
from mjsim.algorithms.go_to_goal.scan_alignment import ScanAlignment
from mjsim.algorithms.scans.distance_grid import DistanceGrid
from mjsim.geometry import Pose
from mjsim.interface import Odometry, RobotInfo

ORIGIN = Pose(0.0, 0.0, 0.0)
BOX = np.array([[-0.25, -0.2], [0.25, -0.2], [0.25, 0.2], [-0.25, 0.2]])


def robot(**keys):
    usual = {
        "name": "r", "drive": "differential", "max_speed": 1.0, "max_turn": 2.0, "max_acceleration": 2.0,
        "max_turn_acceleration": 6.0, "wheels": (), "wheel_radius": 0.1, "track": 0.4, "radius": math.hypot(0.25, 0.2),
        "dt": 0.04, "prior": ORIGIN, "prior_covariance": np.zeros((3, 3)), "outline": BOX,
    }  # fmt: skip
    return RobotInfo(**(usual | keys))


def ring(distance, beams=360):
    step = 2 * math.pi / beams
    return RangeView("scan", ORIGIN, 0.0, step, np.full(beams, distance), 8.0)


def test_discs_cover_the_outline_and_extend_beyond_its_sides_by_at_most_15_mm():
    discs = BodyDiscs(robot())
    inside = np.random.default_rng(0).uniform((-0.25, -0.2), (0.25, 0.2), (500, 2))
    away = np.hypot(*np.moveaxis(inside[:, None] - discs.centres, -1, 0)) - discs.radii
    assert away.min(axis=1).max() <= 1e-9
    assert discs.radii.max() <= 0.2 + 0.015 + 1e-9
    assert discs.half_width == pytest.approx(0.2, abs=0.015)


def test_a_cell_that_a_scan_sees_through_is_dropped_and_one_that_is_hit_again_stays():
    memory = ObstacleMemory(0.025, seconds=60.0)
    near, far = ring(1.0), ring(2.0)
    memory.add(ORIGIN, [near], near.points(), 0.0)
    assert np.hypot(*memory.points.T) == pytest.approx(1.0, abs=0.04)
    for time in (0.1, 0.2):
        memory.add(ORIGIN, [far], far.points(), time)
    assert np.hypot(*memory.points.T) == pytest.approx(2.0, abs=0.04)
    for time in (0.3, 0.4):
        memory.add(ORIGIN, [far], far.points(), time)
    assert len(memory.points) > 100
    memory.forget(1.0)
    assert not len(memory.points)


def test_obstacles_move_with_an_estimate_that_jumps_but_not_with_small_corrections():
    memory = ObstacleMemory(0.025, seconds=60.0)
    memory.add(ORIGIN, [], np.array([[1.0125, 0.0125]]), 0.0)
    memory.track(ORIGIN, ORIGIN)
    memory.track(Pose(0.01, 0.0, 0.005), ORIGIN)
    np.testing.assert_allclose(memory.points, [[1.0125, 0.0125]], atol=1e-9)
    memory.track(Pose(2.01, 0.0, 0.005 + math.pi / 2), ORIGIN)
    np.testing.assert_allclose(memory.points, [[2.0, 1.0]], atol=0.03)


def test_what_the_first_scan_hits_stood_before_and_what_later_scans_hit_is_new():
    memory = ObstacleMemory(0.025, seconds=60.0)
    for time, distance in ((0.0, 2.0), (0.08, 1.0)):
        memory.add(ORIGIN, [], ring(distance).points(), time)
    assert np.hypot(*memory.older(0.0).T) == pytest.approx(2.0, abs=0.04)
    assert np.hypot(*memory.older(0.1).T).min() == pytest.approx(1.0, abs=0.04)


def test_averaged_ranges_have_less_noise_but_edges_stay():
    rng = np.random.default_rng(0)
    true = np.where(np.arange(1000) < 500, 2.0, 4.0)
    noisy = true + rng.normal(0.0, 0.03, 1000)
    noisy[7] = np.inf
    found = smoothed(noisy, 0.09)
    assert found[7] == np.inf
    keep = np.arange(1000) != 7
    assert np.std((found - true)[keep]) < 0.5 * np.std((noisy - true)[keep])
    assert np.abs(found - true)[keep].max() < 0.15


def test_the_time_to_a_goal_leads_around_a_wall_and_is_told_where_there_is_none():
    planner = Planner(np.zeros(2), np.array([4.0, 3.0]), 0.1)
    wall = np.stack([np.full(40, 2.05), np.linspace(0.0, 2.2, 40)], axis=-1)
    clear = DistanceGrid(planner.drawn(wall), lower=planner.lower, cell=0.1).distance
    price = time_per_metre(clear, half_width=0.2, gap=0.1, top=1.0)
    field = planner.cost_to_go(price, np.array([3.55, 0.55]))
    assert field.at(np.array([0.55, 0.55])) > 2.0 * math.hypot(1.5, 1.6)
    path = field.path(np.array([0.55, 0.55]))
    np.testing.assert_allclose(path[[0, -1]], [[0.55, 0.55], [3.55, 0.55]])
    assert path[:, 1].max() > 2.4
    ahead, up = field.direction(np.array([1.55, 1.05]))
    assert up > abs(ahead)
    near = planner.near(path, 0.3)
    assert near[planner.cells(path)].all()
    assert not near[planner.cells(np.array([[0.55, 2.55], [2.55, 0.55]]))].any()
    shut = np.stack([np.full(80, 2.05), np.linspace(0.0, 3.2, 80)], axis=-1)
    clear = DistanceGrid(planner.drawn(shut), lower=planner.lower, cell=0.1).distance
    field = planner.cost_to_go(time_per_metre(clear, half_width=0.2, gap=0.1, top=1.0), np.array([3.55, 0.55]))
    assert field.at(np.array([0.55, 0.55])) == UNREACHED
    assert len(field.path(np.array([0.55, 0.55]))) == 1


def test_dead_reckoning_is_corrected_by_a_scan_of_known_walls():
    wall = np.linspace(-2.0, 2.0, 200)
    room = np.concatenate([np.stack([wall, np.full(200, y)], axis=-1) for y in (-1.5, 1.5)])
    room = np.concatenate([room, np.stack([np.full(200, 2.0), wall * 0.75], axis=-1)])
    alignment = ScanAlignment(ORIGIN)
    alignment.move(Odometry(0.1, 0.0, 0.05, np.diag([1e-3, 1e-3, 1e-3])))
    true = Pose(0.13, 0.03, 0.02)
    alignment.align(true.inverse().transform(room), ObstacleMap(np.zeros(2), room, cell=0.025, half=3.0))
    error = true.inverse() @ alignment.pose
    assert abs(error.heading) < 0.005
    assert math.hypot(error.x, error.y) < 0.02


def test_a_correction_far_beyond_what_wheels_slip_is_refused():
    posts = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    a = np.linspace(0.0, 2 * math.pi, 16)
    known = (posts[:, None] + 0.1 * np.stack([np.cos(a), np.sin(a)], axis=-1)).reshape(-1, 2)
    map, found = ObstacleMap(np.zeros(2), known, cell=0.025, half=3.0), []
    for turn in (0.05, 0.27):
        alignment = ScanAlignment(ORIGIN)
        # Four times this covariance: a deviation of 0.06 rad.
        alignment.move(Odometry(0.0, 0.0, 0.0, np.diag([1e-6, 1e-6, 9e-4])))
        alignment.align(Pose(0.0, 0.0, turn).inverse().transform(known), map)
        found.append(alignment.pose.heading)
    assert found[0] > 0.03
    assert found[1] == 0.0


def test_a_larger_correction_is_right_if_nearly_all_of_many_points_fit_after_it():
    side = np.linspace(-2.0, 2.0, 100)
    room = np.concatenate(
        [turned for x in (-2.0, 2.0) for turned in (np.c_[0 * side + x, side], np.c_[side, 0 * side + x])]
    )
    map, true = ObstacleMap(np.zeros(2), room, cell=0.025, half=3.0), Pose(0.0, 0.1, 0.08)
    # A robot skids sideways, of which wheels tell nothing.
    alignment = ScanAlignment(ORIGIN)
    alignment.move(Odometry(0.0, 0.0, 0.0, np.diag([1e-6, 1e-4, 2e-4])))
    alignment.align(true.inverse().transform(room), map)
    np.testing.assert_allclose(alignment.pose.as_array(), true.as_array(), atol=0.03)


def test_a_scan_of_other_things_near_known_ones_corrects_nothing():
    wall = np.stack([np.linspace(-2.0, 2.0, 200), np.full(200, 1.5)], axis=-1)
    elsewhere = np.stack([np.full(100, 1.0), np.linspace(-1.5, 0.9, 100)], axis=-1)
    known, behind = ObstacleMap(np.zeros(2), wall, cell=0.025, half=3.0), wall + np.array([0.0, 0.2])
    for seen, error in ((wall, 0.0), ([*wall, *elsewhere], 0.0), ([*wall, *behind], 1.0)):
        alignment = ScanAlignment(ORIGIN)
        alignment.move(Odometry(0.0, 0.05, 0.02, np.diag([1e-3, 1e-3, 1e-3])))
        alignment.align(np.array(seen), known)
        np.testing.assert_allclose(alignment.pose.as_array()[1:], error * np.array([0.05, 0.02]), atol=0.01)


def test_a_thing_that_moves_is_found_with_its_velocity_and_one_that_stands_is_not():
    rng, things = np.random.default_rng(0), MovingThings()
    rim = 0.2 * np.stack([np.cos(np.linspace(0, 2 * math.pi, 20)), np.sin(np.linspace(0, 2 * math.pi, 20))], axis=-1)
    for tick in range(12):
        time = 0.08 * tick
        places = np.array([[2.0 - 0.5 * time, 1.0], [3.0, -1.0]])
        # The side towards the robot.
        points = np.concatenate([place + rim[rim @ place < 0.0] for place in places])
        things.update(points + rng.normal(0.0, 0.005, points.shape), ORIGIN, time)
    (thing,) = things.predicted(ORIGIN, 0.88)
    np.testing.assert_allclose(thing.velocity, [-0.5, 0.0], atol=0.1)
    np.testing.assert_allclose(thing.place, [1.56, 1.0], atol=0.15)
    assert things.predicted(ORIGIN, 3.0) == [] or things.predicted(ORIGIN, 3.0)[0].place[0] < 1.0
    assert [len(group) for group in grouped(rim, 0.15)] == [20]


@pytest.mark.parametrize(
    ("keys", "bend"), [({}, math.inf), ({"max_curvature": 1.5}, 1.5), ({"max_left": 0.5}, math.inf)]
)
def test_a_motion_is_free_and_within_the_limits_of_the_drive(keys, bend):
    local = PathIntegral(robot(**keys), np.random.default_rng(0), top=1.0)
    box = np.stack([np.full(30, 1.0), np.linspace(-0.3, 0.3, 30)], axis=-1)
    map = ObstacleMap(np.zeros(2), box, cell=0.025, half=local.reach)
    now = np.zeros(3)
    for _ in range(8):
        local.shift(0.04)
        twist = local.twist(ORIGIN, now, map, Toward(np.array([3.0, 0.0])), MotionPrices(reverse=0.0))
        assert twist is not None
        assert np.all(np.abs(twist - now) <= np.array([2.0, 2.0, 6.0]) * STEP + 1e-6)
        assert abs(twist[2]) <= bend * abs(twist[0]) + 1e-6
        now = twist
    c, s = np.cos(local.motion[:, 2]), np.sin(local.motion[:, 2])
    dx, dy = box[:, 0, None] - local.motion[:, 0], box[:, 1, None] - local.motion[:, 1]
    apart = np.maximum(np.abs(c * dx + s * dy) - 0.25, np.abs(c * dy - s * dx) - 0.2)
    assert apart.min() > 0.0


def test_obstacles_matter_as_far_as_any_part_of_the_body_can_come():
    local = PathIntegral(robot(), np.random.default_rng(0), top=0.8)
    local._plan[:, 0] = 0.8
    seconds = STEP * len(local._plan)
    assert local.reach > 0.8 * seconds + local.body.reach + 0.2
    assert local.body.reach >= math.hypot(0.25, 0.2) - 1e-6
    local.shift(10.0)
    assert local.planned[0] == pytest.approx(0.8)


def test_without_progress_it_backs_out_on_its_way_and_says_so_after_5_s():
    recovery, time = Recovery(), 0.0
    for tick in range(25):
        time = 0.04 * tick
        assert not recovery.update(Pose(time, 0.0, 0.0), 10.0 - time, time)
    stands = [0.04 * tick for tick in range(25, 200)]
    begun = [at for at in stands if recovery.update(Pose(time, 0.0, 0.0), 10.0 - time, at)]
    assert begun[0] == pytest.approx(time + 2.0, abs=0.3)
    assert recovery.silent(stands[-1])
    assert recovery.attempt in (Attempt.BACK, Attempt.DRIVE, Attempt.LOOK)
    assert recovery.stuck[0] == pytest.approx((time + 0.3, 0.0))
    assert recovery.target[0] == pytest.approx(time - 0.7, abs=0.15)


@pytest.mark.parametrize("key", ["speed", "tolerance", "cell"])
def test_a_goal_without_a_positive_size_or_speed_is_refused(key):
    with pytest.raises(ValueError, match=f"{key} is 0; it must be above 0"):
        GoToGoal([1.0, 2.0], **{key: 0})
