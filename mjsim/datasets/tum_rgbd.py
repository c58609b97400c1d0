"""Exports pictures of a recording as TUM RGB-D data sets, one per camera.

    DIR/R_CAMERA/rgb/STAMP.png        pictures, and rgb.txt with `stamp file`
    DIR/R_CAMERA/depth/STAMP.png      depth along the optical axis, 16 bits, 5000 per metre, 0 for none; and depth.txt
    DIR/R_CAMERA/groundtruth.txt      `stamp tx ty tz qx qy qz qw` of the optical frame in the world, at every tick and
                                      every picture, if the recording has any
    DIR/R_CAMERA/accelerometer.txt    `stamp ax ay az` of the robot's first inertial sensor, if it has one
    DIR/R_CAMERA/camera.yaml          calibration, as ORB-SLAM reads it

Times in seconds with nine digits, lengths in metres.

References:
    Sturm et al., A benchmark for the evaluation of RGB-D SLAM systems, IROS 2012; "File formats" of its web page.
"""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO

import numpy as np

from mjsim.datasets.dataset_folder import new_folders
from mjsim.datasets.recorded_robots import RecordedRobots, RecordedTick, depth_time, png_of
from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose3
from mjsim.interface import Intrinsics
from mjsim.record import Recording

DEPTH_SCALE = 5000.0
"""Values per metre in a depth picture."""
FILES = r"(rgb|depth)/[\d.]+\.(png|jpg)|(rgb|depth|groundtruth|accelerometer)\.txt|camera\.yaml"


def export_tum_rgbd(
    recording: Recording, folder: str | Path, *, redraw: bool = False, overwrite: bool = False
) -> list[Path]:
    """Write a TUM RGB-D data set for each camera, in `R_CAMERA`; depth, if there is any, is rendered again.

    Args:
        recording: A run.
        folder: Folder of all data sets.
        redraw: Whether to render pictures again from the recorded states, as PNG; otherwise as recorded.
        overwrite: Whether an existing folder may be replaced.

    Returns:
        The folder of each data set.

    Raises:
        UsageError: No robot has a camera, pictures were not recorded, or a data set exists or cannot be written.
    """
    cameras = recording.cameras()
    if not cameras:
        raise UsageError(f"'{recording.path}' has no camera; a TUM RGB-D data set consists of pictures")
    places = [Path(folder) / f"{robot}_{camera}" for robot, camera in cameras]
    with (
        new_folders(places, files=FILES, overwrite=overwrite) as parts,
        RecordedRobots(recording, redraw=redraw) as recorded,
    ):
        for (robot, camera), part in zip(cameras, parts, strict=True):
            _write(recorded, robot, camera, part)
    return places


def _write(recorded: RecordedRobots, robot: str, camera: str, folder: Path) -> None:
    """Write the data set of one camera."""
    depth = recorded.has_depth(robot, camera)
    for name in ("rgb", "depth") if depth else ("rgb",):
        (folder / name).mkdir(parents=True)
    pictures, depths, stamps = [], [], []
    imu = next((name for name, sensor in recorded.infos[robot].sensors.items() if sensor.kind == "imu"), None)
    for tick in _felt(recorded.ticks(robot), imu, folder / "accelerometer.txt"):
        if (stamp := tick.stamps.get(camera)) is not None:
            data, suffix = recorded.picture(robot, camera, stamp)
            pictures.append(_file(folder, "rgb", stamp, data, suffix))
            stamps.append(stamp)
            if depth:
                frame = recorded.frame(robot, camera, stamp)
                if frame.depth is not None:  # a log may lack some
                    png = png_of(_in_steps(frame.depth))
                    depths.append(_file(folder, "depth", depth_time(frame), png, "png"))
    _list(folder / "rgb.txt", "color images\n# timestamp filename", pictures)
    if depth:
        _list(folder / "depth.txt", f"depth maps, {DEPTH_SCALE:g} per metre\n# timestamp filename", depths)
    truth = [_row(time, pose.as_array()) for time, pose in _poses(recorded, robot, camera, stamps).items()]
    # A log without any has no such file, as programs that read the format expect.
    if truth:
        _list(folder / "groundtruth.txt", "ground truth trajectory\n# timestamp tx ty tz qx qy qz qw", truth)
    intrinsics = recorded.infos[robot].sensors[camera].intrinsics
    assert intrinsics is not None, "it is a camera"
    rate = recorded.infos[robot].sensors[camera].rate_hz
    (folder / "camera.yaml").write_text(_calibration(intrinsics, rate_hz=rate))


def _poses(recorded: RecordedRobots, robot: str, camera: str, stamps: Sequence[float]) -> dict[float, Pose3]:
    """Return the true poses of a camera's optical frame by time [s]: at each tick, and at pictures between ticks.

    Pictures of a log may be between ticks, and programs look for a pose at each. A camera on an arm has none there.
    """
    if camera in recorded.on_arms(robot):
        placed = ((tick.moment, recorded.world_from_sensor(robot, camera, tick)) for tick in recorded.ticks(robot))
        return {time: pose for time, pose in placed if pose is not None}
    mounted = recorded.infos[robot].sensors[camera].robot_from_sensor
    poses = recorded.truths(robot, stamps)
    return {time: Pose3.from_matrix(pose.matrix() @ mounted) for time, pose in poses.items()}


def _felt(ticks: Iterator[RecordedTick], imu: str | None, path: Path) -> Iterator[RecordedTick]:
    """Yield ticks, and write the accelerations that an inertial sensor measured; no file without any."""
    with ExitStack() as stack:
        file: IO[str] | None = None
        for tick in ticks:
            for each in tick.seen.imu if tick.seen is not None else ():
                if each.name == imu and np.isfinite(each.acceleration).all():
                    if file is None:
                        file = stack.enter_context(path.open("w"))
                        file.write("# accelerometer data\n# timestamp ax ay az\n")
                    file.write(f"{_row(each.stamp, each.acceleration)}\n")
            yield tick


def _in_steps(metres: Array) -> "np.ndarray[tuple[int, ...], np.dtype[np.uint16]]":
    """Return depth [m] in TUM's unit, 0 for none or beyond the range of 16 bits."""
    steps = np.rint(np.where(np.isfinite(metres), metres, 0.0) * DEPTH_SCALE)
    return np.where(steps <= np.iinfo(np.uint16).max, steps, 0.0).astype(np.uint16)


def _row(time: float, values: Array) -> str:
    return f"{time:.9f} {' '.join(map(repr, values.tolist()))}"


def _file(folder: Path, kind: str, stamp: float, data: bytes, suffix: str) -> str:
    """Write a picture, and return its line in the list."""
    # Padded, so that files sort by time.
    name = f"{kind}/{stamp:020.9f}.{suffix}"
    (folder / name).write_bytes(data)
    return f"{stamp:.9f} {name}"


def _list(path: Path, head: str, rows: Sequence[str]) -> None:
    path.write_text("".join(f"{line}\n" for line in (f"# {head}", *rows)))


def _calibration(camera: Intrinsics, *, rate_hz: float) -> str:
    """Return a calibration in the format of ORB-SLAM2 and ORB-SLAM3."""
    fisheye = camera.lens == "fisheye"
    keys = ("k1", "k2", "k3", "k4") if fisheye else ("k1", "k2", "p1", "p2", "k3")
    if camera.is_rational():
        raise UsageError("the lens has a rational model with 8 coefficients; calibrations of ORB-SLAM support up to 5")
    numbers = {
        "fx": camera.fx,
        "fy": camera.fy,
        "cx": camera.cx,
        "cy": camera.cy,
        **dict(zip(keys, camera.coefficients(), strict=True)),
    }
    return "\n".join(
        [
            "%YAML:1.0",
            f'Camera.type: "{"KannalaBrandt8" if fisheye else "PinHole"}"',
            *(f"Camera.{key}: {float(value)!r}" for key, value in numbers.items()),
            f"Camera.width: {camera.width}",
            f"Camera.height: {camera.height}",
            f"Camera.fps: {rate_hz:g}",
            "Camera.RGB: 1",
            f"DepthMapFactor: {DEPTH_SCALE:.1f}",
            "",
        ]
    )
