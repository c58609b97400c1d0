"""Converts a log in memory, of any format, to a recording."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array, Pose, Pose3, places_at, poses_at
from mjsim.interface import PointCloud, Scan
from mjsim.logs.resampling.origin import near_origin
from mjsim.logs.resampling.record_output import Output
from mjsim.logs.resampling.resample import MotionNoise, continuous
from mjsim.logs.resampling.robot_log import NO_ODOMETRY, RESTARTS, RobotLog, write_robot_logs
from mjsim.logs.resampling.ticks import cut, generated_world, name_from
from mjsim.logs.resampling.timed_readings import sensors_of, stamps_of
from mjsim.logs.resampling.wishes import Wishes
from mjsim.record import LoggedCamera
from mjsim.world import World

MOTION = MotionNoise(distance=0.05, turn=0.1, veer=0.02)
"""Noise of odometry for logs that do not give it. A guess for small robots on hard floors."""
RANGE, BEARING = 0.1, math.radians(2.0)
"""Standard deviations of a sighting for logs that do not give them [m, rad]. A guess."""
MAX_SECONDS = 1e6
"""Maximum duration of a recording, as in world files [s]."""
MIN_TICK_LIMIT, MAX_TICKS_PER_READING = 100_000, 1000
"""Maximum number of ticks of a recording: in total, and for each reading of its log."""
TICK_RATES = (10.0, 12.5, 25.0, 50.0, 125.0)
"""Tick rates to choose from by default [Hz]; ticks are whole numbers of physics steps."""
MIN_TICKS_PER_SCAN = 1.5
"""Minimum number of ticks per scan at the chosen rate."""
MAX_PITCH = 89.0
"""Maximum pitch of a camera in a world file, up and down [deg]."""


AHEAD = np.array([[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.3], [0.0, 0.0, 0.0, 1.0]])
"""robot_from_camera of a camera that looks ahead, 0.3 m above the floor; used if a log gives no pose [m]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mount:
    """Mounting pose of a lidar or an inertial sensor on its robot."""

    at: tuple[float, float, float] = (0.0, 0.0, 0.3)
    """Position in the robot's frame [m]."""
    yaw: float = 0.0
    """Left positive [rad]."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Log:
    """The log of one robot."""

    kind: str
    """Name of the format."""
    robot: RobotLog
    name: str = "robot"
    """Name of the robot."""
    mounts: Mapping[str, Mount] = field(default_factory=dict)
    """By the name of the lidar, or of the inertial sensor."""
    cameras: Mapping[str, LoggedCamera] = field(default_factory=dict)
    """Data sheets by the name of the camera."""
    sensors: Sequence[str] = ()
    """Further sensors, as text for a world file."""
    steps: int | None = None
    """Counts of a wheel's encoder per revolution; None without encoders."""
    landmarks: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Positions of surveyed landmarks [m]."""
    motion: MotionNoise = MOTION
    sighting: tuple[float, float] = (RANGE, BEARING)
    """Standard deviations of range and bearing [m, rad]."""
    notes: Mapping[str, str] = field(default_factory=dict)
    """Entries for the recording's metadata, such as what was left out."""

    def times(self) -> tuple[float, float]:
        """Return the times of the first and the last reading, ignoring ground truth [s]."""
        columns = self._columns()
        return min(float(column[0]) for column in columns), max(float(column[-1]) for column in columns)

    def readings(self) -> int:
        """Return the number of readings, ignoring ground truth."""
        return sum(map(len, self._columns()))

    def _columns(self) -> Sequence[Array]:
        """Return the times of the readings of each sensor that has any [s]."""
        robot = self.robot
        moves = robot.track if robot.track is not None else robot.twists
        seen, felt = stamps_of(robot.sightings), stamps_of(robot.imu)
        streams = [each.stamps for part in (robot.scans, robot.cameras, robot.clouds) for each in part.values()]
        return [column for column in (moves[:, 0], seen, felt, *streams) if len(column)]


def record_logs(
    logs: Sequence[Log],
    source: Path,
    wishes: Wishes,
    output: Output,
) -> Iterator[float]:
    """Write the logs of some robots, with a common clock, as a recording, and yield the progress [%].

    Args:
        logs: One per robot, with different names.
        source: The file or folder that they were read from.
        wishes: Options of the user.
        output: The recording.

    Raises:
        UsageError: The selected part of the log is empty.
        RecordingError: The file cannot be written.
    """
    logs = [_continuous(log, f"{RESTARTS} of {log.name}" if len(logs) > 1 else RESTARTS) for log in logs]
    robots, marks, origin = near_origin([log.robot for log in logs], [log.landmarks for log in logs])
    logs = [
        replace(log, robot=robot, landmarks=landmarks)
        for log, robot, landmarks in zip(logs, robots, marks, strict=True)
    ]
    firsts, lasts = zip(*(log.times() for log in logs), strict=True)
    rate = wishes.rate_hz or max(_rate_of(log) for log in logs)
    # One more tick, for data after the last one.
    last = max(lasts) if wishes.seconds is not None else max(lasts) + 1.0 / rate - 1e-6
    if max(lasts) <= min(firsts):
        raise UsageError(f"all readings in '{source}' have the same time; a recording needs at least two ticks")
    span = cut(min(firsts), last, begin=wishes.begin, seconds=wishes.seconds, rate_hz=rate)
    readings = sum(log.readings() for log in logs)
    longest = min(MAX_SECONDS, (MIN_TICK_LIMIT + MAX_TICKS_PER_READING * readings) / rate)
    if span[1] - span[0] > longest:
        raise UsageError(
            f"'{source}' lasts {span[1] - span[0]:.0f} s and has {readings} readings; a recording of them lasts at most"
            f" {longest:.0f} s: choose a part with --begin and --seconds, or give the unit of its times if they are not"
            " seconds"
        )
    notes = {key: value for log in logs for key, value in (*log.notes.items(), *_missed_truth(log, span))}
    if origin:
        notes["origin of the world"] = origin
    if not all(log.robot.has_odometry() for log in logs):
        notes.setdefault("odometry", NO_ODOMETRY)
    return write_robot_logs(
        world_of(logs, name_from(source), span=span, rate_hz=rate, wishes=wishes, source=f"readings of '{source}'"),
        {log.name: log.robot for log in logs},
        span=span,
        noise=wishes.motion_over(logs[0].motion),
        bias=wishes.bias,
        metadata={"log": logs[0].kind, "log source": str(source), **notes},
        cameras={(log.name, name): camera for log in logs for name, camera in log.cameras.items()},
        output=output,
    )


def _continuous(log: Log, fact: str) -> Log:
    """Return a log whose odometry is continuous; restarts are noted as a fact."""
    if log.robot.track is None:
        return log
    track, restarted = continuous(log.robot.track)
    if not restarted:
        return log
    return replace(log, robot=replace(log.robot, track=track), notes={**log.notes, fact: restarted})


def _missed_truth(log: Log, span: tuple[float, float]) -> Iterator[tuple[str, str]]:
    """Yield a message if the times of the ground truth do not overlap those of the sensors."""
    truth = log.robot.poses if log.robot.poses is not None else log.robot.truth
    if truth is not None and len(truth) and (truth[-1, 0] < span[0] or truth[0, 0] > span[1]):
        first, last = float(truth[0, 0]), float(truth[-1, 0])
        fact = f"all of it is from {first:.15g} to {last:.15g} s, readings from {span[0]:.15g} to {span[1]:.15g} s"
        yield (f"truth of {log.name} left out", fact)


def world_of(
    logs: Sequence[Log],
    name: str,
    *,
    span: tuple[float, float],
    rate_hz: float,
    wishes: Wishes,
    source: str,
    step_ms: int = 4,
) -> World:
    """Return the world of logs: no walls, their landmarks as reflectors, their robots at their starts.

    Args:
        logs: One per robot.
        name: Name of the world.
        span: First and last time of the log's clock [s].
        rate_hz: Ticks per second.
        wishes: Options of the user.
        source: Where they are from, for error messages.
        step_ms: Step of the world's physics; ticks are whole numbers of it.

    Raises:
        UsageError: A name or a number in the logs is not possible in a world.
    """
    marks = {mark: place for log in logs for mark, place in log.landmarks.items()}
    beacons = [f"  - {{name: {json.dumps(mark)}, at: [{x!r}, {y!r}], width: 0.1}}" for mark, (x, y) in marks.items()]
    robots = [line for log in logs for line in _robot_lines(log, span[0], rate_hz, wishes)]
    lines = [
        f"# From a log: {logs[0].kind}. It contains no walls, and the robot's body is a guess.",
        "mjsim: 1",
        f"name: {name}",
        *(["beacons:", *beacons] if beacons else []),
        "robots:",
        *robots,
        f"run: {{seconds: {span[1] - span[0]!r}, rate_hz: {rate_hz!r}, step_ms: {step_ms},",
        f"      map: {'known' if wishes.known_map else 'unknown'}}}",
    ]
    return generated_world("\n".join(lines) + "\n", source)


def _robot_lines(log: Log, time: float, rate_hz: float, wishes: Wishes) -> list[str]:
    """Return the lines of the world file about a robot that starts at a time [s]."""
    start, sensors = _start(log.robot, time), _sensor_texts(log, rate_hz, wishes)
    return [
        f"  - name: {json.dumps(log.name)}",
        f"    at: [{start.x!r}, {start.y!r}]",
        f"    heading_deg: {math.degrees(start.heading)!r}",
        "    drive: {type: differential, wheel_radius: 0.1, track: 0.4, max_speed: 3}",
        "    body: {radius: 0.25, height: 0.3, mass: 15}",
        *([f"    odometry: {{ticks: {log.steps}}}"] if log.steps is not None else []),
        *(["    sensors:", *(f"      - {text}" for text in sensors)] if sensors else []),
    ]


def _sensor_texts(log: Log, rate_hz: float, wishes: Wishes) -> list[str]:
    """Return the lines of the world file about each sensor of a robot."""
    robot, deviations = log.robot, wishes.sighting_over(*log.sighting)
    texts = [
        _lidar_text(lidar, scans.take(0), log.mounts.get(lidar, Mount()), rate_hz)
        for lidar, scans in robot.scans.items()
    ]
    texts += [_camera_text(name, log.cameras[name], rate_hz) for name in robot.cameras]
    texts += [
        _lidar3d_text(name, clouds.take(0), log.mounts.get(name, Mount()), rate_hz)
        for name, clouds in robot.clouds.items()
    ]
    if robot.sightings:
        noise = f"noise: {{range: {deviations[0]!r}, bearing_deg: {math.degrees(deviations[1])!r}}}"
        nameless = all(sighting.name is None for sighting in robot.sightings)
        texts.append(
            f"{{beacons: eyes, range: [0.01, {_farthest(log)!r}], fov_deg: 360, rate_hz: {rate_hz!r},"
            f" anonymous: {str(nameless).lower()}, {noise}}}"
        )
    texts += log.sensors
    return texts + [_imu_text(imu, log.mounts.get(imu, Mount())) for imu in sensors_of(robot.imu)]


def _camera_text(name: str, camera: LoggedCamera, rate_hz: float) -> str:
    """Return the closest description possible in a world file; the data sheet in the metadata is exact."""
    intrinsics, place = camera.intrinsics, camera.robot_from_camera
    place = AHEAD if place is None else place
    ahead = place[:3, 2]
    yaw, pitch = math.atan2(ahead[1], ahead[0]), math.asin(min(max(float(ahead[2]), -1.0), 1.0))
    fov = math.degrees(2.0 * math.atan(intrinsics.width / 2.0 / intrinsics.fx))
    pitch_deg = min(max(math.degrees(pitch), -MAX_PITCH), MAX_PITCH)
    return (
        f"{{camera: {name}, at: {place[:3, 3].tolist()}, yaw_deg: {math.degrees(yaw)!r},"
        f" pitch_deg: {pitch_deg!r}, width: {intrinsics.width}, height: {intrinsics.height},"
        f" fov_deg: {min(max(fov, 5.0), 150.0)!r}, rate_hz: {rate_hz!r}, noise: 0"
        f"{', depth: true' if camera.has_depth else ''}}}"
    )


def _lidar_text(name: str, scan: Scan, mount: Mount, rate_hz: float) -> str:
    beams = len(scan.ranges)
    fov = min(math.degrees(abs(scan.angle_increment)) * (beams - 1), 360.0)
    # Each scan has its own angles; an asymmetric fan is described only by them.
    return (
        f"{{lidar: {name}, at: {[float(value) for value in mount.at]}, yaw_deg: {math.degrees(mount.yaw)!r},"
        f" beams: {beams}, fov_deg: {max(fov, 1e-3)!r}, range: [{scan.range_min!r}, {scan.range_max!r}],"
        f" rate_hz: {rate_hz!r}, noise: {{range: 0.02}}}}"
    )


def _lidar3d_text(name: str, cloud: PointCloud, mount: Mount, rate_hz: float) -> str:
    """Return the closest description possible in a world file; each cloud has its own directions."""
    rings = min(int(cloud.rings.max(initial=0)) + 1, 256)
    return (
        f"{{lidar3d: {name}, at: {[float(value) for value in mount.at]}, yaw_deg: {math.degrees(mount.yaw)!r},"
        f" rings: {rings}, range: [0.01, 1000], rate_hz: {rate_hz!r}}}"
    )


def _imu_text(name: str, mount: Mount) -> str:
    return f"{{imu: {name}, at: {[float(value) for value in mount.at]}, yaw_deg: {math.degrees(mount.yaw)!r}}}"


def _farthest(log: Log) -> float:
    return max(1.0, 1.1 * max(float(sighting.range) for sighting in log.robot.sightings))


def _start(robot: RobotLog, time: float) -> Pose:
    """Return the start of a robot: its true pose, or else the origin."""
    if robot.poses is not None:
        begin = np.array([time]).clip(robot.poses[0, 0], robot.poses[-1, 0])
        return Pose3(*poses_at(begin, robot.poses, gap=math.inf)[0].tolist()).planar()
    if robot.truth is None or not len(robot.truth):
        return Pose(0.0, 0.0, 0.0)
    begin = np.array([time]).clip(robot.truth[0, 0], robot.truth[-1, 0])
    return Pose.from_array(places_at(begin, robot.truth, gap=math.inf)[0])


def _rate_of(log: Log) -> float:
    """Return the lowest of `TICK_RATES` with `MIN_TICKS_PER_SCAN` ticks or more per reading of lidars and cameras."""
    first, last = log.times()
    robot = log.robot
    counts = [len(each) for part in (robot.scans, robot.cameras, robot.clouds) for each in part.values()]
    frequency = max(counts, default=0) / max(last - first, 1e-3)
    return next((rate for rate in TICK_RATES if rate >= MIN_TICKS_PER_SCAN * frequency), TICK_RATES[-1])
