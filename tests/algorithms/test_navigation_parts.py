"""Parts of GoToGoal against what is computed another way: brute force, interpolation by scipy, sums step by step."""

import heapq
import itertools
import math

import numpy as np
import pytest
import shapely
from scipy.interpolate import RegularGridInterpolator
from scipy.spatial import cKDTree

from mjsim.algorithms.go_to_goal.body_discs import BodyDiscs
from mjsim.algorithms.go_to_goal.cost_to_go import MAX_PRICE, UNREACHED, Planner, allowed_speed, time_per_metre
from mjsim.algorithms.go_to_goal.moving_things import MovingThings, Thing
from mjsim.algorithms.go_to_goal.obstacle_map import ObstacleMap
from mjsim.algorithms.go_to_goal.obstacle_memory import ObstacleMemory
from mjsim.algorithms.go_to_goal.range_views import RangeView
from mjsim.algorithms.go_to_goal.way_plan import WayPlan
from mjsim.geometry import Pose
from tests.algorithms.test_local_navigation import ORIGIN, ring, robot

FAR = np.array([[50.0, 50.0]])


def times_from(price, cell, goal):
    """Return the times to a cell by Dijkstra's algorithm on a dictionary."""
    times, queue = {}, [(0.0, goal)]
    while queue:
        time, (row, column) = heapq.heappop(queue)
        if (row, column) in times:
            continue
        times[row, column] = time
        for down, right in itertools.product((-1, 0, 1), repeat=2):
            r, c = row + down, column + right
            if (down or right) and 0 < r < price.shape[0] - 1 and 0 < c < price.shape[1] - 1:
                step = 0.5 * (price[row, column] + price[r, c]) * math.hypot(down, right) * cell
                if math.isfinite(step):
                    heapq.heappush(queue, (time + step, (r, c)))
    return times


def test_times_to_a_goal_are_the_shortest_over_the_prices_of_the_cells():
    planner = Planner(np.array([-1.0, 0.5]), np.array([1.3, 2.0]), 0.1)
    price = np.random.default_rng(5).uniform(1.0, 3.0, planner.shape)
    price[5:12, 9] = math.inf
    goal = np.array([-0.55, 1.05])
    row, column = (int(each[0]) for each in planner.cells(goal[None]))
    price[row, column] = math.inf
    field = planner.cost_to_go(price, goal)
    price[row, column] = MAX_PRICE
    expected = np.full(planner.shape, UNREACHED)
    for cell, time in times_from(price, 0.1, (row, column)).items():
        expected[cell] = time
    reached = expected < UNREACHED
    np.testing.assert_allclose(field.seconds[reached], expected[reached])
    # Around what is reached times go on, by a second a cell, for three cells.
    assert (field.seconds[0] < UNREACHED).all()
    assert field.seconds[0, 5] == pytest.approx(1.0 + expected[1, 4:7].min())
    near = planner.cost_to_go(price, goal, limit=1.0)
    np.testing.assert_allclose(near.seconds[expected < 1.0], expected[expected < 1.0])
    assert (near.before[(expected > 1.0).ravel()] < 0).all()
    # A path follows neighbours, and its time is that of its first cell.
    start = np.array([1.05, 1.85])
    path = field.path(start)
    cells = [tuple(int(each) for each in pair) for pair in zip(*planner.cells(path), strict=True)]
    walked = sum(0.05 * (price[one] + price[other]) * math.dist(one, other) for one, other in itertools.pairwise(cells))
    assert walked == pytest.approx(expected[cells[0]])
    np.testing.assert_allclose(path[1:-1], planner.lower + 0.1 * (np.array(cells)[1:-1, ::-1] + 0.5))
    np.testing.assert_array_equal(path[[0, -1]], [start, goal])


def test_between_the_middles_of_cells_times_are_interpolated_and_beyond_the_grid_those_of_its_edge():
    planner = Planner(np.array([-1.0, 0.3]), np.array([1.3, 2.0]), 0.1)
    field = planner.cost_to_go(np.ones(planner.shape), np.array([0.15, 1.15]))
    y, x = (planner.lower[axis] + 0.1 * (np.arange(planner.shape[1 - axis]) + 0.5) for axis in (1, 0))
    exact = RegularGridInterpolator((y, x), field.seconds)
    points = np.random.default_rng(5).uniform((x[0], y[0]), (x[-1], y[-1]), (4, 50, 2))
    np.testing.assert_allclose(field.at(points), exact(points[..., ::-1]), rtol=1e-3)
    for beyond, edge in (((-9.0, 1.0), (x[0], 1.0)), ((0.0, 9.0), (0.0, y[-1])), ((9.0, -9.0), (x[-1], y[0]))):
        assert field.at(np.array(beyond)) == pytest.approx(float(exact(edge[::-1]).item()), rel=0.01)
    # Away from the goal the steepest descent leads to it along rows, columns and diagonals.
    for way in itertools.product((-1, 0, 1), repeat=2):
        if way != (0, 0):
            ahead, up = field.direction(np.array([0.15, 1.15]) - 0.4 * np.array(way))
            assert (ahead, up) == pytest.approx(way / np.hypot(*way), abs=0.05)


def test_cells_of_points_are_drawn_and_those_beyond_the_grid_are_not():
    planner = Planner(np.array([-1.0, 0.5]), np.array([1.3, 2.0]), 0.1)
    np.testing.assert_allclose(planner.upper, planner.lower + 0.1 * np.array(planner.shape[::-1]))
    points = np.concatenate(
        [np.random.default_rng(5).uniform(-2.0, 3.0, (60, 2)), planner.lower[None], planner.upper[None]]
    )
    inside = [planner.contains(point) for point in points]
    assert inside[-2:] == [True, False]
    expected = np.zeros(planner.shape, dtype=bool)
    for (x, y), is_in in zip(points.tolist(), inside, strict=True):
        assert is_in == (-1.0 <= x < planner.upper[0] and 0.5 <= y < planner.upper[1])
        if is_in:
            expected[int((y - 0.5) / 0.1), int((x + 1.0) / 0.1)] = True
    np.testing.assert_array_equal(planner.drawn(points), expected)
    path = np.array([[-0.45, 1.05], [0.55, 1.05], [0.55, 1.55]])
    y, x = np.mgrid[: planner.shape[0], : planner.shape[1]]
    away = shapely.distance(shapely.points(-0.95 + 0.1 * x, 0.55 + 0.1 * y), shapely.LineString(path))
    near = planner.near(path, 0.3)
    assert near[away < 0.2].all()
    assert not near[away > 0.45].any()


def test_a_metre_takes_longer_beside_obstacles_and_where_nobody_has_seen():
    clearance = np.array([0.1, 0.18, 0.2, 0.25, 0.3, 0.35, 0.9])
    for seen, factor in ((False, 1.3), (True, 1.0)):
        doubt = np.full(7, not seen)
        found = time_per_metre(clearance, half_width=0.2, gap=0.1, top=0.8, doubt=doubt)
        for value, far in zip(found.tolist(), (clearance - 0.2).tolist(), strict=True):
            speed = min(0.8, max(0.3, 0.3 + 3.5 * far))
            lacking = max(1.0 - far / 0.1, 0.0)
            expected = factor / speed * (1.0 + lacking + 4.0 * lacking**2)
            assert value == (math.inf if far < -0.01 else pytest.approx(expected))
    np.testing.assert_allclose(time_per_metre(clearance[3:], half_width=0.2, gap=0.0, top=9.0)[0], 1 / 0.475)
    np.testing.assert_allclose(allowed_speed(np.array([-1.0, 0.0, 0.2])), [0.3, 0.3, 1.0])


@pytest.mark.parametrize("turned", [False, True])
def test_discs_lie_in_a_row_along_the_longer_side(turned):
    outline = np.array([[-0.1, -0.2], [0.7, -0.2], [0.7, 0.2], [-0.1, 0.2]])
    discs = BodyDiscs(robot(outline=outline[:, ::-1] if turned else outline))
    along, across = discs.centres.T[::-1] if turned else discs.centres.T
    np.testing.assert_allclose(across, 0.0, atol=1e-12)
    width = np.diff(along)
    np.testing.assert_allclose(width, width[0])
    assert (along[0] - width[0] / 2, along[-1] + width[0] / 2) == pytest.approx((-0.1, 0.7))
    assert discs.radii == pytest.approx(math.hypot(0.2, width[0] / 2))
    # With one disc less they would extend by more than 15 mm.
    assert math.hypot(0.2, 0.4 / (len(along) - 1)) > 0.215 >= discs.radii[0]
    assert len(BodyDiscs(robot(outline=outline * (9.0, 1.0))).radii) == 9
    circle = np.stack([np.cos(np.arange(12)), np.sin(np.arange(12))], axis=-1)
    for single in (None, 0.3 * circle):
        discs = BodyDiscs(robot(outline=single, radius=0.3))
        assert (discs.centres.tolist(), discs.radii.tolist(), discs.half_width) == ([[0.0, 0.0]], [0.3], 0.3)


def test_distances_around_a_robot_are_those_to_the_nearest_obstacle():
    place, points = np.array([3.0, -2.0]), np.array([3.0, -2.0]) + np.random.default_rng(5).uniform(-1.5, 1.5, (12, 2))
    map = ObstacleMap(place, points, cell=0.02, half=1.0)
    inside = np.abs(points - place).max(axis=1) < 1.0
    at = place + np.random.default_rng(5).uniform(-0.95, 0.95, (100, 2))
    expected, _ = cKDTree(points[inside]).query(at)
    np.testing.assert_allclose(map.at(*at.T), expected, atol=0.045)
    distance, slope = map.slope(at)
    np.testing.assert_array_equal(distance, map.at(*at.T))
    ahead, up = (map.at(*(at + side).T) - map.at(*(at - side).T) for side in (0.02 * np.eye(2)))
    np.testing.assert_allclose(slope, np.stack([ahead, up], axis=-1) / 0.04, atol=1e-4)
    corner = map.at(np.array([9.0]), np.array([-9.0]))
    assert corner == pytest.approx(cKDTree(points[inside]).query([4.0, -3.0])[0], abs=0.06)
    assert ObstacleMap(place, np.zeros((0, 2)), cell=0.02, half=1.0).at(*at.T) == pytest.approx(2.0)


def test_obstacles_are_dropped_after_as_many_contradictions_as_hits_at_most_4():
    hit, see_through = np.array([[1.0125, 0.0125]]), [ring(2.0)]
    for hits in range(1, 7):
        memory = ObstacleMemory(0.025, seconds=5.0)
        for _ in range(hits):
            memory.add(ORIGIN, [], hit, 0.0)
        seen = 0
        while len(memory.points):
            memory.add(ORIGIN, see_through, np.zeros((0, 2)), 0.0)
            seen += 1
        assert seen == min(hits, 4)
    memory.add(ORIGIN, [], hit, 1.0)
    memory.add(ORIGIN, [], hit + 1.0, 5.9)
    assert len(memory.points) == 2
    memory.add(ORIGIN, [], hit + 1.0, 6.1)
    np.testing.assert_allclose(memory.points, hit + 1.0, atol=0.0126)
    memory.forget(6.1)
    assert len(memory.points) == 1
    memory.forget(7.0, kept=np.array([True]))
    assert len(memory.points) == 1


def test_a_jump_is_what_odometry_does_not_explain():
    for move, jump, moved in ((0.3, 0.04, False), (0.3, 0.06, True), (0.0, 0.06, True)):
        memory = ObstacleMemory(0.01, seconds=5.0)
        memory.add(ORIGIN, [], np.array([[1.005, 0.005]]), 0.0)
        memory.track(Pose(2.0, 1.0, 0.5), ORIGIN)
        memory.track(Pose(2.0, 1.0, 0.5) @ Pose(move + jump, 0.0, 0.0), Pose(move, 0.0, 0.0))
        expected = np.array([1.005, 0.005]) + moved * jump * np.array([math.cos(0.5), math.sin(0.5)])
        np.testing.assert_allclose(memory.points, [expected], atol=0.0051)


def test_the_velocity_of_a_thing_is_the_line_through_its_sightings_since_its_last_turn():
    rim = np.array([[0.0, 0.0], [0.1, 0.1], [0.0, 0.2], [0.1, 0.2]])
    things, turn, robot, seen, radius, since = MovingThings(), 8, np.array([0.5, -1.0]), [], 0.0, 0
    ways = np.cumsum(np.random.default_rng(5).uniform(0.04, 0.05, (16, 2)), axis=0)
    ways[turn:] = 2.0 * ways[turn - 1] - ways[turn:] + (0.0, 0.12)
    for tick, way in enumerate(ways):
        size = 1.0 + 0.1 * (tick == 3)
        points = way + (2.0, 1.0) + size * rim
        things.update(points, Pose(*robot, 0.0), 0.1 * tick)
        own, middle = 0.5 * size * math.hypot(0.1, 0.2), points.mean(axis=0)
        seen.append(middle + 0.7 * own * (middle - robot) / math.dist(middle, robot))
        radius = max(0.8 * radius, own)
        (thing,) = things.tracked
        times = 0.1 * np.arange(tick + 1) - 0.1 * tick
        since = max(since, tick - 5)
        while tick:
            fit = np.polyfit(times[since:], np.array(seen[since:]), 1)
            apart = np.array(seen[since:]) - fit[1] - times[since:, None] * fit[0]
            if np.abs(apart).max() < 0.06 or since == tick - 1:
                np.testing.assert_allclose(thing.velocity, fit[0], atol=1e-9)
                np.testing.assert_allclose(thing.place, fit[1], atol=1e-9)
                break
            since += 1
        assert (thing.count, thing.radius) == (tick + 1, pytest.approx(radius))
        np.testing.assert_allclose(thing.first, seen[0])
    # What is not seen again is forgotten after 1 s; too few points, or too large ones, are no thing.
    things.update(np.zeros((0, 2)), ORIGIN, 2.4)
    assert len(things.tracked) == 1
    things.update(np.array([[0.0, 0.0], [0.0, 0.1]]), ORIGIN, 2.55)
    things.update(np.array([[0.14 * k, 0.0] for k in range(10)]), ORIGIN, 2.55)
    assert things.tracked == []


def test_things_that_pass_each_other_keep_their_velocities_though_their_points_connect():
    things, a = MovingThings(), np.linspace(0.0, 2.0 * math.pi, 40)
    rim = 0.2 * np.stack([np.cos(a), np.sin(a)], axis=-1)
    for tick in range(30):
        time = 0.08 * tick
        places = np.array([[2.0, -1.0 + 0.8 * time], [2.5, 1.0 - 0.8 * time]])
        things.update(np.concatenate([place + rim[rim @ place < 0.0] for place in places]), ORIGIN, time)
        assert len(things.tracked) == 2
        if tick > 4:
            found = sorted(things.predicted(ORIGIN, time), key=lambda thing: thing.place[0])
            np.testing.assert_allclose([thing.velocity[1] for thing in found], [0.8, -0.8], atol=0.35)


def test_the_six_nearest_things_that_move_are_predicted():
    still = {"velocity": np.array([0.3, 0.4]), "radius": 0.1, "seen": 1.0, "count": 4, "first": np.zeros(2)}
    usual = still | {"error": 0.0}
    things = MovingThings()
    things.tracked = [Thing(np.array([float(x), 0.0]), **usual) for x in (9, 3, 8, 2, 7, 1, 6)]
    odd = ({"count": 3}, {"error": 0.15}, {"velocity": np.array([0.1, 0.06])}, {"velocity": np.array([3.0, 0.1])})
    things.tracked += [Thing(np.array([0.5, 0.0]), **usual | each) for each in odd]
    things.tracked += [Thing(np.array([0.1, 0.1]), **usual)]
    found = things.predicted(Pose(4.0, 0.0, 0.0), 1.5)
    expected = sorted((x + 0.15 for x in (9, 3, 8, 2, 7, 1, 6)), key=lambda x: math.hypot(x - 4.0, 0.2))[:6]
    np.testing.assert_allclose([thing.place for thing in found], [[x, 0.2] for x in expected])


def test_a_plan_waits_for_news_on_the_way_and_has_its_goal_in_the_middle_of_a_cell():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    goal, place, none = np.array([2.0, 0.3]), np.zeros(2), np.zeros((0, 2))
    way.lay_out(goal, place[None])
    assert ((goal - way._planner.lower) / way.cell % 1.0) == pytest.approx([0.5, 0.5])
    assert way.contains(np.array([-2.9, -2.6]))
    first = way.to(goal, place, 0.0, points=none, stuck=[])
    ahead, aside = np.array([[1.0, 0.15]]), np.array([[-2.0, 2.0]])
    assert way.to(goal, place, 0.2, points=ahead, stuck=[]) is first
    second = way.to(goal, place, 0.3, points=ahead, stuck=[])
    assert second is not first
    assert float(second.at(place)) > float(first.at(place)) + 0.05
    both = np.concatenate([ahead, aside])
    assert way.to(goal, place, 0.6, points=both, stuck=[]) is second
    assert way.to(goal, place, 1.2, points=ahead, stuck=[]) is second
    third = way.to(goal, place, 1.5, points=both, stuck=[])
    assert third is not second
    way.begin()
    assert way.to(goal, place, 1.55, points=both, stuck=[(1.0, 0.15)], busy=True) is third
    # With work at each tick it waits for one only.
    fourth = way.to(goal, place, 1.6, points=both, stuck=[(1.0, 0.15)], busy=True)
    assert float(fourth.at(place)) > float(third.at(place)) + 0.05


def test_a_robot_beside_an_obstacle_still_has_a_way_out():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    goal, place = np.array([2.0, 0.3]), np.zeros(2)
    way.lay_out(goal, place[None])
    near = np.array([[0.05, 0.15], [0.1, -0.1]])
    field = way.to(goal, place, 0.0, points=near, stuck=[])
    assert float(field.at(place)) < UNREACHED
    assert float(field.at(np.array([0.05, 0.15]))) < UNREACHED
    # Elsewhere an obstacle is none to pass.
    field = way.to(goal, place, 1.5, points=np.array([[1.0, 1.0]]), stuck=[])
    assert float(field.at(np.array([1.0, 1.0]))) > float(field.at(np.array([1.0, 0.6]))) + 1.0
    costs, corner = way.costs(np.array([1.0, 1.0]), half=0.3)
    assert costs.shape == (7, 7)
    assert costs[3, 3] == 1.0
    np.testing.assert_allclose((np.array([1.0, 1.0]) - corner) / 0.1, [3.5, 3.5], atol=0.5)


def line(start, end):
    """Return points on a wall between two points [m]."""
    return np.linspace(start, end, 2 + int(math.dist(start, end) / 0.05))


U = np.concatenate([line(*ends) for ends in (((2, -2), (2, 2)), ((-6, -2), (2, -2)), ((-6, 2), (2, 2)))])


def test_a_way_out_of_a_u_is_found_where_the_first_grid_did_not_reach():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    goal, place = np.array([4.0, 0.0]), np.zeros(2)
    way.lay_out(goal, place[None])
    way.see(ORIGIN, RangeView("scan", ORIGIN, -3.0, 0.02, np.full(300, 1.0), 8.0), 0.0)
    area = way.seen_area
    assert area == pytest.approx(math.pi, rel=0.1)
    for time in (0.0, 0.3):
        field = way.to(goal, place, time, points=U, stuck=[])
    assert not way.is_barred
    assert field.path(place)[:, 0].min() < -6.0
    # What has been seen stays so.
    assert way.seen_area == pytest.approx(area)


def test_where_there_is_no_way_times_lead_near_the_goal_and_end_before_what_is_in_between():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    goal, place = np.array([4.0, 0.0]), np.zeros(2)
    way.lay_out(goal, place[None])
    closed = np.concatenate([U, line((-6, -2), (-6, 2))])
    for time in (0.0, 0.3):
        field = way.to(goal, place, time, points=closed, stuck=[])
    assert way.is_barred
    assert not way.ends(place)
    assert way.ends(np.array([1.75, 0.0]))
    assert float(field.at(np.array([1.5, 0.0]))) < float(field.at(place)) < UNREACHED
    # Once there is a way again, it is planned for.
    assert float(way.to(goal, place, 0.6, points=U, stuck=[]).at(place)) < float(field.at(place)) + 15.0
    assert not way.is_barred


def test_a_place_where_it_got_stuck_often_stays_passable():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    goal, place = np.array([2.0, 0.3]), np.zeros(2)
    way.lay_out(goal, place[None])
    times = [float(way.to(goal, place, 2.0 * n, points=FAR[:0], stuck=[(1.0, 0.1)] * n).at(place)) for n in (0, 1)]
    way.begin()
    often = float(way.to(goal, place, 4.0, points=FAR[:0], stuck=[(1.0, 0.1)] * 20).at(place))
    assert often < 10.0 * times[0]


def test_what_beams_have_passed_is_no_longer_doubtful():
    way = WayPlan(np.zeros((0, 2)), None, half_width=0.2, gap=0.1, top=1.0, cell=0.1)
    way.lay_out(np.array([2.0, 0.0]), np.array([[-2.0, 0.0], [0.0, 3.0]]))
    pose, sensor = Pose(0.5, 0.2, 0.8), Pose(0.2, 0.0, 0.3)
    view = RangeView("scan", sensor, -0.5, 0.02, np.full(51, 1.5), 8.0)
    way.see(pose, view, 0.0)
    points = np.random.default_rng(5).uniform(-2.0, 3.0, (400, 2))
    x, y = (pose @ sensor).inverse().transform(points).T
    inside = shapely.Polygon([(0, 0), *((1.5 * math.cos(a), 1.5 * math.sin(a)) for a in np.linspace(-0.5, 0.5, 30))])
    away = shapely.distance(shapely.points(x, y), inside.exterior)
    clear = away > 0.15
    np.testing.assert_array_equal(~way.unseen(points)[clear], shapely.contains_xy(inside, x, y)[clear])
    before = way.unseen(points).sum()
    way.see(pose, RangeView("scan", sensor, -3.0, 0.02, np.full(300, 2.5), 8.0), 0.2)
    assert way.unseen(points).sum() == before
    way.see(pose, RangeView("scan", sensor, -3.0, 0.02, np.full(300, 2.5), 8.0), 0.3)
    assert way.unseen(points).sum() < before


def test_points_are_free_where_a_beam_goes_beyond_them():
    ranges = np.where(np.arange(180) < 60, 3.0, 1.0)
    view = RangeView("scan", Pose(0.1, -0.2, 0.4), -math.pi / 2, math.pi / 180, ranges, 4.0, 0.3)
    points = np.random.default_rng(5).uniform(-4.0, 4.0, (500, 2))
    free = view.is_free(points, 0.05)
    x, y = view.robot_from_sensor.inverse().transform(points).T
    away, bearing = np.hypot(x, y), np.degrees(np.arctan2(y, x)) + 90.0
    known = (np.abs(bearing - 59.5) > 6.0) & (bearing > 2.0) & (bearing < 177.0) & (bearing % 360 < 358)
    limit = np.where(bearing < 60.0, 3.0, 1.0) - 0.06
    sure = known & (np.abs(away - limit) > 0.01) & (np.abs(away - 0.3) > 1e-3)
    np.testing.assert_array_equal(free[sure], ((away < limit) & (away > 0.3))[sure])
    assert not free[(bearing < -2.0)].any()
    hits = view.robot_from_sensor.inverse().transform(view.points())
    np.testing.assert_allclose(np.hypot(*hits.T), ranges)
    np.testing.assert_allclose(np.arctan2(hits[:, 1], hits[:, 0]), np.radians(np.arange(180) - 90.0), atol=1e-9)
