"""Exports pictures and inertial readings of a recording as EuRoC (ASL) data sets, one per robot.

    DIR/R/mav0/cam0/data/NANOSECONDS.png, data.csv, sensor.yaml     one per camera; camN in the order of the world
    DIR/R/mav0/imu0/data.csv, sensor.yaml                           one per inertial sensor
    DIR/R/mav0/state_groundtruth_estimate0/data.csv, sensor.yaml    the truth at every tick and picture, where known
    DIR/R/mav0/body.yaml

The body frame is that of imu0, as VIO programs expect, or the robot's without one; `T_BS` of a sensor is
body_from_sensor, that of a camera its optical frame. The world frame R of the truth is the world's, z up. Velocities of
the truth are central differences of its positions; biases are 0, since recordings do not contain those of the sensors.

References:
    Burri et al., The EuRoC micro aerial vehicle datasets, IJRR 35(10), 2016, section 4.
"""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from mjsim.datasets.dataset_folder import new_folders
from mjsim.datasets.recorded_robots import RecordedRobots
from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose3
from mjsim.interface import SensorInfo
from mjsim.progress import say
from mjsim.record import Recording
from mjsim.ros import nanoseconds

FILES = r"mav0/(body\.yaml|[^/]+/(data\.csv|sensor\.yaml|data/\d+\.(png|jpg)))"
IMU_HEAD = (
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
)
TRUTH_HEAD = (
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [],"
    " v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1],"
    " b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1],"
    " b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]"
)


def export_euroc(
    recording: Recording, folder: str | Path, *, redraw: bool = False, overwrite: bool = False
) -> list[Path]:
    """Write an EuRoC data set for each robot with a camera or an inertial sensor.

    Args:
        recording: A run.
        folder: Folder of all data sets.
        redraw: Whether to render pictures again from the recorded states, as PNG; otherwise as recorded.
        overwrite: Whether an existing folder may be replaced.

    Returns:
        The folder of each data set.

    Raises:
        UsageError: No robot has such a sensor fixed to it, pictures were not recorded, or a data set
            exists or cannot be written.
    """
    with RecordedRobots(recording, redraw=redraw) as recorded:
        robots = [robot for robot in recording.robots if _sensors(recorded, robot, "camera", "imu")]
        carried = _carried(recorded)
        if not robots and carried:
            raise UsageError(f"{carried[0]} moves with an arm; EuRoC supports only fixed sensors")
        if not robots:
            raise UsageError(f"'{recording.path}' has no camera and no inertial sensor; a EuRoC data set needs one")
        for each in carried:
            say(f"{each} moves with an arm; EuRoC supports only fixed sensors: it is left out")
        places = [Path(folder) / robot for robot in robots]
        with new_folders(places, files=FILES, overwrite=overwrite) as parts:
            for robot, part in zip(robots, parts, strict=True):
                _write(recorded, robot, part / "mav0")
    return places


def _sensors(recorded: RecordedRobots, robot: str, *kinds: str) -> dict[str, SensorInfo]:
    """Return the sensors of some kinds that are fixed to a robot."""
    sheets, moving = recorded.infos[robot].sensors, recorded.on_arms(robot)
    return {name: sheet for name, sheet in sheets.items() if sheet.kind in kinds and name not in moving}


def _carried(recorded: RecordedRobots) -> list[str]:
    """Return the names of cameras and inertial sensors on arms, for a message."""
    return [
        f"'{name}' of robot '{robot}'"
        for robot, about in recorded.infos.items()
        for name in sorted(recorded.on_arms(robot))
        if about.sensors[name].kind in ("camera", "imu")
    ]


def _write(recorded: RecordedRobots, robot: str, folder: Path) -> None:
    """Write the data set of one robot."""
    folder.mkdir(parents=True)
    cameras, sheets = _sensors(recorded, robot, "camera"), _sensors(recorded, robot, "imu")
    waiting = tables_of(recorded, robot, list(sheets), folder)
    imus = {name: sheet for name, sheet in sheets.items() if name in waiting}
    for name in sheets.keys() - imus.keys():
        line = f"'{name}' of robot '{robot}' does not measure turn rates and accelerations, as EuRoC requires"
        if not cameras and not imus:
            raise UsageError(line)
        say(f"{line}: it is left out")
    base_from_body = next((sheet.robot_from_sensor for sheet in imus.values()), np.eye(4))
    body_from_base = np.linalg.inv(base_from_body)
    for number, (name, sheet) in enumerate(cameras.items()):
        mounted = body_from_base @ sheet.robot_from_sensor
        _begin(folder / f"cam{number}", _camera_yaml(f"{robot}/{name}", sheet, mounted))
        _list(folder / f"cam{number}", "#timestamp [ns],filename", _pictures(recorded, robot, name, folder, number))
    for number, (name, sheet) in enumerate(imus.items()):
        _begin(folder / f"imu{number}", _imu_yaml(f"{robot}/{name}", sheet, body_from_base @ sheet.robot_from_sensor))
        waiting[name].rename(folder / f"imu{number}" / "data.csv")
    if states := _states(recorded, robot, base_from_body):
        truth = folder / "state_groundtruth_estimate0"
        _begin(truth, _yaml("truth", "visual-inertial", "the truth of the recording", np.eye(4)))
        _list(truth, TRUTH_HEAD, states)
    (folder / "body.yaml").write_text(f"%YAML:1.0\ncomment: robot {robot} of mjsim\n")


def _pictures(recorded: RecordedRobots, robot: str, camera: str, folder: Path, number: int) -> Iterator[str]:
    """Write the pictures of a camera, and yield their rows."""
    place = folder / f"cam{number}" / "data"
    place.mkdir()
    for tick in recorded.ticks(robot):
        if (stamp := tick.stamps.get(camera)) is not None:
            data, suffix = recorded.picture(robot, camera, stamp)
            file = f"{nanoseconds(stamp):019d}.{suffix}"
            (place / file).write_bytes(data)
            yield f"{nanoseconds(stamp)},{file}"


def tables_of(recorded: RecordedRobots, robot: str, names: Sequence[str], folder: Path) -> dict[str, Path]:
    """Write the table of each inertial sensor while the recording is read; it is moved once sensors have their numbers.

    Readings that lack a quantity are left out: the format has no value for that.

    Returns:
        Sensor -> its table; sensors without a complete reading are left out.
    """
    files, seen, written = {name: folder / f".{name}.csv" for name in names}, Counter[str](), Counter[str]()
    with ExitStack() as stack:
        tables = {name: stack.enter_context(file.open("w")) for name, file in files.items()}
        for table in tables.values():
            table.write(f"{IMU_HEAD}\n")
        for tick in recorded.ticks(robot) if names else ():
            for each in tick.seen.imu if tick.seen is not None else ():
                values = [*each.turn.tolist(), *each.acceleration.tolist()]
                seen[each.name] += 1
                if each.name in tables and all(map(math.isfinite, values)):
                    tables[each.name].write(f"{','.join([str(nanoseconds(each.stamp)), *map(repr, values)])}\n")
                    written[each.name] += 1
    unmeasured = [name for name in names if seen[name] and not written[name]]
    for name in unmeasured:
        files.pop(name).unlink()
    return files


def _begin(folder: Path, about: str) -> None:
    folder.mkdir(parents=True)
    (folder / "sensor.yaml").write_text(about)


def _list(folder: Path, head: str, rows: Iterable[str]) -> None:
    with (folder / "data.csv").open("w") as file:
        file.write(f"{head}\n")
        file.writelines(f"{line}\n" for line in rows)


def _states(recorded: RecordedRobots, robot: str, base_from_body: Array) -> list[str]:
    """Return the rows of the truth: position, quaternion (w first), velocity, biases."""
    taken = [stamp for tick in recorded.ticks(robot) for stamp in tick.stamps.values()]
    known = recorded.truths(robot, taken)
    times = np.array(list(known))
    poses = [Pose3.from_matrix(truth.matrix() @ base_from_body) for truth in known.values()]
    places = np.array([(pose.x, pose.y, pose.z) for pose in poses]).reshape(-1, 3)
    speeds = np.gradient(places, times, axis=0) if len(times) > 1 else np.zeros_like(places)
    return [
        ",".join(
            [
                str(nanoseconds(time)),
                *map(repr, (pose.x, pose.y, pose.z, pose.qw, pose.qx, pose.qy, pose.qz, *speed)),
                *["0.0"] * 6,
            ]
        )
        for time, pose, speed in zip(times.tolist(), poses, speeds.tolist(), strict=True)
    ]


def _yaml(name: str, kind: str, comment: str, T_BS: Array, more: Mapping[str, object] | None = None) -> str:
    """Return a sensor.yaml; T_BS is body_from_sensor, shape (4, 4) [m]."""
    return "\n".join(
        [
            "%YAML:1.0",
            f"sensor_type: {kind}",
            f"comment: {name}, {comment}",
            "T_BS:",
            "  cols: 4",
            "  rows: 4",
            f"  data: {T_BS.ravel().tolist()}",
            *(f"{key}: {value}" for key, value in (more or {}).items()),
            "",
        ]
    )


def _camera_yaml(name: str, sheet: SensorInfo, T_BS: Array) -> str:
    camera = sheet.intrinsics
    assert camera is not None, "it is a camera"
    fisheye = camera.lens == "fisheye"
    if camera.is_rational():
        raise UsageError(f"camera '{name}' has a rational lens model with 8 coefficients; EuRoC supports up to 5")
    lens = camera.coefficients()
    more = {
        "rate_hz": f"{sheet.rate_hz:g}",
        "resolution": [camera.width, camera.height],
        "camera_model": "pinhole",
        "intrinsics": [float(each) for each in (camera.fx, camera.fy, camera.cx, camera.cy)],
        "distortion_model": "equidistant" if fisheye else "radial-tangential",
        "distortion_coefficients": lens if any(lens[4:]) else lens[:4],
    }
    return _yaml(
        name, "camera", "fu fv cu cv; k1 k2 p1 p2 and k3 where it is not 0, or k1 to k4 of a fisheye", T_BS, more
    )


def _imu_yaml(name: str, sheet: SensorInfo, T_BS: Array) -> str:
    """Return the data sheet of an inertial sensor; densities are those of white noise at the rate of the readings."""
    root = np.sqrt(sheet.rate_hz)
    densities = {
        "gyroscope_noise_density": sheet.noise.get("turn", 0.0) / root,
        "gyroscope_random_walk": sheet.noise.get("turn_walk", 0.0),
        "accelerometer_noise_density": sheet.noise.get("acceleration", 0.0) / root,
        "accelerometer_random_walk": sheet.noise.get("acceleration_walk", 0.0),
    }
    more = {"rate_hz": f"{sheet.rate_hz:g}", **{key: float(value) for key, value in densities.items()}}
    return _yaml(name, "imu", "rad/s/sqrt(Hz), rad/s^2/sqrt(Hz), m/s^2/sqrt(Hz), m/s^3/sqrt(Hz)", T_BS, more)
