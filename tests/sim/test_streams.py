"""Each source of chance has its own stream: what is added leaves all other noise byte for byte as it was."""

import numpy as np

from mjsim.interface import Command, Observation
from mjsim.sim import Simulation, stream
from mjsim.sim.streams import streams_of
from mjsim.world import parse_world

SCAN = "{lidar: scan, beams: 40, noise: {range: 0.02}, missed: 0.1, mixed_pixels: 0.3}"
RING = "{beacons: ring, noise: {range: 0.1, bearing_deg: 2}, missed: 0.2, false_rate: 3, outliers: 0.1}"
MORE = "{lidar: aux, noise: {range: 0.5}, rate_hz: 25}, {beacons: more, noise: {range: 1}, rate_hz: 25}"
NOISY = "drive: {noise: {speed: 0.02, turn: 0.02}}, odometry: {noise: {distance: 0.02, turn: 0.02}}"


def readings(sensors: str, *, others: str = "", seed: int = 3) -> tuple[list[Observation], list[bytes]]:
    """Return what a robot senses in a short drive of given sensors and other robots far away, and where it is."""
    world = parse_world(
        f"mjsim: 1\nwalls: [{{points: [[-3, -3], [3, -3], [3, 3], [-3, 3]], closed: true}}]\n"
        f"beacons: [{{name: a, at: [2, 1]}}, {{name: b, at: [-2, 1]}}]\n"
        f"robots: [{{name: r, at: [0, 0], {NOISY}, sensors: [{sensors}]}}{others}]\n"
    )
    seen, places = [], []
    with Simulation(world, seed=seed) as sim:
        for _ in range(30):
            for name in sim.robots:
                sim.sense(name)
                sim.apply(name, Command(0.3, turn=0.2))
            seen.append(sim.sense("r"))
            places.append(np.array([sim.truth("r").x, sim.truth("r").y, sim.truth("r").heading]).tobytes())
            sim.step()
    return seen, places


def texts(seen: list[Observation], scan: str = "scan", *, of_ring: int | None = None) -> list[bytes]:
    """Return the bytes of every noisy number: of a scan, the sightings and odometry of each tick."""
    rows = []
    for each in seen:
        numbers = [each.odometry.forward, each.odometry.left, each.odometry.turn]
        numbers += [value for s in each.sightings[:of_ring] for value in (s.range, s.bearing)]
        scans = each.scans[scan].ranges.tobytes() if scan in each.scans else b""
        rows.append(np.array(numbers).tobytes() + scans)
    return rows


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others():
    first, second, other = (texts(readings(f"{SCAN}, {RING}", seed=seed)[0]) for seed in (3, 3, 4))
    assert first == second
    assert all(a != b for a, b in zip(first[1:], other[1:], strict=True))


def test_adding_a_sensor_leaves_the_noise_of_all_others_byte_for_byte():
    alone, places = readings(f"{SCAN}, {RING}")
    # Those of the sensors that were there come first.
    counts = [len(each.sightings) for each in alone]
    more, same_places = readings(f"{SCAN}, {RING}, {MORE}")
    assert places == same_places
    for each, other, count in zip(alone, more, counts, strict=True):
        assert texts([each]) == texts([other], of_ring=count)
        assert "aux" in other.scans


def test_adding_a_robot_leaves_the_noise_of_all_others_byte_for_byte():
    other = f", {{name: other, at: [20, 0], {NOISY}, sensors: [{SCAN}, {RING}]}}"
    assert texts(readings(f"{SCAN}, {RING}")[0]) == texts(readings(f"{SCAN}, {RING}", others=other)[0])


def test_one_option_of_a_sensor_leaves_the_chance_of_its_others_as_it_was():
    plain = readings("{lidar: scan, noise: {range: 0.02}}")[0]
    optional = readings("{lidar: scan, noise: {range: 0.02}, missed: 0.2}")[0]
    pairs = [(a.scans["scan"].ranges, b.scans["scan"].ranges) for a, b in zip(plain, optional, strict=True) if a.scans]
    came = [np.isfinite(one) & np.isfinite(other) for one, other in pairs]
    assert all((one[both] == other[both]).all() for (one, other), both in zip(pairs, came, strict=True))
    assert 0.7 < np.mean(came) < 0.9


def test_a_stream_is_seeded_by_its_name_and_no_two_purposes_share_one():
    expected = np.random.default_rng([7, *b"scout/scan/range"]).random(4)
    np.testing.assert_array_equal(stream(7, "scout", "scan/range").random(4), expected)
    np.testing.assert_array_equal(streams_of(7, "scout", "scan")("range").random(4), expected)
    assert not np.isin(expected, stream(7, "scout", "scan/missed").random(4)).any()
