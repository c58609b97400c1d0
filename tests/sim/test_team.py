"""Many robots in one world: each senses, bumps and hears all others, and none changes the chance of another."""

import numpy as np
import pytest

from mjsim.errors import WorldError
from mjsim.interface import Command
from mjsim.sim import Simulation
from mjsim.world import parse_world

RADIUS, APART = 0.22, 0.4405
KEYS = (
    "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.02, turn: 0.02}}, sensors: ["
    "{lidar: scan, at: [0, 0, 0.15], beams: 37, range: [0, 10], rate_hz: 25, noise: {range: 0.02}, missed: 0.3},"
    " {imu: imu, noise: {turn: 0.01}}]"
)
MIDDLE = slice(14, 23)
"""Beams that meet the other robot of a pair."""


def team(count: int) -> Simulation:
    """Return robots in pairs, both of a pair nearly nose to nose, pairs in a column 3 m from each other."""
    robots = "".join(
        f"  - {{name: r{k}, at: [{APART * (k % 2)}, {3 * (k // 2)}], heading_deg: {180 * (k % 2)}, {KEYS}}}\n"
        for k in range(count)
    )
    return Simulation(parse_world(f"mjsim: 1\nrobots:\n{robots}"), seed=5)


@pytest.mark.slow
def test_thirty_two_robots_sense_bump_and_hear_each_other():
    with team(32) as sim:
        for name in sim.robots:
            sim.apply(name, Command(0.1, messages=(name,)))
        sim.step()
        for number, name in enumerate(sim.robots):
            seen = sim.sense(name)
            assert seen.bump == pytest.approx((0.0,), abs=0.02), name
            assert seen.proximity[0] == pytest.approx(0.0, abs=0.005), name
            # The three beams in the middle meet the rim of the other; sigma is 0.02 m, and some are lost.
            ahead = seen.scans["scan"].ranges[17:20]
            assert np.abs(ahead[np.isfinite(ahead)] - (APART - RADIUS)).max(initial=0.0) < 0.1, name
            assert [message.sender for message in seen.messages] == [each for each in sim.robots if each != name]
            assert len(seen.imu) == 5, name
            assert sim.truth(name).y == pytest.approx(3 * (number // 2), abs=0.01), name


def test_a_thirty_third_robot_is_refused():
    with pytest.raises(WorldError) as caught:
        team(33)
    assert str(caught.value) == "world.yaml:3:3: robots is a list of 33 items; it must have at most 32 items"


def chances(sim: Simulation, ticks: int) -> list[bytes]:
    """Return the bytes of which returns the first robot's lidar loses and of what its motors do by chance."""
    rows = []
    for _ in range(ticks):
        seen = sim.sense("r0")
        # Physics rounds otherwise among more robots; which returns are lost does not.
        lost = np.isposinf(seen.scans["scan"].ranges[MIDDLE])
        assert lost.sum() < lost.size
        rows.append(lost.tobytes() + sim.data.ctrl[:2].tobytes())
        sim.step()
    return rows


@pytest.mark.slow
def test_thirty_one_others_leave_the_chance_of_the_first_byte_for_byte():
    with team(2) as two, team(32) as many:
        for sim in (two, many):
            for name in sim.robots:
                sim.apply(name, Command(-0.2))
        assert chances(two, 10) == chances(many, 10)
