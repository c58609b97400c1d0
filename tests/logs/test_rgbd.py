"""RGB-D folders: a run is exported as one, and comes back."""

import shutil

import cv2
import numpy as np
import pytest

import mjsim
from mjsim.datasets import export_euroc, export_tum_rgbd
from mjsim.errors import UsageError
from mjsim.geometry import Pose3
from mjsim.logs.formats.rgbd import read_rgbd
from mjsim.logs.resampling.timed_readings import partners
from mjsim.record import LoggedPictures
from tests.real_logs import imported

WORLD = """mjsim: 1
name: room
walls: [{points: [[0, 0], [5, 0], [5, 4], [0, 4]], closed: true}]
robots:
  - name: scout
    preset: pioneer3dx
    at: [1, 1]
    sensors:
      - {camera: front, at: [0.15, 0, 0.35], pitch_deg: -10, width: 64, height: 48, rate_hz: 12.5, depth: true}
      - {imu: gyro, rate_hz: 50}
run:
  rate_hz: 25
  drivers: {scout: {navigator: {use: "mjsim.algorithms.constant:ConstantCommand", forward: 0.4}}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the folder that a run was exported to, and the run."""
    path = tmp_path_factory.mktemp("rgbd")
    world = mjsim.parse_world(WORLD)
    with mjsim.Simulation(world, seed=1) as sim:
        run = mjsim.run(sim, seconds=0.5, record=path / "run.mcap")
    export_tum_rgbd(run, path / "tum")
    return path / "tum" / "scout_front", run


def test_a_folder_comes_in_with_its_pictures_depth_calibration_and_truth_in_space(folder):
    path, run = folder
    log = imported(path)
    assert log.metadata["log"] == "TUM RGB-D"
    track = log.robots["robot"]
    with mjsim.Simulation(run.world) as sim:
        sensor = sim.robots["scout"].sensors["front"]
    pictures, kept = LoggedPictures(log, "robot"), list(log.pictures("robot", "camera"))
    assert [data for _, data, _ in kept] == [data for _, data, _ in run.pictures("scout", "front")]
    camera = pictures.cameras["camera"]
    np.testing.assert_allclose(camera.intrinsics.matrix(), sensor.intrinsics.matrix())
    depths = sorted((path / "depth").iterdir())
    rows = np.searchsorted(run.time, np.array([stamp for stamp, _, _ in kept]) - 1e-6)
    for number, (stamp, _, _) in enumerate(kept):
        frame = pictures.at(round(stamp * 1e9))("camera", stamp)
        counts = cv2.imread(str(depths[number]), cv2.IMREAD_UNCHANGED).astype(np.float32)
        np.testing.assert_array_equal(frame.depth, np.where(counts > 0, counts / np.float32(5000), np.inf))
        # The camera's optical frame is where the run had it.
        here = int(np.searchsorted(log.time, stamp - 1e-6))
        world_from_camera = Pose3(*track.truth_pose[here].tolist()).matrix() @ camera.robot_from_camera
        expected = Pose3(*run.robots["scout"].truth_pose[rows[number]].tolist()).matrix() @ sensor.robot_from_sensor
        np.testing.assert_allclose(world_from_camera, expected, atol=1e-5)
    # It has no gyroscopes.
    readings = [reading for seen in log.observations("robot") for reading in seen.imu]
    given = [reading for seen in run.observations("scout") for reading in seen.imu]
    np.testing.assert_allclose(
        [each.acceleration for each in readings], [each.acceleration for each in given], atol=1e-6
    )
    assert all(np.isfinite(each.acceleration).all() and np.isnan(each.turn).all() for each in readings)


@pytest.mark.parametrize(
    ("file", "content", "said"),
    [
        ("rgb.txt", "# nothing\n", "lists no pictures"),
        ("rgb.txt", "0.1 rgb/none.png\n", r"rgb\.txt:1: no file 'rgb/none.png'"),
        ("rgb.txt", "0.1 ../../secret.png\n", "the path in the folder"),
        ("rgb.txt", "0.1 rgb/\0.png\n", "the path in the folder"),
        ("rgb.txt", "soon rgb/1.png\n", "a line has a time and a path"),
        ("groundtruth.txt", "0.0 0 0 0 0 0 0 3\n", "has length 3, not 1"),
        ("groundtruth.txt", "0.0 0 0 0\n", "a line has 8"),
        ("camera.yaml", "Camera.fx: wide\n", "has no number Camera.fx"),
    ],
)
def test_an_invalid_folder_is_a_one_line_error(file, content, said, folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    (tmp_path / "tum" / file).write_text(content)
    with pytest.raises(UsageError, match=said) as caught:
        imported(tmp_path / "tum")
    assert "\n" not in str(caught.value)


def test_depth_goes_to_the_closest_picture_within_the_tolerance():
    pictures, depths = np.array([0.0, 0.03, 0.06, 0.09]), np.array([0.013, 0.035, 0.072, 0.2])
    assert partners(pictures, depths, tolerance=0.02).tolist() == [0, 1, 2, -1]
    # One depth between two pictures belongs to the nearer.
    assert partners(np.array([0.0, 0.02]), np.array([0.012]), tolerance=0.02).tolist() == [-1, 0]
    assert partners(np.array([1.0]), np.zeros(0), tolerance=0.02).tolist() == [-1]


def test_a_picture_of_another_kind_is_kept_without_loss(folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "bmp")
    second = sorted((tmp_path / "bmp" / "rgb").iterdir())[1]
    picture = cv2.imread(str(second))
    second.write_bytes(cv2.imencode(".bmp", picture)[1].tobytes())
    _, data, form = list(imported(tmp_path / "bmp").pictures("robot", "camera"))[1]
    assert form == "png"
    np.testing.assert_array_equal(cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR), picture)


def test_depth_that_says_it_has_gigabytes_is_not_decoded(folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "huge")
    file = sorted((tmp_path / "huge" / "depth").iterdir())[0]
    data = bytearray(file.read_bytes())
    data[16:24] = (30_000).to_bytes(4, "big") * 2
    file.write_bytes(data)
    log = imported(tmp_path / "huge")
    assert log.metadata["damaged depth of camera left out"] == "1"
    assert "900 megapixels" in log.metadata["first of the damaged depth of camera left out"]


def test_damaged_pictures_and_depth_are_left_out_and_said(folder, tmp_path, capfd):
    shutil.copytree(folder[0], tmp_path / "cut")
    pictures, depths = (sorted((tmp_path / "cut" / kind).iterdir()) for kind in ("rgb", "depth"))
    (tmp_path / "cut" / "rgb" / "first.png").write_bytes(b"")
    rows = (tmp_path / "cut" / "rgb.txt").read_text()
    (tmp_path / "cut" / "rgb.txt").write_text(f"0.0001 rgb/first.png\n{rows}")
    depths[1].write_bytes(depths[1].read_bytes()[:-60])
    data = depths[3].read_bytes()
    depths[3].write_bytes(data[:90] + bytes(9) + data[99:])
    pictures[2].write_bytes(b"no picture")
    log = imported(tmp_path / "cut")
    assert log.metadata["damaged readings of camera left out"] == "2"
    assert log.metadata["damaged depth of camera left out"] == "2"
    assert depths[1].name in log.metadata["first of the damaged depth of camera left out"]
    assert len(list(log.pictures("robot", "camera"))) == len(pictures) - 1
    assert len(list(log.depths("robot", "camera"))) == len(pictures) - 3
    # The decoder would have lines of its own.
    assert capfd.readouterr().err == ""
    assert log.metadata["log"] == "TUM RGB-D"


@pytest.mark.parametrize("without", [("rgb.txt",), ("rgb.txt", "depth.txt")])
def test_folders_with_depth_or_accelerations_alone_come_in(without, folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    for name in without:
        (tmp_path / "tum" / name).unlink()
    log, whole = imported(tmp_path / "tum"), imported(folder[0])
    felt, expected = (
        np.array([each.acceleration for seen in run.observations("robot") for each in seen.imu]) for run in (log, whole)
    )
    np.testing.assert_array_equal(felt, expected)
    assert np.isfinite(log.robots["robot"].truth).all(axis=1).any()
    cameras = [] if "depth.txt" in without else [("robot", "camera")]
    assert list(log.cameras()) == cameras
    for camera in cameras:
        depths = ([values for _, values in run.depths(*camera)] for run in (log, whole))
        for one, other in zip(*depths, strict=True):
            np.testing.assert_array_equal(one, other)


def test_files_that_a_list_names_and_nobody_has_are_left_out_and_counted(folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    sorted((tmp_path / "tum" / "depth").iterdir())[1].unlink()
    log = imported(tmp_path / "tum")
    assert log.metadata["files of depth.txt that are not there left out"] == "1"
    assert log.metadata["pictures without depth left out"] == "1"


@pytest.mark.parametrize("depth_first", [False, True])
def test_pictures_and_depth_may_be_listed_in_pairs(depth_first, folder, tmp_path):
    path = tmp_path / "tum"
    shutil.copytree(folder[0], path)
    lists = [
        [line for line in (path / f"{name}.txt").read_text().splitlines() if not line.startswith("#")]
        for name in ("rgb", "depth")
    ]
    for name in ("rgb", "depth"):
        (path / f"{name}.txt").unlink()
    pairs = zip(*(lists[::-1] if depth_first else lists), strict=True)
    (path / "associate.txt").write_text("\n".join(" ".join(pair) for pair in reversed(list(pairs))))
    told, paired = (read_rgbd(each).robot.cameras["camera"] for each in (folder[0], path))
    np.testing.assert_array_equal(paired.stamps, told.stamps)
    for number in range(len(told)):
        ours, theirs = told.take(number), paired.take(number)
        assert ours.encoded == theirs.encoded
        np.testing.assert_array_equal(ours.depth, theirs.depth)
    (path / "associations.txt").write_text("0.1 rgb/1.png 0.1 rgb/2.png\n")
    with pytest.raises(UsageError, match=r"associations\.txt:1: .*; a line has time, path, time, path of depth"):
        read_rgbd(path)


@pytest.mark.slow
def test_an_import_that_fails_on_its_way_leaves_what_was_there(folder, tmp_path):
    path, run = tmp_path / "tum", tmp_path / "run.mcap"
    shutil.copytree(folder[0], path)

    def interrupt(percent: float) -> None:
        if percent > 50.0:
            raise KeyboardInterrupt

    run.write_bytes(b"of yesterday")
    with pytest.raises(KeyboardInterrupt):
        mjsim.import_log(path, record=run, progress=interrupt, overwrite=True)
    assert run.read_bytes() == b"of yesterday"
    assert sorted(tmp_path.iterdir()) == [run, path]


def test_a_truth_of_few_poses_a_second_is_one_line_through_them(folder, tmp_path):
    path = tmp_path / "tum"
    shutil.copytree(folder[0], path)
    (path / "groundtruth.txt").write_text("\n".join(f"{time} {time} 0 0 0 0 0 1" for time in (0.0, 0.2, 0.4, 1.2)))
    track = imported(path).robots["robot"]
    # Three steps of 0.2 s are usual, the one of 0.8 s is a hole.
    known = np.isfinite(track.truth[:, 0])
    assert known[:9].all()
    assert not known[-1]
    np.testing.assert_allclose(track.truth_pose[:9, 0], 0.04 * np.arange(9), atol=1e-9)


@pytest.mark.slow
def test_a_log_without_truth_goes_out_without_one_and_comes_in_again(folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    (tmp_path / "tum" / "groundtruth.txt").unlink()
    log = imported(tmp_path / "tum")
    (again,) = export_tum_rgbd(log, tmp_path / "again")
    (euroc,) = export_euroc(log, tmp_path / "euroc")
    assert not [*again.glob("groundtruth*"), *euroc.glob("mav0/state*")]
    for path, camera in ((again, "camera"), (euroc, "cam0")):
        pictures = imported(path).pictures("robot", camera)
        assert [data for _, data, _ in pictures] == [data for _, data, _ in log.pictures("robot", "camera")]


def test_a_camera_that_looks_straight_up_from_its_body_comes_in(folder, tmp_path):
    _, run = folder
    export_euroc(run, tmp_path / "euroc")
    sheet = tmp_path / "euroc" / "scout" / "mav0" / "cam0" / "sensor.yaml"
    up = [0.0, -1.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.2, 0.0, 0.0, 1.0, 0.3, 0.0, 0.0, 0.0, 1.0]
    lines = (f"  data: {up}" if line.startswith("  data:") else line for line in sheet.read_text().splitlines())
    sheet.write_text("\n".join(lines))
    log = imported(tmp_path / "euroc" / "scout")
    place = LoggedPictures(log, "robot").cameras["cam0"].robot_from_camera
    np.testing.assert_allclose(place, np.reshape(up, (4, 4)), atol=1e-12)


def test_cameras_of_tum_vi_are_calibrated_by_kalibr(folder, tmp_path):
    _, run = folder
    export_euroc(run, tmp_path / "euroc")
    place = tmp_path / "euroc" / "scout"
    for sheet in place.rglob("sensor.yaml"):
        sheet.unlink()
    body_from_camera = Pose3(0.1, -0.2, 0.3, 0.5, -0.5, 0.5, 0.5).matrix()
    rows = "".join(f"  - {row}\n" for row in np.linalg.inv(body_from_camera).tolist())
    (place / "dso").mkdir()
    chain = place / "dso" / "camchain.yaml"
    chain.write_text(
        f"cam0:\n  T_cam_imu:\n{rows}  camera_model: pinhole\n  distortion_coeffs: [0.003, 0.001, -0.002, 0.0002]\n"
        "  distortion_model: equidistant\n  intrinsics: [19.0, 19.1, 31.2, 23.9]\n  resolution: [64, 48]\n"
    )
    # Their pictures have 16 bits, though their lists call them PNG as well.
    for picture in (place / "mav0" / "cam0" / "data").iterdir():
        grey = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE).astype(np.uint16) * 256
        picture.write_bytes(cv2.imencode(".png", grey)[1].tobytes())
    log = imported(place)
    camera = LoggedPictures(log, "robot").cameras["cam0"]
    np.testing.assert_allclose(camera.robot_from_camera, body_from_camera, atol=1e-12)
    about = camera.intrinsics
    assert (about.fx, about.fy, about.cx, about.cy, about.lens) == (19.0, 19.1, 31.2, 23.9, "fisheye")
    assert about.distortion == (0.003, 0.001, -0.002, 0.0002)
    assert sum(len(seen.imu) for seen in log.observations("robot")) > 20
    chain.unlink()
    assert imported(place).metadata["calibration of cam0"] == "guessed: 60 degrees; it is not in the folder"
    chain.write_text(f"cam0:\n  T_cam_imu:\n{rows[: rows.rindex('  -')]}  intrinsics: [19.0, 19.1, 31.2, 23.9]\n")
    with pytest.raises(UsageError, match=r"camchain\.yaml': T_cam_imu of cam0 is not a pose; give a rigid transform"):
        imported(place)


def test_lines_of_a_folder_may_be_in_any_order(folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    for file in ("rgb.txt", "depth.txt", "groundtruth.txt", "accelerometer.txt"):
        lines = (tmp_path / "tum" / file).read_text().splitlines()
        np.random.default_rng(0).shuffle(lines)
        (tmp_path / "tum" / file).write_text("\n".join(lines))
    shuffled, ordered = (imported(place) for place in (tmp_path / "tum", folder[0]))
    np.testing.assert_array_equal(shuffled.robots["robot"].truth_pose, ordered.robots["robot"].truth_pose)
    for one, other in zip(shuffled.observations("robot"), ordered.observations("robot"), strict=True):
        assert [each.stamp for each in one.imu] == [each.stamp for each in other.imu]
    assert list(shuffled.pictures("robot", "camera")) == list(ordered.pictures("robot", "camera"))


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("rgb.txt", " rgb/", ",rgb/"),
        ("rgb.txt", " rgb/", " rgb\\"),
        ("groundtruth.txt", " ", ","),
        ("groundtruth.txt", "# ", ""),
        ("groundtruth.txt", "# ", "0 nan nan nan nan nan nan nan\n# "),
    ],
)
def test_lists_of_other_programs_are_the_same_lists(file, old, new, folder, tmp_path):
    shutil.copytree(folder[0], tmp_path / "tum")
    path = tmp_path / "tum" / file
    rows = "".join(line for line in path.read_text().splitlines(True) if not line.startswith("# ground"))
    path.write_text(rows.replace(old, new))
    log, usual = imported(tmp_path / "tum"), imported(folder[0])
    np.testing.assert_array_equal(log.robots["robot"].truth_pose, usual.robots["robot"].truth_pose)
    assert list(log.pictures("robot", "camera")) == list(usual.pictures("robot", "camera"))
    assert log.metadata.get("lines of groundtruth.txt with NaN left out") == ("1" if "nan" in new else None)
