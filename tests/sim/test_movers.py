"""Movers: where they are depends on the time alone, and what stands in their way is pushed."""

import numpy as np
import pytest

from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import parse_world

CROSSING = """
mjsim: 1
walls: [{points: [[-3, -3], [9, -3], [9, 3], [-3, 3]], closed: true}]
obstacles:
  - {box: [0.6, 0.4, 0.8], at: [0, 0], heading_deg: 30, name: cart, path: {points: [[2, 0], [2, 1]], speed: 0.5}}
  - {cylinder: [0.25, 1.7], at: [6, -2], name: walker, path: {points: [[7, -2], [7, 2]], speed: 1, closed: true}}
robots: [{name: far, at: [-2, -2]}]
"""


def test_movers_are_where_their_routes_have_them_at_every_tick():
    sim = Simulation(parse_world(CROSSING))
    for tick in range(1, 226):
        sim.step()
        time, cart = tick * sim.dt, sim.things()["obstacle/cart"]
        way = time * 0.5 % 6.0
        way = min(way, 6.0 - way)
        assert (cart.x, cart.y) == pytest.approx((min(way, 2.0), max(way - 2.0, 0.0)), abs=1e-9)
        assert cart.heading == pytest.approx(np.radians(30))
    walker = sim.things()["obstacle/walker"]
    # 9 m of a round of 5 + sqrt(17) m that ends where it began.
    there = 1.0 - (9.0 - 5.0) / np.sqrt(17)
    assert (walker.x, walker.y) == pytest.approx((6 + there, -2 + 4 * there), abs=1e-9)


def test_a_robot_that_meets_none_moves_as_if_there_were_none():
    places = []
    for text in (CROSSING, CROSSING.replace(", path: {points: [[2, 0], [2, 1]], speed: 0.5}", "").split("  - {cyl")[0]):
        if "robots" not in text:
            text += "robots: [{name: far, at: [-2, -2]}]\n"
        sim = Simulation(parse_world(text))
        for _ in range(75):
            sim.apply("far", Command(0.5, turn=0.4))
            sim.step()
        places.append(sim.truth("far").as_array())
    # The solver stops at other last digits when other bodies are there.
    np.testing.assert_allclose(*places, atol=1e-4)


def test_a_mover_pushes_a_standing_robot_at_its_speed_and_the_robot_feels_it():
    text = """
mjsim: 1
obstacles: [{box: [0.4, 1, 0.6], at: [0, 0], name: sweeper, path: {points: [[3, 0]], speed: 0.4}}]
robots: [{name: r, at: [1, 0.05], heading_deg: 180}]
"""
    sim = Simulation(parse_world(text))
    felt = []
    while sim.time < 5.0:
        sim.step()
        felt.append(sim.sense("r").bump)
        assert sim.things()["obstacle/sweeper"].x == pytest.approx(0.4 * sim.time, abs=1e-9)
    front = 0.4 * 5.0 + 0.2
    assert sim.truth("r").x - 0.22 == pytest.approx(front, abs=0.01)
    # It was met when the front had come from 0.2 to 0.78 m: after 1.45 s.
    first = next(k for k, bump in enumerate(felt) if bump)
    assert (first + 1) * sim.dt == pytest.approx(0.58 / 0.4, abs=0.05)
    assert np.mean([bool(bump) for bump in felt[first:]]) > 0.9
    assert abs(felt[-1][0]) < 0.5


def test_a_lidar_and_a_proximity_ray_meet_a_mover_where_it_is():
    text = """
mjsim: 1
obstacles: [{cylinder: [0.3, 1], at: [2, 0], path: {points: [[3, 0]], speed: 0.5}}]
robots: [{name: r, at: [0, 0], sensors: [{lidar: scan, at: [0, 0, 0.2], beams: 3, fov_deg: 90, rate_hz: 25}]}]
"""
    sim = Simulation(parse_world(text))
    for _ in range(25):
        sim.step()
    scan = sim.sense("r").scans["scan"]
    assert scan.ranges[1] == pytest.approx(2.5 - 0.3, abs=1e-3)


def test_a_run_in_which_movers_push_is_the_same_again():
    runs = []
    for _ in range(2):
        sim = Simulation(parse_world(CROSSING.replace("[-2, -2]", "[1, 0.3]")))
        for _ in range(100):
            sim.step()
        runs.append(sim.state()[0])
    np.testing.assert_array_equal(*runs)
