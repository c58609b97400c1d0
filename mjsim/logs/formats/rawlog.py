"""Rawlogs of MRPT: objects in binary form (see `mrpt_bytes`), compressed by gzip or not.

There are two forms: pairs of actions (`CActionCollection`) and observations (`CSensoryFrame`), or observations with
times one after the other. 2-D scans, landmarks and odometry of both forms are read; others are counted and left out.

References:
    The Mobile Robot Programming Toolkit, https://docs.mrpt.org/reference/latest/, "Rawlog format" and the classes
    `CObservation2DRangeScan` (versions 0 to 8), `CObservationBearingRange` (3), `CObservationOdometry` (0 to 2),
    `CActionRobotMovement2D` (3 to 7).
"""

import gzip
import math
import re
import struct
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError
from mjsim.geometry import Array
from mjsim.interface import Scan, Sighting
from mjsim.inventory import Fate, told
from mjsim.logs.files import MAX_NUMBER
from mjsim.logs.formats.mrpt_bytes import MrptBytes
from mjsim.logs.resampling import Log, Mount, RobotLog, kept

SUFFIXES = (".rawlog", ".rawlog.gz")
MIN_UNPACKED, MAX_COMPRESSION = 64 << 20, 30
"""Maximum length of unpacked data: absolute [bytes], and as a multiple of the size of the file."""
HEAD = 4096
"""Bytes in which the first object must begin."""
MAX_BEAMS, MAX_LANDMARKS, MAX_LIDARS, MAX_KINDS = 10_000, 1000, 20, 50
"""Maximum number of beams of a scan, landmarks of an observation, lidars (or their places), and kinds counted."""
MIN_RANGE = 0.02
"""Smaller ranges were not measured [m]."""
UNIX_EPOCH = 11_644_473_600
"""Start of Unix time in times of MRPT, which begin in 1601 and count 100 ns [s]."""
USUAL_PERIOD = 0.1
"""Usual period from one action to the next, if the file has no times [s]."""
MAX_TILT = math.radians(5.0)
"""A scanner tilted by more does not measure horizontally [rad]."""
VERSIONS: Mapping[str, range] = {
    "CObservation2DRangeScan": range(9),
    "CObservationBearingRange": range(3, 4),
    "CObservationOdometry": range(3),
    "CActionRobotMovement2D": range(3, 8),
}
"""Versions of the classes that are read."""
RANGE, BEARING = 0.1, math.radians(2.0)
"""Standard deviations of a landmark for a log that gives covariances instead [m, rad]. A guess."""
ODOMETRY = 0
"""Method of estimation of a movement that is odometry; 1 is scan matching."""
_HEADER = re.compile(rb"[\x80-\xff](?:[a-z0-9]+::)*C[A-Z0-9][A-Za-z0-9_]{2,60}")


@dataclass(slots=True)
class _Found:
    """The data read so far."""

    odometry: list[tuple[float, float, float, float]] = field(default_factory=list)
    scans: dict[str, list[Scan]] = field(default_factory=dict)
    mounts: dict[str, Mount] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    moved: list[Array] = field(default_factory=list)
    """Movements since the last observations, each shape (4, 4)."""
    pose: Array = field(default_factory=lambda: np.eye(4))
    """The sum of all movements."""
    pairs: int = 0
    """Number of frames of observations."""
    timeless: int = 0
    """Number of observations without a time."""
    sightings: list[Sighting] = field(default_factory=list)

    def leave_out(self, kind: str) -> None:
        """Count an object that is not read."""
        self.left_out[kind if kind in self.left_out or len(self.left_out) < MAX_KINDS else "other objects"] += 1


def is_rawlog(path: Path) -> bool:
    """Return whether a file begins with an object of MRPT."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(HEAD)
    if head.startswith(b"\x1f\x8b"):
        try:
            with gzip.open(path) as packed:
                head = packed.read(HEAD)
        except (OSError, EOFError, zlib.error):
            return False
    first = next(_objects(head), None)
    return first is not None and first[0] == 0


def read_rawlog(path: Path) -> Log:
    """Return the log of a robot; its lidars have the labels of their sensors.

    Raises:
        UsageError: It cannot be read, or holds neither scans nor odometry.
    """
    notes: dict[str, str] = {}
    data = _unpacked(path, notes)
    found, done = _Found(), 0
    for start, name, version in _objects(data):
        if start < done:
            continue
        reader = MrptBytes(data, start)
        reader.head()
        try:
            _take(found, name, version, reader)
            done = reader.place
        except struct.error as error:
            kind = f"{name} that is cut" if "unpack" in str(error) else f"broken {name} ({error})"
            found.leave_out(kind)
    if not found.odometry and not found.scans and not found.sightings:
        seen = ", ".join(f"{count} {name}" for name, count in found.left_out.most_common(5))
        raise UsageError(
            f"'{path}' holds neither 2-D scans, landmarks nor odometry of MRPT{f'; it has {seen}' if seen else ''}"
        )
    notes |= {f"{kind} left out": str(count) for kind, count in sorted(found.left_out.items())}
    if found.timeless:
        notes["times"] = told(
            Fate.GUESSED, f"{found.timeless} observations have none; {USUAL_PERIOD} s from one to the next"
        )
    robot = RobotLog(
        track=_track(found.odometry) if found.odometry else None,
        scans={name: kept(_in_order(scans)) for name, scans in found.scans.items()},
        sightings=sorted(found.sightings, key=lambda sighting: sighting.stamp),
        gap=1.0,
    )
    return Log(kind="rawlog", robot=robot, mounts=found.mounts, notes=notes)


def _unpacked(path: Path, notes: dict[str, str]) -> bytes:
    """Return the contents of a file; a truncated one is read as far as possible, which is noted."""
    limit = max(MIN_UNPACKED, MAX_COMPRESSION * path.stat().st_size)
    parts, size = [], 0
    with path.open("rb") as plain:
        packed = plain.read(2) == b"\x1f\x8b"
        plain.seek(0)
        file = gzip.GzipFile(fileobj=plain) if packed else plain
        try:
            # In small parts: at the end of a truncated file, the part being read is lost.
            while part := file.read1(1 << 16):
                parts.append(part)
                size += len(part)
                if size > limit:
                    raise UsageError(f"'{path}' unpacks to more than {limit >> 20} MB; unpack it yourself")
        except (EOFError, zlib.error, gzip.BadGzipFile):
            notes["file"] = told(Fate.LEFT_OUT, "it is truncated or damaged; read as far as it could be unpacked")
    return b"".join(parts)


def _objects(data: bytes) -> Iterator[tuple[int, str, int]]:
    """Yield where objects begin, their class without namespace, and their version."""
    for match in _HEADER.finditer(data):
        start = match.start()
        end = start + 1 + (data[start] & 0x7F)
        if end < len(data) and end <= match.end():
            yield start, data[start + 1 : end].decode().rpartition("::")[2], data[end]


def _take(found: _Found, name: str, version: int, reader: MrptBytes) -> None:
    """Process an object whose head was read."""
    if version not in VERSIONS.get(name, (version,)):
        found.leave_out(f"{name} of version {version}")
    elif name == "CObservation2DRangeScan":
        _take_scan(found, version, reader)
    elif name == "CObservationOdometry":
        _take_odometry(found, reader)
    elif name == "CObservationBearingRange":
        _take_landmarks(found, reader)
    elif name == "CActionRobotMovement2D":
        if int(reader.take("i")[0]) == ODOMETRY:
            found.moved.append(reader.pose())
        else:
            found.moved.append(_mean(reader))
    elif name == "CSensoryFrame":
        found.pairs += 1
        for move in found.moved:
            found.pose = found.pose @ move
        found.moved.clear()
    elif name.startswith(("CObservation", "CAction")) and name != "CActionCollection":
        found.leave_out(name)


def _take_odometry(found: _Found, reader: MrptBytes) -> None:
    """Process a pose by odometry, which is of no use without its time."""
    pose, _, (ticks,) = reader.pose(), reader.text(), reader.take("Q")
    if not ticks:
        raise struct.error("it has no time")
    found.odometry.append((_seconds(ticks), *_planar(pose)))


def _mean(reader: MrptBytes) -> Array:
    """Return the mean of a movement that scan matching found."""
    name, _ = reader.head()
    if name != "CPosePDFGaussian":
        raise struct.error("a movement of another class")
    return reader.pose()


def _take_landmarks(found: _Found, reader: MrptBytes) -> None:
    """Process ranges and bearings of landmarks, with their numbers."""
    reader.take("4f")
    robot_from_sensor, (ticks,), (has_covariances,) = reader.pose(), reader.take("Q"), reader.take("B")
    spread = (RANGE, BEARING) if has_covariances else reader.take("3f")[:2]
    (count,) = reader.take("I")
    if count > MAX_LANDMARKS or not all(0.0 <= each <= MAX_NUMBER for each in spread):
        raise struct.error("its numbers are not valid landmarks")
    covariance = np.diag(np.square([max(each, 1e-6) for each in spread]))
    seen = [_landmark(reader, robot_from_sensor, has_covariance=bool(has_covariances)) for _ in range(int(count))]
    stamp = _stamp(found, ticks)
    for name, x, y in seen:
        if MIN_RANGE <= math.hypot(x, y) <= MAX_NUMBER:
            found.sightings.append(Sighting(stamp, name, math.hypot(x, y), math.atan2(y, x), covariance))
        else:
            found.leave_out("landmarks without a range")


def _landmark(reader: MrptBytes, robot_from_sensor: Array, *, has_covariance: bool) -> tuple[str | None, float, float]:
    """Return the name of a landmark, None if it has none, and its place in the frame of the robot [m]."""
    distance, bearing, elevation, number = reader.take("3fi")
    if has_covariance:
        reader.matrix()
    if not all(map(math.isfinite, (distance, bearing, elevation))):
        return None, math.nan, math.nan
    flat = distance * math.cos(elevation)
    local = [flat * math.cos(bearing), flat * math.sin(bearing), distance * math.sin(elevation), 1.0]
    x, y, *_ = robot_from_sensor @ local
    return f"landmark{int(number)}" if number >= 0 else None, float(x), float(y)


def _stamp(found: _Found, ticks: float) -> float:
    """Return the time of an observation, and note the pose of the robot then, if it belongs to a frame [s]."""
    if not ticks and not found.pairs:
        raise struct.error("it has no time")
    found.timeless += not ticks
    stamp = _seconds(ticks) if ticks else USUAL_PERIOD * found.pairs
    if found.pairs and (not found.odometry or stamp > found.odometry[-1][0]):
        found.odometry.append((stamp, *_planar(found.pose)))
    return stamp


def _take_scan(found: _Found, version: int, reader: MrptBytes) -> None:
    """Process a 2-D scan."""
    aperture, leftwards, reach = reader.take("fBf")
    robot_from_sensor = reader.pose()
    if version < 6:
        reader.matrix()
    count = int(reader.take("I")[0])
    if not 2 <= count <= MAX_BEAMS or not 0.0 < aperture < 2.1 * math.pi or not 0.0 < reach <= MAX_NUMBER:
        raise struct.error("its numbers are not a valid scan")
    ranges = reader.array("<f4", count).astype(float)
    valid = reader.array("u1", count) > 0 if version >= 1 else ranges < reach
    if version >= 2:
        reader.take("f")
    ticks = reader.take("Q")[0] if version >= 3 else 0
    label, swept = "", 0.0
    if version >= 4:
        reader.take("f")
    if version >= 5:
        label, _ = reader.text(), reader.take("d")
    if version >= 7 and reader.take("B")[0]:
        reader.array("<i4", count)
    if version >= 8:
        (swept,) = reader.take("f")
    stamp = _stamp(found, ticks)
    turned = robot_from_sensor[:3, :3]
    if abs(turned[2, 2]) < math.cos(MAX_TILT):
        found.leave_out("scans of a tilted scanner")
        return
    # An upside-down scanner turns the other way.
    if bool(leftwards) != (turned[2, 2] > 0.0):
        ranges, valid = ranges[::-1], valid[::-1]
    ranges = np.where(valid, ranges, np.inf)
    ranges[~(ranges >= MIN_RANGE)] = -np.inf
    ranges[ranges >= reach] = np.inf
    step = aperture / (count - 1)
    increment = swept / (count - 1) if math.isfinite(swept) and swept > 0.0 else None
    scan = Scan(stamp, ranges, -aperture / 2, step, MIN_RANGE, reach, time_increment=increment)
    name = _named(found, label, robot_from_sensor)
    if name is None:
        found.leave_out(f"scans of more than {MAX_LIDARS} lidars, or places of them")
        return
    if (before := found.scans.get(name)) and len(before[0].ranges) != count:
        found.leave_out(f"scans of {name} with another number of beams")
        return
    found.scans.setdefault(name, []).append(scan)


def _named(found: _Found, label: str, robot_from_sensor: Array) -> str | None:
    """Return the name of a lidar: its label, with a number for another place; None if there are too many."""
    x, y, z = np.round(robot_from_sensor[:3, 3], 3).tolist()
    yaw = round(math.atan2(robot_from_sensor[1, 0], robot_from_sensor[0, 0]), 3)
    mount = Mount(at=(x + 0.0, y + 0.0, z if z > 0.0 else 0.3), yaw=yaw + 0.0)
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", label).strip("_")[:40] or "laser"
    for name in (plain, *(f"{plain}_{number}" for number in range(2, MAX_LIDARS + 1))):
        if name not in found.mounts and len(found.mounts) == MAX_LIDARS:
            return None
        if found.mounts.setdefault(name, mount) == mount:
            return name
    return None


def _planar(pose: Array) -> tuple[float, float, float]:
    return float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0])


def _seconds(ticks: float) -> float:
    """Return a time of MRPT since 1970 [s]."""
    return float(ticks) * 1e-7 - UNIX_EPOCH


def _track(rows: list[tuple[float, float, float, float]]) -> Array:
    """Return poses in order of time, each time once, shape (n, 4)."""
    table = np.array(rows)
    _, first = np.unique(table[:, 0], return_index=True)
    return np.asarray(table[first])


def _in_order(scans: list[Scan]) -> list[Scan]:
    by_time: Mapping[float, Scan] = {scan.stamp: scan for scan in scans}
    return [by_time[stamp] for stamp in sorted(by_time)]
