"""Parts of the avoidance, each against geometry: hits that are kept, paths that are free, escapes."""

import math

import numpy as np
import pytest
import shapely
from shapely import affinity

from mjsim.geometry import Pose
from mjsim.interface import Command, Observation, Odometry, Scan, SensorInfo
from mjsim.safety.footprint import Footprint
from mjsim.safety.hits import NO_HIT_RANGE, RAYS, Hits
from mjsim.safety.ring import RingAvoidance, Trail
from tests.robots import pioneer

NONE = np.full(RAYS, np.inf)
BOX = np.array([[-0.4, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.4, 0.2]])
"""The outline of a long robot [m]."""
LONG = pioneer(radius=float(np.hypot(0.4, 0.2)), outline=BOX)
SCOUT = pioneer()


def seen(time=0.0, *, move=(0.0, 0.0, 0.0), ring=NONE, scans=None):
    return Observation(time, 0.04, Odometry(*move, np.zeros((3, 3))), proximity=ring, scans=scans or {})


def ring_with(**hits):
    """Return the ring with ranges by ray, such as r0=0.5."""
    ring = NONE.copy()
    for name, away in hits.items():
        ring[int(name[1:])] = away
    return ring


def sorted_rows(points):
    return np.array(sorted(np.asarray(points).round(6).tolist()))


def test_hits_stay_in_the_world_while_the_robot_moves():
    hits = Hits(np.full(RAYS, 0.22))
    hits.see(seen(0.0, ring=ring_with(r2=0.78)))
    place = np.array([math.cos(math.pi / 4), math.sin(math.pi / 4)])
    np.testing.assert_allclose(hits.within(2.0), [place, place], atol=1e-9)  # live, and kept
    pose = Pose(0.0, 0.0, 0.0)
    for k, move in enumerate([(0.01, 0.0, 0.01), (0.004, 0.006, -0.02), (0.0, 0.0, 0.02)], start=1):
        pose = pose @ Pose(move[0], move[1], 0.0) @ Pose(0.0, 0.0, move[2])
        hits.see(seen(0.1 * k, move=move))
        np.testing.assert_allclose([hits.x, hits.y, hits.heading], [pose.x, pose.y, pose.heading], atol=1e-9)
        np.testing.assert_allclose(hits.within(2.0), pose.inverse().transform(place[None]), atol=1e-9)
    assert len(hits.within(0.1)) == 0
    hits.see(seen(9.0))
    assert len(hits.within(2.0)) == 0


@pytest.mark.parametrize("heading", [0.0, 0.6, -2.0])
def test_a_point_that_a_ray_passes_through_is_dropped(heading):
    hits = Hits(np.full(RAYS, 0.22))
    hits.see(seen(0.0, move=(0.0, 0.0, heading), ring=ring_with(r3=0.78, r9=0.28)))
    assert len(hits.within(2.0)) == 4
    # Ray 3 now ends a little before the end of its reach: the point there has moved away.
    hits.see(seen(0.5, ring=ring_with(r3=0.9)))
    angle = 3 * math.pi / 8
    expected = [1.12 * np.array([math.cos(angle), math.sin(angle)])] * 2
    near = [0.5 * np.array([math.cos(9 * math.pi / 8), math.sin(9 * math.pi / 8)])]
    found = hits.within(2.0)
    np.testing.assert_allclose(
        sorted_rows(found), sorted_rows(expected if len(found) == 2 else [*expected, *near]), atol=1e-6
    )
    assert len(found) == 2  # ray 9 sees nothing, far beyond


def test_a_point_is_kept_once_and_renewed():
    hits = Hits(np.full(RAYS, 0.22))
    for k in range(5):
        hits.see(seen(0.5 * k, ring=ring_with(r0=0.78 + 0.005 * k)))
    assert len(hits.within(2.0)) == 2
    hits.see(seen(9.9, ring=ring_with(r0=0.5)))
    assert (np.abs(hits.within(2.0) - [1.0, 0.0]).max(axis=1) < 0.05).sum() == 1  # hit last at 2 s
    hits.see(seen(10.4, ring=ring_with(r0=0.5)))
    assert (np.abs(hits.within(2.0) - [1.0, 0.0]).max(axis=1) < 0.05).sum() == 0


def test_between_two_near_hits_a_corner_has_no_way():
    ring = ring_with(r0=0.78, r1=0.78, r5=0.78)
    hits = Hits(np.full(RAYS, 0.22), join=0.5)
    hits.see(seen(0.0, ring=ring))
    a, b = np.array([1.0, 0.0]), np.array([math.cos(math.pi / 8), math.sin(math.pi / 8)])
    found = hits.within(2.0)
    for share in (0.25, 0.5, 0.75):
        assert np.abs(found - (a + share * (b - a))).max(axis=1).min() < 1e-9
    assert len(found) == 3 + 3 + 3


def test_points_of_a_lidar_are_kept_one_a_cell_within_reach():
    hits = Hits(np.full(RAYS, 0.22))
    hits.see(seen(0.0, move=(1.0, 2.0, math.pi / 2)))
    hits.add(np.array([[1.0, 0.0], [1.001, 0.001], [0.5, 0.5], [1.6, 0.0]]), 0.0)
    np.testing.assert_allclose(sorted_rows(hits.within(2.0)), [[0.5, 0.5], [1.0, 0.0]], atol=1e-6)
    kept = hits._points[hits._points[:, 0] < NO_HIT_RANGE]
    np.testing.assert_allclose(sorted_rows(kept), [[0.5, 2.5], [1.0, 3.0]], atol=1e-6)


def swept(shape, poses):
    return shapely.union_all(
        [affinity.translate(affinity.rotate(shape, h, (0, 0), use_radians=True), x, y) for x, y, h in poses]
    )


def arc_poses(speed, turn, times):
    angles = turn * times
    if turn == 0.0:
        return np.column_stack([speed * times, 0 * times, angles])
    return np.column_stack([speed / turn * np.sin(angles), speed / turn * (1 - np.cos(angles)), angles])


@pytest.mark.parametrize("robot", [SCOUT, LONG])
@pytest.mark.parametrize("speed", [0.5, -0.4])
def test_a_path_is_free_up_to_the_pose_that_comes_too_close(robot, speed):
    body = Footprint(robot)
    shape = shapely.Point(0, 0).buffer(robot.radius, 64) if robot.outline is None else shapely.Polygon(BOX)
    nearest = max(0.05, 0.07 * robot.radius)
    times = np.arange(1, 13) / 12 * 2.0
    rng = np.random.default_rng(1)
    turns = np.array([0.0, 0.6, -0.9])
    for _ in range(25):
        point = rng.uniform(-1.2, 1.2, 2)
        if shape.distance(shapely.Point(point)) < 0.2:
            continue
        found = body.arcs(point[None], speed=speed, turns=turns, seconds=2.0)
        for turn, free in zip(turns, found.times, strict=True):
            away = np.array(
                [swept(shape, [pose]).distance(shapely.Point(point)) for pose in arc_poses(speed, turn, times)]
            )
            # The distance from a box is measured along its sides: from a corner it is less than the true one.
            surely, maybe = away < nearest - 0.001, away < math.sqrt(2.0) * nearest
            last = times[np.argmax(surely) - 1] if surely.any() else 2.0
            least = times[max(np.argmax(maybe) - 1, 0)] if maybe.any() else 2.0
            least = 0.0 if maybe.any() and np.argmax(maybe) == 0 else least
            assert least - 1e-9 <= free <= (last if np.argmax(surely) or not surely.any() else 0.0) + 1e-9


@pytest.mark.parametrize("turned", [False, True])
def test_lines_lead_the_way_that_they_say(turned):
    bearings = np.array([0.0, math.pi / 2, -math.pi / 2, math.pi])
    for k, bearing in enumerate(bearings):
        point = 0.9 * np.array([[math.cos(bearing), math.sin(bearing)]])
        free = Footprint(LONG).lines(point, speed=0.5, bearings=bearings, seconds=2.0, turned=turned)
        assert (free.times < 2.0).tolist() == [other == k for other in range(4)]
        ahead = {0: 0.3, 1: 0.2, 2: 0.2, 3: 0.4}[k] if not turned else 0.3
        steps = np.arange(1, 13) / 6
        blocked = 0.9 - 0.5 * steps - ahead < 0.05
        assert free.times[k] == pytest.approx(steps[np.argmax(blocked) - 1])


def test_clearance_slows_and_shapes_are_told():
    body = Footprint(SCOUT)
    assert (body.round, body.width, body.slender) == (True, 0.44, 1.0)
    for beside, ease in ((0.05, 0.35), (0.085, 0.35 + 0.65 * 0.5), (0.12, 1.0), (0.4, 1.0)):
        found = body.arcs(np.array([[0.25, 0.22 + beside]]), speed=0.5, turns=np.zeros(1), seconds=2.0)
        assert found.ease[0] == pytest.approx(ease, abs=0.02)
    box = Footprint(LONG)
    assert (box.round, box.width) == (False, pytest.approx(0.4))
    assert box.slender == pytest.approx(LONG.radius / 0.2)
    assert Footprint(LONG, swing=True).round
    assert Footprint(SCOUT, clearance=0.1).roomy == pytest.approx(0.17)


@pytest.mark.parametrize(
    ("point", "left", "right"), [((0.33, 0.22), True, False), ((0.33, -0.22), False, True), ((2, 2), True, True)]
)
def test_a_long_body_turns_on_the_spot_where_its_corners_have_room(point, left, right):
    # A corner ahead swings left when it turns left.
    box = Footprint(LONG)
    shape, there = shapely.Polygon(BOX), np.array([point], dtype=float)
    for turn, told in ((1.0, left), (-1.0, right)):
        poses = [(0.0, 0.0, turn * angle) for angle in np.linspace(0.06, 0.36, 12)]
        hit = swept(shape, poses).distance(shapely.Point(point)) == 0.0
        assert box.can_spin(there, turn) == (not hit)
        assert told in (True, False)
    assert box.can_spin(np.zeros((0, 2)), 1.0)
    assert Footprint(SCOUT).can_spin(np.array([[0.23, 0.0]]), 1.0)


def avoidance(robot=SCOUT, **keys):
    found = RingAvoidance(**keys)
    found.start(robot, np.random.default_rng(0))
    return found


AHEAD = Command(0.5, 0.0, 0.0)


def test_a_free_way_is_driven_as_it_is_commanded():
    assert avoidance().adjust(AHEAD, seen()) == AHEAD
    curve = Command(0.5, 0.0, 0.4)
    assert avoidance().adjust(curve, seen()) == curve
    spin = Command(0.0, 0.0, 1.0)
    assert avoidance().adjust(spin, seen()) == spin


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_thing_at_one_side_is_passed_at_the_other(sign):
    ray = 1 if sign > 0 else 15
    found = avoidance().adjust(AHEAD, seen(ring=ring_with(**{f"r{ray}": 0.35, "r0": 0.6})))
    assert found.turn * sign < 0.0
    assert 0.0 <= found.forward <= 0.5


def test_before_a_wall_it_turns_on_the_spot_towards_a_free_side():
    wall = ring_with(
        **{f"r{k}": 0.06 / math.cos(k * math.pi / 8) for k in range(4)},
        **{f"r{k}": 0.06 / math.cos(k * math.pi / 8) for k in (13, 14, 15)},
    )
    guard = avoidance()
    found = guard.adjust(AHEAD, seen(ring=wall))
    assert found.forward == 0.0
    assert abs(found.turn) == pytest.approx(min(SCOUT.max_turn, 1.2))
    again = guard.adjust(AHEAD, seen(0.04, ring=wall, move=(0.0, 0.0, found.turn * 0.04)))
    assert again.turn * found.turn > 0.0
    # A command that is sideways, or none at all, forgets the escape.
    stop = guard.adjust(Command(0.0, 0.0, 0.0), seen(0.08, ring=wall))
    assert (stop.forward, stop.turn) == (0.0, 0.0)


def test_towards_a_wall_it_slows_to_what_it_can_stop_from():
    guard = avoidance()
    ring = NONE.copy()
    ring[0] = 0.5
    for k in (1, 15):
        ring[k] = 0.75
    found = guard.adjust(Command(0.7, 0.0, 0.0), seen(ring=ring))
    assert 0.0 < found.forward <= math.sqrt(2 * 0.5 * SCOUT.max_acceleration * 0.5)


def test_a_lidar_sees_what_is_between_the_rays():
    mounted = np.eye(4)
    mounted[:2, 3] = (0.1, 0.0)
    robot = pioneer(sensors={"scan": SensorInfo(kind="lidar", robot_from_sensor=mounted, rate_hz=10.0)})
    leg = np.full(41, np.inf)
    leg[20] = 0.4
    scan = Scan(0.0, leg, -0.4, 0.02, 0.05, 10.0)
    blind, sees = avoidance(robot), avoidance(robot, lidar="scan")
    assert blind.adjust(AHEAD, seen(scans={"scan": scan})) == AHEAD
    found = sees.adjust(AHEAD, seen(scans={"scan": scan}))
    assert found != AHEAD
    assert sees.adjust(AHEAD, seen(0.04)) != AHEAD  # it is remembered
    np.testing.assert_allclose(sees._hits.within(1.0), [[0.5, 0.0]], atol=1e-9)
    with pytest.raises(ValueError, match="lidar"):
        avoidance(pioneer(), lidar="scan")


@pytest.mark.parametrize("clearance", [0.04, 0.51])
def test_a_clearance_that_cannot_be_measured_is_refused(clearance):
    with pytest.raises(ValueError, match=f"clearance is {clearance} m; it must be from 0.05 to"):
        RingAvoidance(clearance=clearance)


def test_a_trail_keeps_places_a_step_apart_and_weighs_those_ahead_by_how_near_they_are():
    trail = Trail()
    for x in np.arange(0.0, 2.01, 0.25):
        trail.add(x, 1.0)
    bearings = np.array([0.0, math.pi / 2, math.pi, -math.pi / 2])
    # Kept at 0, 0.5, ... 2 m: places farther than 4 m do not count, nor do those within a step.
    np.testing.assert_allclose(trail.worn(5.25, 1.0, bearings), [0.0, 0.0, 1 / 3.75 + 1 / 3.25, 0.0])
    np.testing.assert_allclose(trail.worn(2.25, 1.0, bearings), [0.0, 0.0, 1.0, 0.0], err_msg="at most 1")
    np.testing.assert_allclose(trail.worn(-2.75, 1.0, bearings), [1 / 2.75 + 1 / 3.25 + 1 / 3.75, 0.0, 0.0, 0.0])
    # A sector is 0.4 rad to each side.
    beside = math.pi + np.array([0.39, 0.41, -0.39, -0.41])
    np.testing.assert_array_equal(trail.worn(3.0, 1.0, beside) > 0.0, [True, False, True, False])
    assert not Trail().worn(0.0, 0.0, bearings).any()


def test_a_trail_counts_places_in_any_direction():
    rng, trail = np.random.default_rng(3), Trail()
    places = rng.uniform(-3.0, 3.0, (40, 2))
    for x, y in places:
        trail.add(x, y)
    x, y, bearings = 0.4, -0.7, np.linspace(-3.0, 3.0, 25)
    expected = np.zeros(25)
    for each in places[[0, *(1 + np.flatnonzero(np.hypot(*np.diff(places, axis=0).T) >= 0.3))]]:
        away = math.dist(each, (x, y))
        off = [abs(math.remainder(math.atan2(each[1] - y, each[0] - x) - bearing, math.tau)) for bearing in bearings]
        expected += (np.array(off) < 0.4) * (0.3 < away < 4.0) / away
    np.testing.assert_allclose(trail.worn(x, y, bearings), expected / max(expected.max(), 1.0))


def test_a_trail_forgets_the_oldest_places():
    trail, behind = Trail(), np.array([math.pi])
    for number in range(Trail.CAPACITY):
        trail.add(0.5 * number, 0.0)
    assert trail.worn(0.5, 0.0, behind) > 0.0
    trail.add(-9.0, 9.0)
    assert trail.worn(0.5, 0.0, behind) == 0.0


@pytest.mark.parametrize("heading", [0.4, 1.2, 2.5, -0.9])
def test_an_escape_leads_where_the_robot_has_not_been(heading):
    guard = avoidance()
    guard.adjust(AHEAD, seen(move=(0.0, 0.0, heading)))
    for step in range(10):
        guard.adjust(AHEAD, seen(0.04 * step, move=(0.3, 0.0, 0.0)))
    guard.adjust(AHEAD, seen(0.5, move=(0.0, 0.0, math.pi), ring=ring_with(r8=0.6)))
    # It faces its own way, which is as wide as 0.4 rad to each side; what else counts is far less.
    assert all(0.4 < abs(guard._escape_angle(AHEAD)) < 1.3 for _ in range(10))


def turned_over(command):
    return Command(command.forward, -command.left, -command.turn)


def rings(count):
    """Return rings of any ranges, half of whose rays meet nothing."""
    rng = np.random.default_rng(8)
    for _ in range(count):
        ring = rng.uniform(0.05, 2.0, RAYS)
        ring[rng.uniform(size=RAYS) < 0.5] = np.inf
        yield rng, ring


@pytest.mark.parametrize("robot", [SCOUT, LONG], ids=["round", "long"])
def test_what_is_mirrored_is_avoided_to_the_other_side(robot):
    changed = 0
    for rng, ring in rings(40):
        forward, turn = rng.uniform(-0.7, 0.7), rng.uniform(-1.0, 1.0)
        for left in (0.0, rng.uniform(0.1, 0.5)):
            command = Command(forward, left, turn)
            plain, mirrored = avoidance(robot), avoidance(robot)
            found = plain.adjust(command, seen(ring=ring))
            other = mirrored.adjust(turned_over(command), seen(ring=np.roll(ring[::-1], 1)))
            if plain._heading is None and mirrored._heading is None:  # the choice of an escape is left to chance
                expected = turned_over(found)
                assert (other.forward, other.left, other.turn) == pytest.approx(
                    (expected.forward, expected.left, expected.turn), abs=1e-6
                )
                changed += found != command
    assert changed > 15


def test_a_round_robot_backs_off_as_it_would_go_ahead_the_other_way_round():
    for rng, ring in rings(40):
        command = Command(rng.uniform(0.1, 0.7), 0.0, rng.uniform(-1.0, 1.0))
        ahead, back = avoidance(), avoidance()
        found = ahead.adjust(command, seen(ring=ring))
        other = back.adjust(Command(-command.forward, 0.0, command.turn), seen(ring=np.roll(ring, 8)))
        if ahead._heading is None and back._heading is None:
            assert (other.forward, other.turn) == pytest.approx((-found.forward, found.turn), abs=1e-6)
