"""RGB-D folders in the format of TU Munich's computer vision group: a hand-held or mounted camera with depth.

    rgb.txt            time [s], path of a picture
    depth.txt          time [s], path of a PNG of 16 bits, 5000 to a metre, 0 for none
    associations.txt   time and path of a picture, time and path of its depth: in place of both
    groundtruth.txt    time [s], x, y, z [m], quaternion x, y, z, w: the camera's optical frame in the world
    accelerometer.txt  time [s], x, y, z [m/s^2]
    camera.yaml        calibration as ORB-SLAM reads it; not in the published folders

A picture and the depth closest to it, less than 0.02 s apart, belong together. The robot's frame is at the camera, x
ahead. There is no odometry. Intrinsics of published folders follow from the number of the camera in their name.

References:
    Sturm, Engelhard, Endres, Burgard, Cremers, A benchmark for the evaluation of RGB-D SLAM systems, IROS 2012; the
    file formats and the calibrations of freiburg1 to freiburg3 as its pages give them.
"""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array, Pose3
from mjsim.interface import CameraFrame, ImuReading, Intrinsics
from mjsim.inventory import Fate, told
from mjsim.logs.bags import shown_depth
from mjsim.logs.files import (
    bytes_in,
    frame_in,
    lines_of,
    listed_pictures,
    paired_pictures,
    read_table,
    require_sound,
    usual_size,
    with_unit_quaternions,
)
from mjsim.logs.resampling import (
    AHEAD,
    TOGETHER,
    Damage,
    DamagedReadingError,
    Log,
    Readings,
    RobotLog,
    longest_gap,
    partners,
)
from mjsim.models import any_picture_size
from mjsim.record import LoggedCamera, LoggedFrame, logged_frame

ANY_TIME = "timestamp"
"""Column of times in any order: several programs write such folders."""
CAMERA = "camera"
PER_METRE = np.float32(5000.0)
"""Depth values per metre."""
COLOURS, DEPTHS, ACCELERATIONS = "rgb.txt", "depth.txt", "accelerometer.txt"
"""Lists of a folder, of which one is enough."""
ASSOCIATIONS = ("associations.txt", "association.txt", "associate.txt", "associated.txt")
"""Names for what `associate.py` of the data set's tools prints; some data sets only have this file."""
CALIBRATIONS = {
    1: (517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633),
    2: (520.9, 521.0, 325.1, 249.7, 0.2312, -0.7849, -0.0033, -0.0001, 0.9172),
    3: (535.4, 539.2, 320.1, 247.6),
}
"""Camera -> fx, fy, cx, cy [px] and Brown's model, of 640 x 480 pixels."""
DEFAULT_INTRINSICS = (525.0, 525.0, 319.5, 239.5)
"""Default of the data set's tools, for 640 x 480 pixels."""


def is_rgbd(path: Path) -> bool:
    """Return whether a folder contains a list of pictures or of depth, or accelerations with or without poses."""
    return path.is_dir() and any((path / name).is_file() for name in (COLOURS, DEPTHS, ACCELERATIONS, *ASSOCIATIONS))


def read_rgbd(path: Path) -> Log:
    """Read the data of the camera in a folder.

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line).
    """
    notes, damage = dict[str, str](), Damage()
    cameras, frames = _camera(path, notes, damage)
    poses = _truth(path, notes)
    robot = RobotLog(
        cameras=frames,
        imu=_accelerations(path, notes),
        poses=poses,
        gap=longest_gap(poses),
        damage=damage,
    )
    return Log(kind="TUM RGB-D", robot=robot, name="robot", cameras=cameras, notes=notes)


def _camera(
    path: Path, notes: dict[str, str], damage: Damage
) -> tuple[dict[str, LoggedCamera], dict[str, Readings[LoggedFrame]]]:
    """Return the data sheet and the pictures of the camera, by its name; nothing of a folder without pictures."""
    (stamps, pictures), (depth_stamps, depths) = _lists(path, notes)
    if not pictures and not depths:
        return {}, {}
    intrinsics = _intrinsics(path, *usual_size(pictures or depths), notes)
    place = AHEAD.copy()
    place[:3, 3] = 0.0
    camera = LoggedCamera(intrinsics, place, has_depth=bool(depths))
    if not pictures:
        notes["pictures"] = told(Fate.MENDED, "not in the folder; grey ones show the depth")

        def take_depth(number: int) -> LoggedFrame:
            depth = _depth(depths[number], intrinsics)
            return logged_frame(CameraFrame(float(depth_stamps[number]), shown_depth(depth), intrinsics, depth))

        return {CAMERA: camera}, {CAMERA: Readings(depth_stamps, take_depth)}
    partner = partners(stamps, depth_stamps, tolerance=TOGETHER).tolist()
    if depths:
        notes["pictures without depth left out"] = str(sum(other < 0 for other in partner))

    def take(number: int) -> LoggedFrame:
        frame, other = frame_in(pictures[number], float(stamps[number]), intrinsics), partner[number]
        if other < 0:
            return frame
        try:
            return replace(frame, depth=_depth(depths[other], intrinsics), depth_stamp=float(depth_stamps[other]))
        except DamagedReadingError as error:
            damage.add(f"depth of {CAMERA}", error)
            return frame

    return {CAMERA: camera}, {CAMERA: Readings(stamps, take)}


def _lists(path: Path, notes: dict[str, str]) -> tuple[tuple[Array, list[Path]], tuple[Array, list[Path]]]:
    """Return the times [s] and files of pictures and depth in a folder."""
    colours, depths = path / COLOURS, path / DEPTHS
    paired = next((path / name for name in ASSOCIATIONS if (path / name).is_file()), None)
    if not colours.is_file() and paired is not None:
        return paired_pictures(paired, notes)
    none = np.zeros(0), list[Path]()
    pictures = listed_pictures(colours, notes) if colours.is_file() else none
    return pictures, listed_pictures(depths, notes) if depths.is_file() else none


def _depth(file: Path, intrinsics: Intrinsics) -> Array:
    """Return the depth in a file, shape (height, width) [m]; +inf for none.

    Raises:
        DamagedReadingError: It is not such a picture.
    """
    data = bytes_in(file)
    try:
        # Pictures that are too large are not decoded.
        fits = any_picture_size(data) == (intrinsics.width, intrinsics.height)
        require_sound(data)
    except ValueError as error:
        raise DamagedReadingError(f"'{file}': {error}") from None
    values = cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_UNCHANGED) if fits else None
    if values is None or values.dtype != np.uint16 or values.ndim != 2:
        size = f"{intrinsics.width} x {intrinsics.height}"
        raise DamagedReadingError(f"'{file}' is not a depth image of {size} pixels of 16 bits")
    return np.where(values > 0, values.astype(np.float32) / PER_METRE, np.inf).astype(float)


def _intrinsics(path: Path, width: int, height: int, notes: dict[str, str]) -> Intrinsics:
    """Return the calibration of a folder: from its file, from the name of a published one, or the default."""
    known = re.search(r"freiburg([123])", path.resolve().name)
    if (path / "camera.yaml").is_file():
        return _settings(path / "camera.yaml", width, height)
    if known is not None and (width, height) == (640, 480):
        notes["calibration"] = f"of freiburg{known[1]}, as published"
        return _calibrated(CALIBRATIONS[int(known[1])], width, height)
    notes["calibration"] = told(Fate.GUESSED, "a default; it is not in the folder")
    fx, fy, cx, cy = DEFAULT_INTRINSICS
    return _calibrated(
        (fx * width / 640, fy * height / 480, (cx + 0.5) * width / 640 - 0.5, (cy + 0.5) * height / 480 - 0.5),
        width,
        height,
    )


def _calibrated(numbers: Sequence[float], width: int, height: int) -> Intrinsics:
    fx, fy, cx, cy, *lens = numbers
    if not any(lens):
        return Intrinsics(width, height, fx, fy, cx, cy)
    return Intrinsics(width, height, fx, fy, cx, cy, "brown", tuple(lens))


def _settings(file: Path, width: int, height: int) -> Intrinsics:
    """Return the calibration in a file of ORB-SLAM2 or ORB-SLAM3."""
    settings: dict[str, str] = {}
    for line in lines_of(file):
        if found := re.match(r"Camera1?\.(\w+):\s*(\S+)", line):
            settings[found[1]] = found[2].strip('"')
    fisheye = settings.get("type") == "KannalaBrandt8"
    lens = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    try:
        numbers = [float(settings[key]) for key in ("fx", "fy", "cx", "cy")] + [
            float(settings.get(key, "0")) for key in lens
        ]
    except (KeyError, ValueError) as error:
        raise UsageError(f"'{file}' has no number Camera.fx, fy, cx or cy: {error}"[:MAX_MESSAGE_LENGTH]) from None
    if not np.isfinite(numbers).all() or min(numbers[:2]) <= 0.0:
        raise UsageError(f"'{file}': focal lengths are {numbers[0]:g} and {numbers[1]:g}; they must be above 0")
    intrinsics = _calibrated(numbers, width, height)
    return replace(intrinsics, lens="fisheye", distortion=tuple(numbers[4:])) if fisheye else intrinsics


def _truth(path: Path, notes: dict[str, str]) -> Array | None:
    """Return the 3-D poses of the robot's frame, rows of time and pose, shape (N, 8)."""
    file = path / "groundtruth.txt"
    if not file.is_file():
        return None
    rows = read_table(file, (ANY_TIME, "x", "y", "z", "qx", "qy", "qz", "qw"), gaps=True, notes=notes)
    rows = with_unit_quaternions(file, rows[np.argsort(rows[:, 0], kind="stable")])
    optical_from_body = np.linalg.inv(np.vstack([np.column_stack([AHEAD[:3, :3], np.zeros(3)]), [0.0, 0.0, 0.0, 1.0]]))
    for row in rows:
        row[1:] = Pose3.from_matrix(Pose3(*row[1:].tolist()).matrix() @ optical_from_body).as_array()
    notes["truth"] = "groundtruth.txt, of the camera"
    return rows


def _accelerations(path: Path, notes: dict[str, str]) -> list[ImuReading]:
    """Return the readings of the accelerometer; turn rates are NaN, because there are no gyroscopes."""
    file = path / ACCELERATIONS
    if not file.is_file():
        return []
    rows = read_table(file, (ANY_TIME, "x", "y", "z"), notes=notes)
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return [ImuReading(float(row[0]), row[1:].copy(), np.full(3, np.nan), "accelerometer") for row in rows]
