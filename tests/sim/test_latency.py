"""When readings are taken and when they are told: exact to the tick."""

import numpy as np
import pytest

from mjsim.errors import UsageError, WorldError
from mjsim.interface import Command, Observation
from mjsim.sim import Simulation
from mjsim.sim.sensors.suite import ticks_between
from mjsim.world import parse_world

TICKS = 40


def observations(sensors: str, *, moving: bool = True, asked: range = range(TICKS)) -> list[Observation | None]:
    """Return what a robot before a wall senses at each tick of a run at 25 Hz; None where nobody asked."""
    world = parse_world(
        f"mjsim: 1\nwalls: [{{points: [[3, -5], [3, 5]]}}]\nbeacons: [{{name: one, at: [2.8, 0]}}]\n"
        f"robots: [{{name: r, at: [0, 0], sensors: [{sensors}]}}]\n"
    )
    seen: list[Observation | None] = []
    with Simulation(world) as sim:
        for tick in range(TICKS):
            seen.append(sim.sense("r") if tick in asked else None)
            sim.apply("r", Command(0.4 if moving else 0.0))
            sim.step()
    return seen


@pytest.mark.parametrize(("rate_hz", "period"), [(25, 1), (12.5, 2), (5, 5), (2.5, 10)])
@pytest.mark.parametrize("latency", [0, 1, 7])
def test_readings_come_at_their_rate_and_so_many_ticks_after_their_stamp(rate_hz, period, latency):
    seen = observations(
        f"{{lidar: scan, beams: 3, rate_hz: {rate_hz}, latency: {latency}}},"
        f"{{beacons: ring, rate_hz: {rate_hz}, latency: {latency}}}"
    )
    for tick, each in enumerate(seen):
        assert each is not None
        told = tick >= latency and (tick - latency) % period == 0
        assert (set(each.scans) == {"scan"}) == told == (len(each.sightings) == 1)
        if told:
            assert each.scans["scan"].stamp == each.sightings[0].stamp == (tick - latency) * 0.04


def test_a_late_reading_is_of_the_place_where_it_was_taken():
    keys = "noise: {range: 0.05}, rate_hz: 5"
    now = observations(f"{{lidar: scan, {keys}}}")
    late = observations(f"{{lidar: scan, {keys}, latency: 4}}")
    for tick in range(0, TICKS - 4, 5):
        taken, told = now[tick], late[tick + 4]
        assert taken is not None
        assert told is not None
        np.testing.assert_array_equal(taken.scans["scan"].ranges, told.scans["scan"].ranges)


@pytest.mark.parametrize("latency", [0, 4])
def test_a_reading_is_the_same_whether_those_before_it_were_asked_for_or_not(latency):
    noise = "noise: {range: 0.05}, missed: 0.1, mixed_pixels: 0.5"
    sensors = f"{{lidar: scan, {noise}, latency: {latency}}}, {{beacons: ring, noise: {{range: 0.1}}, missed: 0.2,"
    sensors += f"false_rate: 5, outliers: 0.2, latency: {latency}}}, {{lidar: other, noise: {{range: 0.01}}}}"
    always = observations(sensors)
    seldom = observations(sensors, asked=range(0, TICKS, 3))
    for each, same in zip(always, seldom, strict=True):
        if same is None:
            continue
        assert each is not None
        for name, scan in each.scans.items():
            np.testing.assert_array_equal(scan.ranges, same.scans[name].ranges)
        pairs = [[(s.range, s.bearing, s.stamp) for s in one.sightings] for one in (each, same)]
        assert pairs[0] == pairs[1]


def test_a_rate_that_does_not_divide_the_ticks_is_refused_with_the_nearest_that_does():
    with pytest.raises(UsageError, match=r"it must divide the loop's 25, the nearest is 8\.33333"):
        ticks_between(25.0, 9.0)
    for kind in ("lidar", "beacons", "camera"):
        with pytest.raises(WorldError, match="rate_hz is 10 Hz") as caught:
            parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{{{kind}: s, rate_hz: 10}}]}}]\n")
        assert "12.5" in str(caught.value) or "8.33" in str(caught.value)
