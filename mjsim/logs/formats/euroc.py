"""EuRoC (ASL) folders: cameras and inertial sensors fixed to one body.

    mav0/camN/data.csv                         time [ns], name of a picture in camN/data
    mav0/imuN/data.csv                         time [ns], angular velocity [rad/s], specific force [m/s^2]
    mav0/*/sensor.yaml                         T_BS: body_from_sensor; intrinsics, distortion
    dso/camchain.yaml                          of TUM VI, as Kalibr writes it, in place of sensor.yaml
    mav0/state_groundtruth_estimate0/data.csv  time [ns], x, y, z [m], quaternion w, x, y, z of the body in the world
    mav0/mocap0/data.csv                       the same, of TUM VI

The robot's frame is that of the body, whatever its orientation on the carrier. There is no odometry. Ground truth that
only has positions (leica0) is not read.

References:
    Burri et al., The EuRoC micro aerial vehicle datasets, IJRR 35(10), 2016, section 4.
    Schubert et al., The TUM VI benchmark for evaluating visual-inertial odometry, IROS 2018.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array
from mjsim.interface import ImuReading, Intrinsics
from mjsim.inventory import Fate, told
from mjsim.logs.bags import assumed_intrinsics
from mjsim.logs.files import (
    MAX_NUMBER,
    frame_in,
    lines_of,
    listed_pictures,
    read_csv,
    usual_size,
    with_unit_quaternions,
)
from mjsim.logs.resampling import AHEAD, Log, Mount, Readings, RobotLog, longest_gap
from mjsim.record import LoggedCamera, LoggedFrame
from mjsim.world import read_text

NANOSECOND = 1e-9
SHEET = "sensor.yaml"
CALIBRATION_FILES = ("dso/camchain.yaml", "camchain.yaml", "mav0/camchain.yaml")
"""File with the calibrations of all cameras, in the folder with `mav0`."""
TRUTH_FOLDERS = ("state_groundtruth_estimate0", "mocap0")
DETERMINANT_TOLERANCE = 0.01
"""Tolerance of the determinant of a rotation in a file."""
MAX_LETTERS = 1_000_000
"""Maximum number of characters of a calibration."""
LENSES = {"radial-tangential": "brown", "radtan": "brown", "plumb_bob": "brown", "equidistant": "fisheye"}


def is_euroc(path: Path) -> bool:
    """Return whether a folder contains a camera or an inertial sensor of such a data set."""
    return bool(path.is_dir() and _sensors(path, "cam", "imu"))


def read_euroc(path: Path) -> Log:
    """Read the data of all sensors in a folder.

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line).
    """
    notes: dict[str, str] = {}
    cameras: dict[str, LoggedCamera] = {}
    frames: dict[str, Readings[LoggedFrame]] = {}
    for folder in _sensors(path, "cam"):
        cameras[folder.name], frames[folder.name] = _camera(folder, _sheet(folder) or _chained(folder), notes)
    inertial = {folder.name: _imu(folder, notes) for folder in _sensors(path, "imu")}
    readings = sorted(
        (each for _, readings_of in inertial.values() for each in readings_of), key=lambda each: each.stamp
    )
    truth = next((folder for name in TRUTH_FOLDERS for folder in _sensors(path, name)), None)
    notes["truth"] = told(Fate.LEFT_OUT, "not in the folder") if truth is None else truth.name
    poses = None if truth is None else _poses(truth, notes)
    robot = RobotLog(cameras=frames, imu=readings, poses=poses, gap=longest_gap(poses))
    mounts = {name: mount for name, (mount, _) in inertial.items()}
    return Log(kind="EuRoC", robot=robot, cameras=cameras, mounts=mounts, notes=notes)


def _sensors(path: Path, *kinds: str) -> list[Path]:
    """Return the folders of sensors of some kinds that contain data, sorted by name."""
    root = path / "mav0" if (path / "mav0").is_dir() else path
    return sorted(
        folder for folder in root.iterdir() if folder.name.startswith(kinds) and (folder / "data.csv").is_file()
    )


def _camera(
    folder: Path, sheet: tuple[Path, Mapping[str, Any]] | None, notes: dict[str, str]
) -> tuple[LoggedCamera, Readings[LoggedFrame]]:
    """Return the data sheet and the pictures of a camera.

    Args:
        folder: Folder of the camera.
        sheet: The file with its calibration, and its content; None if there is none.
        notes: Facts about the log.
    """
    stamps, files = listed_pictures(folder / "data.csv", notes, folder="data", separator=",", second=NANOSECOND)
    width, height = usual_size(files)
    if sheet is None:
        notes[f"calibration of {folder.name}"] = told(Fate.GUESSED, "60 degrees; it is not in the folder")
        notes[f"place of {folder.name}"] = told(Fate.GUESSED, "not in the folder")
        place, intrinsics = AHEAD, assumed_intrinsics(width, height)
    else:
        place, intrinsics = _body_from_sensor(*sheet), _intrinsics(*sheet, width, height)

    def take(number: int) -> LoggedFrame:
        return frame_in(files[number], float(stamps[number]), intrinsics)

    return LoggedCamera(intrinsics, place), Readings(stamps, take)


def _imu(folder: Path, notes: dict[str, str]) -> tuple[Mount, list[ImuReading]]:
    """Return the mount of an inertial sensor, and its readings rotated to the axes of the body."""
    # Without a sheet the body is that of the inertial sensor, as in TUM VI.
    sheet = _sheet(folder)
    place = np.eye(4) if sheet is None else _body_from_sensor(*sheet)
    table = read_csv(folder / "data.csv", notes=notes)
    times, values = table.column(1), table.block(2, but=1)
    if values.shape[1] < 6:
        raise UsageError(f"'{table.path}' has {values.shape[1]} columns beside time; it needs 3 rates, 3 accelerations")
    if wild := int(np.count_nonzero(np.abs(values[:, :6]) > MAX_NUMBER)):
        notes[f"infinite or huge numbers of {folder.name}/data.csv left out"] = str(wild)
        values = np.where(np.abs(values) > MAX_NUMBER, np.nan, values)
    # Quantities that were not measured are NaN.
    turns, forces = values[:, :3], values[:, 3:6]
    rows = zip((times * NANOSECOND).tolist(), forces @ place[:3, :3].T, turns @ place[:3, :3].T, strict=True)
    x, y, z = place[:3, 3].tolist()
    return Mount(at=(x, y, z)), [ImuReading(stamp, force, turn, folder.name) for stamp, force, turn in rows]


def _poses(folder: Path, notes: dict[str, str]) -> Array:
    """Return rows of time and pose of the body, shape (N, 8)."""
    whole = read_csv(folder / "data.csv", notes=notes)
    table = whole.filled(range(1, 9))
    if left := len(whole.rows) - len(table.rows):
        notes[f"rows of {folder.name}/data.csv without a pose left out"] = str(left)
    rows = np.column_stack([table.column(k) for k in (1, 2, 3, 4, 6, 7, 8, 5)])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    rows[:, 0] *= NANOSECOND
    return with_unit_quaternions(folder / "data.csv", rows)


def _sheet(folder: Path) -> tuple[Path, Mapping[str, Any]] | None:
    """Return the path and content of sensor.yaml; None if there is none."""
    file = folder / SHEET
    return (file, _yaml(file)) if file.is_file() else None


def _chained(folder: Path) -> tuple[Path, Mapping[str, Any]] | None:
    """Return the file with all calibrations, and that of one camera with the keys of sensor.yaml; None without."""
    root = folder.parent.parent if folder.parent.name == "mav0" else folder.parent
    file = next((root / name for name in CALIBRATION_FILES if (root / name).is_file()), None)
    if file is None or not isinstance(sheet := _yaml(file).get(folder.name), dict):
        return None
    camera_from_body = _numbers(sheet.get("T_cam_imu"))
    if camera_from_body.shape != (16,) or abs(np.linalg.det(camera_from_body.reshape(4, 4))) < DETERMINANT_TOLERANCE:
        raise UsageError(f"'{file}': T_cam_imu of {folder.name} is not a pose; give a rigid transform, 4 rows of 4")
    body_from_camera = np.linalg.inv(camera_from_body.reshape(4, 4))
    lens = sheet.get("distortion_coeffs")
    return file, {**sheet, "T_BS": {"data": body_from_camera.ravel().tolist()}, "distortion_coefficients": lens}


def _yaml(file: Path) -> Mapping[str, Any]:
    """Return the keys of a YAML file."""
    text = ""
    for line in lines_of(file):
        # OpenCV starts such files with %YAML:1.0, which is not a YAML directive.
        text += "\n" if line.startswith("%") else line
        if len(text) > MAX_LETTERS:
            raise UsageError(f"'{file}' has more than {MAX_LETTERS:,} characters; a calibration has fewer")
    # Nested aliases could expand to any number of values.
    node, problems = read_text(text, file=str(file))
    if problems:
        raise UsageError(f"{problems[0]} (of a calibration in YAML)"[:MAX_MESSAGE_LENGTH])
    content = None if node is None else node.value
    if not isinstance(content, dict):
        raise UsageError(f"'{file}' holds no keys; it needs a calibration")
    return content


def _body_from_sensor(file: Path, sheet: Mapping[str, Any]) -> Array:
    """Return T_BS, shape (4, 4) [m]."""
    extrinsics = sheet.get("T_BS")
    matrix = _numbers(extrinsics.get("data") if isinstance(extrinsics, dict) else None)
    if matrix.shape != (16,) or abs(np.linalg.det(matrix.reshape(4, 4)[:3, :3]) - 1.0) > DETERMINANT_TOLERANCE:
        raise UsageError(f"'{file}': T_BS is not a pose; its data are 16 numbers of a rigid transform")
    return matrix.reshape(4, 4)


def _intrinsics(file: Path, sheet: Mapping[str, Any], width: int, height: int) -> Intrinsics:
    """Return the calibration of a camera, for pictures of some size [px]."""
    numbers, lens = (_numbers(sheet.get(key)) for key in ("intrinsics", "distortion_coefficients"))
    if numbers.shape != (4,) or min(numbers[:2]) <= 0.0:
        raise UsageError(f"'{file}': intrinsics are {sheet.get('intrinsics')}; they must be fu, fv, cu, cv in pixels")
    fx, fy, cx, cy = numbers.tolist()
    if not lens.any():
        return Intrinsics(width, height, fx, fy, cx, cy)
    model = LENSES.get(str(sheet.get("distortion_model")))
    if model is None or not 4 <= len(lens) <= (5 if model == "brown" else 4):
        raise UsageError(f"'{file}': a lens of model {sheet.get('distortion_model')!r}; {', '.join(LENSES)} are read")
    return Intrinsics(width, height, fx, fy, cx, cy, model, tuple(lens.tolist()))


def _numbers(values: Any) -> Array:
    """Return a list of finite numbers as an array, shape (N,); empty for anything else."""
    try:
        numbers = np.array(values if values is not None else [], dtype=float).ravel()
    except (TypeError, ValueError):
        return np.zeros(0)
    return numbers if np.isfinite(numbers).all() else np.zeros(0)
