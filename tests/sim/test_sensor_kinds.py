"""What every kind of sensor does: its data sheet, its chance, and where it looks from on a robot that leans."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mjsim.sim import Simulation
from mjsim.sim.sensors.compass import SmoothField
from mjsim.world import parse_world
from tests.sim.devices import device_of, moved

COMMON = "at: [0.1, -0.2, 0.4], rate_hz: 5, latency: 2"
TURNED = f"{COMMON}, yaw_deg: 90"
SHEETS = {
    "lidar": (f"{TURNED}, pitch_deg: 30, fov_deg: 200, range: [0.2, 6], noise: {{range: 0.02}}", {"range": 0.02}),
    "lidar3d": (f"{TURNED}, fov_deg: 200, range: [0.2, 6], noise: {{range: 0.02}}", {"range": 0.02}),
    "rosette": (f"{COMMON}, rosette: {{fov_deg: 40}}, range: [0.2, 6]", {"range": 0.0}),
    "beacons": (
        f"{TURNED}, fov_deg: 200, range: [0.2, 6], noise: {{range: 0.1, bearing_deg: 3}}",
        {"range": 0.1, "bearing_deg": 3.0},
    ),
    "uwb": (f"{COMMON}, range: [0.2, 6], noise: {{range: 0.1}}, bias: 0.3", {"range": 0.1, "bias": 0.3}),
    "compass": (
        f"{COMMON}, noise: {{heading_deg: 2}}, bias: {{amplitude_deg: 5}}",
        {"heading": math.radians(2), "bias": math.radians(5)},
    ),
    "imu": (
        f"{TURNED}, noise: {{acceleration: 0.1, turn: 0.2}}, bias: {{acceleration: 0.3, turn: 0.4}},"
        " walk: {acceleration: 0.5, turn: 0.6}",
        dict(
            zip(
                ("acceleration", "turn", "acceleration_bias", "turn_bias", "acceleration_walk", "turn_walk"),
                (0.1, 0.2, 0.3, 0.4, 0.5, 0.6),
                strict=True,
            )
        ),
    ),
    "encoders": ("rate_hz: 5, latency: 2", {}),
}
FOVS = {"lidar": 200, "lidar3d": 200, "rosette": 40, "beacons": 200}
RANGED = {*FOVS, "uwb"}


@pytest.mark.parametrize("kind", SHEETS)
def test_the_data_sheet_has_the_mount_the_rate_the_bounds_and_the_noise_of_the_world(kind):
    keys, noise = SHEETS[kind]
    word = "lidar3d" if kind == "rosette" else kind
    text = f"mjsim: 1\nrobots: [{{name: r, at: [0, 0], odometry: {{ticks: 99}}, sensors: [{{{word}: s, {keys}}}]}}]\n"
    with Simulation(parse_world(text)) as sim:
        info = sim.robots["r"].sensors["s"]
    assert (info.kind, info.rate_hz, info.latency) == (word, 5.0, 2)
    assert dict(info.noise) == pytest.approx(noise)
    assert info.range == ((0.2, 6.0) if kind in RANGED else None)
    assert info.fov == (pytest.approx(math.radians(FOVS[kind])) if kind in FOVS else None)
    yaw, pitch = 90.0 * ("yaw_deg" in keys), 30.0 * ("pitch_deg" in keys)
    expected = np.eye(4)
    expected[:3, :3] = Rotation.from_euler("ZY", [yaw, -pitch], degrees=True).as_matrix()
    expected[:3, 3] = [0.1, -0.2, 0.4] if "at:" in keys else 0.0
    np.testing.assert_allclose(info.robot_from_sensor, expected, atol=1e-12)


NOISY = {
    "lidar": "lidar: s, beams: 180, noise: {range: 0.1}, missed: 0.3, mixed_pixels: 0.5, spot_deg: 5",
    "lidar3d": "lidar3d: s, rings: 2, columns: 20, rate_hz: 12.5, noise: {range: 0.1}, missed: 0.3",
    "beacons": "beacons: s, noise: {range: 0.1, bearing_deg: 2}, missed: 0.3, outliers: 0.3, false_rate: 30",
    "uwb": "uwb: s, noise: {range: 0.1}, missed: 0.2, nlos: {bias: 0.5, missed: 0.2}",
    "compass": "compass: s, noise: {heading_deg: 5}",
    "imu": "imu: s, noise: {acceleration: 0.1, turn: 0.1}, walk: {acceleration: 0.1, turn: 0.1}",
}
FURNISHED = """
mjsim: 1
walls: [{points: [[2, -4], [2, 0.3]]}]
beacons: [{name: near, at: [1.5, 0.5], anchor: true}, {name: far, at: [4, -1], anchor: true}]
"""


def numbers_of(reading) -> list[float]:
    """Return all numbers of a reading, however it holds them."""
    if isinstance(reading, np.ndarray | float | int):
        return np.ravel(reading).astype(float).tolist()
    if isinstance(reading, dict):
        reading = list(reading.values())
    if isinstance(reading, tuple | list):
        return [number for each in reading for number in numbers_of(each)]
    slots = [name for name in getattr(reading, "__slots__", ()) if name != "stamp"]
    return [number for name in slots for number in numbers_of(getattr(reading, name))]


@pytest.mark.parametrize("kind", NOISY)
def test_a_reading_that_nobody_asks_for_takes_as_much_chance_as_one_that_is_taken(kind):
    robots = f"robots: [{{name: r, at: [0, 0], sensors: [{{{NOISY[kind]}}}]}}]\nrun: {{rate_hz: 250}}\n"
    with Simulation(parse_world(FURNISHED + robots)) as sim:
        asked, unasked = device_of(sim), device_of(sim)
        for number in range(4):
            for device in (asked, unasked):
                for _ in range(20 if hasattr(device, "after_step") else 0):
                    device.after_step()
            if number < 3:
                asked.take(0.08 * number)
                unasked.pass_over()
        told = [numbers_of(device.take(0.24)) for device in (asked, unasked)]
    assert len(told[0]) > 0
    np.testing.assert_array_equal(*told)


def test_on_a_robot_that_leans_a_beacon_has_the_bearing_that_it_has_in_the_frame_of_the_robot():
    place = (1.0, 2.0, 1.4)
    beacon = "beacons: [{name: b, at: [1, 2], center: 1.4}]"
    robot = "{name: r, at: [0, 0], sensors: [{beacons: s, at: [0.3, -0.1, 0.5], yaw_deg: 50}]}"
    lean = Rotation.from_euler("zyx", [0.4, 0.2, -0.3])
    with Simulation(parse_world(f"mjsim: 1\n{beacon}\nrobots: [{robot}]\n")) as sim:
        moved(sim, rotation=lean, velocity=np.zeros(3), turn=np.zeros(3))
        sim._refresh()
        (seen,) = device_of(sim).take(0.0).sightings
        x, y, _ = lean.inv().apply(np.array(place) - sim.data.body("r/base").xpos)
    assert (seen.range, seen.bearing) == pytest.approx((math.hypot(x, y), math.atan2(y, x)), abs=1e-9)


def test_the_covariance_of_a_sighting_is_the_noise_of_the_sensor_seen_from_the_robots_origin():
    robot = "{name: r, at: [0, 0], sensors: [{beacons: s, at: [0.3, -0.4, 0.3], yaw_deg: 50, noise: %s}]}"
    text = f"mjsim: 1\nbeacons: [{{name: b, at: [1, 2]}}]\nrobots: [{robot}]\n"
    with Simulation(parse_world(text % "{range: 0.05, bearing_deg: 2}")) as sim:
        (seen,) = sim.sense("r").sightings
    away = np.array([1 - 0.3, 2 + 0.4])
    r, b = math.hypot(*away), math.atan2(away[1], away[0])

    def from_origin(distance: float, bearing: float) -> np.ndarray:
        x, y = 0.3 + distance * math.cos(bearing), -0.4 + distance * math.sin(bearing)
        return np.array([math.hypot(x, y), math.atan2(y, x)])

    step = 1e-6
    slopes = [
        (from_origin(r + step, b) - from_origin(r - step, b)) / (2 * step),
        (from_origin(r, b + step) - from_origin(r, b - step)) / (2 * step),
    ]
    J = np.stack(slopes, axis=1)
    # The sighting itself errs by the noise, and the slopes with it.
    np.testing.assert_allclose(seen.covariance, J @ np.diag([0.05**2, math.radians(2) ** 2]) @ J.T, rtol=0.15)
    with Simulation(parse_world(text % "{}")) as sim:
        (exact,) = sim.sense("r").sightings
    # A sheet names no deviation below a millimetre and 0.1 mrad.
    np.testing.assert_allclose(exact.covariance, J @ np.diag([1e-6, 1e-8]) @ J.T, rtol=1e-3)


def test_a_robot_sees_neither_its_own_beacon_nor_one_that_was_taken_away():
    beacons = "beacons: [{name: own, at: [0.6, 0], on: r}, {name: one, at: [2, 1]}, {name: two, at: [2, -1]}]"
    robots = (
        "robots: [{name: r, at: [0, 0], sensors: [{beacons: s, at: [0, 0, 0.5], rate_hz: 25}]}, {name: q, at: [4, 0]}]"
    )
    with Simulation(parse_world(f"mjsim: 1\n{beacons}\n{robots}\n")) as sim:
        assert {each.name for each in sim.sense("r").sightings} == {"one", "two"}
        sim.remove("one")
        for _ in range(2):
            sim.step()
        assert {each.name for each in sim.sense("r").sightings} == {"two"}


@pytest.mark.parametrize(("inside", "is_seen"), [(0.003, True), (0.01, False)])
def test_what_a_beacon_hangs_on_may_stand_out_by_some_millimetres(inside, is_seen):
    wall = "walls: [{points: [[3, -2], [3, 2]], thickness: 0.2}]"
    at = f"at: [{2.9 + inside}, 0]"
    beacon = f"beacons: [{{name: b, {at}}}, {{name: a, {at}, anchor: true}}]"
    sensors = "[{beacons: s, at: [0, 0, 1]}, {uwb: t, at: [0, 0, 1], nlos: {missed: 1}}]"
    text = f"mjsim: 1\n{wall}\n{beacon}\nrobots: [{{name: r, at: [0, 0], sensors: {sensors}}}]\n"
    with Simulation(parse_world(text)) as sim:
        seen = sim.sense("r")
    assert [each.name for each in seen.sightings] == ["b"] * is_seen
    assert bool(seen.ranges["t"].ranges) == is_seen


def test_what_is_hidden_far_away_is_hidden_while_something_near_is_seen():
    beacons = "beacons: [{name: near, at: [1, 0.8], anchor: true}, {name: far, at: [4, 0], anchor: true}]"
    plain = "{name: close, at: [1, -0.8]}, {name: away, at: [4, 0.1]}"
    text = f"mjsim: 1\nwalls: [{{points: [[3, -1], [3, 1]], height: 3}}]\n{beacons[:-1]}, {plain}]\n"
    text += "robots: [{name: r, at: [0, 0], sensors: [{beacons: s}, {uwb: t, nlos: {missed: 1}}]}]\n"
    with Simulation(parse_world(text)) as sim:
        seen = sim.sense("r")
    assert {each.name for each in seen.sightings} == {"close"}
    assert set(seen.ranges["t"].ranges) == {"near"}


def test_readings_of_two_sensors_of_a_kind_come_together_and_so_do_the_names_of_what_they_saw():
    beacons = "beacons: [{name: ahead, at: [2, 0]}, {name: behind, at: [-2, 0]}]"
    sensors = "{beacons: a, fov_deg: 90}, {beacons: b, fov_deg: 90, yaw_deg: 180, anonymous: true}, {imu: c}, {imu: d}"
    with Simulation(
        parse_world(f"mjsim: 1\n{beacons}\nrobots: [{{name: r, at: [0, 0], sensors: [{sensors}]}}]\n")
    ) as sim:
        sim.step()
        sim.step()
        seen = sim.sense("r")
        assert [each.name for each in seen.sightings] == ["ahead", None]
        assert sim.identities("r") == ("ahead", "behind")
    assert {each.name for each in seen.imu} == {"c", "d"}


def test_a_compass_off_the_middle_of_its_robot_has_the_bias_of_its_own_place():
    bias = "bias: {amplitude_deg: 10, length: 0.3}"
    headings = []
    for place, heading_deg, at in (("[0, 0]", 0, "[0.5, 0.2, 0]"), ("[0.3, 0.5]", 90, "[-0.3, -0.2, 0]")):
        robot = f"{{name: r, at: {place}, heading_deg: {heading_deg}, sensors: [{{compass: c, at: {at}, {bias}}}]}}"
        with Simulation(parse_world(f"mjsim: 1\nrobots: [{robot}]\n")) as sim:
            headings.append(sim.sense("r").compasses["c"].heading - math.radians(heading_deg))
    # Both are at (0.5, 0.2).
    assert headings[0] == pytest.approx(headings[1], abs=1e-3)
    assert headings[0] == pytest.approx(math.radians(10) * SmoothField(0, 0.3).at(np.array([0.5, 0.2])), abs=1e-3)
