"""Scans of a lidar, held to ranges that shapely finds in the plan of the world."""

import math

import numpy as np
import pytest
import shapely
from scipy import stats

from mjsim.geometry import Array, Pose
from mjsim.interface import Command, Scan
from mjsim.sim import Simulation
from mjsim.world import World, parse_world, preset_names, solid
from tests.sim.devices import taken

ROOM = """
mjsim: 1
walls:
  - points: [[0, 0], [8, 0], [8, 6], [0, 6]]
    closed: true
    thickness: 0.1
    openings:
      - {segment: 0, at: 2.0, width: 0.9}
      - {segment: 1, at: 2.0, width: 1.5, sill: 0.2, head: 1.2}
      - {segment: 2, at: 3.0, width: 1.5, sill: 0.6, head: 1.2}
  - {points: [[3, 6], [3.5, 3.2]], thickness: 0.2}
obstacles:
  - {box: [0.8, 0.5, 1.1], at: [6, 4.5], heading_deg: 30}
  - {box: [3, 3, 0.1], at: [5, 2]}
  - {cylinder: [0.25, 1.0], at: [5, 1.2]}
"""
PILLAR = shapely.Point(5, 1.2).buffer(0.25, quad_segs=1000)


def robot(keys: str = "", *, at: tuple[float, float] = (1.5, 2.0), heading_deg: float = 0.0, name: str = "r") -> str:
    """Return a robot with a lidar 'scan' of given keys."""
    lidar = f"{{lidar: scan, {keys}}}" if keys else "{lidar: scan}"
    return f"  - {{name: {name}, at: [{at[0]}, {at[1]}], heading_deg: {heading_deg}, sensors: [{lidar}]}}\n"


def scan_in(world: World, name: str = "r", **keys: int) -> Scan:
    with Simulation(world, **keys) as sim:
        return sim.sense(name).scans["scan"]


def ranges_in_plan(world: World, sensor: Pose, angles: Array, *, height: float, reach: float) -> Array:
    """Return how far shapely's rays go from a sensor before they meet anything of the plan [m]."""
    # A round outline of the plan has 64 corners; a lidar tells the difference.
    plan, start = shapely.union(solid(world, height=height), PILLAR), np.array([sensor.x, sensor.y])
    ends = start + reach * np.stack([np.cos(sensor.heading + angles), np.sin(sensor.heading + angles)], axis=-1)
    met = shapely.intersection(shapely.linestrings([[start, end] for end in ends]), plan)
    return np.where(shapely.is_empty(met), np.inf, shapely.distance(met, shapely.Point(start)))


@pytest.mark.parametrize(("at", "heading_deg"), [((1.5, 2.0), 0.0), ((4.4, 3.0), 130.0), ((7.0, 1.0), -77.0)])
def test_a_scan_is_what_shapely_measures_in_the_plan(at, heading_deg):
    keys = "at: [0.12, -0.05, 0.4], yaw_deg: 20, beams: 181, fov_deg: 270, range: [0.05, 7]"
    world = parse_world(ROOM + "robots:\n" + robot(keys, at=at, heading_deg=heading_deg))
    scan = scan_in(world)
    assert scan.angle_min == pytest.approx(-math.radians(135))
    assert scan.angles()[-1] == pytest.approx(math.radians(135))
    sensor = Pose(*at, math.radians(heading_deg)) @ Pose(0.12, -0.05, math.radians(20))
    expected = ranges_in_plan(world, sensor, scan.angles(), height=0.4, reach=7.0)
    assert 0 < np.isinf(expected).sum() < 120
    np.testing.assert_array_equal(np.isinf(scan.ranges), np.isinf(expected))
    # The robot stands on its wheels to within a tenth of a millimetre.
    met = np.isfinite(expected)
    np.testing.assert_allclose(scan.ranges[met], expected[met], atol=5e-4)
    points = shapely.points(sensor.transform(scan.points()))
    assert shapely.distance(points, solid(world, height=0.4)).max() < 2e-3


def test_all_around_the_first_beam_looks_back_and_none_comes_twice():
    world = parse_world(ROOM + "robots:\n" + robot("beams: 8, fov_deg: 360"))
    assert scan_in(world).angles() == pytest.approx(np.radians([-180, -135, -90, -45, 0, 45, 90, 135]))


def test_a_robot_alone_meets_nothing_of_itself_whatever_it_carries():
    sensors = (
        "{lidar: low, at: [0, 0, 0.05]}, {lidar: in, at: [0.3, 0, 0.1], fov_deg: 360}, {camera: c, at: [0.1, 0, 1]}"
    )
    sensors += ", {lidar: high, at: [-0.1, 0, 0.8], fov_deg: 360}, {beacons: b, at: [0.2, 0, 0.1]}"
    world = parse_world(f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], sensors: [{sensors}]}}]")
    with Simulation(world) as sim:
        for _ in range(3):
            scans = sim.sense("r").scans
            assert all(np.isposinf(scan.ranges).all() for scan in scans.values())
            for _ in range(2):
                sim.apply("r", Command(0.5, turn=1.0))
                sim.step()


def test_another_robot_is_seen_where_it_is_and_where_it_has_gone():
    world = parse_world(
        "mjsim: 1\nrobots:\n"
        + robot("beams: 3, fov_deg: 90, at: [0, 0, 0.2]", at=(0, 0))
        + "  - {name: other, at: [2, 0], heading_deg: 0, body: {radius: 0.3, height: 0.4}}\n"
    )
    with Simulation(world) as sim:
        for _ in range(40):
            scan = sim.sense("r").scans.get("scan")
            if scan is not None:
                gone = sim.truth("r").inverse() @ sim.truth("other")
                assert scan.ranges[1] == pytest.approx(gone.x - 0.3, abs=2e-3)
            sim.apply("other", Command(0.5))
            sim.step()
        assert gone.x > 2.4


def test_what_is_too_far_is_plus_and_what_is_too_near_is_minus_infinity():
    walls = "walls: [{points: [[2, -5], [2, 5]], thickness: 0.1}]\n"
    for reach, expected in (("[0.1, 1.9]", np.inf), ("[0.1, 1.96]", 1.95), ("[1.96, 3]", -np.inf)):
        keys = f"beams: 3, fov_deg: 2, range: {reach}, at: [0, 0, 0.3]"
        world = parse_world(f"mjsim: 1\n{walls}robots:\n{robot(keys, at=(0, 0))}")
        scan = scan_in(world)
        assert (scan.range_min, scan.range_max) == world.robots[0].sensors[0].range
        assert scan.ranges[1] == pytest.approx(expected, abs=1e-4)


def many(keys: str, count: int = 60) -> tuple[Array, list[Scan]]:
    """Return exact ranges of one place, shape (beams,), and as many scans there of a lidar with given keys."""
    common = "beams: 400, fov_deg: 350, rate_hz: 25, at: [0, 0, 0.3], range: [0.05, 20]"
    exact = scan_in(parse_world(ROOM + "robots:\n" + robot(common))).ranges
    with Simulation(parse_world(ROOM + "robots:\n" + robot(f"{common}, {keys}"))) as sim:
        scans = []
        for _ in range(count):
            scans.append(sim.sense("r").scans["scan"])
            sim.step()
    return exact, scans


def test_the_noise_of_ranges_is_as_its_data_sheet_says():
    exact, scans = many("noise: {range: 0.02}")
    met = np.isfinite(exact)
    errors = np.array([scan.ranges[met] for scan in scans]) - exact[met]
    # 60 scans of some 380 beams: the standard deviation is known to 1/sqrt(2 n) = 0.5 %; 4 of them are allowed.
    assert errors.std() == pytest.approx(0.02, rel=0.02)
    assert abs(errors.mean()) < 4 * 0.02 / math.sqrt(errors.size) + 1e-5
    neighbours = np.corrcoef(errors[:, 0], errors[:, 1])[0, 1], np.corrcoef(errors[0], errors[1])[0, 1]
    assert max(map(abs, neighbours)) < 0.5


def test_missed_returns_are_as_many_as_asked_for_and_read_as_nothing_there():
    exact, scans = many("missed: 0.1")
    met = np.isfinite(exact)
    ranges = np.array([scan.ranges[met] for scan in scans])
    share = np.isposinf(ranges).mean()
    assert share == pytest.approx(0.1, abs=4 * math.sqrt(0.09 / ranges.size))
    np.testing.assert_allclose(
        ranges[np.isfinite(ranges)], np.tile(exact[met], (60, 1))[np.isfinite(ranges)], atol=1e-4
    )


def test_mixed_pixels_lie_between_the_two_surfaces_of_an_edge_and_nowhere_else():
    exact, scans = many("mixed_pixels: 0.5, spot_deg: 2.0")
    ranges = np.array([scan.ranges for scan in scans])
    with np.errstate(invalid="ignore"):
        changed = np.abs(ranges - exact) > 1e-3
    edges = np.flatnonzero(changed.any(axis=0))
    assert 4 <= len(edges) <= 60
    for beam in edges:
        # The spot covers one beam's step to either side.
        around = exact[max(beam - 2, 0) : beam + 3]
        near, far = around[np.isfinite(around)].min(), around[np.isfinite(around)].max()
        assert ((ranges[:, beam] >= near - 0.05) & (ranges[:, beam] <= far + 0.05)).all()
        assert 0.2 < changed[:, beam].mean() < 0.8


def test_a_mixed_pixel_is_as_often_as_asked_for_anywhere_between_the_two_surfaces():
    walls = "walls: [{points: [[2, -5], [2, 0]], thickness: 0.1}, {points: [[5, -9], [5, 9]], thickness: 0.1}]\n"
    keys = "beams: 3, fov_deg: 20, spot_deg: 5, mixed_pixels: 0.2"
    with Simulation(parse_world(f"mjsim: 1\n{walls}robots:\n{robot(keys, at=(0, 0))}")) as sim:
        ranges = np.array([scan.ranges for scan in taken(sim, 500)])
    middle, off = ranges[:, 1], math.cos(math.radians(2.5))
    mixed = middle[(np.abs(middle - 1.95) > 1e-3) & (np.abs(middle - 4.95) > 1e-3)]
    assert len(mixed) == pytest.approx(100, abs=4 * math.sqrt(500 * 0.16))
    assert stats.kstest(mixed, stats.uniform(1.95 / off, 3 / off).cdf).pvalue > 1e-3
    assert np.ptp(ranges[:, [0, 2]], axis=0).max() == 0.0


def test_intensity_is_brightness_times_the_cosine_at_which_a_surface_is_met():
    wall = "walls: [{points: [[2, -5], [2, 5]], color: '#808080'}]\n"
    world = parse_world(f"mjsim: 1\n{wall}robots:\n{robot('beams: 5, fov_deg: 120, intensity: true', at=(0, 0))}")
    scan = scan_in(world)
    assert scan.intensities is not None
    assert scan.intensities == pytest.approx(128 / 255 * np.cos(np.radians([-60, -30, 0, 30, 60])), rel=1e-3)
    assert scan_in(parse_world(ROOM + "robots:\n" + robot())).intensities is None
    for keys in ("range: [0.05, 2.5]", "range: [2.2, 9]", "missed: 0.5"):
        text = f"mjsim: 1\n{wall}robots:\n{robot(f'beams: 61, fov_deg: 120, intensity: true, {keys}', at=(0, 0))}"
        scan = scan_in(parse_world(text))
        gone = ~np.isfinite(scan.ranges)
        assert 0 < gone.sum() < 61
        np.testing.assert_array_equal(scan.intensities == 0.0, gone)


@pytest.mark.parametrize(("color", "brightness"), [("'#ff0000'", 0.2126), ("'#00ff00'", 0.7152), ("'#0000ff'", 0.0722)])
@pytest.mark.parametrize(
    "keys",
    [
        "lidar: s, beams: 3, fov_deg: 2, intensity: true",
        "lidar3d: s, elevation_deg: [-2, 0, 2], rings: 3, columns: 3, fov_deg: 2",
    ],
)
def test_the_brightness_of_a_colour_is_that_of_the_standard_for_television(color, brightness, keys):
    wall = f"walls: [{{points: [[2, -5], [2, 5]], color: {color}, height: 3}}]"
    world = parse_world(f"mjsim: 1\n{wall}\nrobots: [{{name: r, at: [0, 0], sensors: [{{{keys}}}]}}]\n")
    with Simulation(world) as sim:
        seen = sim.sense("r")
    strengths = next(each.intensities for each in (*seen.scans.values(), *seen.clouds.values()))
    assert strengths.max() == pytest.approx(brightness, rel=1e-4)  # ITU-R BT.709


@pytest.mark.slow
def test_no_robot_that_can_be_bought_is_met_by_its_own_beams_or_its_own_ring():
    sensors = "{lidar: low, at: [0, 0, 0.04], fov_deg: 360}, {lidar: high, at: [0.05, 0, 0.5], fov_deg: 360}"
    robots = "".join(
        f"  - {{name: {name}, preset: {name}, at: [{50 * k}, 0], sensors: [{sensors}]}}\n"
        for k, name in enumerate(preset_names())
    )
    with Simulation(parse_world(f"mjsim: 1\nrobots:\n{robots}")) as sim:
        for _ in range(3):
            for name in sim.robots:
                seen = sim.sense(name)
                assert np.isposinf(seen.proximity).all(), name
                assert all(np.isposinf(scan.ranges).all() for scan in seen.scans.values()), name
                sim.apply(name, Command(0.2, turn=0.3 if name != "f1tenth" else 0.05))
            sim.step()
            sim.step()


def test_doors_stop_beams_where_they_stand_and_movers_where_they_have_gone():
    world = parse_world(
        "mjsim: 1\n"
        "walls: [{points: [[2, -3], [2, 3]], openings: [{name: gate, segment: 0, at: 2.5, width: 1.0, door: {}}]}]\n"
        "obstacles: [{name: cart, cylinder: [0.2, 1], at: [-2, 0], path: {points: [[-2, 0], [-4, 0]], speed: 0.5}}]\n"
        "robots:\n" + robot("beams: 4, fov_deg: 360, rate_hz: 25", at=(0, 0))
    )
    with Simulation(world) as sim:
        shut = sim.sense("r").scans["scan"].ranges
        assert shut[2] == pytest.approx(2.0, abs=0.06)
        assert shut[0] == pytest.approx(1.8, abs=0.01)
        sim.open_door("gate")
        for _ in range(75):
            sim.step()
        opened = sim.sense("r").scans["scan"].ranges
        assert np.isposinf(opened[2])
        cart = sim.things()["obstacle/cart"]
        assert cart.x < -3
        assert opened[0] == pytest.approx(-cart.x - 0.2, abs=0.01)
