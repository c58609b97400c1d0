"""The UTIAS Multi-Robot Cooperative Localization and Mapping data sets.

Five robots drive among fifteen tubes with barcodes, tracked by a motion capture system. One folder per data set:

    Barcodes.dat                 subject, barcode
    Landmark_Groundtruth.dat     subject, x [m], y [m], their standard deviations [m]
    Robot1_Groundtruth.dat       time [s], x [m], y [m], heading [rad]; at about 100 Hz
    Robot1_Odometry.dat          time [s], forward velocity [m/s], turn [rad/s], as commanded; at about 67 Hz
    Robot1_Measurement.dat       time [s], barcode, range [m], bearing [rad], left positive

Subjects 1 to 5 are the robots, 6 to 20 the landmarks. The camera's frame is that of the robot. Both kinds of ground
truth are optional: without them robots start side by side at the origin, and only the names of landmarks are known.

The range in the files is the depth along the camera's axis. Divided by the cosine of the bearing, it agrees with the
motion capture with standard deviations of 0.03, 0.08 and 0.03 m for robots 1 to 3 of data set 7; without that, 0.12,
0.17 and 0.17 m.

References:
    Leung, Halpern, Barfoot, Liu, The UTIAS multi-robot cooperative localization and mapping dataset, IJRR 30(8), 2011.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mjsim.errors import UsageError, did_you_mean
from mjsim.geometry import Array, places_at
from mjsim.interface import Sighting
from mjsim.inventory import Fate, told
from mjsim.logs.files import TIME, read_table, whole_numbers
from mjsim.logs.resampling import (
    MotionNoise,
    Output,
    RobotLog,
    Wishes,
    cut,
    generated_world,
    name_from,
    write_robot_logs,
)
from mjsim.world import World

MOTION = MotionNoise(distance=0.1, turn=0.2, veer=0.06)
"""The log has commands, which an iRobot Create does not follow exactly. The data set does not give the error. On data
set 7, `mjsim calibrate` finds distances 8 to 12 % too long and turn rates up to 0.23 degrees/s too large (0.06 rad per
metre at its speed), and noise of 0.05 m/sqrt(m) and 0.15 rad/sqrt(rad). Estimators derive the size of systematic errors
from it.
"""
RANGE, BEARING = 0.15, math.radians(2.0)
"""Standard deviations of a sighting [m, rad]. A guess: the data set does not give them."""
DEFAULT_RATE_HZ = 10.0
"""Default tick rate [Hz]."""
MAX_TRUTH_GAP = 0.1
"""If poses are farther apart than this, motion capture had lost the robot [s]."""
MAX_ROBOT_SUBJECT = 5
"""Subjects up to this number are robots."""
UNKNOWN_START_SPACING = 1.0
"""Distance between robots with unknown starts [m]."""
MAX_RANGE = 12.0
"""Maximum range for the sensor's data sheet; nothing depends on it [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class _Files:
    """The text files of one robot."""

    truth: Array | None
    twists: Array
    sightings: tuple[Sighting, ...]
    unknown: int
    """Number of measurements of other robots and of unknown barcodes."""


def convert_mrclam(folder: Path, wishes: Wishes, output: Output) -> Iterator[float]:
    """Convert a data set to a recording, and yield the progress [%].

    Raises:
        UsageError: A file does not exist or is invalid (the message has file and line).
        RecordingError: The recording cannot be written.
    """
    rate, sighting = wishes.rate_hz or DEFAULT_RATE_HZ, wishes.sighting_over(RANGE, BEARING)
    robots = [_number(robot) for robot in wishes.robots]
    subjects = _subjects(folder)
    landmarks = _landmarks(folder)
    cuts: dict[str, str] = {}
    files = {f"robot{n}": _read_robot(folder, n, subjects, landmarks, sighting, cuts) for n in _numbers(folder, robots)}
    if wishes.known_map and landmarks is None:
        raise UsageError(f"no 'Landmark_Groundtruth.dat' in '{folder}'; its map is unknown, leave out --known-map")
    tables = [table for each in files.values() for table in (each.truth, each.twists) if table is not None]
    first, last = max(float(table[0, 0]) for table in tables), min(float(table[-1, 0]) for table in tables)
    span = cut(first, last, begin=wishes.begin, seconds=wishes.seconds, rate_hz=rate)
    logs = {
        name: RobotLog(
            twists=each.twists,
            sightings=each.sightings,
            identities=[str(seen.name) for seen in each.sightings],
            truth=each.truth,
            gap=MAX_TRUTH_GAP,
        )
        for name, each in files.items()
    }
    world = _world(folder, files, landmarks or {}, span, rate_hz=rate, known_map=wishes.known_map, sighting=sighting)
    left_out = {f"{name} measurements of no landmark left out": str(each.unknown) for name, each in files.items()}
    unknown = {
        f"{name} truth": told(Fate.LEFT_OUT, "not in the log") for name, each in files.items() if each.truth is None
    }
    metadata = {"log": "mrclam", "log folder": str(folder), **left_out, **unknown, **cuts}
    yield from write_robot_logs(
        world,
        logs,
        span=span,
        noise=wishes.motion_over(MOTION),
        bias=wishes.bias,
        metadata=metadata,
        output=output,
    )


def _number(robot: str) -> int:
    """Return the number of a robot."""
    if not robot.isdecimal():
        raise UsageError(f"no robot '{robot}'; MRCLAM numbers its robots 1 to 5")
    return int(robot)


def _numbers(folder: Path, requested: Sequence[int]) -> list[int]:
    """Return the numbers of the robots to read."""
    files = (re.fullmatch(r"Robot(\d+)_Odometry\.dat", path.name) for path in folder.iterdir())
    present = sorted(int(match[1]) for match in files if match)
    if not present:
        raise UsageError(f"no file Robot1_Odometry.dat in '{folder}'; it is not an MRCLAM data set")
    for number in requested:
        if number not in present:
            raise UsageError(f"no robot {number} in '{folder}'{did_you_mean(str(number), map(str, present))}")
    return sorted(set(requested)) if requested else present


def _subjects(folder: Path) -> dict[int, int]:
    """Return barcode -> subject."""
    path = folder / "Barcodes.dat"
    table = read_table(path, ("subject", "barcode"))
    subjects, barcodes = (whole_numbers(path, table[:, k], name) for k, name in enumerate(("subject", "barcode")))
    if len(set(barcodes)) < len(barcodes):
        twice = next(code for code in barcodes if barcodes.count(code) > 1)
        raise UsageError(f"'{path}': barcode {twice} is used for two subjects; each needs its own")
    return dict(zip(barcodes, subjects, strict=True))


def _landmarks(folder: Path) -> dict[int, tuple[float, float]] | None:
    """Return subject -> position [m]; None for a landmark that was not surveyed."""
    path = folder / "Landmark_Groundtruth.dat"
    if not path.exists():
        return None
    table = read_table(path, ("subject", "x", "y", "x deviation", "y deviation"))
    numbers = whole_numbers(path, table[:, 0], "subject")
    if len(set(numbers)) < len(numbers):
        raise UsageError(f"'{path}': a landmark has two positions; each subject must have one line")
    return {number: (float(x), float(y)) for number, (x, y) in zip(numbers, table[:, 1:3], strict=True)}


def _read_robot(
    folder: Path,
    number: int,
    subjects: Mapping[int, int],
    landmarks: Mapping[int, tuple[float, float]] | None,
    deviations: tuple[float, float],
    cuts: dict[str, str],
) -> _Files:
    """Return the files of a robot; truncated ends of files are noted."""
    path = folder / f"Robot{number}_Measurement.dat"
    seen = read_table(path, (TIME, "barcode", "range", "bearing"), positive={"range"}, notes=cuts)
    codes = whole_numbers(path, seen[:, 1], "barcode")
    if len(behind := np.flatnonzero(np.cos(seen[:, 3]) < 1e-3)):
        raise UsageError(f"'{path}': a bearing is {seen[behind[0], 3]:g} rad; the camera looks ahead")
    covariance = np.diag(np.square(deviations))
    named = (
        [subject for subject in subjects.values() if subject > MAX_ROBOT_SUBJECT] if landmarks is None else landmarks
    )
    sightings = [
        Sighting(stamp, f"landmark{subjects[code]}", depth / math.cos(bearing), bearing, covariance)
        for code, (stamp, _, depth, bearing) in zip(codes, seen.tolist(), strict=True)
        if subjects.get(code) in named
    ]
    truth = folder / f"Robot{number}_Groundtruth.dat"
    return _Files(
        truth=read_table(truth, (TIME, "x", "y", "heading"), notes=cuts) if truth.exists() else None,
        twists=read_table(folder / f"Robot{number}_Odometry.dat", (TIME, "forward velocity", "turn"), notes=cuts),
        sightings=tuple(sightings),
        unknown=len(codes) - len(sightings),
    )


def _world(
    folder: Path,
    files: Mapping[str, _Files],
    landmarks: Mapping[int, tuple[float, float]],
    span: tuple[float, float],
    *,
    rate_hz: float,
    known_map: bool,
    sighting: tuple[float, float],
) -> World:
    """Return the world: no walls, the landmarks as reflectors, the robots at their starts."""
    beacons = [
        f"  - {{name: landmark{number}, at: [{x!r}, {y!r}], width: 0.15, center: 0.4}}"
        for number, (x, y) in landmarks.items()
    ]
    camera = (
        f"     sensors: [{{beacons: camera, range: [0.1, {MAX_RANGE}], fov_deg: 65, rate_hz: {rate_hz!r},\n"
        f"                noise: {{range: {sighting[0]!r}, bearing_deg: {math.degrees(sighting[1])!r}}}}}]}}"
    )
    robots = []
    for row, (name, each) in enumerate(files.items()):
        x, y, heading = 0.0, UNKNOWN_START_SPACING * row, 0.0
        if each.truth is not None:
            x, y, heading = places_at(np.array([span[0]]), each.truth, gap=math.inf)[0].tolist()
        at = f"at: [{x!r}, {y!r}], heading_deg: {math.degrees(heading)!r}"
        robots += [f"  - {{name: {name}, preset: create3, {at},", camera]
    lines = [
        "# From a data set of MRCLAM. It contains no walls, and the noise of the sensor is a guess.",
        "mjsim: 1",
        f"name: {name_from(folder)}",
        *(["beacons:", *beacons] if beacons else []),
        "robots:",
        *robots,
        f"run: {{seconds: {span[1] - span[0]!r}, rate_hz: {rate_hz!r}, map: {'known' if known_map else 'unknown'}}}",
    ]
    return generated_world("\n".join(lines) + "\n", f"readings of '{folder}'")
