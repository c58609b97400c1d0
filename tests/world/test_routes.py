"""Routes: where a thing that goes by itself is depends on the time alone."""

import numpy as np
import pytest

from mjsim.video.plan_parts import world_bounds
from mjsim.world import extent, parse_world, route_of


def route(path: str):
    world = parse_world(f"mjsim: 1\nobstacles: [{{sphere: 0.1, at: [1, 1], path: {path}}}]\n")
    found = route_of(world.obstacles[0])
    assert found is not None
    return found


def test_an_open_path_is_walked_there_and_back():
    there_and_back = route("{points: [[4, 1], [4, 5]], speed: 0.5}")
    assert there_and_back.period == pytest.approx(2 * (3 + 4) / 0.5)
    for time, place, velocity in [
        (0.0, (1, 1), (0.5, 0)),
        (3.0, (2.5, 1), (0.5, 0)),
        (10.0, (4, 3), (0, 0.5)),
        (18.0, (4, 3), (0, -0.5)),
        (28.0 + 3.0, (2.5, 1), (0.5, 0)),
    ]:
        np.testing.assert_allclose(there_and_back.at(time), (place, velocity), atol=1e-9)


def test_a_closed_path_goes_round():
    square = route("{points: [[2, 1], [2, 2], [1, 2]], speed: 0.25, closed: true}")
    assert square.period == pytest.approx(16.0)
    np.testing.assert_allclose(square.at(14.0), ((1, 1.5), (0, -0.25)), atol=1e-9)


def test_it_waits_at_each_stop():
    waiting = route("{points: [[3, 1]], speed: 1, wait: 5}")
    assert waiting.period == pytest.approx(14.0)
    for time, x in [(4.9, 1), (6, 2), (7, 3), (11.9, 3), (13, 2), (14 + 4.9, 1)]:
        assert waiting.at(time)[0][0] == pytest.approx(x)


def test_places_are_the_sum_of_velocities():
    rng = np.random.default_rng(0)
    points = rng.uniform(0, 5, (6, 2)).round(2).tolist()
    wild, dt = route(f"{{points: {points}, speed: 1.3, wait: 0.2}}"), 1e-3
    times = np.arange(0.0, 1.5 * wild.period, dt)
    places = np.array([wild.at(time)[0] for time in times])
    moved = np.linalg.norm(np.diff(places, axis=0), axis=1)
    # It never jumps, and moves at its speed whenever it moves.
    assert moved.max() <= 1.3 * dt + 1e-9
    going = (moved > 1.3 * dt - 1e-9).sum() * dt
    assert going == pytest.approx(1.5 * wild.period - 0.2 * 15, rel=0.02)


def test_a_path_whose_points_are_all_where_it_stands_goes_nowhere():
    assert route("{points: [[1, 1]]}").at(7.0) == ((1.0, 1.0), (0.0, 0.0))


def test_the_views_reach_as_far_as_a_mover_goes():
    world = parse_world("mjsim: 1\nobstacles: [{sphere: 0.5, at: [1, 1], path: {points: [[4, 7], [-3, 2]]}}]\n")
    (sphere,) = world.obstacles
    low, high = extent(sphere).min(axis=0), extent(sphere).max(axis=0)
    np.testing.assert_allclose([low, high], [[-3.5, 0.5], [4.5, 7.5]])
    bounds = world_bounds(world)
    assert (bounds[0] <= low + 1e-9).all()
    assert (bounds[1] >= high - 1e-9).all()
