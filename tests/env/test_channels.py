"""The arrays of observations and actions, each from one observation made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely

from mjsim.env.actions import Actions
from mjsim.env.channels import channels_of
from mjsim.env.episodes import Starts
from mjsim.errors import UsageError
from mjsim.geometry import Pose
from mjsim.interface import Command, Estimate, Odometry, Sighting, WheelCommand
from mjsim.run import Noticed
from mjsim.sim import Simulation
from mjsim.world import parse_world, solid

WORLD = """
mjsim: 1
beacons: [{name: a, at: [3, 0]}, {name: b, at: [0, 3]}]
robots:
  - name: r
    at: [0, 0]
    drive: {type: differential, max_speed: 0.8, max_turn_deg: 90}
    proximity_range: 1.5
    sensors: [{beacons: ring, at: [0.3, 0.4, 0.2], range: [0.1, 5], noise: {range: 0.1}, anonymous: %s}]
"""
NOISE, ORIGIN = np.eye(2), Pose(0.0, 0.0, 0.0)


def told(names, *, anonymous="false", pose=ORIGIN, **seen):
    """Return the channels of a robot after an observation with these readings."""
    world = parse_world(WORLD % anonymous)
    with Simulation(world) as sim:
        info, here = sim.robots["r"], sim.sense("r")
    channels = channels_of(world.robots[0], info, world, names)
    for channel in channels.values():
        channel.update(Noticed(replace(here, **seen), Estimate(pose, np.eye(3)), ()))
    return channels


def test_odometry_is_forward_left_and_turn_within_four_times_what_the_drive_can_do_in_a_tick():
    (channel,) = told(["odometry"], odometry=Odometry(0.01, -0.02, 0.03, np.eye(3))).values()
    np.testing.assert_allclose(channel.value(), [0.01, -0.02, 0.03], rtol=1e-6)
    np.testing.assert_allclose(channel.high, 4 * 0.04 * np.array([0.8, 0.8, math.pi / 2]), rtol=1e-6)
    np.testing.assert_array_equal(channel.low, -channel.high)
    (far,) = told(["odometry"], odometry=Odometry(9.0, -9.0, 9.0, np.eye(3))).values()
    np.testing.assert_array_equal(far.value(), channel.high * [1, -1, 1])


def test_the_ring_reads_its_range_where_nothing_is():
    (channel,) = told(["proximity"], proximity=np.array([0.2, np.inf, *[1.4] * 14])).values()
    np.testing.assert_allclose(channel.value(), [0.2, 1.5, *[1.4] * 14], rtol=1e-6)
    channel.start()
    np.testing.assert_array_equal(channel.value(), [1.5] * 16)


@pytest.mark.parametrize(
    ("bearing_deg", "sector"), [(0, 0), (11, 0), (12, 1), (90, 4), (180, 8), (-180, 8), (-90, 12), (-12, 15), (-11, 0)]
)
def test_a_bump_is_in_the_sector_around_its_bearing(bearing_deg, sector):
    (channel,) = told(["bump"], bump=(math.radians(bearing_deg),)).values()
    assert np.flatnonzero(channel.value()).tolist() == [sector]


def test_an_estimate_has_its_heading_within_half_a_turn():
    (channel,) = told(["estimate"], pose=Pose(-3.0, 4.0, math.radians(190))).values()
    np.testing.assert_allclose(channel.value(), [-3.0, 4.0, math.radians(-170)], rtol=1e-6)


def test_of_two_sightings_of_a_beacon_the_nearer_counts_and_nameless_ones_follow_the_beacons():
    seen = [
        Sighting(0.0, *each, NOISE) for each in (("b", 2.0, 0.3), ("b", 1.5, 0.4), ("b", 1.8, 0.5), (None, 1.0, -0.2))
    ]
    (channel,) = told(["sightings"], sightings=tuple(seen)).values()
    np.testing.assert_allclose(channel.value(), [[0, 0, 0], [1, 1.5, 0.4]], rtol=1e-6)
    (channel,) = told(["sightings"], anonymous="true", sightings=tuple(seen)).values()
    np.testing.assert_allclose(channel.value(), [[0, 0, 0], [1, 1.5, 0.4], [1, 1.0, -0.2], [0, 0, 0]], rtol=1e-6)
    # The farthest that a sensor sees, from the robot's origin, and six standard deviations.
    assert channel.high[0].tolist() == pytest.approx([1.0, 5 + 0.5 + 0.6, math.pi])
    np.testing.assert_array_equal(channel.low, np.tile([0.0, 0.0, np.float32(-math.pi)], (4, 1)))


@pytest.mark.parametrize(
    ("drive", "names"),
    [("type: differential", ("forward", "turn")), ("type: mecanum, track: 0.4", ("forward", "left", "turn"))],
)
def test_an_action_of_one_is_the_most_that_the_drive_can_do(drive, names):
    world = parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], drive: {{{drive}}}}}]\n")
    with Simulation(world) as sim:
        info = sim.robots["r"]
    most = {"forward": info.max_speed, "left": info.max_left, "turn": info.max_turn}
    twist = Actions(info, "twist")
    assert twist.names == names
    assert twist.largest.tolist() == [most[name] for name in names]
    shares = np.linspace(0.5, -0.25, len(names))
    expected = dict.fromkeys(most, 0.0) | {name: share * most[name] for name, share in zip(names, shares, strict=True)}
    assert twist.command(shares) == Command(**expected)
    wheels = Actions(info, "wheels")
    # Over all corners of what the drive can do, by least squares: each wheel's largest speed.
    corners = np.array(np.meshgrid(*[[-value, value] for value in most.values()])).reshape(3, -1)
    speeds = np.linalg.lstsq(info.twist_from_wheels, corners, rcond=None)[0]
    np.testing.assert_allclose(wheels.largest, np.abs(speeds).max(axis=1))
    assert wheels.command(np.ones(len(info.wheels))) == WheelCommand(tuple(wheels.largest.tolist()))
    for wrong in ([0.1], [math.nan] * len(names)):
        with pytest.raises(UsageError):
            twist.command(wrong)


ROOMS = """
mjsim: 1
walls:
  - points: [[0, 0], [6, 0], [6, 4], [0, 4]]
    closed: true
  - {points: [[4, 0], [4, 4]], openings: [{at: 2, width: 1, door: {}}]}
obstacles: [{box: [0.6, 0.6, 0.2], at: [2, 2]}, {box: [1, 1, 0.2], at: [1, 3], elevation: 1}]
robots: [{name: r, at: [1, 1], body: {radius: 0.2, height: 0.4}}]
"""


def test_random_starts_are_anywhere_that_is_free_and_nowhere_else():
    world = parse_world(ROOMS)
    starts, rng = Starts(world, world.robots[0]), np.random.default_rng(4)
    poses = [starts.draw(rng, [(5.0, 1.0, 0.3)]) for _ in range(150)]
    places = shapely.points([(pose.x, pose.y) for pose in poses])
    # Five centimetres around a body of 0.2 m.
    assert shapely.distance(places, solid(world, height=0.1)).min() >= 0.25 - 2e-3
    assert min(math.hypot(pose.x - 5.0, pose.y - 1.0) for pose in poses) > 0.25 + 0.3
    # Both rooms, below the shelf, but not in the doorway, where its leaf may turn.
    for corner in (shapely.box(0, 0, 2, 1.6), shapely.box(4, 2, 6, 4), shapely.box(0.5, 2.5, 1.5, 3.5)):
        assert shapely.contains(corner, places).any()
    assert not shapely.contains(shapely.box(3.8, 1.7, 4.2, 2.3), places).any()
    headings = np.array([pose.heading for pose in poses])
    assert np.ptp(headings) > 0.9 * math.tau
    assert np.abs(headings).max() <= math.pi
