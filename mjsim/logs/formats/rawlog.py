"""Rawlogs of MRPT: objects in binary form, compressed by gzip or not.

An object is a byte with the length of its class's name and the highest bit set, the name, a byte with the version, its
fields in the order in which they are written (little-endian), and the byte 0x88. Fields may be objects.

There are two forms: pairs of actions (`CActionCollection`) and observations (`CSensoryFrame`), or observations with
times one after the other. Read are 2-D scans, landmarks and odometry of both forms; others are counted and left out.

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
from mjsim.logs.files import MAX_NUMBER
from mjsim.logs.resampling import Log, Mount, RobotLog, kept

SUFFIXES = (".rawlog", ".rawlog.gz")
MIN_UNPACKED, MAX_COMPRESSION = 64 << 20, 30
"""Maximum length of what is unpacked: so much, or so many times the size of the file [bytes]."""
HEAD = 4096
"""Bytes in which the first object must begin."""
MAX_BEAMS = 10_000
MIN_RANGE = 0.02
"""Smaller ranges were not measured [m]."""
UNIX_EPOCH = 11_644_473_600
"""Of times in MRPT, which begin in 1601 and count 100 ns [s]."""
USUAL_PERIOD = 0.1
"""From one action to the next, if the file has no times [s]."""
MAX_TILT = math.radians(5.0)
"""A scanner tilted by more does not measure horizontally [rad]."""
LANDMARKS_VERSION = 3
"""Version of `CObservationBearingRange` that is read."""
RANGE, BEARING = 0.1, math.radians(2.0)
"""Standard deviations of a landmark for a log that gives covariances instead [m, rad]. A guess."""
ODOMETRY = 0
"""Method of estimation of a movement that is odometry; 1 is scan matching."""
_HEADER = re.compile(rb"[\x80-\xff](?:[a-z0-9]+::)*C[A-Z0-9][A-Za-z0-9_]{2,60}")


@dataclass(slots=True)
class _Bytes:
    """Reads values one after the other."""

    data: bytes
    place: int = 0

    def take(self, form: str) -> tuple[float, ...]:
        """Return values of a form of `struct`.

        Raises:
            struct.error: The data end before.
        """
        values = struct.unpack_from(f"<{form}", self.data, self.place)
        self.place += struct.calcsize(f"<{form}")
        return values

    def array(self, kind: str, count: int) -> Array:
        """Return an array of numbers, shape (count,)."""
        size = np.dtype(kind).itemsize * count
        if self.place + size > len(self.data):
            raise struct.error("the array is cut")
        found = np.frombuffer(self.data, dtype=kind, count=count, offset=self.place)
        self.place += size
        return found

    def text(self) -> str:
        """Return a text."""
        length = int(self.take("I")[0])
        if length > MAX_BEAMS:
            raise struct.error("the text is too long")
        return bytes(self.array("u1", length).astype(np.uint8)).decode(errors="replace")

    def head(self) -> tuple[str, int]:
        """Return class, without namespace, and version of an object."""
        length = int(self.take("B")[0]) & 0x7F
        name = bytes(self.array("u1", length).astype(np.uint8)).decode(errors="replace")
        return name.rpartition("::")[2], int(self.take("B")[0])

    def pose(self) -> Array:
        """Return a pose in 2-D or 3-D that is an object, shape (4, 4) [m]."""
        from scipy.spatial.transform import Rotation

        name, version = self.head()
        pose = np.eye(4)
        if name == "CPose2D":
            x, y, heading = self.take("3d" if version else "3f")
            pose[:2, 3] = x, y
            pose[:3, :3] = Rotation.from_euler("z", heading).as_matrix()
        elif name == "CPose3D" and version == 3:
            pose[:3, 3], turn = self.take("3d"), self.take("9d")
            pose[:3, :3] = np.reshape(turn, (3, 3))
        elif name == "CPose3D" and version == 2:
            pose[:3, 3], (w, x, y, z) = self.take("3d"), self.take("4d")
            pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
        elif name == "CPose3D" and version < 2:
            pose = self.matrix()
        else:
            raise struct.error(f"{name} has the version {version}")
        self.take("B")
        if pose.shape != (4, 4) or not np.isfinite(pose).all() or np.abs(pose).max() > MAX_NUMBER:
            raise struct.error("a pose is not finite")
        return pose

    def matrix(self) -> Array:
        """Return a matrix that is an object."""
        name, _ = self.head()
        rows, columns = (int(value) for value in self.take("2I"))
        if rows * columns > MAX_BEAMS:
            raise struct.error("a matrix is too large")
        kind = "<f8" if name == "CMatrixD" else "<f4"
        found = self.array(kind, rows * columns).astype(float).reshape(rows, columns)
        self.take("B")
        return found


@dataclass(slots=True)
class _Found:
    """The data read so far."""

    odometry: list[tuple[float, float, float, float]] = field(default_factory=list)
    scans: dict[str, list[Scan]] = field(default_factory=dict)
    mounts: dict[str, Mount] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    moved: list[Array] = field(default_factory=list)
    """Movements before the observations to come, each shape (4, 4)."""
    pose: Array = field(default_factory=lambda: np.eye(4))
    """The sum of all movements."""
    pairs: int = 0
    """Number of frames of observations."""
    timeless: int = 0
    """Number of observations without a time."""
    sightings: list[Sighting] = field(default_factory=list)


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
        reader = _Bytes(data, start)
        reader.head()
        try:
            _take(found, name, version, reader)
            done = reader.place
        except struct.error as error:
            kind = f"broken {name}" if "unpack" not in str(error) else f"{name} that is cut"
            found.left_out[kind] += 1
    if not found.odometry and not found.scans and not found.sightings:
        seen = ", ".join(f"{count} {name}" for name, count in found.left_out.most_common(5))
        raise UsageError(
            f"'{path}' holds neither 2-D scans, landmarks nor odometry of MRPT{f'; it has {seen}' if seen else ''}"
        )
    notes |= {f"{kind} left out": str(count) for kind, count in sorted(found.left_out.items())}
    if found.timeless:
        notes["times"] = f"{found.timeless} observations have none; {USUAL_PERIOD} s from one to the next"
    robot = RobotLog(
        track=_track(found.odometry) if found.odometry else None,
        scans={name: kept(_in_order(scans)) for name, scans in found.scans.items()},
        sightings=sorted(found.sightings, key=lambda sighting: sighting.stamp),
        gap=1.0,
    )
    return Log(kind="rawlog", robot=robot, mounts=found.mounts, notes=notes)


def _unpacked(path: Path, notes: dict[str, str]) -> bytes:
    """Return the contents of a file; one that was cut as far as it goes, which is noted."""
    limit = max(MIN_UNPACKED, MAX_COMPRESSION * path.stat().st_size)
    parts, size = [], 0
    with path.open("rb") as plain:
        packed = plain.read(2) == b"\x1f\x8b"
        plain.seek(0)
        file = gzip.GzipFile(fileobj=plain) if packed else plain
        try:
            # Not more at once than is there, since what was read before the end of a cut file would be lost.
            while part := file.read1(1 << 16):
                parts.append(part)
                size += len(part)
                if size > limit:
                    raise UsageError(f"'{path}' unpacks to more than {limit >> 20} MB; unpack it yourself")
        except (EOFError, zlib.error, gzip.BadGzipFile):
            notes["file"] = "it was cut or is damaged; read as far as it could be unpacked"
    return b"".join(parts)


def _objects(data: bytes) -> Iterator[tuple[int, str, int]]:
    """Yield where objects begin, their class without namespace, and their version."""
    for match in _HEADER.finditer(data):
        start = match.start()
        end = start + 1 + (data[start] & 0x7F)
        if end < len(data) and end <= match.end():
            yield start, data[start + 1 : end].decode().rpartition("::")[2], data[end]


def _take(found: _Found, name: str, version: int, reader: _Bytes) -> None:
    """Process an object whose head was read."""
    if name == "CObservation2DRangeScan":
        _take_scan(found, version, reader)
    elif name == "CObservationOdometry":
        pose, _, (stamp,) = reader.pose(), reader.text(), reader.take("Q")
        found.odometry.append((_seconds(stamp), *_planar(pose)))
    elif name == "CObservationBearingRange" and version == LANDMARKS_VERSION:
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
        found.left_out[name] += 1


def _mean(reader: _Bytes) -> Array:
    """Return the mean of a movement that scan matching found."""
    name, _ = reader.head()
    if name != "CPosePDFGaussian":
        raise struct.error(f"a movement is a {name}")
    return reader.pose()


def _take_landmarks(found: _Found, reader: _Bytes) -> None:
    """Process ranges and bearings of landmarks, with their numbers."""
    reader.take("4f")
    robot_from_sensor, (ticks,), (has_covariances,) = reader.pose(), reader.take("Q"), reader.take("B")
    spread = (RANGE, BEARING) if has_covariances else (float(each) for each in reader.take("3f")[:2])
    stamp = _stamp(found, ticks)
    (count,) = reader.take("I")
    variances = np.square([max(each, 1e-6) for each in spread])
    for _ in range(int(count)):
        distance, bearing, elevation, number = reader.take("3fi")
        if has_covariances:
            reader.matrix()
        flat = distance * math.cos(elevation)
        local = np.array([flat * math.cos(bearing), flat * math.sin(bearing), distance * math.sin(elevation), 1.0])
        x, y, *_ = robot_from_sensor @ local
        if not math.isfinite(x) or not math.isfinite(y) or math.hypot(x, y) < MIN_RANGE:
            found.left_out["landmarks without a range"] += 1
            continue
        name = f"landmark{int(number)}" if number >= 0 else None
        covariance = np.diag(variances)
        found.sightings.append(Sighting(stamp, name, math.hypot(x, y), math.atan2(y, x), covariance))


def _stamp(found: _Found, ticks: float) -> float:
    """Return the time of an observation, and note where the robot is then, if it is one of a frame [s]."""
    found.timeless += not ticks
    stamp = _seconds(ticks) if ticks else USUAL_PERIOD * found.pairs
    if found.pairs and (not found.odometry or stamp > found.odometry[-1][0]):
        found.odometry.append((stamp, *_planar(found.pose)))
    return stamp


def _take_scan(found: _Found, version: int, reader: _Bytes) -> None:
    """Process a 2-D scan."""
    aperture, leftwards, reach = reader.take("fBf")
    robot_from_sensor = reader.pose()
    if version < 6:
        reader.matrix()
    count = int(reader.take("I")[0])
    if not 2 <= count <= MAX_BEAMS or not 0.0 < aperture < 2.1 * math.pi or not reach > 0.0:
        raise struct.error("its numbers make no scan")
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
        found.left_out["scans of a tilted scanner"] += 1
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
    if (before := found.scans.get(name)) and len(before[0].ranges) != count:
        found.left_out[f"scans of {name} with another number of beams"] += 1
        return
    found.scans.setdefault(name, []).append(scan)


def _named(found: _Found, label: str, robot_from_sensor: Array) -> str:
    """Return the name of a lidar: its label, with a number for another place."""
    x, y, z = np.round(robot_from_sensor[:3, 3], 3).tolist()
    yaw = round(math.atan2(robot_from_sensor[1, 0], robot_from_sensor[0, 0]), 3)
    mount = Mount(at=(x + 0.0, y + 0.0, z if z > 0.0 else 0.3), yaw=yaw + 0.0)
    plain = re.sub(r"[^A-Za-z0-9_-]+", "_", label).strip("_")[:40] or "laser"
    number = 1
    while True:
        name = plain if number == 1 else f"{plain}_{number}"
        if found.mounts.setdefault(name, mount) == mount:
            return name
        number += 1


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
