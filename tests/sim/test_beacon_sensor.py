"""Sightings of the beacon sensor, held to where beacons hang by the world file."""

import math
from collections.abc import Sequence
from types import SimpleNamespace

import numpy as np
import pytest

from mjsim.geometry import Pose, wrap_angle
from mjsim.interface import Sighting
from mjsim.sim import Simulation
from mjsim.sim.sensors.beacons import BeaconDevice
from mjsim.world import parse_world
from tests.sim.devices import taken

BEACONS = """
mjsim: 1
beacons:
  - {name: ahead, at: [3, 0]}
  - {name: left, at: [1, 2]}
  - {name: behind, at: [-2, -1]}
  - {name: far, at: [0, -9]}
"""
ORIGIN = Pose(0, 0, 0)


def looks(keys: str, world: str = BEACONS, *, pose: Pose = ORIGIN, count: int = 1) -> list[tuple[Sighting, ...]]:
    """Return the sightings of a robot that stands still, one tuple a look."""
    heading = math.degrees(pose.heading)
    robot = f"{{name: r, at: [{pose.x}, {pose.y}], heading_deg: {heading}, sensors: [{{beacons: ring, {keys}}}]}}"
    with Simulation(parse_world(f"{world}robots: [{robot}]\nrun: {{rate_hz: 250}}\n")) as sim:
        if count == 1:
            return [sim.sense("r").sightings]
        return [reading.sightings for reading in taken(sim, count)]


def named(sightings: Sequence[Sighting]) -> dict[str | None, Sighting]:
    return {sighting.name: sighting for sighting in sightings}


@pytest.mark.parametrize("pose", [Pose(0, 0, 0), Pose(0.5, -1, 2.5), Pose(-1, 1, -1.2)])
def test_without_noise_range_and_bearing_are_those_of_the_world_from_the_robots_origin(pose):
    world = parse_world(BEACONS)
    seen = named(looks("at: [0.2, -0.1, 0.4], yaw_deg: 50, range: [0.1, 6]", pose=pose)[0])
    assert set(seen) == {"ahead", "left", "behind"}
    for beacon in world.beacons[:3]:
        x, y = pose.inverse().transform(beacon.at)
        # A robot stands on its wheels to within a tenth of a millimetre.
        assert seen[beacon.name].range == pytest.approx(math.hypot(x, y), abs=2e-4)
        assert abs(wrap_angle(seen[beacon.name].bearing - math.atan2(y, x))) < 1e-4


def test_the_field_of_view_and_the_range_are_where_the_data_sheet_puts_them():
    # From the robot, `left` is at 63.43 degrees and `ahead` at 0.
    assert set(named(looks("fov_deg: 126, rate_hz: 250")[0])) == {"ahead"}
    assert set(named(looks("fov_deg: 128")[0])) == {"ahead", "left"}
    assert set(named(looks("fov_deg: 10, yaw_deg: 63.4")[0])) == {"left"}
    assert set(named(looks("range: [0.1, 2.99]")[0])) == {"left", "behind"}
    assert set(named(looks("range: [2.99, 20]")[0])) == {"ahead", "far"}


def test_walls_and_things_hide_a_beacon_up_to_their_edge_and_their_height():
    def seen(thing: str) -> bool:
        return "ahead" in named(looks("at: [0, 0, 1.2]", f"{BEACONS}{thing}\n")[0])

    wall = "walls: [{{points: [[1.5, {}], [1.5, 5]], thickness: 0.1, height: {}}}]"
    assert not seen(wall.format(-0.02, 2))
    assert seen(wall.format(0.02, 2))
    assert seen(wall.format(-5, 1.18))
    assert not seen(wall.format(-5, 1.22))
    assert not seen("obstacles: [{cylinder: [0.1, 1.5], at: [2, 0.08]}]")
    assert seen("obstacles: [{cylinder: [0.1, 1.5], at: [2, 0.12]}]")
    assert seen("obstacles: [{box: [0.2, 0.2, 0.2], at: [2, 0], elevation: 1.3}]")


def test_a_beacon_that_hangs_on_a_wall_is_seen_from_its_front_and_a_reflector_from_all_sides():
    wall = "mjsim: 1\nwalls: [{points: [[3, -2], [3, 2]], thickness: 0.2}]\n"
    for beacon, front, back in (
        ("image: posters/lion.jpg, at: [2.89, 0], heading_deg: 180", True, False),
        ("image: posters/lion.jpg, at: [3.11, 0], heading_deg: 0", False, True),
        ("image: posters/lion.jpg, at: [2.7, 0], heading_deg: 0", False, False),
        ("at: [2.89, 0], heading_deg: 180", True, False),
    ):
        world = f"{wall}beacons: [{{name: one, {beacon}}}]\n"
        assert bool(looks("range: [0.1, 9]", world)[0]) == front, beacon
        assert bool(looks("range: [0.1, 9]", world, pose=Pose(6, 0, 3.0))[0]) == back, beacon


def errors(seen: list[tuple[Sighting, ...]], name: str, pose: Pose = ORIGIN) -> np.ndarray:
    """Return how far sightings of one beacon are off, shape (n, 2) [m, rad]."""
    place = next(beacon.at for beacon in parse_world(BEACONS).beacons if beacon.name == name)
    x, y = pose.inverse().transform(place)
    truth = math.hypot(x, y), math.atan2(y, x)
    ours = [sighting for sightings in seen for sighting in sightings if sighting.name == name]
    return np.array([(s.range - truth[0], wrap_angle(s.bearing - truth[1])) for s in ours])


def test_noise_is_as_the_data_sheet_says_and_the_covariance_is_honest():
    keys = "at: [0.3, 0.2, 0.3], rate_hz: 250, noise: {range: 0.05, bearing_deg: 2}"
    seen = looks(keys, count=300)
    for name in ("ahead", "left"):
        off = errors(seen, name)
        covariance = next(s.covariance for s in seen[0] if s.name == name)
        nees = np.einsum("ij,jk,ik->i", off, np.linalg.inv(covariance), off)
        # The mean of n values of chi-square with 2 degrees of freedom is known to 2/sqrt(n) = 0.12; 4 of them.
        assert nees.mean() == pytest.approx(2.0, abs=0.46), name
    off = errors(looks("rate_hz: 250, noise: {range: 0.05, bearing_deg: 2}", count=300), "ahead")
    assert off.std(axis=0) == pytest.approx([0.05, math.radians(2)], rel=0.12)


def test_heavy_tails_keep_the_standard_deviation_and_throw_farther():
    keys = "rate_hz: 250, noise: {range: 0.05}"
    plain, odd = looks(keys, count=500), looks(f"{keys}, heavy_tails: 4", count=500)
    normal, heavy = (
        np.concatenate([errors(seen, name)[:, 0] for name in ("ahead", "left", "behind")]) for seen in (plain, odd)
    )
    assert heavy.std() == pytest.approx(0.05, rel=0.25)
    # Beyond 4 standard deviations: normal 6e-5, Student's t with 4 degrees of freedom 5e-3 of all (scipy.stats.t.sf).
    assert (np.abs(normal) > 0.2).mean() < 2e-3 < (np.abs(heavy) > 0.2).mean() < 1.2e-2


def test_missed_sightings_are_as_many_as_asked_for():
    seen = looks("rate_hz: 250, missed: 0.3", count=500)
    share = 1 - sum(len(sightings) for sightings in seen) / 1500
    assert share == pytest.approx(0.3, abs=4 * math.sqrt(0.21 / 1500))


def test_false_sightings_come_as_often_as_asked_for_and_fill_the_field_of_view_evenly():
    seen = looks("rate_hz: 250, false_rate: 125, fov_deg: 180, range: [1, 5]", "mjsim: 1\n", count=1500)
    counts = np.array([len(sightings) for sightings in seen])
    # Poisson: 0.5 a look, and its variance is its mean.
    assert counts.mean() == pytest.approx(0.5, abs=4 * math.sqrt(0.5 / 1500))
    assert counts.var() == pytest.approx(0.5, rel=0.2)
    polar = np.array([(s.range, s.bearing) for sightings in seen for s in sightings])
    assert all(s.name is None for sightings in seen for s in sightings)
    assert 1 <= polar[:, 0].min() < polar[:, 0].max() <= 5
    assert np.histogram(polar[:, 0], 4, (1, 5))[0] == pytest.approx(len(polar) / 4, rel=0.3)
    assert np.histogram(polar[:, 1], 4, (-math.pi / 2, math.pi / 2))[0] == pytest.approx(len(polar) / 4, rel=0.3)


def test_outliers_are_anywhere_in_the_field_of_view_under_the_beacons_own_name():
    off = errors(looks("rate_hz: 250, outliers: 0.2, range: [0.1, 8]", count=500), "ahead")
    astray = np.abs(off).max(axis=1) > 1e-3
    assert astray.mean() == pytest.approx(0.2, abs=4 * math.sqrt(0.16 / 500))
    assert off[astray, 0].min() < -2 < 4 < off[astray, 0].max()


def test_who_is_who_is_told_to_the_recording_and_never_to_the_modules():
    keys = "anonymous: true, noise: {range: 0.1, bearing_deg: 3}, false_rate: 200, rate_hz: 250, range: [0.1, 6]"
    robot = f"robots: [{{name: r, at: [0, 0], sensors: [{{beacons: ring, {keys}}}]}}]\n"
    with Simulation(parse_world(f"{BEACONS}{robot}run: {{rate_hz: 250}}\n")) as sim:
        for _ in range(100):
            seen, who = sim.sense("r").sightings, sim.identities("r")
            assert len(seen) == len(who)
            assert all(sighting.name is None for sighting in seen)
            assert set(who) - {None} == {"ahead", "left", "behind"}
            bearings = [sighting.bearing for sighting in seen]
            assert bearings == sorted(bearings)
            for sighting, name in zip(seen, who, strict=True):
                if name == "ahead":
                    assert (sighting.range, sighting.bearing) == pytest.approx((3.0, 0.0), abs=0.5)
            sim.step()


def test_another_robot_hides_a_beacon_while_it_is_in_the_way():
    world = BEACONS.replace("- {name: ahead, at: [3, 0]}", "- {name: ahead, at: [3, 0], center: 0.3}")
    other = "{name: other, at: [1.5, 0], body: {radius: 0.2, height: 0.5}}"
    robot = "{name: r, at: [0, 0], sensors: [{beacons: ring, rate_hz: 250, at: [0, 0, 0.3]}]}"
    with Simulation(parse_world(f"{world}robots: [{robot}, {other}]\nrun: {{rate_hz: 250}}\n")) as sim:
        assert "ahead" not in named(sim.sense("r").sightings)
        joint = sim.model.joint("other/free").qposadr[0]
        sim.data.qpos[joint + 1] = 0.6
        sim.step()
        assert "ahead" in named(sim.sense("r").sightings)


def test_a_bare_anchor_gives_a_beacon_sensor_nothing_and_the_catalogue_tells_which_beacons_are_anchors():
    world = """
mjsim: 1
beacons:
  - {name: bare, at: [2, 0], anchor: true}
  - {name: both, at: [2, 1], heading_deg: 180, anchor: true, marker: {id: 3}}
  - {name: plain, at: [2, -1]}
"""
    assert set(named(looks("range: [0.1, 6]", world)[0])) == {"both", "plain"}
    with Simulation(parse_world(world)) as sim:
        assert {name: info.anchor for name, info in sim.catalogue.items()} == {
            "bare": True,
            "both": True,
            "plain": False,
        }


def test_heavy_tails_have_the_deviation_of_the_data_sheet():
    text = "mjsim: 1\nbeacons: [{name: a, at: [2, 0]}]\nrobots: [{name: r, at: [0, 0], sensors: [%s]}]"
    keys = "{beacons: ring, heavy_tails: 6, noise: {range: 0.1, bearing_deg: 2}}"
    with Simulation(parse_world(text % keys)) as sim:
        device = BeaconDevice(sim.world.robots[0].sensors[0], _mounting(sim))
    errors = np.array([device._chances()[0][0] for _ in range(4000)])
    # The fourth moment of Student's t with 6 degrees of freedom is 6: its deviation errs by sqrt((6 - 1) / 4n).
    np.testing.assert_allclose(errors.std(axis=0), [0.1, np.radians(2.0)], rtol=4 * np.sqrt(5 / 16000))


def _mounting(sim):
    streams = {}

    def stream(purpose):
        return streams.setdefault(purpose, np.random.default_rng(len(streams)))

    return SimpleNamespace(
        model=sim.model, data=sim.data, streams=stream, robot=sim.world.robots[0], beacons=sim.world.beacons
    )
