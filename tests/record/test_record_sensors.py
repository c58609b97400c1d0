"""What sensors told, and whom they saw, stands in the recording exactly."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from mjsim.interface import Command, Estimate, Observation, RobotInfo
from mjsim.record import Recording, export_csv, export_mat, export_npz
from mjsim.run import Driver, run
from mjsim.sim import Simulation
from mjsim.world import parse_world

WORLD = """
mjsim: 1
walls: [{points: [[-2, -2], [3, -2], [3, 2], [-2, 2]], closed: true, openings: [{segment: 1, at: 1, width: 1}]}]
beacons: [{name: a, at: [2.5, 1]}, {name: b, at: [-1, 1]}]
robots:
  - name: r
    at: [0, 0]
    sensors:
      - {lidar: front, beams: 40, noise: {range: 0.02}, range: [2.2, 10], intensity: true}
      - {lidar: rear, beams: 20, yaw_deg: 180, rate_hz: 5, latency: 2}
      - {beacons: ring, anonymous: true, noise: {range: 0.1, bearing_deg: 2}, false_rate: 5}
      - {imu: imu, noise: {turn: 0.01}}
      - {imu: slow, rate_hz: 62.5}
  - {name: blind, at: [1, 1]}
"""


class Keeper:
    """A navigator that keeps what it was given."""

    def __init__(self) -> None:
        self.seen: list[Observation] = []

    def start(self, robot: RobotInfo, map: object, rng: np.random.Generator) -> None:
        self.seen.clear()

    def command(self, seen: Observation, belief: Estimate) -> Command:
        self.seen.append(seen)
        return Command(0.3, turn=0.5)


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, list[Observation], list[tuple[str | None, ...]]]:
    keeper, path = Keeper(), tmp_path_factory.mktemp("sensors") / "run.mcap"
    who = []
    with Simulation(parse_world(WORLD)) as sim:
        drivers = {"r": Driver(navigator=keeper), "blind": Driver()}
        recording = run(sim, drivers=drivers, seconds=1.2, record=path, watch=lambda _: who.append(sim.identities("r")))
    return recording, keeper.seen, who


def test_every_number_of_scans_and_inertial_readings_reads_back_exactly(kept):
    recording, given, _ = kept
    for seen, read in zip(given, recording.observations("r"), strict=True):
        assert list(seen.scans) == list(read.scans)
        for scan, same in zip(seen.scans.values(), read.scans.values(), strict=True):
            for key in ("stamp", "angle_min", "angle_increment", "range_min", "range_max"):
                assert getattr(scan, key) == getattr(same, key)
            np.testing.assert_array_equal(scan.ranges, same.ranges)
            np.testing.assert_array_equal(scan.intensities, same.intensities)
        assert [(r.name, r.stamp) for r in seen.imu] == [(r.name, r.stamp) for r in read.imu]
        for reading, same_reading in zip(seen.imu, read.imu, strict=True):
            np.testing.assert_array_equal(reading.acceleration, same_reading.acceleration)
            np.testing.assert_array_equal(reading.turn, same_reading.turn)
    ranges = np.concatenate([scan.ranges for seen in given for scan in seen.scans.values()])
    assert np.isposinf(ranges).any()
    assert np.isneginf(ranges).any()
    assert not list(recording.observations("blind"))[5].scans


def test_whom_the_sensors_saw_stands_beside_what_they_told(kept):
    recording, given, who = kept
    track = recording.robots["r"]
    assert list(track.identities) == who
    assert {name for names in who for name in names} == {"a", "b", None}
    for seen, sightings, names in zip(given, track.sightings, track.identities, strict=True):
        assert len(seen.sightings) == len(sightings) == len(names)
    assert not any(recording.robots["blind"].identities)


def test_foxglove_gets_its_own_scans_with_a_frame_for_each_lidar(kept):
    recording, given, _ = kept
    scans = [(f"r/{name}", scan) for seen in given for name, scan in seen.scans.items()]
    # Strings and packed doubles stand in a message of Protocol Buffers as they are.
    for message, (name, scan) in zip(recording.messages("/r/scan"), scans, strict=True):
        assert name.encode() in message
        assert scan.ranges.tobytes() in message
    frames = next(recording.messages("/tf"))
    assert b"r/front" in frames
    assert b"r/rear" in frames


@pytest.mark.slow
def test_two_equal_runs_have_equal_readings_and_a_run_without_sensors_no_topic_of_them(kept, tmp_path: Path):
    recording, _, _ = kept
    with Simulation(parse_world(WORLD)) as sim:
        again = run(sim, drivers={"r": Driver(navigator=Keeper()), "blind": Driver()}, seconds=1.2)
    for topic in ("/r/observation", "/r/imu", "/r/scan", "/r/identities"):
        assert list(recording.messages(topic)) == list(again.messages(topic)) != []
    assert list(recording.messages("/blind/scan")) == list(recording.messages("/blind/imu")) == []
    assert math.isclose(recording.time[-1], 1.16)


def test_tables_and_arrays_hold_the_scans_and_the_inertial_readings(kept, tmp_path: Path):
    recording, given, _ = kept
    written = {path.name for path in export_csv(recording, tmp_path)}
    assert {"r_scan_front.csv", "r_scan_rear.csv", "r_imu_imu.csv", "r_imu_slow.csv"} <= written
    scans = [(seen.time, seen.scans["front"]) for seen in given if "front" in seen.scans]
    table = np.loadtxt(tmp_path / "r_scan_front.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table[:, 0], [time for time, _ in scans])
    np.testing.assert_array_equal(table[:, 4:], [scan.ranges for _, scan in scans])
    felt = [each for seen in given for each in seen.imu if each.name == "slow"]
    table = np.loadtxt(tmp_path / "r_imu_slow.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(table[:, 1:], [(each.stamp, *each.acceleration, *each.turn) for each in felt])
    with np.load(export_npz(recording, tmp_path / "run.npz")) as arrays:
        np.testing.assert_array_equal(arrays["r/scan_front/ranges"], [scan.ranges for _, scan in scans])
        np.testing.assert_array_equal(arrays["r/scan_front/intensities"], [scan.intensities for _, scan in scans])
        np.testing.assert_array_equal(arrays["r/imu_slow/turn"], [each.turn for each in felt])
    robot = loadmat(export_mat(recording, tmp_path / "run.mat"), simplify_cells=True)["robots"]["r"]
    np.testing.assert_array_equal(robot["scan_front"]["ranges"], [scan.ranges for _, scan in scans])
