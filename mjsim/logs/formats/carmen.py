"""CARMEN logs: one message per line, as used by the robots of Freiburg, Seattle and Austin.

    ODOM x y theta tv rv accel                                                     ipc_timestamp host logger_timestamp
    FLASER n [ranges] x y theta odom_x odom_y odom_theta                           ...
    RLASER                                                                         the same, looking backwards
    RAWLASER1 type start fov step max accuracy remission n [ranges] k [remissions] ...
    ROBOTLASER1 ... as RAWLASER1, then laser x y theta, robot x y theta, tv rv, three distances of safety ...
    TRUEPOS true_x true_y true_theta odom_x odom_y odom_theta                      ...
    PARAM name value                                                               ...; see `OFFSETS` and `NOISE`

Lengths in metres, angles in radians, left positive. Odometry is the robot's pose in a frame that drifts. The pose of
the laser in FLASER may have been corrected by SLAM; it is not read. Other messages are counted and ignored.

References:
    Montemerlo, Roy, Thrun, Perspectives on standardization in mobile robot programming: the Carnegie Mellon navigation
    (CARMEN) toolkit, IROS 2003; the formats as in the headers of the logs.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from mjsim.errors import MAX_MESSAGE_LENGTH, UsageError
from mjsim.geometry import Array
from mjsim.interface import Scan
from mjsim.inventory import Fate, told
from mjsim.logs.files import MAX_NUMBER, left_out_cut, lines_of
from mjsim.logs.resampling import MOTION, ForwardClock, Log, MotionNoise, Mount, RobotLog, kept

MESSAGE_KINDS = ("ODOM", "FLASER", "RLASER", "TRUEPOS", "PARAM", "SYNC")
"""First words of lines of such a log, beside those of `LASERS`."""
LASERS = {f"{kind}{number}": number for kind in ("RAWLASER", "ROBOTLASER") for number in range(1, 6)}
"""Messages of lasers with a configuration in each message, and the number of the laser."""
OFFSETS = {"front": "robot_frontlaser_offset", "rear": "robot_rearlaser_offset"}
"""Parameters with the forward offset of a laser [m]."""
RESOLUTIONS = {"FLASER": "laser_front_laser_resolution", "RLASER": "laser_rear_laser_resolution"}
"""Parameters with the angle between two beams of a laser whose number of beams does not imply it [deg]."""
NOISE = {"distance": "odometry_noise_distance", "turn": "odometry_noise_turn", "veer": "odometry_noise_veer"}
"""Parameters in logs of `mjsim export --carmen`, by the fields of `MotionNoise`."""
MAX_BEAMS = 10_000
MIN_RANGE = 0.02
"""Smaller ranges were not measured [m]."""
MAX_NOISE = 10.0
MIN_BEAMS, TOO_FEW = 2, "scans of less than 2 beams"
"""Minimum number of beams of a scan, and name of scans with fewer."""
MIN_NO_RETURNS = 50
"""Minimum number of beams with the largest value of a log for it to mean no return."""
RANGE_RESOLUTION = 0.005
"""Ranges that differ by at most this are one value [m]."""
NO_RETURN_SPREAD = 1e-3
"""Maximum relative difference between the largest values: a SICK scanner reports 8183 to 8191 for no return."""


@dataclass(slots=True)
class _Found:
    """The data read so far."""

    odometry: list[tuple[float, float, float, float]] = field(default_factory=list)
    twists: list[tuple[float, float, float]] = field(default_factory=list)
    truth: list[tuple[float, float, float, float]] = field(default_factory=list)
    scans: dict[str, list[Scan]] = field(default_factory=dict)
    mounts: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    parameters: dict[str, str] = field(default_factory=dict)
    left_out: Counter[str] = field(default_factory=Counter)
    clock: ForwardClock = field(default_factory=lambda: ForwardClock(()))
    stamps: list[float] = field(default_factory=list)
    """Stamps of all messages in the order of the file, as written [s]."""


def is_carmen(path: Path) -> bool:
    """Return whether the first lines of a file are messages of CARMEN."""
    if not path.is_file():
        return False
    known = 0
    for number, line in enumerate(lines_of(path, {})):
        word = line.split(maxsplit=1)[0] if line.strip() else "#"
        if word in MESSAGE_KINDS or word in LASERS:
            known += 1
        # Messages of other sensors may come first.
        elif not (word.startswith("#") or word.isupper() or known):
            return False
        if known >= 3 or number > 500:
            break
    return known > 0


def read_carmen(path: Path) -> Log:
    """Read a log; lasers are named 'front', 'rear', or 'laser1' to 'laser5'.

    Raises:
        UsageError: It cannot be read, contains neither odometry nor scans, or a line is invalid.
    """
    notes = dict[str, str]()
    found = _read(path, notes, ForwardClock(()))
    clock = ForwardClock(found.stamps)
    if clock.begins:
        found = _read(path, notes, clock)
        notes["clock"] = told(Fate.MENDED, f"{clock.about}, as in logs that were joined; times continue from there")
    if not found.odometry and not found.scans:
        raise UsageError(f"'{path}' holds neither odometry nor scans of CARMEN")
    notes |= {f"{kind} left out": str(count) for kind, count in sorted(found.left_out.items())}
    lasers = {}
    for name, scans in found.scans.items():
        ordered = _in_order(scans)
        beams = max(len(scan.ranges) for scan in ordered)
        lasers[name] = [_with_beams(scan, beams) for scan in ordered]
        if fewer := sum(len(scan.ranges) < beams for scan in ordered):
            notes[f"{name} scans with fewer than {beams} beams"] = told(
                Fate.MENDED, f"{fewer}; the other beams are not measured"
            )
    robot = RobotLog(
        track=clock.connected(_rows(found.odometry, 4)) if found.odometry else None,
        twists=_rows(found.twists, 3),
        scans={name: kept(_without_returns(scans, name, notes)) for name, scans in lasers.items()},
        truth=_rows(found.truth, 4) if found.truth else None,
        gap=1.0,
    )
    return Log(kind="carmen", robot=robot, mounts=_mounts(found, path), motion=_motion(found, path), notes=notes)


def _read(path: Path, notes: dict[str, str], clock: ForwardClock) -> _Found:
    """Return the data in a file, with times by a clock."""
    found = _Found(clock=clock)
    for number, line in enumerate(lines_of(path, notes), start=1):
        words = line.split()
        if not words or words[0].startswith("#"):
            continue
        try:
            _take(found, words)
        except (ValueError, IndexError) as error:
            if (found.odometry or found.scans) and left_out_cut(path, line, notes):
                break
            why = str(error) if isinstance(error, ValueError) else f"{words[0]} has too few values"
            raise UsageError(f"{path}:{number}: {why}"[:MAX_MESSAGE_LENGTH]) from None
    return found


def _take(found: _Found, words: Sequence[str]) -> None:
    """Process a line."""
    kind = words[0]
    if kind == "PARAM":
        found.parameters[words[1]] = words[2] if len(words) > 2 else ""
    elif kind == "ODOM":
        x, y, heading, forward, turn, _ = _numbers(words, 1, 7)
        stamp = _stamp(found, words, 7)
        found.odometry.append((stamp, x, y, heading))
        found.twists.append((stamp, forward, turn))
    elif kind == "TRUEPOS":
        x, y, heading, *moved = _numbers(words, 1, 7)
        stamp = _stamp(found, words, 7)
        found.truth.append((stamp, x, y, heading))
        found.odometry.append((stamp, moved[0], moved[1], moved[2]))
    elif kind in ("FLASER", "RLASER"):
        _take_old(found, words)
    elif kind in LASERS:
        _take_new(found, words)
    else:
        found.left_out[f"messages of {kind[:40]}"] += 1


def _take_old(found: _Found, words: Sequence[str]) -> None:
    """Process a message of the front or the rear laser."""
    count = _count(words[1], least=0)
    ranges = _values(words, 2, 2 + count)
    _, _, _, x, y, heading = _numbers(words, 2 + count, 8 + count)
    stamp = _stamp(found, words, 8 + count)
    found.odometry.append((stamp, x, y, heading))
    if count < MIN_BEAMS:
        found.left_out[TOO_FEW] += 1
        return
    step = _step(count, found.parameters.get(RESOLUTIONS[words[0]]))
    name = "front" if words[0] == "FLASER" else "rear"
    first = -math.pi / 2 if count * step > 3.0 and count * step < 3.2 else -step * (count - 1) / 2
    found.scans.setdefault(name, []).append(_scan(stamp, ranges, first, step))


def _take_new(found: _Found, words: Sequence[str]) -> None:
    """Process a message of a laser with its configuration."""
    _, first, _fov, step, farthest, _, _ = _numbers(words, 1, 8)
    count = _count(words[8], least=0)
    ranges = _values(words, 9, 9 + count)
    if not (0.0 < step < math.pi and -7.0 <= first <= 7.0 and farthest > 0.0):
        raise ValueError(f"{words[0]} begins at {first:g} rad, with {step:g} rad a beam and up to {farthest:g} m")
    at = 9 + count
    number = _count(words[at], least=0)
    strengths = _numbers(words, at + 1, at + 1 + number)
    at += 1 + number
    name = "front" if LASERS[words[0]] == 1 else f"laser{LASERS[words[0]]}"
    if words[0].startswith("ROBOT"):
        laser, robot = _numbers(words, at, at + 3), _numbers(words, at + 3, at + 6)
        stamp = _stamp(found, words, at + 11)
        found.odometry.append((stamp, robot[0], robot[1], robot[2]))
        found.mounts.setdefault(name, _seen_from(laser, robot))
    else:
        stamp = _stamp(found, words, at)
    if count < MIN_BEAMS:
        found.left_out[TOO_FEW] += 1
        return
    scan = _scan(stamp, ranges, first, step, farthest=farthest)
    if len(strengths) == len(ranges):
        scan = replace(scan, intensities=np.array(strengths))
    found.scans.setdefault(name, []).append(scan)


def _scan(stamp: float, ranges: Sequence[float], first: float, step: float, *, farthest: float = math.inf) -> Scan:
    values = np.array(ranges)
    values[~(values >= MIN_RANGE)] = -np.inf
    values[values >= farthest] = np.inf
    return Scan(stamp, values, first, step, MIN_RANGE, farthest)


def _with_beams(scan: Scan, count: int) -> Scan:
    """Return a scan with a number of beams, those after its last one not measured; its angles stay as they are."""
    lacking = (0, count - len(scan.ranges))
    strengths = scan.intensities
    return replace(
        scan,
        ranges=np.pad(scan.ranges, lacking, constant_values=-np.inf),
        intensities=None if strengths is None else np.pad(strengths, lacking),
    )


def _without_returns(scans: Sequence[Scan], name: str, notes: dict[str, str]) -> list[Scan]:
    """Return the scans of a laser; its largest values, if they are frequent, become infinite, and a note says so."""
    if not scans:
        return []
    ranges = np.array([scan.ranges for scan in scans])
    finite = ranges[np.isfinite(ranges)]
    if not len(finite):
        return list(scans)
    largest = float(finite.max())
    top = largest - max(RANGE_RESOLUTION, NO_RETURN_SPREAD * largest)
    at_top = int((finite > top).sum())
    if at_top >= MIN_NO_RETURNS and at_top > int(((finite > 0.9 * largest) & (finite <= top)).sum()):
        ranges[ranges > top] = np.inf
        notes[f"returns of {name}"] = told(
            Fate.GUESSED, f"none where the range is {largest:g} m, its largest: {at_top} of {len(finite)} ranges"
        )
        finite = ranges[np.isfinite(ranges)]
    declared = scans[0].range_max
    reach = declared if math.isfinite(declared) else max(1.0, math.ceil(float(finite.max(initial=1.0))))
    return [replace(scan, ranges=row, range_max=reach) for scan, row in zip(scans, ranges, strict=True)]


def _mounts(found: _Found, path: Path) -> dict[str, Mount]:
    """Return the mounts of the lasers, from the parameters of the log, or else from the poses in its messages."""
    mounts = {}
    for name in found.scans:
        x, y, yaw = found.mounts.get(name, (0.0, 0.0, math.pi if name == "rear" else 0.0))
        offset = _parameter(found, path, OFFSETS.get(name, ""))
        if offset is not None and name not in found.mounts:
            x = offset
        mounts[name] = Mount(at=(x, y, 0.3), yaw=yaw)
    return mounts


def _motion(found: _Found, path: Path) -> MotionNoise:
    """Return the noise of odometry, from the parameters of the log, or else the default."""
    given = {name: _parameter(found, path, parameter) for name, parameter in NOISE.items()}
    for name, value in given.items():
        if value is not None and not 0.0 <= value <= MAX_NOISE:
            raise UsageError(f"'{path}': {NOISE[name]} is {value:g}; it must be 0 to {MAX_NOISE:g}")
    return replace(MOTION, **{name: value for name, value in given.items() if value is not None})


def _parameter(found: _Found, path: Path, name: str) -> float | None:
    """Return the value of a parameter; None if it is not in the log."""
    if (text := found.parameters.get(name)) is None:
        return None
    try:
        return float(text)
    except ValueError:
        raise UsageError(f"'{path}': {name} is {text[:40]!r}; it must be a number") from None


def _seen_from(laser: Sequence[float], robot: Sequence[float]) -> tuple[float, float, float]:
    """Return a laser's pose in the frame of its robot."""
    c, s = math.cos(robot[2]), math.sin(robot[2])
    x, y = laser[0] - robot[0], laser[1] - robot[1]
    return c * x + s * y, c * y - s * x, laser[2] - robot[2]


def _step(count: int, given: str | None) -> float:
    """Return the angle between two beams of a laser without a configuration [rad].

    Args:
        count: Number of its beams.
        given: Angle stated by a parameter of the log, used if no usual laser has this number of beams [deg].

    References:
        The resolutions of the SICK LMS of 1, 0.5 and 0.25 degrees, with and without the last beam, over 180, 100 and
        270 degrees; those of the Hokuyo URG and UTM.
    """
    steps = {180: 1.0, 181: 1.0, 360: 0.5, 361: 0.5, 401: 0.25, 400: 0.25, 540: 0.5, 541: 0.5}
    steps |= {682: 360.0 / 1024.0, 683: 360.0 / 1024.0, 769: 360.0 / 1024.0, 1080: 0.25, 1081: 0.25}
    if given is not None and count not in steps:
        try:
            resolution = float(given)
        except ValueError:
            resolution = 0.0
        if not 0.0 < resolution * (count - 1) <= 360.0:
            raise ValueError(f"a laser has {count} beams {given[:40]} degrees apart; they must cover 0 to 360 degrees")
        return math.radians(resolution)
    return math.radians(steps.get(count, 180.0 / (count - 1)))


def _values(words: Sequence[str], begin: int, end: int) -> list[float]:
    """Return the numbers at some places of a line; infinite and not-a-number values stay."""
    if len(words) < end:
        raise ValueError(f"{words[0]} has {len(words) - 1} values; it must have at least {end - 1}")
    try:
        return [float(word) for word in words[begin:end]]
    except ValueError as error:
        raise ValueError(f"{words[0]}: {error}; numbers are written as 1.5") from None


def _numbers(words: Sequence[str], begin: int, end: int) -> list[float]:
    """Return the finite numbers at some places of a line."""
    values = _values(words, begin, end)
    # Written so that NaN fails too.
    if not all(abs(value) <= MAX_NUMBER for value in values):
        bad = next(word for word, value in zip(words[begin:end], values, strict=True) if not abs(value) <= MAX_NUMBER)
        raise ValueError(f"{words[0]} holds {bad[:40]!r}; numbers must be finite, and at most {MAX_NUMBER:g}")
    return values


def _count(word: str, *, least: int) -> int:
    if not word.isdecimal() or not least <= int(word) <= MAX_BEAMS:
        raise ValueError(f"a laser scan has {word[:40]} values; it must have {least} to {MAX_BEAMS}")
    return int(word)


def _stamp(found: _Found, words: Sequence[str], at: int) -> float:
    """Return when a message was sent [s]; its word follows the last value."""
    if len(words) < at + 1:
        raise ValueError(f"{words[0]} has no time at its end; after its values come time, host and time of logging")
    (stamp,) = _numbers(words, at, at + 1)
    found.stamps.append(stamp)
    return found.clock.time(len(found.stamps) - 1, stamp)


def _in_order(scans: Sequence[Scan]) -> list[Scan]:
    """Return scans in order of time, without duplicate times."""
    ordered: list[Scan] = []
    for scan in sorted(scans, key=lambda item: item.stamp):
        if not ordered or scan.stamp > ordered[-1].stamp:
            ordered.append(scan)
    return ordered


def _rows(rows: Sequence[tuple[float, ...]], columns: int) -> Array:
    """Return rows in order of time, shape (N, columns)."""
    table = np.array(rows, dtype=float).reshape(-1, columns)
    return table[np.argsort(table[:, 0], kind="stable")]
