#!/usr/bin/env python3
"""Write CARMEN logs of buildings and robots that are harder than those of `carmen_logs.py`, and map each.

    .venv/bin/python scripts/measure/hard_logs.py [BUILDING ...] [--styles plain near ...] [--seeds 1] [--keep DIR]

Odometry has the errors `coarse` of `carmen_logs.py`, and rows have the same figures. Buildings: `loop`, a ring of bare
corridors, 196 m around, that closes late; `wings`, four wings with identical rooms around a hall, so that the building
looks the same from all four sides; `campus`, two rings with long corridors, doors in niches, and a large hall; `lofts`,
rooms with few straight walls whose doors are narrow. Styles of robots and logs:

- `plain`: 180 beams of 1 degree, up to 40 m, 5 scans a second;
- `near`: ranges up to 8 m, others read 8.0;
- `slow`: 361 beams of half a degree, 3 scans a second, at 1 m/s and in turns at up to 100 degrees/s;
- `jumps`: at every third door sill (each 12 m) odometry jumps by 5 to 20 degrees within 0.2 s;
- `bursts`: every 50 s the wheels slip for 4 s: by half of the way, and 6 degrees/s to one side;
- `glass`: a quarter of the walls, in pieces of 1.5 m, returns only beams that meet it within 8 degrees of its normal;
- `people`: eight people walk beside the robot;
- `stands`: the robot stands for 60 s every two minutes, and odometry lines come ten times as often as scans;
- `worn`: the errors of `jumps` and `glass`, with ranges up to 8 m, and 3 scans a second.
"""

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from carmen_logs import SPEED, Building, Drive, box, driven, jagged, niched, rectangle, row, world
from lidar_buildings import walks
from threadpoolctl import threadpool_limits

import mjsim
from mjsim.geometry import Array, Pose, wrap_angles

ROBOT = """
robots:
  - name: scout
    preset: pioneer3dx
    at: AT
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

    half: bool = False
    """Whether beams are half a degree apart."""
    speed: float = SPEED
    reach: float = 40.0
    every: float = 0.2
    """Mean time between two scans [s]."""
    jumps: bool = False
    bursts: bool = False
    glass: bool = False
    people: int = 0
    stands: bool = False


STYLES = {
    "plain": Style(),
    "near": Style(reach=NEAR),
    "slow": Style(half=True, speed=1.0, every=0.33),
    "jumps": Style(jumps=True),
    "bursts": Style(bursts=True),
    "glass": Style(glass=True),
    "people": Style(people=8),
    "stands": Style(stands=True),
    "worn": Style(reach=NEAR, every=0.33, jumps=True, glass=True),
}


def buildings() -> dict[str, Building]:
    """Return all buildings by their names."""
    return {"loop": loop(), "wings": wings(), "campus": campus(), "lofts": lofts()}


def loop() -> Building:
    """Return a ring of bare corridors."""
    walls = [rectangle(0, 0, 62, 40), rectangle(2.2, 2.2, 57.6, 35.6)]
    ring = [(60.9, 1.1), (60.9, 38.9), (1.1, 38.9), (1.1, 1.1)]
    return Building(world("loop", walls), (3.0, 1.1), [*ring, *ring[:2], (20.0, 38.9), (60.9, 38.9), *ring[:1]])


def wings() -> Building:
    """Return four wings with identical rooms around a hall: the building looks the same from four sides."""
    middle, quarter = np.array([22.0, 22.0]), np.array([[0.0, -1.0], [1.0, 0.0]])
    lines, doors, way = list[list[tuple[float, float]]](), list[str](), list[tuple[float, float]]()
    R = np.eye(2)
    for _ in range(4):

        def at(*points: tuple[float, float], R: Array = R) -> list[tuple[float, float]]:
            return [tuple((middle + R @ point).round(3).tolist()) for point in points]

        lines += [at((4, -4), (4, -1), (20, -1)), at((20, -6), (20, 6)), at((20, 1), (4, 1), (4, 4))]
        for x in (4.0, 8.0, 12.0, 16.0):
            lines += [at((x, 1.0), (x, 6.0)), at((x, -1.0), (x, -6.0))]
        lines += [at((4.0, 6.0), (20.0, 6.0)), at((4.0, -6.0), (20.0, -6.0))]
        way += at((18.5, 0.0), (2.5, 0.0))
        R = quarter @ R
    return Building(world("wings", lines, doors), (22.0, 22.0), [*way, *way[:6], (22.0, 22.0)])


def campus() -> Building:
    """Return two rings with long corridors, doors in niches, and a hall with pillars between them."""
    rng = np.random.default_rng(11)
    walls = [niched(rectangle(2, 2, 42, 26), rng, inward=True), niched(rectangle(66, 2, 24, 26), rng, inward=True)]
    walls.append(niched(rectangle(0, 0, 92, 30), rng, inward=False))
    things = [f"{{cylinder: [0.3, 2.0], at: [{x}, {y}]}}" for x in (49.0, 55.0, 61.0) for y in (6.0, 15.0, 24.0)]
    left, right = [(1.0, 29.0), (1.0, 1.0)], [(91.0, 1.0), (91.0, 29.0)]
    way = [(46.0, 1.0), (64.0, 1.0), *right, (46.0, 29.0), *left, (46.0, 1.0), (52.0, 12.0), (52.0, 27.0), (46.0, 29.0)]
    return Building(world("campus", walls, (), things), (3.0, 1.0), [*way, *left, (46.0, 1.0), (64.0, 1.0), *right])


def lofts() -> Building:
    """Return rooms with uneven walls and furniture; doors are narrow."""
    rng, doors, things = np.random.default_rng(12), list[str](), list[str]()
    for i in range(1, 4):
        doors.append(
            f"{{points: [[{9 * i}, 0], [{9 * i}, 16]], openings: [{{at: 3, width: 1}}, {{at: 12, width: 1}}]}}"
        )
    for i in range(4):
        doors.append(f"{{points: [[{9 * i}, 8], [{9 * i + 9}, 8]], openings: [{{at: 5, width: 1.0}}]}}")
    for _ in range(40):
        spot = rng.uniform([0.8, 0.8], [35.2, 15.2])
        if abs(spot[1] - 3.5) > 1.2 and abs(spot[1] - 12.5) > 1.2 and abs((spot[0] - 5.5) % 9.0) > 1.1:
            things.append(box((spot[0], spot[1]), rng.uniform([0.2, 0.2], [0.9, 0.5]), float(rng.uniform(0, 90))))
    way = [(5.5, 3.5), (5.5, 12.5), (14.5, 12.5), (14.5, 3.5), (23.5, 3.5), (23.5, 12.5), (32.5, 12.5), (32.5, 3.5)]
    walls = [jagged(rectangle(0, 0, 36, 16), rng)]
    return Building(world("lofts", walls, doors, things), (2.0, 3.5), [*way, *way[::-1], *way, (5.5, 3.5)])


def drive_of(building: Building, style: Style, *, seed: int) -> Drive:
    """Return a drive through a building."""
    beams, fov, yaw = (361, 180.0, 0.0) if style.half else (180, 179.0, -0.5)
    text = building.text + ROBOT.replace("BEAMS", str(beams)).replace("FOV", str(fov)).replace("YAW", str(yaw))
    room = mjsim.parse_world(text.replace("AT", str(list(building.start))))
    people = mjsim.parse_world(f"mjsim: 1\nname: people\nobstacles: [{', '.join(walks(building, style.people))}]\n")
    room = room.model_copy(update={"obstacles": [*room.obstacles, *people.obstacles]})
    return driven(room, building.points, speed=style.speed, seed=seed)


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
        way += ahead
        place = place @ Pose(forward, 0.0, turn)
        told.append(place)
    poses = np.array([pose.as_array() for pose in told])
    return np.column_stack(
        [poses[:, :2].round(2), wrap_angles(np.radians(0.5 * np.round(2 * np.degrees(poses[:, 2]))))]
    )


def spoilt(drive: Drive, number: int, style: Style, rng: np.random.Generator) -> Array:
    """Return the ranges of a scan as a robot of a style logs them, shape (n,) [m]."""
    ranges = drive.ranges[number].copy()
    if style.glass:
        x, y, heading = drive.poses[number]
        angles = np.radians(np.arange(len(ranges)) * (0.5 if style.half else 1.0) - 90.0) + heading
        reached = np.where(np.isfinite(ranges), ranges, 0.0)
        ends = np.stack([x + reached * np.cos(angles), y + reached * np.sin(angles)], axis=-1)
        pane = np.floor(ends / 1.5).astype(int)
        glass = (pane[:, 0] * 73856093 ^ pane[:, 1] * 19349663) % 4 == 0
        straight = np.abs((angles + np.pi / 4) % (np.pi / 2) - np.pi / 4) < np.radians(8.0)
        ranges[glass & ~straight] = np.inf
    ranges[rng.random(len(ranges)) < 0.02] = np.inf
    return np.where(ranges < style.reach, ranges, style.reach if style.reach < 40.0 else CODE)


def log_lines(drive: Drive, style: Style, seed: int) -> Iterator[str]:
    """Yield the lines of a log."""
    rng = np.random.default_rng([seed, 5])
    drive = standing(drive) if style.stands else drive
    told, due = odometry(drive, style, rng), 0.0
    yield "PARAM robot_frontlaser_offset 0.2 nohost 0\n"
    for number, time in enumerate(drive.times.tolist()):
        x, y, heading = told[number].tolist()
        pose, stamp = f"{x:.6f} {y:.6f} {heading:.6f}", 1e9 + time + rng.uniform(0.0, 0.02)
        if style.stands and number:
            for share in np.linspace(0.1, 0.9, 9):
                between = (1 - share) * told[number - 1] + share * told[number]
                between[2] = told[number - 1, 2]
                line = " ".join(f"{value:.6f}" for value in between.tolist())
                yield f"ODOM {line} 0 0 0 {stamp - 0.07 * (1 - share):.6f} nohost 0\n"
        true = " ".join(f"{value:.6f}" for value in drive.poses[number].tolist())
        yield f"TRUEPOS {true} {pose} {stamp:.6f} nohost 0\n"
        if time < due:
            continue
        due = time + style.every * rng.uniform(0.5, 1.5) - 0.05
        values = " ".join(f"{value:.2f}" for value in spoilt(drive, number, style, rng).tolist())
        yield f"FLASER {drive.ranges.shape[1]} {values} {pose} {pose} {stamp:.6f} nohost 0\n"


def main() -> None:
    """Print a row for each building, style and seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("buildings", nargs="*", choices=[[], *buildings()], help="all unless given")
    parser.add_argument("--styles", nargs="+", choices=STYLES, default=[*STYLES])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder in which the logs stay")
    given = parser.parse_args()
    print("                       relations, mean and largest [m]: final path, online, odometry; ATE [m]: final path,")
    print("building style   seed   odometry; NEES mean, median; loops, scans in the map")
    for name in given.buildings or buildings():
        for seed in range(1, given.seeds + 1):
            drives: dict[Style, Drive] = {}
            for kind in given.styles:
                style = STYLES[kind]
                driving = Style(half=style.half, speed=style.speed, people=style.people)
                if driving not in drives:
                    drives[driving] = drive_of(buildings()[name], driving, seed=seed)
                with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
                    log = (given.keep or Path(folder)) / f"{name}-{kind}-{seed}.log"
                    log.parent.mkdir(parents=True, exist_ok=True)
                    log.write_text("".join(log_lines(drives[driving], style, seed)))
                    print(f"{name:<9}{kind:<9}{seed:3d}  {row(log)}", flush=True)


if __name__ == "__main__":
    main()
