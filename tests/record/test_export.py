import csv
import resource
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evo.core import metrics
from evo.tools import file_interface
from scipy.io import loadmat

import mjsim
from mjsim.errors import UsageError
from mjsim.geometry import Pose, wrap_angles
from mjsim.record import Recording, export_csv, export_images, export_mat, export_npz, export_tum, read_recording
from tests.record_ticks import ROBOTS, hand_made_ticks, record

TICKS = 20


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return read_recording(record(tmp_path_factory.mktemp("export") / "run.mcap", hand_made_ticks(TICKS)))


def test_evo_reads_the_trajectories_and_finds_the_same_error(recording: Recording, tmp_path: Path):
    export_tum(recording, tmp_path)
    for name, track in recording.robots.items():
        truth, estimate = (
            file_interface.read_tum_trajectory_file(tmp_path / f"{name}_{kind}.tum") for kind in ("truth", "estimate")
        )
        np.testing.assert_array_equal(truth.timestamps, track.time)
        np.testing.assert_array_equal(truth.positions_xyz[:, :2], track.truth[:, :2])
        # Roll, pitch and yaw from a quaternion of doubles.
        yaw = truth.get_orientations_euler()[:, 2]
        np.testing.assert_allclose(wrap_angles(yaw - track.truth[:, 2]), 0.0, atol=1e-12)
        ape = metrics.APE(metrics.PoseRelation.translation_part)
        ape.process_data((truth, estimate))
        error = np.hypot(*(track.estimate - track.truth)[:, :2].T)
        assert ape.get_statistic(metrics.StatisticsType.rmse) == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-12)


def test_a_robot_without_a_driver_has_its_true_trajectory_alone(recording: Recording, tmp_path: Path):
    nothing = np.full((TICKS, 3), np.nan)
    idle = replace(recording.robots["scout"], estimate=nothing, odometry=nothing)
    files = export_tum(replace(recording, robots={"scout": idle}), tmp_path)
    assert [file.name for file in files] == ["scout_truth.tum"]


def test_tables_read_back_exactly(recording: Recording, tmp_path: Path):
    export_csv(recording, tmp_path)
    track = recording.robots["scout"]
    rows = table(tmp_path / "scout_track.csv")
    assert [float(row["time"]) for row in rows] == track.time.tolist()
    for kind, poses in (("truth", track.truth), ("odometry", track.odometry), ("estimate", track.estimate)):
        read = [[float(row[f"{kind}_{state}"]) for state in ("x", "y", "heading")] for row in rows]
        np.testing.assert_array_equal(read, poses)
    assert float(rows[5]["estimate_cov_x_heading"]) == track.covariance[5, 0, 2]
    assert rows[3]["command_forward"] == ""
    sightings = [seen for seens in track.sightings for seen in seens]
    read = table(tmp_path / "scout_sightings.csv")
    assert [row["name"] for row in read] == [seen.name or "" for seen in sightings]
    assert [float(row["range"]) for row in read] == [seen.range for seen in sightings]
    assert float(read[0]["v3"]) == sightings[0].corners[3, 1]
    assert [row["text"] for row in table(tmp_path / "scout_events.csv")] == ["touched the wall"]
    innovations = [item for items in track.innovations for item in items]
    assert [float(row["nu_1"]) for row in table(tmp_path / "scout_innovations.csv")] == [
        nu[1] for _, nu, _ in innovations
    ]


def test_the_table_of_landmarks_gives_the_map_at_every_tick(recording: Recording, tmp_path: Path):
    export_csv(recording, tmp_path)
    landmarks = recording.robots["scout"].landmarks
    mean = np.full_like(landmarks.mean, np.nan)
    # '7' and 7 are two landmarks with one text; the one of the number comes first.
    places = {str(name): k for k, name in reversed(list(enumerate(landmarks.names)))}
    for row in table(tmp_path / "scout_landmarks.csv"):
        first = np.searchsorted(recording.time, float(row["time"]))
        if row["name"] != "7":
            mean[first:, places[row["name"]]] = float(row["x"]), float(row["y"])
    rest = [k for k, name in enumerate(landmarks.names) if str(name) != "7"]
    np.testing.assert_array_equal(mean[:, rest], landmarks.mean[:, rest])


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_numpy_arrays_read_back(recording: Recording, tmp_path: Path):
    with np.load(export_npz(recording, tmp_path / "run.npz")) as arrays:
        assert arrays["seed"] == recording.seed
        np.testing.assert_array_equal(arrays["qpos"], recording.qpos)
        for name, track in recording.robots.items():
            for key in ("truth", "odometry", "odometry_covariance", "estimate", "covariance", "command"):
                np.testing.assert_array_equal(arrays[f"{name}/{key}"], getattr(track, key))
            np.testing.assert_array_equal(arrays[f"{name}/landmarks/mean"], track.landmarks.mean)
            np.testing.assert_array_equal(arrays[f"{name}/landmarks/covariance"], track.landmarks.covariance)
            assert arrays[f"{name}/landmarks/names"].tolist() == [str(mark) for mark in track.landmarks.names]
            for tick, stamp, corners in zip(
                arrays[f"{name}/sightings/tick"],
                arrays[f"{name}/sightings/stamp"],
                arrays[f"{name}/sightings/corners"],
                strict=True,
            ):
                assert any(
                    seen.stamp == stamp
                    and np.array_equal(
                        corners, np.full((4, 2), np.nan) if seen.corners is None else seen.corners, equal_nan=True
                    )
                    for seen in track.sightings[tick]
                )


def test_matlab_arrays_read_back_under_names_that_matlab_allows(recording: Recording, tmp_path: Path):
    content = loadmat(export_mat(recording, tmp_path / "run.mat"), simplify_cells=True)
    assert content["seed"] == recording.seed
    np.testing.assert_array_equal(content["time"], recording.time)
    for field, name in (("scout", "scout"), ("x7_tip_top_2", ROBOTS[1])):
        read, track = content["robots"][field], recording.robots[name]
        assert read["name"] == name
        np.testing.assert_array_equal(read["estimate"], track.estimate)
        np.testing.assert_array_equal(read["odometry_covariance"], track.odometry_covariance)
        np.testing.assert_array_equal(read["innovations"]["tick"].size, sum(map(len, track.innovations)))
    np.testing.assert_array_equal(
        content["robots"]["scout"]["landmarks"]["mean"], recording.robots["scout"].landmarks.mean
    )


def test_pictures_are_the_recorded_bytes_and_sort_by_time(recording: Recording, tmp_path: Path):
    assert export_images(recording, tmp_path) == TICKS // 2
    files = sorted((tmp_path / "scout" / "front").iterdir())
    recorded = list(recording.pictures("scout", "front"))
    assert [file.read_bytes() for file in files] == [data for _, data, _ in recorded]
    assert [float(file.stem) for file in files] == [stamp for stamp, _, _ in recorded]
    assert files[1].name == "00000000.080000.jpg"


def test_an_export_that_fails_leaves_no_half_file(recording: Recording, tmp_path: Path):
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"file' exists and is not a folder; name another one"):
        export_npz(recording, tmp_path / "file" / "run.npz")
    blocked = tmp_path / "blocked"
    (blocked / "scout_truth.tum").mkdir(parents=True)
    with pytest.raises(UsageError, match=r"scout_truth.tum' is a folder; name a file"):
        export_tum(recording, blocked)
    assert [path.name for path in blocked.iterdir()] == ["scout_truth.tum"]


@pytest.mark.parametrize("export", [export_tum, export_csv, export_images])
def test_an_export_that_fails_leaves_no_file_and_those_before_as_they_were(
    export: Callable[..., object], recording: Recording, tmp_path: Path
):
    whole, before = tmp_path / "whole", resource.getrlimit(resource.RLIMIT_FSIZE)
    export(recording, whole)
    files = {path: path.read_bytes() for path in whole.rglob("*") if path.is_file()}
    sizes = sorted(map(len, files.values()))
    # Some files fit on the disk, others do not.
    largest = (sizes[0] + sizes[-1]) // 2
    for path in files:
        path.write_text("old")
    for place, overwrite in ((tmp_path / "made", False), (whole, True)):
        try:
            resource.setrlimit(resource.RLIMIT_FSIZE, (largest, before[1]))
            with pytest.raises(UsageError, match=r"^cannot write '[^']*': File too large$"):
                export(recording, place, overwrite=overwrite)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert {path: path.read_text() for path in tmp_path.rglob("*") if path.is_file()} == dict.fromkeys(files, "old")
    assert not (tmp_path / "made").exists()
    export(recording, whole, overwrite=True)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == files


def test_a_written_file_replaces_the_one_before_when_told(recording: Recording, tmp_path: Path):
    old = tmp_path / "scout_truth.tum"
    old.write_text("old")
    with pytest.raises(UsageError, match="exists"):
        export_tum(recording, tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == [old.name]
    export_tum(recording, tmp_path, overwrite=True)
    first = [float(value) for value in old.read_text().splitlines()[0].split()]
    assert Pose(first[1], first[2], 2 * np.arctan2(first[6], first[7])).as_array() == pytest.approx(
        recording.robots["scout"].truth[0], abs=1e-12
    )


def test_an_export_of_nothing_is_an_error_that_writes_nothing(tmp_path):
    bare = mjsim.parse_world("mjsim: 1\nname: bare\nrobots:\n  - {name: r, preset: create3, at: [0, 0]}\n")
    with mjsim.Simulation(bare) as sim:
        driven = mjsim.run(sim, seconds=0.2, record=tmp_path / "run.mcap")
    with pytest.raises(UsageError, match=r"run\.mcap' has no camera; nothing is written"):
        export_images(driven, tmp_path / "pictures")
    crank = mjsim.load_world("worlds/mechanisms/fourbar.yaml")
    with mjsim.Simulation(crank) as sim:
        turned = mjsim.run(sim, seconds=0.2, record=tmp_path / "crank.mcap")
    with pytest.raises(UsageError, match=r"crank\.mcap' has no poses of robots; nothing is written"):
        export_tum(turned, tmp_path / "poses")
    assert {each.name for each in tmp_path.iterdir()} == {"run.mcap", "crank.mcap"}
