"""Logs of real robots become recordings; here they are written from motions that are known exactly."""

import itertools
import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

import mjsim
from mjsim.algorithms.ekf_slam.ekf_slam import EkfSlam
from mjsim.errors import UsageError
from mjsim.geometry import Pose, places_at, wrap_angle, wrap_angles
from mjsim.logs import Wishes
from mjsim.logs.files.antenna import car_poses
from mjsim.logs.resampling.resample import MotionNoise, motions
from mjsim.report import statistics
from tests.real_logs import (
    CAR,
    LANDMARKS,
    START,
    TREES,
    circle,
    imported,
    run_command,
    write_mrclam,
    write_table,
    write_victoria_park,
)


def test_motion_between_ticks_is_that_of_all_twists_that_held():
    rng = np.random.default_rng(3)
    twists = np.column_stack([np.sort(rng.uniform(0.5, 9.5, 40)), rng.uniform(-1, 1, 40), rng.uniform(-2, 2, 40)])
    edges = np.arange(0.0, 10.01, 0.4)
    told = motions(twists, edges, MotionNoise(distance=0.1, turn=0.1, veer=0.1))
    place = Pose(0.0, 0.0, 0.0)
    for step in told:
        place = place @ Pose(step.forward, step.left, step.turn)
    # Euler steps of 10 us, in which the twist that holds can be looked up plainly.
    dt = 1e-5
    rows = np.searchsorted(twists[:, 0], np.arange(0.0, 10.0, dt) + dt / 2) - 1
    forward, turn = (np.where(rows >= 0, twists[np.maximum(rows, 0), k], 0.0) for k in (1, 2))
    headings = np.cumsum(turn) * dt - turn * dt / 2
    x, y = np.sum(forward * np.cos(headings)) * dt, np.sum(forward * np.sin(headings)) * dt
    # A step in which the twist changes is off by less than one step's way.
    np.testing.assert_allclose([place.x, place.y], [x, y], atol=40 * dt)
    assert abs(wrap_angle(place.heading - np.sum(turn) * dt)) < 80 * dt
    for step in told:
        assert np.linalg.eigvalsh(step.covariance)[0] >= -1e-15


def test_truth_lies_between_its_neighbours_and_is_unknown_where_they_are_far_apart():
    track = np.array([[0.0, 0.0, 0.0, 3.1], [0.1, 1.0, 0.0, -3.1], [0.9, 2.0, 2.0, 0.0], [1.0, 2.0, 3.0, 0.0]])
    found = places_at(np.array([-0.1, 0.0, 0.05, 0.5, 0.975, 1.1]), track, gap=0.2)
    half_turn = np.pi  # Between 3.1 and -3.1 the short way leads over pi.
    np.testing.assert_allclose(found[1], [0.0, 0.0, 3.1])
    np.testing.assert_allclose(found[2][:2], [0.5, 0.0])
    assert abs(abs(found[2][2]) - half_turn) < 1e-12
    np.testing.assert_allclose(found[4], [2.0, 2.75, 0.0])
    assert np.isnan(found[[0, 3, 5]]).all()


@pytest.fixture(scope="module")
def mrclam(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs") / "MRCLAM_Dataset1"
    write_mrclam(folder, numbers=(1, 2), seconds=6.0)
    return imported(folder, record=folder.parent / "log.mcap")


def test_a_log_of_mrclam_becomes_a_recording_of_its_robots_and_landmarks(mrclam):
    assert set(mrclam.robots) == {"robot1", "robot2"}
    assert {beacon.name: tuple(beacon.at) for beacon in mrclam.world.beacons} == {
        f"landmark{n}": place for n, place in LANDMARKS.items()
    }
    assert mrclam.world.walls == ()
    np.testing.assert_allclose(mrclam.time, 0.1 * np.arange(len(mrclam.time)), atol=1e-12)
    assert 58 <= len(mrclam.time) <= 60
    assert float(mrclam.metadata["log start"]) == pytest.approx(START, abs=1e-6)
    for number in (1, 2):
        track = mrclam.robots[f"robot{number}"]
        truth = circle(Pose(0.2 * number, -0.3 * number, 0.4 * number), 0.3, 0.25, mrclam.time)
        np.testing.assert_allclose(track.truth[:, :2], truth[:, :2], atol=1e-5)
        # Velocities were told without error, so dead reckoning is the truth.
        np.testing.assert_allclose(track.odometry[:, :2], truth[:, :2], atol=1e-5)
        np.testing.assert_allclose(wrap_angles(track.odometry[:, 2] - truth[:, 2]), 0.0, atol=1e-5)
        # The state of the scene has the robot there, so that it can be seen in 3-D.
        assert any((mrclam.qpos[:, k : k + 2] == track.truth[:, :2]).all() for k in range(mrclam.qpos.shape[1]))
        assert (np.diff(track.odometry_covariance[:, 2, 2]) > 0.0).all()
        np.testing.assert_allclose(track.command[1:], np.tile([0.3, 0.0, 0.25], (len(truth) - 1, 1)))


def test_every_sighting_keeps_its_stamp_and_comes_at_the_tick_after_it(mrclam):
    rows = np.loadtxt(Path(mrclam.metadata["log folder"]) / "Robot1_Measurement.dat")
    others = np.isin(rows[:, 1], [14, 99])
    rows = rows[~others]
    track = mrclam.robots["robot1"]
    told = [(time, seen) for time, tick in zip(mrclam.time, track.sightings, strict=True) for seen in tick]
    last = START + mrclam.time[-1]
    assert len(told) == (rows[:, 0] <= last).sum()
    np.testing.assert_allclose([seen.stamp for _, seen in told], rows[: len(told), 0] - START, atol=1e-6)
    assert all(time - 0.1 - 1e-6 < seen.stamp <= time + 1e-6 for time, seen in told)
    assert [name for tick in track.identities for name in tick] == [seen.name for _, seen in told]
    # Of another robot, and of a barcode that there is not.
    assert mrclam.metadata["robot1 measurements of no landmark left out"] == str(others.sum())


def test_the_class_that_runs_in_simulation_maps_the_landmarks_of_a_log(mrclam):
    again = mjsim.replay(mrclam, robot="robot1", estimator=EkfSlam())
    figures = statistics(again)["robot1"]
    # Sightings are up to a tick old, 0.05 s on average: taken for new ones they would err by 5 cm at 4 m.
    assert figures["position_error_m"]["max"] < 0.01
    looks = Counter(seen.name for tick in again.robots["robot1"].sightings for seen in tick)
    assert figures["landmark_error_m"]["count"] == sum(count >= 3 for count in looks.values()) >= 3
    assert figures["landmark_error_m"]["rms"] < 0.08
    assert statistics(again)["robot2"]["position_error_m"]["max"] < 0.01


def test_an_mrclam_log_without_ground_truth_is_replayed_without_errors_in_its_report(tmp_path):
    folder = tmp_path / "MRCLAM"
    write_mrclam(folder, numbers=(1, 2), seconds=3.0)
    for path in folder.glob("*Groundtruth.dat"):
        path.unlink()
    with pytest.raises(UsageError, match="its map is unknown, leave out --known-map"):
        imported(folder, wishes=Wishes(known_map=True))
    run = imported(folder)
    assert run.world.beacons == ()
    assert run.metadata["robot1 truth"] == "left out: not in the log"
    again = mjsim.replay(run, robot="robot1", estimator=EkfSlam())
    track = again.robots["robot1"]
    assert np.isnan(track.truth).all()
    names = track.landmarks.names
    assert len(names) >= 3  # those that come before the camera
    # Distances between landmarks are those between the tubes.
    found = np.array([track.landmarks.mean[-1, track.landmarks.names.index(name)] for name in names])
    places = np.array([LANDMARKS[int(str(name).removeprefix("landmark"))] for name in names])
    apart = [np.linalg.norm(each[:, None] - each[None], axis=-1) for each in (found, places)]
    np.testing.assert_allclose(apart[0], apart[1], atol=0.15)
    figures = statistics(again)["robot1"]
    assert figures["position_error_m"] is None
    assert figures["ate_m"] is None


def test_only_the_robots_and_the_seconds_that_were_asked_for_are_read(mrclam):
    wishes = Wishes(robots=["2"], rate_hz=50.0, begin=2.0, seconds=1.0, known_map=True)
    part = imported(mrclam.metadata["log folder"], wishes=wishes)
    assert set(part.robots) == {"robot2"}
    assert len(part.time) == 51
    np.testing.assert_allclose(part.robots["robot2"].truth[0, :2], mrclam.robots["robot2"].truth[20, :2], atol=1e-4)
    assert part.world.run.map == "known"
    with pytest.raises(UsageError, match=r"no robot 7 in '.*'; there are 1, 2"):
        imported(mrclam.metadata["log folder"], wishes=Wishes(robots=["7"]))
    with pytest.raises(UsageError, match=r"0 s of a log of 5\.9\d+ s remain; two ticks are 0.1 s apart"):
        imported(mrclam.metadata["log folder"], wishes=Wishes(begin=100.0))


@pytest.fixture(scope="module")
def park(tmp_path_factory):
    folder = tmp_path_factory.mktemp("park") / "VictoriaPark"
    start = write_victoria_park(folder)
    return imported(folder, wishes=Wishes(rate_hz=12.5), record=folder.parent / "log.mcap"), start


@pytest.mark.slow
def test_the_car_of_victoria_park_follows_its_wheel_and_its_steering(park):
    recording, start = park
    track = recording.robots["car"]
    speed, steering = CAR
    way = circle(start, speed, speed * np.tan(steering) / 2.83, recording.time)
    known = np.isfinite(track.truth).all(axis=1)
    assert np.hypot(*(track.truth[known, :2] - way[known, :2]).T).max() < 0.01
    assert not known[(recording.time > 8.0) & (recording.time < 11.9)].any()
    assert known[(recording.time < 7.7) | ((recording.time > 12.3) & (recording.time < 19.7))].all()
    assert np.abs(wrap_angles(track.truth[known, 2] - way[known, 2])).max() < 0.003
    ends = [poses[-1, :2] - poses[0, :2] for poses in (track.odometry, way)]
    assert np.linalg.norm(ends[0]) == pytest.approx(np.linalg.norm(ends[1]), abs=0.01)
    assert recording.world.robots[0].drive.type == "ackermann"


def test_trees_are_seen_from_the_rear_axle_where_they_stand(park):
    recording, start = park
    speed, steering = CAR
    count = 0
    for tick in recording.robots["car"].sightings:
        for seen in tick:
            assert seen.name is None
            assert np.linalg.eigvalsh(seen.covariance)[0] > 0.0
            car = Pose.from_array(circle(start, speed, speed * np.tan(steering) / 2.83, np.array([seen.stamp]))[0])
            tree = car.transform(seen.range * np.array([np.cos(seen.bearing), np.sin(seen.bearing)]))
            assert np.linalg.norm(np.array(TREES) - tree, axis=1).min() < 1e-6
            count += 1
    assert count == len(np.loadtxt(Path(recording.metadata["log folder"]) / "measurements.dat"))


@pytest.mark.slow
def test_a_filter_that_pairs_anonymous_sightings_finds_the_trees(park):
    again = mjsim.replay(park[0], robot="car", estimator=EkfSlam(association="joint"))
    track = again.robots["car"]
    assert len(track.landmarks.names) == len(TREES)
    figures = statistics(again)["car"]
    assert figures["landmark_error_m"]["count"] == len(TREES)
    assert figures["ate_m"]["rmse"] < 0.1


def test_without_fixes_there_is_no_truth_and_the_rest_works(park, tmp_path):
    folder = tmp_path / "blind"
    write_victoria_park(folder, seconds=3.0)
    (folder / "gps.dat").unlink()
    blind = imported(folder)
    assert np.isnan(blind.robots["car"].truth).all()
    assert blind.robots["car"].odometry[0].tolist() == [0.0, 0.0, 0.0]
    assert statistics(blind)["car"]["position_error_m"] is None


def drive_with_fixes(jumps=()):
    """Return the truth, fixes of an antenna, and odometry of a car that stands, goes ahead in a bow, and backs."""
    times = np.arange(0.0, 60.0, 0.2)
    speed = np.select([times < 8, times < 30, times < 36], [0.0, 2.0, 0.0], -1.5)
    twists = np.column_stack([times, speed, 0.08 * speed])
    steps = motions(twists, times, MotionNoise(distance=0.04, turn=0.0, veer=0.01))
    poses = list(
        itertools.accumulate(steps, lambda pose, step: pose @ Pose(step.forward, step.left, step.turn), initial=BEGIN)
    )
    fixes = np.array([pose.transform(ANTENNA) for pose in poses]) + np.random.default_rng(1).normal(0, 0.05, (300, 2))
    fixes[list(jumps)] += (4.0, -3.0)
    return np.array([pose.as_array() for pose in poses]), np.column_stack([times, fixes]), steps


BEGIN, ANTENNA = Pose(3.0, -2.0, 2.0), (3.78, 0.5)


def test_fixes_tell_where_a_car_is_and_odometry_how_it_is_turned_even_while_it_stands_or_backs():
    truth, fixes, steps = drive_with_fixes()
    found = car_poses(fixes, steps, ANTENNA)
    assert len(found.rows) == len(fixes)
    assert np.degrees(np.abs(wrap_angles(found.rows[:, 3] - truth[:, 2]))).max() < 0.5
    # A fix errs by 0.05 m in each direction.
    assert np.hypot(*(found.rows[:, 1:3] - truth[:, :2]).T).max() < 0.25


def test_fixes_that_jump_are_left_out_and_counted_and_turn_nothing():
    jumps = range(120, 140)
    truth, fixes, steps = drive_with_fixes(jumps)
    found = car_poses(fixes, steps, ANTENNA)
    assert found.jumped == len(jumps)
    kept = np.delete(np.arange(len(fixes)), jumps)
    np.testing.assert_array_equal(found.rows[:, 0], fixes[kept, 0])
    assert np.degrees(np.abs(wrap_angles(found.rows[:, 3] - truth[kept, 2]))).max() < 0.5


def test_fixes_of_a_car_that_never_moves_tell_no_heading():
    times = np.arange(0.0, 4.0, 0.2)
    still = motions(np.array([[0.0, 0.0, 0.0]]), times, MotionNoise(distance=0.04, turn=0.0, veer=0.01))
    found = car_poses(np.column_stack([times, np.ones((20, 2))]), still, ANTENNA)
    assert (len(found.rows), found.jumped) == (0, 0)


@pytest.mark.parametrize(
    ("file", "line", "said"),
    [
        ("Robot1_Odometry.dat", "1248272273.0 0.3", "2 values; a line has 3: time, forward velocity, turn"),
        ("Robot1_Odometry.dat", "1248272273.0 fast 0", "forward velocity is 'fast'; it must be a finite number"),
        ("Robot1_Groundtruth.dat", "1248272273.0 1 nan 0", "y is 'nan'; it must be a finite number"),
        ("Robot1_Measurement.dat", "1248272273.0 63 -1 0", "range is -1; it must be above 0"),
        ("Robot1_Odometry.dat", "12 0 0", "time is 12 after 1248272272.84; lines must be in order of time"),
    ],
)
def test_a_line_that_is_not_as_it_must_be_is_named(tmp_path, file, line, said):
    write_mrclam(tmp_path / "log", seconds=1.0)
    path = tmp_path / "log" / file
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines[:2], line, *lines[2:]]) + "\n")
    with pytest.raises(UsageError) as caught:
        imported(tmp_path / "log")
    assert str(caught.value) == f"{path}:3: {said}"


def test_files_of_other_times_and_folders_of_logs_are_told(tmp_path):
    write_mrclam(tmp_path / "log", numbers=(1, 2), seconds=1.0)
    for path in (tmp_path / "log").iterdir():
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert len(imported(tmp_path / "log").robots) == 2
    odometry = tmp_path / "log" / "Robot1_Odometry.dat"
    odometry.write_text("1348272272.0 0 0\n1348272273.0 0 0\n")
    with pytest.raises(UsageError, match=r"some files of the log end at .*, before others begin, at 1348272272 s"):
        imported(tmp_path / "log")
    write_mrclam(tmp_path / "other", seconds=1.0)
    with pytest.raises(UsageError, match=r"is a folder of logs; name one of them: log, other$"):
        imported(tmp_path)


def test_files_that_are_not_there_or_hold_nothing_are_named(tmp_path):
    write_mrclam(tmp_path / "log", seconds=1.0)
    measured = tmp_path / "log" / "Robot1_Measurement.dat"
    measured.write_text("# nothing\n")
    with pytest.raises(UsageError, match="holds no numbers; each line has 4: time, barcode, range, bearing"):
        imported(tmp_path / "log")
    measured.unlink()
    with pytest.raises(UsageError, match=r"cannot read '.*Robot1_Measurement.dat': No such file"):
        imported(tmp_path / "log")
    write_table(tmp_path / "log" / "Barcodes.dat", [(6, 63), (7, 63)])
    with pytest.raises(UsageError, match="barcode 63 is used for two subjects; each needs its own"):
        imported(tmp_path / "log")


@pytest.mark.slow
def test_the_command_tells_the_kind_of_a_log_by_its_files(tmp_path, capsys):
    write_victoria_park(tmp_path / "park", seconds=2.0)
    output = tmp_path / "park.mcap"
    assert run_command("import-log", tmp_path / "park", "-o", output, "--rate", 12.5, "--range-noise", 0.5) == 0
    assert capsys.readouterr().out.strip() == str(output)
    recording = mjsim.read_recording(output)
    assert len(recording.time) == 25
    assert recording.world.robots[0].sensors[0].noise.range == 0.5
    (tmp_path / "none").mkdir()
    with pytest.raises(UsageError, match="none' is an empty folder"):
        imported(tmp_path / "none")
    (tmp_path / "none" / "notes.txt").write_text("The floor was wet.\n")
    with pytest.raises(UsageError, match=r"is not a supported log; give a folder of MRCLAM \(Barcodes.dat\)"):
        imported(tmp_path / "none")
    assert run_command("import-log", tmp_path / "park", "-o", tmp_path / "new.mcap", "--known-map") == 2
    assert "Victoria Park has no known map; leave out --known-map" in capsys.readouterr().err


@pytest.mark.slow
def test_report_film_and_export_take_a_log_that_was_imported_and_replayed(park, tmp_path):
    # From the time when fixes end.
    short = imported(park[0].metadata["log folder"], wishes=Wishes(begin=7.0, seconds=1.2))
    again = mjsim.replay(short, robot="car", estimator=EkfSlam(association="joint"), record=tmp_path / "run.mcap")
    for command in (
        ("report", again.path, "-o", tmp_path / "report"),
        ("video", again.path, "-o", tmp_path / "run.mp4"),
        ("export", again.path, "--tum", tmp_path, "--csv", tmp_path),
    ):
        assert run_command(*command) == 0
    figures = json.loads((tmp_path / "report" / "statistics.json").read_text())["robots"]["car"]
    assert figures["position_error_m"]["rmse"] < 0.3
    poses = np.loadtxt(tmp_path / "car_truth.tum")
    assert np.isfinite(poses).all()
    assert len(poses) == np.isfinite(again.robots["car"].truth).all(axis=1).sum()
