"""A drive of the user's own, on a robot from a file of MJCF."""

import math

import numpy as np
import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.geometry import Pose
from mjsim.interface import Command, WheelCommand
from mjsim.sim import Simulation
from mjsim.world import load_world, parse_world
from tests.rover import ROVER, TANK, WORLD


@pytest.fixture
def rover(tmp_path):
    (tmp_path / "rover.xml").write_text(ROVER)
    (tmp_path / "tank.py").write_text(TANK)
    (tmp_path / "room.yaml").write_text(WORLD)
    return tmp_path / "room.yaml"


def driven(sim: Simulation, command: Command | WheelCommand, seconds: float) -> tuple[list[Pose], list[Pose]]:
    """Return a motion at each tick from its start, as it is and as odometry tells it."""
    sim.apply("rover", command)
    start, was, told = sim.truth("rover"), [Pose(0.0, 0.0, 0.0)], [Pose(0.0, 0.0, 0.0)]
    for _ in range(round(seconds / sim.dt)):
        sim.step()
        seen = sim.sense("rover").odometry
        was.append(start.inverse() @ sim.truth("rover"))
        told.append(told[-1] @ Pose(seen.forward, seen.left, seen.turn))
    return was, told


def test_it_drives_and_tells_its_motion_as_the_users_class_says(rover):
    with Simulation(load_world(rover)) as sim:
        info = sim.robots["rover"]
        assert (info.drive, info.wheels) == ("Tank", ("left", "right"))
        was, told = driven(sim, Command(0.4), 4.0)
        # From rest at 1 m/s^2, which costs half the square of the speed.
        assert was[-1].x == pytest.approx(0.4 * 4.0 - 0.4**2 / 2, rel=0.02)
        assert told[-1].x == pytest.approx(was[-1].x, rel=0.002)
        driven(sim, WheelCommand((-2.0, 2.0)), 1.0)
        was, told = driven(sim, WheelCommand((-2.0, 2.0)), 1.0)
        # 2 rad/s on wheels of 0.08 m that are 0.3 m apart.
        assert was[-1].heading == pytest.approx(2.0 * 0.08 * 2.0 / 0.3, rel=0.02)
        assert told[-1].heading == pytest.approx(was[-1].heading, rel=0.002)


@pytest.mark.parametrize(
    ("forward", "turn"), [(0.2, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -1.5), (0.4, 0.6), (0.15, -0.8), (-0.25, 0.5)]
)
def test_at_steady_speed_it_goes_straight_turns_on_the_spot_and_drives_arcs_as_it_is_told(rover, forward, turn):
    with Simulation(load_world(rover)) as sim:
        driven(sim, Command(forward, turn=turn), 1.0)
        was, told = driven(sim, Command(forward, turn=turn), 2.0)
    points = np.array([pose.as_array()[:2] for pose in was])
    way, off = 2.0 * abs(forward), 0.02 * 2.0 * abs(forward) + 0.002
    assert sum(map(math.dist, points, points[1:])) == pytest.approx(way, abs=off)
    assert was[-1].heading == pytest.approx(2.0 * turn, rel=0.02, abs=0.002)
    # An arc ends where its chord does, which points half its turn aside.
    chord = 2.0 * forward * np.sinc(turn / math.pi)
    np.testing.assert_allclose(points[-1], (chord * math.cos(turn), chord * math.sin(turn)), atol=off)
    # Tyres slip outward on an arc, by some millimetres for a metre; turning on the spot, by a thousandth of the turn.
    np.testing.assert_allclose(told[-1].as_array()[:2], points[-1], atol=off)
    assert told[-1].heading == pytest.approx(was[-1].heading, rel=0.005, abs=0.001)


def test_it_feels_walls_and_its_own_wheels_are_hit_by_no_ray(rover):
    with Simulation(load_world(rover)) as sim:
        assert sim.sense("rover").proximity[4] == pytest.approx(float("inf"))
        sim.apply("rover", Command(0.5))
        bumps = []
        for _ in range(250):
            sim.step()
            bumps += sim.sense("rover").bump
        # Its nose is a flat face, 0.24 m wide and 0.2 m ahead.
        assert bumps
        assert max(map(abs, bumps)) == pytest.approx(math.atan2(0.12, 0.2), abs=0.02)
        assert sim.truth("rover").x < 3.0


def test_a_wheel_that_the_file_lacks_is_named(rover):
    (rover.parent / "tank.py").write_text(TANK.replace('"right")', '"starboard")'))
    with pytest.raises(UsageError, match="starboard"):
        Simulation(load_world(rover))


def test_a_file_without_a_base_is_reported(rover):
    (rover.parent / "rover.xml").write_text(ROVER.replace('name="base"', 'name="hull"'))
    with pytest.raises(WorldError, match="no body named 'base'"):
        Simulation(load_world(rover))


def test_a_drive_of_ones_own_needs_a_body_of_ones_own():
    with pytest.raises(WorldError, match="give both drive"):
        parse_world('mjsim: 1\nrobots: [{name: r, at: [0, 0], drive: {use: "tank.py:Tank"}}]\n')
