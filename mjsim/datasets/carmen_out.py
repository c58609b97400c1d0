"""Exports odometry, scans and truth of a recording as CARMEN logs, one file per robot.

    PARAM robot_frontlaser_offset METRES                          ...
    PARAM odometry_noise_distance NUMBER                          ... at the end; also _turn, _veer: noise of odometry
    ODOM x y theta tv rv accel                                    ipc_timestamp host logger_timestamp
    ROBOTLASERn type start fov step max accuracy remission n [ranges] k [remissions] laser x y theta, robot x y theta,
                tv rv forward_safety side_safety turn_axis        ...
    TRUEPOS true_x true_y true_theta odom_x odom_y odom_theta     ...

Laser n is the n-th lidar of the robot, at most five. Poses are those of dead reckoning, the laser's with its mount. A
beam without a return reads the laser's range, one that hit something too near reads 0.

References:
    The formats as described in the headers of logs of CARMEN's recorder.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from mjsim.datasets.recorded_robots import RecordedRobots, planar_pose
from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3
from mjsim.interface import Observation, Odometry, Scan
from mjsim.output import require_free, write_file
from mjsim.record import Recording

MAX_LASERS = 5
HOST = "mjsim"


def export_carmen(recording: Recording, file: str | Path, *, overwrite: bool = False) -> list[Path]:
    """Write a CARMEN log for each robot with a driver: FILE, or `FILE` with `_R` before its suffix for several.

    Returns:
        The files written.

    Raises:
        UsageError: No robot has a driver, one has more than five lidars, or a file exists or cannot be written.
    """
    robots = [robot for robot in recording.robots if recording.is_observed(robot)]
    if not robots:
        raise UsageError(f"'{recording.path}' has no observations; no robot had a driver in that run")
    file = Path(file)
    names = {robot: file if len(robots) == 1 else file.with_stem(f"{file.stem}_{robot}") for robot in robots}
    require_free(*names.values(), overwrite=overwrite, source=recording.path)
    with RecordedRobots(recording, redraw=False) as recorded:
        for robot, path in names.items():
            text = "".join(f"{line}\n" for line in _lines(recorded, robot))
            write_file(path, text.encode(), overwrite=overwrite)
    return list(names.values())


def _lines(recorded: RecordedRobots, robot: str) -> Iterator[str]:
    lidars = [name for name, sensor in recorded.infos[robot].sensors.items() if sensor.kind == "lidar"]
    if len(lidars) > MAX_LASERS:
        raise UsageError(f"robot '{robot}' has {len(lidars)} lidars; CARMEN supports at most {MAX_LASERS}")
    if moving := recorded.on_arms(robot) & {*lidars}:
        raise UsageError(
            f"lidar '{min(moving)}' of robot '{robot}' moves with an arm; CARMEN supports only fixed lidars"
        )
    yield "# CARMEN Logfile"
    yield f"# a run of mjsim, seed {recorded.recording.seed}; robot {robot}"
    mounts = {
        name: Pose3.from_matrix(recorded.infos[robot].sensors[name].robot_from_sensor).planar() for name in lidars
    }
    for name, word in zip(lidars, ("frontlaser", "rearlaser"), strict=False):
        yield _line("PARAM", f"robot_{word}_offset {mounts[name].x!r}", 0.0)
    track, claims = recorded.recording.robots[robot], list[tuple[float, float, float, float]]()
    last = 0.0
    for tick in recorded.ticks(robot):
        odometry, seen = planar_pose(track.odometry[tick.row]), tick.seen
        if seen is None or odometry is None:
            continue
        claims.append(_claim(seen.odometry))
        last = seen.moment
        yield _line("ODOM", _numbers(odometry, *_speeds(seen), 0.0), seen.moment)
        if tick.truth is not None:
            yield _line("TRUEPOS", f"{_numbers(tick.truth.planar())} {_numbers(odometry)}", seen.moment)
        for name, scan in seen.scans.items():
            taken = planar_pose(track.odometry_at([scan.stamp])[0]) or Pose(0.0, 0.0, 0.0)
            laser = f"ROBOTLASER{lidars.index(name) + 1}"
            yield _line(laser, _laser(scan, taken, mounts[name], _speeds(seen)), scan.stamp)
    for name, value in _noise(np.array(claims).reshape(-1, 4)).items():
        yield _line("PARAM", f"odometry_noise_{name} {value!r}", last)


def _claim(moved: Odometry) -> tuple[float, float, float, float]:
    """Return distance [m], turn [rad] and the variances of both for a step of odometry."""
    return float(np.hypot(moved.forward, moved.left)), abs(moved.turn), moved.covariance[0, 0], moved.covariance[2, 2]


def _noise(claims: Array) -> dict[str, float]:
    """Return the noise that explains the variances of odometry, by the fields of `MotionNoise`.

    Args:
        claims: Distance, turn and the variances of both for each step, shape (n, 4).
    """
    distance, turned, along, around = claims.T
    if not distance.sum() > 0.0:
        return {}
    (turn, veer), _ = nnls(np.column_stack([turned, distance]), around)
    return {
        "distance": float(np.sqrt(along.sum() / distance.sum())),
        "turn": float(turn**0.5),
        "veer": float(veer**0.5),
    }


def _speeds(seen: Observation) -> tuple[float, float]:
    """Return speed and turn rate since the last tick, by odometry [m/s, rad/s]."""
    return seen.odometry.forward / seen.dt, seen.odometry.turn / seen.dt


def _laser(scan: Scan, odometry: Pose, robot_from_laser: Pose, speeds: tuple[float, float]) -> str:
    """Return the fields of ROBOTLASER: unknown type and accuracy, remission if available."""
    step, farthest = float(scan.angle_increment), float(scan.range_max)
    ranges = np.where(scan.ranges == np.inf, farthest, np.where(scan.ranges == -np.inf, 0.0, scan.ranges)).tolist()
    strengths = [] if scan.intensities is None else scan.intensities.tolist()
    return " ".join(
        [
            "0",
            *map(repr, (float(scan.angle_min), step * (len(ranges) - 1), step, farthest, 0.0)),
            str(int(bool(strengths))),
            *(str(len(ranges)), *map(repr, ranges), str(len(strengths)), *map(repr, strengths)),
            _numbers(odometry @ robot_from_laser),
            _numbers(odometry, *speeds, 0.0, 0.0, 0.0),
        ]
    )


def _numbers(pose: Pose, *more: float) -> str:
    return " ".join(repr(float(each)) for each in (pose.x, pose.y, pose.heading, *more))


def _line(word: str, values: str, time: float) -> str:
    return f"{word} {values} {time!r} {HOST} {time!r}"
