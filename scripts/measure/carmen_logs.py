#!/usr/bin/env python3
"""Write CARMEN logs of simulated buildings as old robots logged them, and print how well `LidarSlam` maps each.

    .venv/bin/python scripts/measure/carmen_logs.py [BUILDING ...] [--odometry coarse turns ...] [--seeds 1]
        [--keep DIR]

A robot drives the loops of each building. The log has FLASER and TRUEPOS lines: 180 beams over 180 degrees in whole
centimetres, about 5 scans a second at uneven times; 1 in 50 beams, and all that meet nothing, read one of the codes of
a SICK scanner, 81.83 to 81.91 m; odometry is poses in whole centimetres and half degrees, 0.05 s older than the scans.
The log is imported as by `mjsim import-log`. Each step of odometry has independent errors (`coarse`): 5 % of the way,
10 % of the turn and 2 degrees for each metre, standard deviations for one metre and one radian. The other kinds add

- `turns`: turns 10 % too large and ways 4 % too long,
- `veers`: a turn of 1 degree for each metre,
- `slips`: every 45 s the wheels turn by 0.4 m and 12 degrees while the robot stands,
- `carried`: after 60 % of the drive the robot is carried to where it would be after 80 %.

Each row has the mean and the largest translational error of relations between places that the robot came back to (at
least a minute later, within 1 m and 40 degrees), for the final path, the online estimate and odometry; then the ATE of
the final path and of odometry, NEES mean and median, loops, scans in the map, and the mean and the largest rotational
error of relations for the final path. Buildings: `blocks`, corridors around four blocks; `offices`, rooms along two
corridors; `mine`, tunnels around four pillars of rock; `ward`, two long corridors with identical rooms; `cubicles`, a
hall with a regular grid of identical partitions.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lidar_buildings import Told
from relations import Relation, misfits
from threadpoolctl import threadpool_limits

import mjsim
from mjsim.algorithms.lidar_slam import LidarSlam
from mjsim.algorithms.waypoints import Waypoints
from mjsim.geometry import Array, Pose, wrap_angle, wrap_angles
from mjsim.report.metrics import absolute_trajectory_errors

ROBOT = """
robots:
  - name: scout
    preset: pioneer3dx
    at: AT
    drive: {noise: {speed: 0.02, turn: 0.02}}
    sensors: [{lidar: scan, at: [0.2, 0, 0.3], yaw_deg: -0.5, beams: 180, fov_deg: 179, range: [0.05, 40], rate_hz: 10,
               noise: {range: 0.01}}]
run: {rate_hz: 10, step_ms: 4}
"""
CODES = (81.83, 81.87, 81.90, 81.91)
"""What the scanner says when nothing came back, or too much did [m]."""
LAG = 0.05
"""By so much odometry is older than the scan beside it [s]."""
CARRIED = 0.5
"""No robot drives that far in a tenth of a second [m]."""
SETTLED = 2
"""NEES counts from so many scans in the map on: before, odometry in whole steps has told nothing yet."""
SPEED = 0.7
"""[m/s]"""
LONGEST = 1500.0
"""When a drive that does not come to its end is given up [s]."""
ERRORS = {"coarse": (1.0, 1.0, 0.0), "turns": (1.04, 1.1, 0.0), "veers": (1.0, 1.0, np.radians(1.0))}
"""Of odometry: factors on ways and on turns, and turn for each metre [rad/m]."""


@dataclass(frozen=True, slots=True)
class Building:
    """Walls and things as a world file has them, and where a robot goes."""

    text: str
    start: tuple[float, float]
    points: Sequence[tuple[float, float]]
    later: tuple[str, int] | None = None
    """As it is after so many of the points; None if nothing changes."""


@dataclass(frozen=True, slots=True, eq=False)
class Drive:
    """What is true of a drive, 10 times a second."""

    times: Array
    """Shape (N,) [s]."""
    poses: Array
    """World frame, shape (N, 3)."""
    ranges: Array
    """Infinite where nothing came back, shape (N, 180) [m]."""


def buildings() -> dict[str, Building]:
    """Return all buildings by their names."""
    return {"blocks": blocks(), "offices": offices(), "mine": mine(), "ward": ward(), "cubicles": cubicles()}


def blocks() -> Building:
    """Return corridors around four blocks, with doors that are closed, in niches."""
    rng = np.random.default_rng(1)
    sides = [rectangle(2 + 18.0 * i, 2 + 15.0 * j, 16, 13) for i in range(2) for j in range(2)]
    walls = [niched(side, rng, inward=True) for side in sides] + [niched(rectangle(0, 0, 38, 32), rng, inward=False)]
    x, y = (1, 19, 37), (1, 16, 31)
    way = [(x[2], y[0]), (x[2], y[1]), (x[1], y[1]), (x[1], y[0]), (x[0], y[0]), (x[0], y[2]), (x[2], y[2])]
    way += [(x[2], y[1]), (x[0], y[1]), (x[0], y[2]), (x[1], y[2]), (x[1], y[0]), (x[2], y[0]), (x[2], y[2])]
    way += [(x[0], y[2]), (x[0], y[0])]
    return Building(world("blocks", walls), (2.0, 1.0), way)


def offices() -> Building:
    """Return rooms with furniture along two corridors that are joined at both ends."""
    rng, walls, things, doors = np.random.default_rng(2), [rectangle(0, 0, 40, 22)], [], list[str]()
    ways: dict[bool, list[tuple[float, float]]] = {False: [], True: []}
    for north in (False, True):
        x = 2.0
        mirror = (lambda y: 22.0 - y) if north else (lambda y: y)
        while x < 38.0:
            width = min(float(rng.uniform(3.0, 5.0)), 38.0 - x)
            width = 38.0 - x if 38.0 - x - width < 3.0 else width
            walls.append([(x, mirror(0.0)), (x, mirror(6.0))])
            at = float(rng.uniform(0.3, width - 1.3))
            doors.append(
                f"{{points: [[{x}, {mirror(6.0)}], [{x + width}, {mirror(6.0)}]], openings: [{{at: {at}, width: 1}}]}}"
            )
            for _ in range(3):
                size = rng.uniform([0.4, 0.4], [1.4, 0.8])
                spot = x + rng.uniform(0.7, width - 0.7), mirror(float(rng.uniform(0.5, 3.0)))
                things.append(box(spot, size, rng.choice([0.0, 90.0, rng.uniform(0, 90)])))
            if rng.random() < 0.5:
                door = x + at + 0.5
                ways[north] += [(door, mirror(7.0)), (door, mirror(4.4)), (door, mirror(7.0))]
            x += width
        walls.append([(38.0, mirror(0.0)), (38.0, mirror(6.0))])
    walls += [rectangle(2, 8, 36, 6)]
    south, back = ways[False], ways[True][::-1]
    ring = [(39.0, 7.0), (39.0, 15.0), (1.0, 15.0), (1.0, 7.0)]
    way = [*south, (39.0, 7.0), (39.0, 15.0), *back, (1.0, 15.0), (1.0, 7.0), *ring, *south[:6], (3.0, 7.0)]
    return Building(world("offices", walls, doors, things), (3.0, 7.0), way)


def mine() -> Building:
    """Return tunnels around four pillars of rock: no wall is straight."""
    rng = np.random.default_rng(3)
    sides = [rectangle(3.5 + 15.5 * i, 3.5 + 13.5 * j, 12, 10) for i in range(2) for j in range(2)]
    walls = [jagged(side, rng) for side in [*sides, rectangle(0, 0, 34.5, 30.5)]]
    x, y = (1.75, 17.25, 32.75), (1.75, 15.25, 28.75)
    way = [(x[2], y[0]), (x[2], y[2]), (x[0], y[2]), (x[0], y[0]), (x[1], y[0]), (x[1], y[2]), (x[0], y[2])]
    way += [(x[0], y[1]), (x[2], y[1]), (x[2], y[2]), (x[1], y[2]), (x[1], y[0]), (x[0], y[0])]
    return Building(world("mine", walls), (3.0, 1.75), way)


def ward() -> Building:
    """Return two corridors of 56 m with rooms that all look alike, joined at both ends."""
    walls, doors, things = [rectangle(0, 0, 60, 22), rectangle(2, 8.4, 56, 5.2)], list[str](), list[str]()
    for y, out in ((6.0, -1), (16.0, 1)):
        for k in range(14):
            x = 2.0 + 4.0 * k
            walls.append([(x, y), (x, 11.0 + out * 11.0)])
            doors.append(f"{{points: [[{x}, {y}], [{x + 4}, {y}]], openings: [{{at: 1.4, width: 1.1}}]}}")
            things += [box((x + 0.7, y + out * 3.0), (1.0, 2.0), 0.0), box((x + 3.2, y + out * 1.2), (0.6, 0.5), 0.0)]
        walls.append([(58.0, y), (58.0, 11.0 + out * 11.0)])
    south = [(4.0 * k + 3.95, y) for k in (2, 7, 11) for y in (7.2, 4.0, 7.2)]
    north = [(4.0 * k + 3.95, y) for k in (9, 3) for y in (14.8, 18.0, 14.8)]
    ring = [(59.0, 7.2), (59.0, 14.8), (1.0, 14.8), (1.0, 7.2)]
    way = [*south, *ring[:2], *north, *ring[2:], *ring[:3], (1.0, 7.2), (20.0, 7.2)]
    return Building(world("ward", walls, doors, things), (3.0, 7.2), way)


def cubicles() -> Building:
    """Return a hall in which low walls make the same place over and over."""
    walls = [rectangle(0, 0, 32, 25)]
    for i in range(7):
        for j in range(4):
            left, low = 2.0 + 4.0 * i, 2.0 + 5.6 * j
            right, high = left + 2.4, low + 3.6
            walls += [[(left, high), (left, low), (right, low), (right, high)], [(left, low + 1.8), (right, low + 1.8)]]
    x, y = [5.2 + 4.0 * k for k in range(6)], [1.0 + 5.6 * k for k in range(5)]
    y[4] = 23.9
    way = [(31.0, y[0]), (31.0, y[2]), (x[0], y[2]), (x[0], y[0]), (x[3], y[0]), (x[3], y[4]), (1.0, y[4]), (1.0, y[1])]
    way += [
        (x[5], y[1]),
        (x[5], y[3]),
        (x[1], y[3]),
        (x[1], y[0]),
        (31.0, y[0]),
        (31.0, y[4]),
        (1.0, y[4]),
        (1.0, y[0]),
    ]
    return Building(world("cubicles", walls), (2.0, 1.0), way)


def rectangle(x: float, y: float, width: float, height: float) -> list[tuple[float, float]]:
    """Return its corners and the first once more."""
    return [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)]


def niched(
    corners: Sequence[tuple[float, float]], rng: np.random.Generator, *, inward: bool
) -> list[tuple[float, float]]:
    """Return a wall with a niche of 12 cm for a door every few metres; corners go around counter-clockwise."""
    points: list[tuple[float, float]] = []
    for a, b in zip(np.array(corners[:-1]), np.array(corners[1:]), strict=True):
        length = float(np.hypot(*(b - a)))
        ahead = (b - a) / length
        aside = 0.12 * np.array([-ahead[1], ahead[0]]) * (1.0 if inward else -1.0)
        points.append(tuple(a.tolist()))
        at = float(rng.uniform(0.8, 4.0))
        while at + 1.0 < length - 0.5:
            one, other = a + at * ahead, a + (at + 1.0) * ahead
            points += [tuple(p.tolist()) for p in (one, one + aside, other + aside, other)]
            at += 1.0 + float(rng.uniform(1.5, 5.0))
    return [*points, points[0]]


def jagged(corners: Sequence[tuple[float, float]], rng: np.random.Generator) -> list[tuple[float, float]]:
    """Return a wall of rock."""
    points: list[tuple[float, float]] = []
    for a, b in zip(np.array(corners[:-1]), np.array(corners[1:]), strict=True):
        shares = np.sort(np.concatenate([[0.0], rng.uniform(0.02, 0.98, int(np.hypot(*(b - a)) / 0.9))]))
        points += [tuple((a + s * (b - a) + rng.uniform(-0.35, 0.35, 2)).round(3).tolist()) for s in shares]
    return [*points, points[0]]


def box(at: tuple[float, float], size: Sequence[float], heading_deg: float) -> str:
    """Return a piece of furniture."""
    return (
        f"{{box: [{size[0]:.3f}, {size[1]:.3f}, 1.0], at: [{at[0]:.3f}, {at[1]:.3f}], heading_deg: {heading_deg:.1f}}}"
    )


def world(
    name: str,
    walls: Sequence[Sequence[tuple[float, float]]],
    more: Sequence[str] = (),
    things: Sequence[str] = (),
) -> str:
    """Return the text of a world."""
    lines = [f"  - {{points: {[list(map(float, point)) for point in wall]}}}" for wall in walls]
    lines += [f"  - {each}" for each in more]
    found = "".join(f"  - {each}\n" for each in things)
    return f"mjsim: 1\nname: {name}\nwalls:\n" + "\n".join(lines) + "\n" + (f"obstacles:\n{found}" if found else "")


def driven(room: mjsim.World, navigator: Waypoints, *, seed: int) -> Drive:
    """Return a drive of the robot `scout` through a world."""
    told, rows, still = Told(), list[tuple[float, Array, Array]](), 0
    driver = mjsim.Driver(estimator=told, navigator=navigator, avoidance=True)
    with mjsim.Simulation(room, seed=seed) as sim:
        for tick in mjsim.ticks(sim, {"scout": driver}):
            told.pose = tick.truth["scout"]
            rows += [(tick.time, told.pose.as_array(), scan.ranges) for scan in tick.seen["scout"].scans.values()]
            still = still + 1 if tick.orders["scout"].command == mjsim.Command() else 0
            if tick.time > LONGEST or still > 20:
                break
    times, poses, ranges = zip(*rows, strict=True)
    return Drive(np.array(times), np.array(poses), np.array(ranges))


def carried(drive: Drive) -> Drive:
    """Return a drive with a part left out, over which the robot is carried at once."""
    row, count = np.arange(len(drive.times)), len(drive.times)
    kept = (row < 0.6 * count) | (row > 0.8 * count)
    return Drive(drive.times[: kept.sum()], drive.poses[kept], drive.ranges[kept])


def odometry(drive: Drive, kind: str, rng: np.random.Generator) -> Array:
    """Return the poses that odometry tells of a drive, shape (N, 3)."""
    gain, turning, veer = ERRORS.get(kind, ERRORS["coarse"])
    place, told = Pose(0.0, 0.0, 0.0), [Pose(0.0, 0.0, 0.0)]
    for number in range(1, len(drive.times)):
        step = Pose(*drive.poses[number - 1]).inverse() @ Pose(*drive.poses[number])
        if np.hypot(step.x, step.y) > CARRIED:
            step = Pose(0.0, 0.0, 0.0)
        way, turned = abs(step.x), abs(step.heading)
        forward = gain * step.x + rng.normal(0.0, 0.05 * np.sqrt(way))
        turn = turning * step.heading + veer * way
        turn += rng.normal(0.0, 0.1 * np.sqrt(turned)) + rng.normal(0.0, np.radians(2.0) * np.sqrt(way))
        if kind == "slips" and drive.times[number] % 45.0 > 44.0:
            forward, turn = forward + 0.04, turn + np.radians(1.2)
        place = place @ Pose(forward, 0.0, turn)
        told.append(place)
    poses = np.array([pose.as_array() for pose in told])
    poses[:, 2] = np.unwrap(poses[:, 2])
    late = np.column_stack([np.interp(drive.times - LAG, drive.times, column) for column in poses.T])
    return np.column_stack(
        [late[:, :2].round(2), wrap_angles(np.radians(0.5 * np.round(2.0 * np.degrees(late[:, 2]))))]
    )


def log_lines(drive: Drive, kind: str, seed: int) -> Iterator[str]:
    """Yield the lines of a log."""
    rng = np.random.default_rng([seed, *kind.encode()])
    if kind == "carried":
        drive = carried(drive)
    told = odometry(drive, kind, rng)
    yield "PARAM robot_frontlaser_offset 0.2 nohost 0\n"
    for number, time in enumerate(drive.times):
        x, y, heading = told[number].tolist()
        stamp = 1e9 + time + rng.uniform(0.0, 0.02)
        true = " ".join(f"{value:.6f}" for value in drive.poses[number].tolist())
        yield f"TRUEPOS {true} {x:.6f} {y:.6f} {heading:.6f} {stamp:.6f} nohost 0\n"
        if rng.random() < 0.5:
            continue
        ranges = drive.ranges[number].round(2)
        lost = ~np.isfinite(ranges) | (rng.random(len(ranges)) < 0.02)
        ranges[lost] = rng.choice(CODES, size=int(lost.sum()), p=[0.7, 0.1, 0.1, 0.1])
        values = " ".join(f"{value:.2f}" for value in ranges.tolist())
        pose = f"{x:.6f} {y:.6f} {heading:.6f}"
        yield f"FLASER {len(ranges)} {values} {pose} {pose} {stamp:.6f} nohost 0\n"


def row(log: Path) -> str:
    """Return what `LidarSlam` makes of a log, as a line."""
    recording, slam = mjsim.import_log(log), LidarSlam()
    with mjsim.Simulation(recording.world, seed=0) as sim:
        slam.start(sim.robots["robot"], {}, np.random.default_rng(0))
    truth = recording.robots["robot"].truth
    # The last tick lies behind the log's end.
    truth = truth[np.isfinite(truth).all(axis=1)]
    seen, times = list(recording.observations("robot"))[: len(truth)], recording.time[: len(truth)]
    nees, online, reckoned = list[float](), list[Array](), [Pose(*truth[0])]
    for each, true in zip(seen, truth, strict=True):
        belief = slam.update(each)
        off = belief.pose.as_array() - true
        off[2] = wrap_angle(float(off[2]))
        online.append(belief.pose.as_array())
        if len(slam.keyframes) >= SETTLED:
            nees.append(off @ np.linalg.pinv(belief.covariance, hermitian=True) @ off)
        moved = each.odometry
        reckoned.append(reckoned[-1] @ Pose(moved.forward, moved.left, moved.turn))
    final = np.array([pose.as_array() for _, pose in slam.path()])
    relations = revisited(times, truth)
    wheels = np.array([pose.as_array() for pose in reckoned[1:]])
    shifts, turns = zip(*[misfits(relations, times, poses) for poses in (final, np.array(online), wheels)], strict=True)
    ates = [np.sqrt(np.mean(absolute_trajectory_errors(truth, poses) ** 2)) for poses in (final, wheels)]
    told = "  ".join(f"{shift.mean():6.3f} {shift.max():6.3f}" for shift in shifts)
    turned = np.degrees(turns[0])
    return (
        f"{told}  {ates[0]:6.3f} {ates[1]:6.2f}  {np.mean(nees):6.1f} {np.median(nees):6.2f} "
        f"{slam.loops:5d} {len(slam.keyframes):5d}  {turned.mean():5.2f} {turned.max():5.2f}"
    )


def revisited(times: Array, truth: Array, count: int = 300) -> list[Relation]:
    """Return true relations between places that the robot came back to, spread over the drive."""
    rng, found = np.random.default_rng(1), list[Relation]()
    for number in rng.permutation(len(times)):
        later = times > times[number] + 60.0
        turned = np.abs(wrap_angles(truth[:, 2] - truth[number, 2]))
        near = later & (np.hypot(*(truth[:, :2] - truth[number, :2]).T) < 1.0) & (turned < np.radians(40.0))
        if near.any() and len(found) < count:
            other = int(rng.choice(np.flatnonzero(near)))
            step = Pose(*truth[number]).inverse() @ Pose(*truth[other])
            found.append(Relation(float(times[number]), float(times[other]), step, 1.0))
    return found


def main() -> None:
    """Print a row for each building, kind of odometry and seed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("buildings", nargs="*", choices=[[], *buildings()], help="all unless given")
    parser.add_argument("--odometry", nargs="+", choices=[*ERRORS, "slips", "carried"], default=[*ERRORS, "slips"])
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="folder in which the logs stay")
    given = parser.parse_args()
    print("                        relations, mean and largest [m]: final path, online, odometry; ATE [m]: final path,")
    print(
        "building  odometry seed   odometry; NEES mean, median; loops, scans in the map; turn, mean and largest [deg]"
    )
    for name in given.buildings or buildings():
        for seed in range(1, given.seeds + 1):
            building = buildings()[name]
            room = mjsim.parse_world(building.text + ROBOT.replace("AT", str(list(building.start))))
            drive = driven(room, Waypoints(building.points, speed=SPEED), seed=seed)
            for kind in given.odometry:
                with tempfile.TemporaryDirectory() as folder, threadpool_limits(1, user_api="blas"):
                    log = (given.keep or Path(folder)) / f"{name}-{kind}-{seed}.log"
                    log.parent.mkdir(parents=True, exist_ok=True)
                    log.write_text("".join(log_lines(drive, kind, seed)))
                    print(f"{name:<10}{kind:<9}{seed:3d}  {row(log)}", flush=True)


if __name__ == "__main__":
    main()
