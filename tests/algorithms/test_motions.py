"""Sampled motions, recovery and goals of GoToGoal against sums step by step, polygons and its limits."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from mjsim.algorithms.go_to_goal import GoToGoal
from mjsim.algorithms.go_to_goal.moving_things import Thing
from mjsim.algorithms.go_to_goal.obstacle_map import ObstacleMap
from mjsim.algorithms.go_to_goal.path_integral import STEP, MotionPrices, PathIntegral
from mjsim.algorithms.go_to_goal.recovery import Around, Attempt, Recovery, Toward
from mjsim.geometry import Pose
from mjsim.interface import Estimate, Observation, Odometry, WorldMap
from tests.algorithms.test_local_navigation import ORIGIN, robot

FAR = np.array([[50.0, 50.0]])


class Still:
    """A source of random numbers that are all 0: only the plan and the fan are tried."""

    def standard_normal(self, shape, dtype):
        return np.zeros(shape, dtype)


def driven(pose, twists):
    """Return the poses on the way of twists, each at the heading in the middle of its step."""
    x, y, heading, found = pose.x, pose.y, pose.heading, []
    for ahead, left, turn in np.asarray(twists, dtype=float).tolist():
        middle = heading + 0.5 * STEP * turn
        x += STEP * (ahead * math.cos(middle) - left * math.sin(middle))
        y += STEP * (ahead * math.sin(middle) + left * math.cos(middle))
        heading += STEP * turn
        found.append((x, y, heading))
    return np.array(found)


def test_a_tricycle_turns_its_wheel_by_at_most_75_degrees_and_stops_ahead_no_sooner_than_its_wheel_can():
    # A wheel 1.23 m from the axle, which accelerates by 0.5 m/s^2 along and across.
    keys = {"drive": "tricycle", "max_acceleration": 0.5, "max_turn_acceleration": 0.5 / 1.23, "radius": 1.6}
    local = PathIntegral(robot(**keys), np.random.default_rng(0), top=0.9)
    start = np.array([-0.35, 0.0, -0.8])
    twists = local._limited(local._samples(), start, math.inf).astype(float)
    twists = np.concatenate([np.broadcast_to(start, (len(twists), 1, 3)), twists], axis=1)
    ahead, across = twists[..., 0], 1.23 * twists[..., 2]
    wheel, rim = np.degrees(np.arctan2(np.abs(across), np.abs(ahead))), np.hypot(ahead, across)
    assert 74.0 < wheel[rim > 1e-3].max() < 75.1
    # Along and across together, with what it plans to use of its acceleration.
    assert np.abs(np.diff(rim, axis=1)).max() < 1.42 * 0.85 * 0.5 * STEP


def test_where_one_part_of_a_tricycle_seems_to_be_inside_an_obstacle_the_others_do_not_touch_theirs():
    local = PathIntegral(robot(drive="tricycle"), np.random.default_rng(0), top=0.9)
    behind, twists = np.array([[-0.33, 0.0]]), np.zeros((1, 20, 3))
    twists[:, :, 0] = -0.1
    for points in (behind, np.concatenate([behind, [[0.1, 0.0]]])):
        map = ObstacleMap(np.zeros(2), points, cell=0.025, half=local.reach)
        _, hits = local._judged(ORIGIN, twists, map, Toward(np.array([1.0, 0.0])), MotionPrices())
        assert hits.all()


LEFT = {"max_left": 0.5}
PASSER = Thing(np.array([1.2, 0.3]), np.array([-0.4, 0.1]), 0.2, 0.0, 9, np.zeros(2))


@pytest.mark.parametrize("keys", [{}, LEFT, {"max_curvature": 1.5}])
@pytest.mark.parametrize("things", [(), (PASSER,)])
def test_a_motion_is_priced_by_the_time_from_where_it_leads_and_how_it_is_driven(keys, things):
    local = PathIntegral(robot(**keys), np.random.default_rng(0), top=0.9)
    pose, goal = Pose(0.2, -0.1, 0.4), np.array([1.9, 0.5])
    wall = np.array([[1.0, 0.4], [0.9, -0.55], [1.6, -0.3]])
    map, leads = ObstacleMap(np.zeros(2), wall, cell=0.025, half=local.reach), Toward(goal)
    prices = MotionPrices(reverse=0.7, things=things)
    twists = local._limited(local._samples(), np.array([0.3, 0.0, 0.1]), 0.8)[5::20].astype(float)
    cost, hits = local._judged(pose, twists, map, leads, prices)
    limits = np.array([0.9, keys.get("max_left", 0.0), 2.0])
    discs = list(zip(local.body.centres, local.body.radii, strict=True))
    half_turn = 2 * math.pi / (1.5 * 0.9) if "max_curvature" in keys else 0.25 * math.pi / 2.0
    assert hits.any()
    assert not hits.all()
    # It stands before it meets what moves: from the time that it takes to stop on, this does not matter yet.
    fastest = max(math.hypot(ahead, left) for ahead, left in twists[:, 0, :2])
    stops = math.ceil((fastest / 2.0 + 0.3) / STEP)
    gaps = np.full((len(twists), 20), math.inf)
    for row, motion in enumerate(twists):
        for step, (x, y, heading) in enumerate(driven(pose, motion), start=1):
            for thing in things:
                at, size = thing.place + STEP * step * thing.velocity, thing.radius + 0.12 * STEP * step
                gaps[row, step - 1] = min(
                    math.dist(Pose(x, y, heading).transform(centre), at) - radius - size for centre, radius in discs
                )
    start = min(0.0, gaps[:, 0].max() - 0.004)
    for motion, price, hit, gap in zip(twists, cost, hits, gaps, strict=True):
        way, total, when, beside, met = driven(pose, motion), 0.0, None, 0.0, False
        for step, (x, y, heading) in enumerate(way, start=1):
            places = [Pose(x, y, heading).transform(centre) for centre, _ in discs]
            clear = min(float(map.at(*at)) - radius for at, (_, radius) in zip(places, discs, strict=True))
            ahead, left, _ = motion[step - 1]
            meets = step <= stops and gap[step - 1] < start and math.hypot(ahead, left) > 0.05
            met |= meets
            when = step - 1 if when is None and clear < 0.02 else when
            beside += 15.0 * max(1.0 - gap[step - 1] / 0.25, 0.0)
            clear = min(clear, 0.5 * gap[step - 1])
            total += 2.0 * max(math.hypot(ahead, left) - max(0.3 + 3.5 * clear, 0.3), 0.0)
            total += 0.5 * max(1.0 - clear / 0.12, 0.0) + 0.7 * max(-ahead, 0.0)
        total = STEP * (total + beside) + 0.01 * np.abs(np.diff(motion / np.maximum(limits, 1e-6), axis=0)).sum()
        times = 3.0 * np.hypot(*(way[3::4, :2] - goal).T)
        course = way[-1, 2] - math.atan2(*(way[-1, :2] - goal)[::-1])
        total += 0.6 * times[-1] + 0.4 * times.mean() + half_turn * (1.0 - math.cos(course)) * min(times[-1], 1.0)
        assert hit == (when is not None)
        total += 5.0 * met
        assert price == pytest.approx(total + (50.0 * (2.0 - when / 20) if hit else 0.0), rel=1e-4)


@pytest.mark.parametrize("keys", [{}, LEFT, {"max_curvature": 1.5}])
def test_tried_motions_obey_the_limits_of_the_robot_from_its_present_speed(keys):
    local, now = PathIntegral(robot(**keys), Still(), top=2.0), np.array([0.5, 0.0, -0.4])
    assert local.twist(ORIGIN, now, ObstacleMap(np.zeros(2), FAR, cell=0.1, half=2.0), Toward(np.array([-3.0, 0.0])),
                       MotionPrices(top=0.6)) is not None  # fmt: skip
    twists = local._limited(local._samples(), now, 0.6)
    before = np.concatenate([np.broadcast_to(now, (len(twists), 1, 3)), twists[:, :-1]], axis=1)
    bend = keys.get("max_curvature", 1e6)
    changes = np.abs(twists - before)[..., : 2 if "max_curvature" in keys else 3]
    assert (changes <= 0.85 * STEP * np.array([2.0, 2.0, 6.0])[: changes.shape[-1]] + 1e-5).all()
    assert (np.abs(twists[..., 2]) <= bend * np.maximum(np.abs(twists[..., 0]), 1e-5)).all()
    most = [0.6, keys.get("max_left", 0.0), min(2.0, bend * 0.6)]
    np.testing.assert_allclose(np.abs(twists[:, -1]).max(axis=0), most, rtol=1e-5)


def test_a_plan_goes_on_after_a_time_between_its_steps():
    local = PathIntegral(robot(), Still(), top=1.0)
    local._plan = np.random.default_rng(5).normal(size=(20, 3)).astype(np.float32)
    plan = local._plan.copy()
    local.shift(1.25 * STEP)
    at = np.minimum(np.arange(20) + 1.25, 19)
    for axis in range(3):
        np.testing.assert_allclose(local._plan[:, axis], np.interp(at, np.arange(20), plan[:, axis]), atol=1e-5)
    np.testing.assert_allclose(local.planned, local._plan[0])
    local.reset()
    assert not local._plan.any()


def test_the_chosen_motion_is_the_one_that_its_twists_drive_and_keeps_its_clearance():
    local = PathIntegral(robot(), np.random.default_rng(3), top=1.0)
    pose, wall = Pose(0.3, 0.2, 0.3), np.array([[1.2, 0.2], [0.6, -0.6]])
    map = ObstacleMap(np.zeros(2), wall, cell=0.02, half=local.reach)
    twist = local.twist(pose, np.array([0.4, 0.0, 0.0]), map, Toward(np.array([3.0, 0.5])), MotionPrices())
    np.testing.assert_allclose(twist, local._plan[0])
    np.testing.assert_allclose(local.motion, driven(pose, local._plan), atol=1e-4)
    places = [Pose(*row).transform(local.body.centres) for row in local.motion.tolist()]
    away = min(float((np.hypot(*(at[:, None] - wall).T).T - local.body.radii[:, None]).min()) for at in places)
    assert local.clearance == pytest.approx(away, abs=0.04)
    middle = np.hypot(*(local.motion[::2, None, :2] - wall).T).min() - local.body.reach
    assert local.apart(wall) == pytest.approx(middle, abs=1e-6)
    assert local.apart(np.zeros((0, 2))) == math.inf
    for most in (7, 40, 1000):
        ways = local.candidates(most)
        assert len(ways) <= most
        np.testing.assert_allclose(ways[0], driven(pose, local._sampled[1][0])[::3, :2], atol=1e-4)
    shut = ObstacleMap(np.zeros(2), pose.transform(np.array([[0.0, 0.0]])), cell=0.02, half=local.reach)
    assert local.twist(pose, np.zeros(3), shut, Toward(np.array([3.0, 0.5])), MotionPrices()) is not None
    assert not local.can_turn(pose, 0.0, map) or local.can_turn(pose, 0.1, map)


class Ahead(Toward):
    """Time to a place in a straight line, with the front first."""

    def direction(self, points):
        x, y = super().direction(points)
        return -x, -y


@pytest.mark.parametrize("seed", [1, 2])
def test_in_a_slit_it_samples_finer_motions_until_enough_are_free(seed):
    # 10 cm wider than the body, which is askew: motions of full size collide.
    x = np.linspace(-0.5, 1.6, 85)
    walls = np.concatenate([np.stack([x, np.full_like(x, side)], axis=-1) for side in (-0.25, 0.25)])
    local, pose, twist = PathIntegral(robot(), np.random.default_rng(seed), top=2.0), Pose(0.0, 0.0, 0.08), np.zeros(3)
    map = ObstacleMap(np.zeros(2), walls, cell=0.025, half=local.reach)
    for _ in range(25):
        local.shift(STEP)
        chosen = local.twist(pose, twist, map, Ahead(np.array([4.0, 0.0])), MotionPrices())
        twist = np.zeros(3) if chosen is None else chosen
        pose = pose @ Pose(*(STEP * twist).tolist())
    assert pose.x > 0.3


@pytest.mark.parametrize("angle", [math.pi, -math.pi, 1.0, -1.0])
def test_it_turns_on_the_spot_where_its_body_does_not_touch(angle):
    outline = np.array([[-0.1, -0.2], [0.7, -0.2], [0.7, 0.2], [-0.1, 0.2]])
    local = PathIntegral(robot(outline=outline, radius=math.hypot(0.7, 0.2)), Still(), top=1.0)
    for bearing in np.arange(-3.0, 3.1, 1.2).tolist():
        post, pose = np.array([0.6 * math.cos(bearing), 0.6 * math.sin(bearing)]), Pose(0.0, 0.0, 0.0)
        map = ObstacleMap(np.zeros(2), post[None], cell=0.01, half=1.0)
        away = [
            shapely.distance(shapely.Polygon(Pose(0.0, 0.0, turn).transform(outline)), shapely.Point(post))
            for turn in np.linspace(0.0, angle, 40)
        ]
        if away[0] and (min(away) > 0.05 or min(away) == 0.0):
            assert local.can_turn(pose, angle, map) == (min(away) > 0.0)


def test_leads_out_of_a_corner_point_the_back_to_a_place_or_elsewhere():
    toward, points = Toward(np.array([1.0, 2.0])), np.random.default_rng(5).normal(size=(5, 4, 2))
    np.testing.assert_allclose(toward.at(points), 3.0 * np.hypot(points[..., 0] - 1.0, points[..., 1] - 2.0))
    ahead, up = toward.direction(points)
    np.testing.assert_allclose(np.stack([ahead, up], axis=-1), points - (1.0, 2.0))
    around = Around(0.5)
    assert around.at(points).shape == (5, 4)
    np.testing.assert_allclose(np.arctan2(*around.direction(points)[::-1]), np.full((5, 4), 2.5))
    assert (around.at(points) == 1.0).all()


def test_every_third_attempt_looks_round_and_the_others_back_out_until_they_are_there():
    recovery, begun, now, x = Recovery(), [], 0.0, 0.0
    for _ in range(20):
        x, now = x + 0.1, now + 0.1
        assert not recovery.update(Pose(x, 0.0, 0.0), 10.0 - x, now)
    for _ in range(600):
        now += 0.1
        if recovery.update(Pose(x, 0.0, 0.0), 10.0 - x, now):
            begun.append((recovery.attempt, now))
    kinds = [kind for kind, _ in begun]
    assert kinds[:6] == [Attempt.BACK, Attempt.DRIVE] * 2 + [Attempt.LOOK, Attempt.DRIVE]
    lasted = [end - begin for (_, begin), (_, end) in itertools.pairwise(begun)]
    assert lasted[:5] == pytest.approx([3.0, 2.1, 3.0, 2.1, 4.0], abs=0.15)
    assert len(recovery.stuck) <= 21
    # There, within 0.15 m of the target, it drives again at once.
    recovery.restart(now)
    assert (recovery.attempt, recovery.silent(now + 5.0), recovery.silent(now + 5.1)) == (Attempt.DRIVE, False, True)
    while not recovery.update(Pose(x, 0.0, 0.0), 5.0, now):
        now += 0.1
    there = Pose(float(recovery.target[0]) + 0.14, float(recovery.target[1]), 0.0)
    assert not recovery.update(Pose(there.x + 0.02, there.y, 0.0), 5.0, now + 0.1)
    assert recovery.update(there, 5.0, now + 0.2)
    assert recovery.attempt is Attempt.DRIVE


def test_a_robot_that_turns_or_moves_to_and_fro_is_not_at_rest_but_without_progress_for_8_s():
    for pose_at in (lambda t: Pose(0.0, 0.0, t), lambda t: Pose(0.3 * math.sin(2.0 * t), 0.0, 0.0)):
        recovery, now = Recovery(), 0.0
        while not recovery.update(pose_at(now), 10.0, now):
            now += 0.1
        assert now == pytest.approx(8.1, abs=0.15)


def test_space_seen_for_the_first_time_and_a_detour_as_long_as_planned_are_no_lack_of_progress():
    for area_at, seconds_at, begins in (
        (lambda _: 0.0, lambda _: 5.0, 8.1),
        (lambda now: 0.2 * now, lambda _: 5.0, math.inf),
        (lambda _: 0.0, lambda now: 5.0 if now < 0.05 else 25.0 - now, 28.0),
    ):
        recovery, now, x = Recovery(), 0.0, 0.0
        while now < 40.0 and not recovery.update(Pose(x, 0.0, 0.0), max(seconds_at(now), 5.0), now, area=area_at(now)):
            x, now = x + 0.05, now + 0.1
            assert not (begins > 20.0 and recovery.silent(min(now, 24.0)))
        assert now >= 40.0 if begins == math.inf else now == pytest.approx(begins, abs=0.3)


def observation(time, *, proximity=math.inf, odometry=(0.0, 0.0, 0.0)):
    return Observation(
        time=time, dt=0.04, odometry=Odometry(*odometry, 1e-6 * np.eye(3)), proximity=np.full(16, proximity)
    )


def navigated(goals, pose, *, time=0.04, **keys):
    module = GoToGoal(goals, **keys)
    module.start(robot(prior=pose), None, np.random.default_rng(0))
    belief = Estimate(pose=pose, covariance=np.zeros((3, 3)))
    # At the first tick it plans, at the next scan it drives.
    module.command(observation(time), belief)
    return module, module.command(observation(time + 0.16), belief), belief


@pytest.mark.parametrize(("heading", "goal_deg"), [(0.0, 90.0), (3.0, -170.0), (-3.0, 170.0), (0.5, -60.0)])
def test_at_its_goal_a_robot_turns_the_shorter_way_and_brakes_in_time(heading, goal_deg):
    module, order, _ = navigated([1.0, 2.0, goal_deg], Pose(1.02, 2.03, heading))
    apart = math.remainder(math.radians(goal_deg) - heading, 2 * math.pi)
    assert (order.forward, order.left) == (0.0, 0.0)
    assert order.turn == pytest.approx(math.copysign(min(2.0, math.sqrt(6.0 * abs(apart))), apart))
    assert not module.is_done
    module, order, _ = navigated([1.0, 2.0, goal_deg], Pose(1.02, 2.03, math.radians(goal_deg + 3.9)))
    assert module.is_done
    assert order.turn == 0.0
    module, _, _ = navigated([1.0, 2.0, goal_deg], Pose(1.02, 2.03, math.radians(goal_deg + 4.1)))
    assert not module.is_done


@pytest.mark.parametrize(
    ("goals", "message"),
    [
        ([], "give at least one"),
        ([[1.0]], "give at least one"),
        ([[1.0, 2.0, 3.0, 4.0]], "give at least one"),
        ("here", "give at least one"),
        ([[1.0, math.nan]], "give finite numbers"),
    ],
)
def test_goals_that_are_no_places_are_refused(goals, message):
    with pytest.raises(ValueError, match=message):
        GoToGoal(goals)


def test_goals_are_passed_in_order_and_another_takes_the_place_of_all():
    module, order, belief = navigated([[0.05, 0.0], [0.0, 0.08], [2.0, 0.0]], ORIGIN)
    assert order.forward > 0.0
    (path,) = module.show()
    np.testing.assert_allclose(path.points[[0, -1], :2], [[0.0, 0.0], [2.0, 0.0]])
    module.take_goal(-2.0, 1.0)
    module.command(observation(0.4), belief)
    np.testing.assert_allclose(module.show()[0].points[-1, :2], [-2.0, 1.0])
    module.take_goal(0.0, 0.0, 0.02)
    assert module.command(observation(0.8), belief).turn == 0.0
    assert module.is_done
    assert module.show() == ()


def test_what_it_touches_unseen_is_gone_around_though_rays_pass_above():
    module, _, belief = navigated([2.0, 0.0], ORIGIN)
    touches = replace(observation(0.08, proximity=1.5), bump=(0.0,))
    module.command(touches, belief)
    for time in (0.4, 0.8):
        module.command(observation(time, proximity=1.5), belief)
    (path,) = module.show()
    assert np.abs(path.points[:, 1]).max() > 0.2


def test_all_of_a_plan_is_shown_in_the_frame_of_the_estimate():
    module, _, _ = navigated([[0.0, 0.05], [2.0, 0.5, 90.0]], Pose(0.0, 0.0, 0.3), show_all=True)
    costs, candidates, goals, arrows, path = module.show()
    assert [item.name for item in (costs, candidates, goals, arrows, path)] == [
        "costs", "candidates", "goals", "goals", "planned path"
    ]  # fmt: skip
    np.testing.assert_allclose(goals.points[:, :2], [[2.0, 0.5]])
    np.testing.assert_allclose(arrows.points[:, :2], [[2.0, 0.5], [2.0, 0.9]])
    rows, columns = costs.cells.shape
    # 4 m about the robot, as far as the grid goes: 3 m beyond robot and goals.
    low = np.array([costs.origin.x, costs.origin.y])
    np.testing.assert_allclose(low, [-3.0, -3.0], atol=0.11)
    np.testing.assert_allclose(low + costs.resolution * np.array([columns, rows]), [4.0, 3.5], atol=0.11)
    # Unseen space takes 1.3 times as long: its cost is 1 - 1 / 1.3.
    assert np.median(costs.cells) == pytest.approx(1.0 - 1.0 / 1.3)
    pieces = candidates.points[:, :2].reshape(-1, 2, 2)
    assert 0.0 < np.hypot(*(pieces[:, 1] - pieces[:, 0]).T).max() <= 3 * STEP + 1e-6
    np.testing.assert_allclose(pieces[1:6, 0], pieces[:5, 1])
    module, _, _ = navigated([[2.0, 0.5]], ORIGIN)
    assert [item.name for item in module.show()] == ["planned path"]


@pytest.mark.parametrize(
    ("half", "goal", "reason"),
    [
        ((0.4, 0.15), [0.0, 0.0, 90.0], "no room to turn to 90 degrees at [0, 0]"),
        ((1.0, 1.0), [3.0, 0.5], "no path to [3, 0.5] between the obstacles seen so far"),
        ((9.0, 9.0), [3.0, 0.5], "no progress towards [3, 0.5]"),
    ],
)
def test_why_it_gets_no_nearer_is_told_after_five_seconds(half, goal, reason):
    outline = np.array([[-0.25, -0.05], [0.25, -0.05], [0.25, 0.05], [-0.25, 0.05]])
    corners = half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], float)
    walls = WorldMap(segments=np.stack([corners, np.roll(corners, -1, axis=0)], axis=1), beacons={})
    module, belief = GoToGoal([goal]), Estimate(pose=ORIGIN, covariance=np.zeros((3, 3)))
    module.start(robot(outline=outline, radius=0.26), walls, np.random.default_rng(0))
    for time in (0.04, 4.9, 5.2):
        module.command(observation(time), belief)
        told = module.blocked()
        assert told is None or time > 5.0
    assert told.startswith(reason)
