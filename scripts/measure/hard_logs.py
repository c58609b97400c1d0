#!/usr/bin/env python3
"""Write CARMEN logs of buildings and robots that are harder than those of `carmen_logs.py`, and map each.

    .venv/bin/python scripts/measure/hard_logs.py [BUILDING ...] [--styles plain near ...] [--seeds 1] [--keep DIR]

Odometry has the errors `coarse` of `carmen_logs.py`, and rows have the same figures. Buildings: `loop`, a ring of bare
corridors, 196 m around, that closes late; `wings`, four wings with identical rooms around a hall, so that the building
looks the same from all four sides; `campus`, two rings with long corridors, doors in niches, and a large hall; `lofts`,
rooms with few straight walls whose doors are narrow; `square`, four corridors and a cross between them, loops of 51 m,
and `courts`, two rings of 250 m and the corridor between them, both with offices and furniture; in these two, doors
and furniture change half-way; `rooms`, a corridor with small rooms full of furniture, `halls` of an exhibition with
curved walls, and a `laboratory`, oblique corridors around an open space. Styles of robots and logs:

- `plain`: 180 beams of 1 degree, up to 40 m, 5 scans a second;
- `near`: ranges up to 8 m, others read 8.0;
- `slow`: 361 beams of half a degree, 3 scans a second, at 1 m/s and in turns at up to 100 degrees/s;
- `jumps`: at every third door sill (each 12 m) odometry jumps by 5 to 20 degrees within 0.2 s;
- `bursts`: every 50 s the wheels slip for 4 s: by half of the way, and 6 degrees/s to one side;
- `glass`: a quarter of the walls, in pieces of 1.5 m, returns only beams that meet it within 8 degrees of its normal;
- `people`: eight people walk beside the robot;
- `stands`: the robot stands for 60 s every two minutes, and odometry lines come ten times as often as scans;
- `worn`: the errors of `jumps` and `glass`, with ranges up to 8 m, and 3 scans a second;
- `aged`: as logs of 2000: a scan every 0.1 to 0.4 m or 3 to 12 degrees; odometry is up to 0.08 s old, 2 % too long,
  with turns 3 % too large and 0.3 degrees for each metre, and every minute the wheels slip by 0.2 m and 5 degrees;
  four people; glass; two sectors of each scan return nothing;
- `mount`: as `aged`, and the log does not tell that the lidar is 0.2 m ahead of the axle;
- `sparse`: as `mount`, with a scan every 0.3 to 1 m or 9 to 30 degrees;
- `late` and `early`: 360 beams of half a degree, and odometry is 0.25 s older, or 0.15 s newer, than the scans;
- `stick`: driven by hand: every 8 to 20 s the robot stops and spins by up to a full turn at 90 degrees/s; 360 beams;
  the rate of scans changes between 2 and 8 a second every 40 s, and none comes for 3 s every 90 s; odometry
  is 0.2 s old, 5 % too long, with turns 5 % too small and half a degree for each metre.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from carmen_logs import SPEED, Building, Drive, driven, row
from hard_buildings import buildings
from lidar_buildings import walks
from old_buildings import halls, laboratory, rooms
from threadpoolctl import threadpool_limits

import mjsim
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array, Pose, wrap_angle, wrap_angles
from mjsim.interface import Command, Estimate, Observation

ROBOT = """
robots:
  - name: scout
    preset: pioneer3dx
    at: AT
    heading_deg: HEADING
    drive: {noise: {speed: 0.02, turn: 0.02}}
    sensors: [{lidar: scan, at: [0.2, 0, 0.3], yaw_deg: YAW, beams: BEAMS, fov_deg: FOV, range: [0.05, 40],
               rate_hz: 10, noise: {range: 0.01}}]
run: {rate_hz: 10, step_ms: 4}
"""
CODE = 81.83
"""What the scanner says when nothing came back [m]."""
NEAR = 8.0
"""As far as a lidar of the style `near` sees [m]."""
SILLS = 12.0
"""Way between two sills at which odometry jumps [m]."""


@dataclass(frozen=True, slots=True)
class Style:
    """How a robot drives and logs."""

    beams: int = 180
    """Over half a circle: a degree or half a degree apart, the first to the right."""
    speed: float = SPEED
    reach: float = 40.0
    every: float = 0.2
    """Mean time between two scans [s]."""
    jumps: bool = False
    bursts: bool = False
    glass: bool = False
    people: int = 0
    stands: bool = False
    aged: bool = False
    """Whether odometry and scans are those of `aged`."""
    apart: float = 1.0
    """Distance between two scans of `aged`, relative to that of `aged` itself."""
    told: bool = True
    """Whether the log tells where the lidar is."""
    lag: float = 0.0
    """How much older odometry is than the scan beside it [s]."""
    stick: bool = False
    """Whether drive and log are those of `stick`."""

    @property
    def step_deg(self) -> float:
        """Angle between two beams."""
        return 1.0 if self.beams == 180 else 0.5

    @property
    def drive(self) -> "Style":
        """Of this style what matters to the drive."""
        return Style(beams=self.beams, speed=self.speed, people=self.people, stick=self.stick)


STYLES = {
    "plain": Style(),
    "near": Style(reach=NEAR),
    "slow": Style(beams=361, speed=1.0, every=0.33),
    "jumps": Style(jumps=True),
    "bursts": Style(bursts=True),
    "glass": Style(glass=True),
    "people": Style(people=8),
    "stands": Style(stands=True),
    "worn": Style(reach=NEAR, every=0.33, jumps=True, glass=True),
    "aged": Style(aged=True, glass=True, people=4),
    "mount": Style(aged=True, glass=True, people=4, told=False),
    "sparse": Style(aged=True, glass=True, people=4, told=False, apart=2.5),
    "late": Style(beams=360, lag=0.25),
    "early": Style(beams=360, lag=-0.15),
    "stick": Style(beams=360, lag=0.2, stick=True),
}
AHEAD = 0.2
"""The lidar is so far ahead of the axle [m]."""
SPIN = np.radians(90.0)
"""Speed of a turn on the spot of `stick` [rad/s]."""
LAG = 0.08
"""Largest age of odometry beside a scan [s]."""


class Stick(Waypoints):
    """Follows points, but stops every 8 to 20 s and spins, as robots do that are driven by hand."""

    def __init__(self, points: Sequence[Sequence[float]], *, seed: int) -> None:
        """Set the path, and the seed of the stops."""
        super().__init__(points, speed=SPEED)
        self._rng, self._next, self._left = np.random.default_rng([seed, 6]), 10.0, 0.0
        self._heading = 0.0

    def command(self, seen: Observation, belief: Estimate) -> Command:
        """Return the twist; zero once the end is reached."""
        turned, self._heading = wrap_angle(belief.pose.heading - self._heading), belief.pose.heading
        self._left = max(self._left - abs(turned), 0.0)
        follows = super().command(seen, belief)
        if seen.time > self._next and follows != Command():
            self._next = seen.time + self._rng.uniform(8.0, 20.0)
            self._left, self._side = self._rng.uniform(0.5, 2.0 * np.pi), self._rng.choice([-1.0, 1.0])
        return Command(turn=self._side * min(SPIN, 3.0 * self._left)) if self._left > 0.1 else follows


def every_building() -> dict[str, Building]:
    """Return all buildings by their names."""
    return buildings() | {"rooms": rooms(), "halls": halls(), "laboratory": laboratory()}


def drive_of(building: Building, style: Style, *, seed: int) -> Drive:
    """Return a drive through a building."""
    fov = (style.beams - 1) * style.step_deg
    robot = ROBOT.replace("BEAMS", str(style.beams)).replace("FOV", str(fov)).replace("YAW", str(0.5 * fov - 90.0))
    people = mjsim.parse_world(f"mjsim: 1\nname: people\nobstacles: [{', '.join(walks(building, style.people))}]\n")
    later, change = building.later or ("", len(building.points))
    drives, pose = list[Drive](), np.array([*building.start, 0.0])
    for text, points in ((building.text, building.points[:change]), (later, building.points[change:])):
        if points:
            at, heading = str(pose[:2].tolist()), str(float(np.degrees(pose[2])))
            room = mjsim.parse_world(text + robot.replace("AT", at).replace("HEADING", heading))
            room = room.model_copy(update={"obstacles": [*room.obstacles, *people.obstacles]})
            navigator = Stick(points, seed=seed) if style.stick else Waypoints(points, speed=style.speed)
            drives.append(driven(room, navigator, seed=seed))
            pose = drives[-1].poses[-1]
    poses, ranges = (np.concatenate(each) for each in zip(*[(d.poses, d.ranges) for d in drives], strict=True))
    return Drive(0.1 * np.arange(len(poses)), poses, ranges)


def standing(drive: Drive) -> Drive:
    """Return a drive in which the robot stands for a minute every two minutes."""
    number = np.arange(len(drive.times))
    repeats = np.where((number % 1200 == 1199), 600, 1)
    rows = np.repeat(number, repeats)
    return Drive(0.1 * np.arange(len(rows)), drive.poses[rows], drive.ranges[rows])


def odometry(drive: Drive, style: Style, rng: np.random.Generator) -> Array:
    """Return the poses that odometry tells of a drive, shape (N, 3)."""
    place, told, way, side = Pose(0.0, 0.0, 0.0), [Pose(0.0, 0.0, 0.0)], 0.0, 1.0
    jump, sign = 0, 0.0
    for number in range(1, len(drive.times)):
        step = Pose(*drive.poses[number - 1]).inverse() @ Pose(*drive.poses[number])
        ahead, turned = abs(step.x), abs(step.heading)
        forward = step.x + rng.normal(0.0, 0.05 * np.sqrt(ahead))
        turn = step.heading + rng.normal(0.0, 0.1 * np.sqrt(turned)) + rng.normal(0.0, np.radians(2) * np.sqrt(ahead))
        if style.bursts and drive.times[number] % 50.0 > 46.0:
            side = side if drive.times[number] % 50.0 > 46.15 else rng.choice([-1.0, 1.0])
            forward, turn = 1.5 * forward, turn + side * np.radians(0.6)
        if style.jumps and (way + ahead) // SILLS > way // SILLS:
            jump, sign = 2, rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(5.0, 20.0))
        if jump:
            jump, turn = jump - 1, turn + 0.5 * sign
        if style.aged:
            slips = drive.times[number] % 60.0 > 59.0
            forward, turn = 1.02 * forward + 0.02 * slips, 1.03 * turn + np.radians(0.3 * ahead + 0.5 * slips)
        if style.stick:
            forward, turn = 1.05 * forward, 0.95 * turn + np.radians(0.5) * ahead
        way += ahead
        place = place @ Pose(forward, 0.0, turn)
        told.append(place)
    poses = np.array([pose.as_array() for pose in told])
    poses[:, 2] = np.unwrap(poses[:, 2])
    if style.aged or style.lag:
        lag = rng.uniform(0.0, LAG, len(poses)) if style.aged else style.lag
        poses = np.column_stack([np.interp(drive.times - lag, drive.times, column) for column in poses.T])
    return np.column_stack(
        [poses[:, :2].round(2), wrap_angles(np.radians(0.5 * np.round(2 * np.degrees(poses[:, 2]))))]
    )


def spoilt(drive: Drive, number: int, style: Style, rng: np.random.Generator) -> Array:
    """Return the ranges of a scan as a robot of a style logs them, shape (n,) [m]."""
    ranges = drive.ranges[number].copy()
    if style.glass:
        x, y, heading = drive.poses[number]
        angles = np.radians(np.arange(len(ranges)) * style.step_deg - 90.0) + heading
        reached = np.where(np.isfinite(ranges), ranges, 0.0)
        ends = np.stack([x + reached * np.cos(angles), y + reached * np.sin(angles)], axis=-1)
        pane = np.floor(ends / 1.5).astype(int)
        glass = (pane[:, 0] * 73856093 ^ pane[:, 1] * 19349663) % 4 == 0
        straight = np.abs((angles + np.pi / 4) % (np.pi / 2) - np.pi / 4) < np.radians(8.0)
        ranges[glass & ~straight] = np.inf
    ranges[rng.random(len(ranges)) < 0.02] = np.inf
    if style.aged:
        for begin, width in zip(rng.integers(len(ranges), size=2), rng.integers(3, 20, size=2), strict=True):
            ranges[begin : begin + width] = np.inf
    return np.where(ranges < style.reach, ranges, style.reach if style.reach < 40.0 else CODE)


def log_lines(drive: Drive, style: Style, seed: int) -> Iterator[str]:
    """Yield the lines of a log."""
    rng = np.random.default_rng([seed, 5])
    drive = standing(drive) if style.stands else drive
    told, due = odometry(drive, style, rng), Due(style, rng)
    yield f"PARAM robot_frontlaser_offset {AHEAD if style.told else 0.0} nohost 0\n"
    for number, time in enumerate(drive.times.tolist()):
        x, y, heading = told[number].tolist()
        pose, stamp = f"{x:.6f} {y:.6f} {heading:.6f}", 1e9 + time + rng.uniform(0.0, 0.02)
        if style.stands and number:
            for share in np.linspace(0.1, 0.9, 9):
                between = (1 - share) * told[number - 1] + share * told[number]
                between[2] = told[number - 1, 2]
                line = " ".join(f"{value:.6f}" for value in between.tolist())
                yield f"ODOM {line} 0 0 0 {stamp - 0.07 * (1 - share):.6f} nohost 0\n"
        # Without a place of the lidar, it is taken for the robot.
        where = Pose(*drive.poses[number]) @ Pose(0.0 if style.told else AHEAD, 0.0, 0.0)
        true = " ".join(f"{value:.6f}" for value in where.as_array().tolist())
        yield f"TRUEPOS {true} {pose} {stamp:.6f} nohost 0\n"
        if not due.now(time, drive.poses[number]):
            continue
        values = " ".join(f"{value:.2f}" for value in spoilt(drive, number, style, rng).tolist())
        yield f"FLASER {drive.ranges.shape[1]} {values} {pose} {pose} {stamp:.6f} nohost 0\n"


class Due:
    """When a robot logs a scan."""

    def __init__(self, style: Style, rng: np.random.Generator) -> None:
        """Log the first one."""
        self._style, self._rng = style, rng
        self._next, self._last, self._far = 0.0, np.full(3, np.inf), np.zeros(2)

    def now(self, time: float, pose: Array) -> bool:
        """Return whether a scan is logged at a time [s] and a true pose (3,)."""
        if self._style.aged:
            x, y, turn = np.abs(pose - self._last)
            due = time >= self._next or np.hypot(x, y) > self._far[0] or abs(wrap_angle(turn)) > self._far[1]
        else:
            due = time >= self._next
        if due and self._style.aged:
            self._next, self._last = time + 2.0, pose
            least, most = np.array([0.12, np.radians(3.6)]), np.array([0.4, np.radians(12.0)])
            self._far = self._style.apart * self._rng.uniform(least, most)
        elif due:
            every = (0.5, 0.12, 0.2)[int(time / 40.0) % 3] if self._style.stick else self._style.every
            self._next = time + every * self._rng.uniform(0.5, 1.5) - 0.05
            if self._style.stick and time % 90.0 > 87.0:
                self._next = time + 3.0
        return bool(due)


def main() -> None:
    """Print a row for each building, style and seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("buildings", nargs="*", choices=[[], *every_building()], help="all unless given")
    parser.add_argument("--styles", nargs="+", choices=STYLES, default=[*STYLES])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder in which the logs stay")
    given = parser.parse_args()
    places = every_building()
    print("                       relations, mean and largest [m]: final path, online, odometry; ATE [m]: final path,")
    print("building style   seed   odometry; NEES mean, median; loops, scans in the map; turn, mean and largest [deg]")
    for name in given.buildings or places:
        for seed in range(1, given.seeds + 1):
            drives: dict[Style, Drive] = {}
            for kind in given.styles:
                style = STYLES[kind]
                if style.drive not in drives:
                    drives[style.drive] = drive_of(places[name], style.drive, seed=seed)
                with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
                    log = (given.keep or Path(folder)) / f"{name}-{kind}-{seed}.log"
                    log.parent.mkdir(parents=True, exist_ok=True)
                    log.write_text("".join(log_lines(drives[style.drive], style, seed)))
                    print(f"{name:<9}{kind:<9}{seed:3d}  {row(log)}", flush=True)


if __name__ == "__main__":
    main()
